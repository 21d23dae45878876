#pragma once
// Opens the contents of examples/content in a player.

#include <gtest/gtest.h>

#include "ugoki/content/player.h"
#include "ugoki/files/files.h"
#include "ugoki/lsi/payload.h"
#include "ugoki/studio/content_recipes.h"

namespace ugoki::studio {

inline content::Player open_content(const std::string& name) {
  const Result<std::string> text = files::read_file(std::string(UGOKI_SOURCE_DIR) + "/examples/content/" + name + ".json");
  EXPECT_TRUE(text);
  const Result<content::ContentText> made = make_content(*text, name);
  EXPECT_TRUE(made) << (made ? "" : made.error().text());
  const auto bytes = content::generate(made->scenario, made->resources);
  EXPECT_TRUE(bytes) << (bytes ? "" : bytes.error().text());
  auto player = content::Player::open(*bytes, name);
  EXPECT_TRUE(player) << (player ? "" : player.error().text());
  return std::move(*player);
}

/// The numbers of an output pin, for example "dynamics.applied".
inline const double* output(content::Player& player, const char* pin) {
  return reinterpret_cast<const double*>(player.interpreter().find_output(pin)->bytes.data());
}

/// The grips that are closed: of each, the force and the gap.
inline std::span<const lsi::EventRecord> grips_of(content::Player& player) {
  return lsi::records<lsi::EventRecord>(player.interpreter().find_output("dynamics.grips")->bytes.data());
}

}  // namespace ugoki::studio
