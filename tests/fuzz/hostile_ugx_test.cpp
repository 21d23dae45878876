// Executable data and motion files changed at random: neither the readers nor the player may crash, hang or take much memory. Unlike
// libFuzzer this needs no special build, and it changes whole numbers and names, because changed bytes rarely pass the JSON reader.

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "fuzz_targets.h"

namespace ugoki {
namespace {

using Random = std::mt19937_64;

std::vector<std::string> seeds(std::initializer_list<const char*> folders) {
  std::vector<std::filesystem::path> files;
  for (const char* folder : folders)
    for (const auto& e : std::filesystem::directory_iterator(std::string(UGOKI_SOURCE_DIR) + "/tests/fuzz/seeds/" + folder))
      files.push_back(e.path());
  std::sort(files.begin(), files.end());
  std::vector<std::string> out;
  for (const auto& file : files) {
    std::ifstream in(file, std::ios::binary);
    out.emplace_back(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
  }
  return out;
}

std::size_t below(Random& random, std::size_t n) { return n == 0 ? 0 : static_cast<std::size_t>(random() % n); }

/// Position and length of a number or a quoted text at or after a random position; length 0: none found.
std::pair<std::size_t, std::size_t> token(const std::string& s, Random& random, bool number) {
  for (std::size_t at = below(random, s.size()); at < s.size(); ++at) {
    if (number && (std::isdigit(static_cast<unsigned char>(s[at])) != 0 || s[at] == '-')) {
      while (at > 0 && std::string_view("0123456789.eE+-").find(s[at - 1]) != std::string_view::npos) --at;
      const std::size_t end = std::min(s.find_first_not_of("0123456789.eE+-", at), s.size());
      return {at, end - at};
    }
    if (!number && s[at] == '"') {
      const std::size_t end = s.find('"', at + 1);
      if (end != std::string::npos) return {at, end + 1 - at};
    }
  }
  return {0, 0};
}

void change(std::string& s, const std::vector<std::string>& all, Random& random, bool numbers_only) {
  static const std::vector<std::string> numbers = {"0",      "-1",         "1",          "1e-300", "1e300", "-1e300",
                                                   "1e9",    "4294967296", "2147483648", "86400",  "1e-9",  "1000",
                                                   "0.0005", "1e5",        "-0.0",       "3.5",    "1e15",  "18446744073709551615"};
  static const std::vector<std::string> words = {"\"\"",          "\"box\"",       "\"capsule\"",     "\"mesh\"",  "\"floating\"",
                                                 "\"spherical\"", "\"prismatic\"", "\"helical\"",     "\"world\"", "\"a\"",
                                                 "\"b\"",         "\"track\"",     "\"passive\"",     "\"throw\"", "\"push\"",
                                                 "\"ellipsoid\"", "\"planar\"",    "\"height_field\""};
  if (s.empty()) return;
  switch (numbers_only ? 2 : random() % 9) {
    case 0: s[below(random, s.size())] = static_cast<char>(random()); break;
    case 1: s[below(random, s.size())] ^= static_cast<char>(1 << random() % 8); break;
    case 2:
    case 3:
    case 4: {
      const auto [at, size] = token(s, random, true);
      if (size > 0) s.replace(at, size, numbers[below(random, numbers.size())]);
      break;
    }
    case 5: {
      const auto [at, size] = token(s, random, false);
      if (size > 0) s.replace(at, size, words[below(random, words.size())]);
      break;
    }
    case 6: {  // repeats a piece of the input
      const std::size_t at = below(random, s.size()), size = below(random, std::min<std::size_t>(200, s.size() - at));
      s.insert(below(random, s.size()), s.substr(at, size));
      break;
    }
    case 7: s.erase(below(random, s.size()), below(random, 40)); break;
    case 8: {  // inserts a piece of another input
      const std::string& other = all[below(random, all.size())];
      if (other.empty()) break;
      const std::size_t at = below(random, other.size());
      s.insert(below(random, s.size()), other.substr(at, below(random, std::min<std::size_t>(300, other.size() - at))));
      break;
    }
  }
}

/// Calls `target` with `count` changed inputs. Each call must end within seconds, and the process may grow to 1 GiB.
/// @param folders folders with the seeds @param numbers_only true: changes only numbers, so that most inputs are accepted
void run(void (*target)(const std::uint8_t*, std::size_t), int count, std::uint64_t seed, std::initializer_list<const char*> folders,
         bool numbers_only) {
  const std::vector<std::string> all = seeds(folders);
  Random random(seed);
  double longest = 0;
  std::string slowest;
  for (int i = 0; i < count; ++i) {
    std::string input = all[below(random, all.size())];
    for (std::uint64_t k = 1 + random() % 4; k > 0; --k) change(input, all, random, numbers_only);
    if (const char* found = std::getenv("UGOKI_UGX_FOUND"); found != nullptr)  // saves the input that aborts the process
      std::ofstream(std::string(found) + "/current", std::ios::binary) << input;
    const std::clock_t began = std::clock();  // processor time: the machine may be busy
    target(reinterpret_cast<const std::uint8_t*>(input.data()), input.size());
    const double seconds = static_cast<double>(std::clock() - began) / CLOCKS_PER_SEC;
    if (seconds > longest) {
      longest = seconds;
      slowest = input;
    }
    if (const char* found = std::getenv("UGOKI_UGX_FOUND"); found != nullptr && seconds > 0.1)  // saves slow inputs
      std::ofstream(std::string(found) + '/' + std::to_string(static_cast<int>(1000 * seconds)) + "ms-" + std::to_string(seed) + '-' +
                        std::to_string(i),
                    std::ios::binary)
          << input;
    // Limit of the processor time of up to ten steps, s. GuardedStep limits the work of a step; a machine that is half as fast passes too.
    ASSERT_LT(seconds, 1) << "input " << i << " of seed " << seed << "\n" << input;
  }
  rusage use{};
  getrusage(RUSAGE_SELF, &use);
  EXPECT_LT(use.ru_maxrss, 1L << 20) << "kB";
  std::printf("%d inputs, longest call %.3f s, %ld MB\n", count, longest, use.ru_maxrss / 1024);
  if (longest > 0.5) std::printf("%s\n", slowest.c_str());
}

TEST(HostileUgx, SeedsOfThePlayerRun) {
  for (const std::string& seed : seeds({"ugx_run"})) {
    const long before = ugx_runs;
    fuzz_ugx_run(reinterpret_cast<const std::uint8_t*>(seed.data()), seed.size());
    EXPECT_EQ(ugx_runs, before + 1) << seed;
  }
}

/// For debugging: UGOKI_UGX_INPUT names a file with one input; run it with --gtest_also_run_disabled_tests.
TEST(HostileUgx, DISABLED_GivenInputIsRun) {
  const char* path = std::getenv("UGOKI_UGX_INPUT");
  if (path == nullptr) GTEST_SKIP() << "UGOKI_UGX_INPUT is not set";
  std::ifstream in(path, std::ios::binary);
  const std::string input{std::istreambuf_iterator<char>(in), {}};
  const auto began = std::chrono::steady_clock::now();
  fuzz_ugx_run(reinterpret_cast<const std::uint8_t*>(input.data()), input.size());
  std::printf("%.3f s\n", std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count());
}

TEST(HostileUgx, ReaderStandsChangedData) { run(fuzz_ugx, 5'000, 1, {"ugx", "ugx_run"}, false); }
TEST(HostileUgx, PlayerStandsChangedData) {
  const long before = ugx_runs;
  run(fuzz_ugx_run, 2'000, 2, {"ugx_run"}, true);
  EXPECT_GT(ugx_runs - before, 300) << "most inputs were refused before they ran";
}
TEST(SlowHostileUgx, ReaderStandsAMillionChangedData) { run(fuzz_ugx, 1'000'000, 3, {"ugx", "ugx_run"}, false); }
TEST(SlowHostileUgx, PlayerStandsAHundredThousandChangedData) {
  const long before = ugx_runs;
  run(fuzz_ugx_run, 100'000, 4, {"ugx_run"}, false);
  run(fuzz_ugx_run, 700'000, 5, {"ugx_run"}, true);
  EXPECT_GT(ugx_runs - before, 100'000);
}

/// Readers of motion files whose parsers are Ugoki's own. FBX and COLLADA are read by a library in a guard process; scripts/fuzz counts its
/// faults.
struct Reader {
  const char* seeds;
  void (*target)(const std::uint8_t*, std::size_t);
};
constexpr Reader readers[] = {{"mvnx", fuzz_mvnx},       {"usda", fuzz_usda},           {"smpl", fuzz_smpl},
                              {"opensim", fuzz_opensim}, {"deepmimic", fuzz_deepmimic}, {"csv", fuzz_csv}};
class HostileMotions : public testing::TestWithParam<Reader> {};
class SlowHostileMotions : public HostileMotions {};
std::string seeds_of(const testing::TestParamInfo<Reader>& each) { return each.param.seeds; }
INSTANTIATE_TEST_SUITE_P(Each, HostileMotions, testing::ValuesIn(readers), seeds_of);
INSTANTIATE_TEST_SUITE_P(Slow_Each, SlowHostileMotions, testing::ValuesIn(readers), seeds_of);
TEST_P(HostileMotions, ReaderStandsChangedData) { run(GetParam().target, 1'000, 6, {GetParam().seeds}, false); }
TEST_P(SlowHostileMotions, ReaderStandsAMillionChangedData) { run(GetParam().target, 1'000'000, 7, {GetParam().seeds}, false); }
}  // namespace
}  // namespace ugoki
