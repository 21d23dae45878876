#pragma once
// Opens the contents of examples/content in a player.

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "ugoki/content/player.h"
#include "ugoki/files/files.h"
#include "ugoki/lsi/payload.h"
#include "ugoki/studio/content_recipes.h"

namespace ugoki::studio {

/// The text of a content of examples/content.
inline std::string content_text(const std::string& name) {
  const Result<std::string> text = files::read_file(std::string(UGOKI_SOURCE_DIR) + "/examples/content/" + name + ".json");
  EXPECT_TRUE(text);
  return *text;
}

inline content::Player open_text(const std::string& text, const std::string& name) {
  const Result<content::ContentText> made = make_content(text, name);
  EXPECT_TRUE(made) << (made ? "" : made.error().text());
  const auto bytes = content::generate(made->scenario, made->resources);
  EXPECT_TRUE(bytes) << (bytes ? "" : bytes.error().text());
  auto player = content::Player::open(*bytes, name);
  EXPECT_TRUE(player) << (player ? "" : player.error().text());
  return std::move(*player);
}

inline content::Player open_content(const std::string& name) { return open_text(content_text(name), name); }

/// The numbers of an output pin, for example "dynamics.applied"; fails, and returns values that are no numbers, if there is no such pin.
inline const double* output(content::Player& player, const char* pin) {
  static const std::vector<double> none(100, std::nan(""));
  const auto found = player.interpreter().find_output(pin);
  EXPECT_TRUE(found) << (found ? "" : found.error().text());
  return found ? reinterpret_cast<const double*>(found->bytes.data()) : none.data();
}

/// The grips that are closed: of each, the force and the gap.
inline std::span<const lsi::EventRecord> grips_of(content::Player& player) {
  return lsi::records<lsi::EventRecord>(player.interpreter().find_output("dynamics.grips")->bytes.data());
}

}  // namespace ugoki::studio
