// Executable data of every released version of the format can be read. tests/player/released contains one file of each version.

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "../content/fixture.h"
#include "ugoki/content/player.h"
#include "ugoki/content/ugx.h"

namespace ugoki::content {
namespace {

const std::string folder = std::string(UGOKI_SOURCE_DIR) + "/tests/player/released/";

std::vector<std::byte> bytes_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  const auto* p = reinterpret_cast<const std::byte*>(text.data());
  return {p, p + text.size()};
}

TEST(ReleasedUgx, Version1IsReadAndRuns) {
  const std::string path = folder + "park-1.ugx";
  if (std::getenv("UGOKI_WRITE_RELEASED") != nullptr) {  // use this only for a new version of the format, with a new file name
    const auto made = generate(testing::make_scenario(), testing::make_resources());
    ASSERT_TRUE(made);
    std::ofstream(path, std::ios::binary).write(reinterpret_cast<const char*>(made->data()), static_cast<std::streamsize>(made->size()));
  }
  const std::vector<std::byte> bytes = bytes_of(path);
  ASSERT_GT(bytes.size(), 1000u) << path;
  auto player = Player::open(bytes, path);
  ASSERT_TRUE(player) << player.error().text();
  const Executable& content = player->content();
  EXPECT_EQ(content.name, "park");
  EXPECT_EQ(content.duration, 8);
  ASSERT_EQ(content.characters.size(), 2u);
  EXPECT_EQ(content.characters[0].track.size(), 3u);
  EXPECT_EQ(content.mechanisms[static_cast<std::size_t>(content.characters[0].mechanism)]->link(1).label, "shank left");
  ASSERT_EQ(content.events.size(), 2u);
  EXPECT_EQ(content.events[1].velocity, (Vec3{-6, 0, 2}));
  EXPECT_EQ(content.characters[1].q0, (std::vector<double>{3, 0, 0.11, 1, 0, 0, 0}));
  for (int i = 0; i < 50; ++i) ASSERT_TRUE(player->step());
  // The ball rests on the floor.
  EXPECT_NEAR(player->q(1)[2], 0.11, 2e-3);
}

TEST(ReleasedUgx, FutureVersionIsRefusedWithASentence) {
  std::vector<std::byte> bytes = bytes_of(folder + "park-1.ugx");
  ASSERT_GT(bytes.size(), 64u);
  bytes[8] = std::byte{9};
  const auto player = Player::open(bytes, "park.ugx");
  ASSERT_FALSE(player);
  EXPECT_NE(player.error().text().find("version 9"), std::string::npos) << player.error().text();
  EXPECT_NE(player.error().text().find("newer Ugoki"), std::string::npos) << player.error().text();
}

TEST(ReleasedUgx, EveryTruncationAndEveryFlippedByteIsRefused) {
  const std::vector<std::byte> bytes = bytes_of(folder + "park-1.ugx");
  for (std::size_t size = 0; size < bytes.size(); size += 1 + bytes.size() / 300) {
    const auto ugx = read_ugx(std::span(bytes).first(size));
    ASSERT_FALSE(ugx) << size;
    ASSERT_FALSE(ugx.error().problems.front().message.empty());
  }
  const auto whole = read_ugx(bytes);
  ASSERT_TRUE(whole);
  for (const UgxSection& s : whole->sections()) {
    if (s.bytes.empty()) continue;
    std::vector<std::byte> damaged = bytes;
    damaged[static_cast<std::size_t>(s.bytes.data() - bytes.data()) + s.bytes.size() / 2] ^= std::byte{1};
    const auto ugx = read_ugx(damaged);
    ASSERT_FALSE(ugx) << s.name;
    EXPECT_NE(ugx.error().text().find(s.name), std::string::npos) << "the error should name the damaged section";
  }
}

}  // namespace
}  // namespace ugoki::content
