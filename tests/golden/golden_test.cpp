// State hashes of the golden contents for every SIMD width and for 1, 2 and 8 threads. Each compiler runs these tests; tests/wasm/run.mjs
// compares the WebAssembly player with the same hashes.

#include <gtest/gtest.h>

#include <cinttypes>
#include <cstdio>
#include <fstream>
#include <map>
#include <span>
#include <sstream>

#include "contents.h"
#include "ugoki/collision/bubble_kernel.h"
#include "ugoki/collision/gilbert_width.h"
#include "ugoki/contact/solver_kernels.h"
#include "ugoki/content/player.h"
#include "ugoki/dynamics/kernels.h"
#include "ugoki/plugin/thread_pool.h"

namespace ugoki::golden {
namespace {

std::string text_of(std::uint64_t hash) {
  char text[17];
  std::snprintf(text, sizeof text, "%016" PRIx64, hash);
  return text;
}

/// Reads hashes.txt. @return state hashes by name of the content and number of steps
std::map<std::pair<std::string, long>, std::string> kept_hashes() {
  std::ifstream file(UGOKI_SOURCE_DIR "/tests/golden/hashes.txt");
  std::map<std::pair<std::string, long>, std::string> all;
  std::string line, name, hash;
  long step = 0;
  while (std::getline(file, line))
    if (std::istringstream words(line); line[0] != '#' && words >> name >> step >> hash) all[{name, step}] = hash;
  return all;
}

/// Runs all contents and compares their state hashes after each number of steps in `steps`. @param pool null: the calling thread only
void expect_kept_hashes(std::span<const long> steps, plugin::ThreadPool* pool = nullptr) {
  static const std::vector<GoldenContent> contents = make_contents();
  const auto kept = kept_hashes();
  EXPECT_EQ(kept.size(), contents.size() * std::size(checkpoints));
  for (const GoldenContent& c : contents) {
    Result<content::Player> player = content::Player::open(c.ugx, c.name, {.library = nullptr, .activity = nullptr, .executor = pool});
    ASSERT_TRUE(player) << player.error().text();
    for (const long step : steps) {
      while (player->step_count() < static_cast<std::uint64_t>(step)) {
        const Result<void> done = player->step();
        ASSERT_TRUE(done) << c.name << ": " << done.error().text();
      }
      const auto found = kept.find({c.name, step});
      ASSERT_TRUE(found != kept.end()) << c.name << " " << step;
      EXPECT_EQ(text_of(player->state_hash()), found->second) << c.name << ", step " << step << "; docs/design/step.md explains hashes";
    }
  }
}

enum class Width { plain, avx2, avx512 };
/// Makes all kernels use this SIMD width. @return false if the processor does not support it
bool use_width(Width width) {
  const bool dynamics = dynamics::use_simd(static_cast<dynamics::SimdWidth>(width));
  const bool bubble = collision::use_bubble_width(static_cast<collision::BubbleWidth>(width));
  const bool gilbert = collision::use_gilbert_width(static_cast<collision::GilbertWidth>(width));
  const bool dense = contact::use_solver_kernels(width != Width::plain);
  return dynamics && bubble && gilbert && dense;
}

void expect_kept_hashes_with_every_width(std::span<const long> steps) {
  for (const Width width : {Width::plain, Width::avx2, Width::avx512}) {
    if (!use_width(width)) continue;
    SCOPED_TRACE("width " + std::to_string(static_cast<int>(width)));
    expect_kept_hashes(steps);
  }
  for (const Width width : {Width::avx512, Width::avx2, Width::plain})
    if (use_width(width)) break;  // set the widest supported width again
}

void expect_kept_hashes_with_threads(std::span<const long> steps) {
  for (const int threads : {2, 8}) {
    SCOPED_TRACE(std::to_string(threads) + " threads");
    plugin::ThreadPool pool(threads);
    expect_kept_hashes(steps, &pool);
  }
}

constexpr std::span<const long> all(checkpoints);
constexpr std::span<const long> first = all.first(fast_checkpoints);

TEST(Golden, HashesAreEqualForEverySimdWidth) { expect_kept_hashes_with_every_width(first); }
TEST(Golden, HashesAreEqualForEveryNumberOfThreads) { expect_kept_hashes_with_threads(first); }
TEST(SlowGolden, HashesAreEqualForEverySimdWidth) { expect_kept_hashes_with_every_width(all); }
TEST(SlowGolden, HashesAreEqualForEveryNumberOfThreads) { expect_kept_hashes_with_threads(all); }

}  // namespace
}  // namespace ugoki::golden
