// The child process around assimp: crashes, hangs and excessive memory use become errors of the caller.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <random>
#include <stdexcept>
#include <vector>

#include "made_scene.h"
#include "ugoki/scene_formats/guarded_call.h"
#include "ugoki/scene_formats/scene_file.h"

namespace ugoki::scene_formats {
namespace {

#if defined(__has_feature)
#if __has_feature(address_sanitizer)
#define UGOKI_ASAN
#endif
#endif

TEST(Guard, AnswersAreReturnedCompletely) {
  const std::string long_answer(5'000'000, 'x');
  const auto r = call_guarded([&] { return long_answer; }, "place");
  ASSERT_TRUE(r.has_value());
  EXPECT_EQ(*r, long_answer);
  EXPECT_EQ(*call_guarded([] { return std::string(); }, "place"), "");
}

TEST(Guard, CrashesAreErrors) {
  const auto crash = call_guarded([]() -> std::string { abort(); }, "bad.fbx");
  ASSERT_FALSE(crash.has_value());
  EXPECT_EQ(crash.error().problems[0].location, "bad.fbx");
  EXPECT_NE(crash.error().text().find("crashed"), std::string::npos);
  EXPECT_FALSE(call_guarded([]() -> std::string { throw std::runtime_error("no"); }, "bad.fbx").has_value());
  EXPECT_FALSE(call_guarded([]() -> std::string { _exit(3); }, "bad.fbx").has_value());
  EXPECT_TRUE(call_guarded([] { return std::string("still here"); }, "good.fbx").has_value());
}

TEST(Guard, HangsAndLongAnswersAreStopped) {
  const auto hang = call_guarded(
      []() -> std::string {
        for (;;) pause();
      },
      "slow.fbx", {.seconds = 0.2});
  ASSERT_FALSE(hang.has_value());
  EXPECT_NE(hang.error().text().find("longer"), std::string::npos);
  EXPECT_FALSE(call_guarded([] { return std::string(2'000'000, 'x'); }, "big.fbx", {.answer = 1'000'000}).has_value());
}

#ifndef UGOKI_ASAN
TEST(Guard, ExcessiveMemoryUseIsStopped) {
  const auto big_use = call_guarded(
      [] {
        std::vector<std::string> all;
        for (int i = 0; i < 1000; ++i) all.emplace_back(std::size_t{1} << 20, 'x');
        return all.back();
      },
      "greedy.fbx", {.memory = std::size_t{200} << 20});
  ASSERT_FALSE(big_use.has_value());
  EXPECT_NE(big_use.error().text().find("memory"), std::string::npos);
}
#endif

/// Reads damaged files: each is read or refused, and this process survives.
void damage(int rounds) {
  std::mt19937 engine(3);
  const MeasuredMotion m = random_motion(2, 4);
  int refused = 0;
  for (const auto& [format, name] : {std::pair("binary", "d.fbx"), std::pair("fbxa", "d.fbx"), std::pair("collada", "d.dae")}) {
    // A binary header followed by arbitrary bytes, and complete files.
    const std::string good = std::string(format) == "binary"
                                 ? std::string("Kaydara FBX Binary  \0\x1a\0\xe8\x1c\0\0", 27) + std::string(2000, '\1')
                                 : make_scene_file(m, {.format = format, .units_per_metre = 100});
    for (int round = 0; round < rounds; ++round) {
      std::string bad = good;
      for (int k = 0; k < 1 + round % 8; ++k) bad[engine() % bad.size()] = static_cast<char>(engine());
      if (round % 5 == 0) bad.resize(engine() % bad.size());
      const auto r = read_scene(std::as_bytes(std::span(bad.data(), bad.size())), name, {.seconds = 20});
      if (!r) {
        ++refused;
        for (const Problem& p : r.error().problems) EXPECT_FALSE(p.location.empty() || p.message.empty() || p.remedy.empty());
      }
    }
  }
  EXPECT_GT(refused, 0);
}
TEST(Guard, DamagedFilesAreReadOrRefused) { damage(12); }
TEST(Slow_Guard, DamagedFilesAreReadOrRefused) { damage(2000); }

}  // namespace
}  // namespace ugoki::scene_formats
