#pragma once
// Fixture for tests of commands: runs them on a document, and plays the document.

#include <gtest/gtest.h>

#include "fixture.h"
#include "ugoki/content/commands.h"
#include "ugoki/content/player.h"

namespace ugoki::content::testing {

class CommandFixture : public ::testing::Test {
 protected:
  void apply(const std::string& command) {
    auto effect = apply_command(document, command, catalogue, next_id);
    ASSERT_TRUE(effect) << effect.error().text();
    document = std::move(effect->scenario);
    label = effect->label;
  }
  /// The command is refused with this code at this location, with a message that contains `words`, and with a remedy.
  void refuses(const std::string& command, ErrorCode code, const std::string& location, const std::string& words = "") {
    const auto effect = apply_command(document, command, catalogue, next_id);
    ASSERT_FALSE(effect) << command;
    EXPECT_EQ(effect.error().problems.front().code, code) << effect.error().text();
    EXPECT_EQ(effect.error().problems.front().location, location) << effect.error().text();
    EXPECT_NE(effect.error().problems.front().message.find(words), std::string::npos) << effect.error().text();
    EXPECT_FALSE(effect.error().problems.front().remedy.empty());
  }
  Player open() {
    const auto bytes = generate(document, resources);
    EXPECT_TRUE(bytes) << (bytes ? "" : bytes.error().text());
    auto player = Player::open(*bytes, "test");
    EXPECT_TRUE(player) << (player ? "" : player.error().text());
    return std::move(*player);
  }

  Resources resources = make_resources();
  Catalogue catalogue = catalogue_of(resources);
  Scenario document;
  std::string label;  ///< of the last command
  std::uint64_t next_id = 1;
};

}  // namespace ugoki::content::testing
