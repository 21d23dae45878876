// A hundred thousand motions: browsing and searching within 50 ms, on both databases.

#include <chrono>
#include <random>

#include "on_both.h"
#include "ugoki/store/copy.h"

namespace ugoki::store {
namespace {

constexpr int motions = 100'000;

/// Names and tags as libraries of motion capture have them: subject_trial, what is done, how, where it comes from.
LibraryItem motion_number(int i, std::mt19937& random) {
  const char* actions[] = {"walk", "run", "jump", "turn", "sit", "dance", "kick", "climb", "throw", "fall"};
  const char* ways[] = {"slow", "fast", "left", "right", "old", "child", "happy", "tired", "sneak", "limp"};
  const char* action = actions[random() % 10];
  const std::string subject = std::to_string(i / 100), trial = std::to_string(i % 100);
  std::string name = subject + "_" + trial;
  if (random() % 3) name = std::string(action) + " " + name;
  std::vector<std::string> tags = {random() % 2 ? "cmu" : "own", ways[random() % 10]};
  if (i % 1000 == 0) tags.push_back("checked");
  const std::string summary = R"({"mechanism": "m-0123456789abcdef", "frames": )" + std::to_string(random() % 5000) +
                              R"(, "joints": 31, "rate": 120, "duration": )" +
                              std::to_string(static_cast<double>(random() % 100'000) / 1000) + R"(, "cyclic": false, "source": "cmu_)" +
                              subject + "_" + trial + "_" + action + R"(.bvh"})";
  return make_item(EntryKind::motion, name, "data " + std::to_string(i), tags, summary);
}

class SpeedTest : public OnBoth {};

TEST_P(SpeedTest, AHundredThousandMotionsAreBrowsedAndSearched) {
  using clock = std::chrono::steady_clock;
  const auto ms = [](clock::duration d) { return std::chrono::duration<double, std::milli>(d).count(); };
  const auto began = clock::now();
  {
    Library library = open();
    std::mt19937 random(20260601);
    std::vector<LibraryItem> items;
    for (int i = 0; i < motions; ++i) {
      items.push_back(motion_number(i, random));
      if (items.size() < 5000) continue;
      ASSERT_TRUE(library.put(items));
      items.clear();
    }
  }
  std::printf("putting in %d motions: %.1f s\n", motions, ms(clock::now() - began) / 1000);
  Library library = open();
  struct Case {
    const char* what;
    LibraryQuery query;
    std::size_t least;  ///< found
  };
  const std::vector<std::string> motion = {"motion"}, usual = {"mechanism", "motion"};
  using enum LibraryOrder;
  const Case cases[] = {
      {"all, by name", {.kinds = usual, .limit = 100}, 100},
      {"all, newest", {.kinds = usual, .limit = 100, .order = newest}, 100},
      {"all, longest", {.limit = 100, .order = longest}, 100},
      {"a letter", {.text = "w", .kinds = usual, .limit = 100, .order = relevance}, 100},
      {"frequent word", {.text = "walk", .kinds = usual, .limit = 100, .order = relevance}, 100},
      {"in all sources", {.text = "bvh", .kinds = usual, .limit = 100, .order = relevance}, 100},
      {"in all, newest", {.text = "cmu", .kinds = usual, .limit = 100, .order = newest}, 100},
      {"two words", {.text = "walk slow", .kinds = usual, .limit = 100, .order = relevance}, 100},
      {"rare", {.text = "512_7", .kinds = usual, .limit = 100, .order = relevance}, 1},
      {"numbers", {.text = "51", .kinds = usual, .limit = 100, .order = relevance}, 100},
      {"nothing", {.text = "xylophone", .kinds = usual, .limit = 100, .order = relevance}, 0},
      {"frequent tag", {.kinds = usual, .tags = {"cmu"}, .limit = 100}, 100},
      {"rare tag", {.kinds = usual, .tags = {"checked"}, .limit = 100}, 100},
      {"word and tags", {.text = "jump", .kinds = motion, .tags = {"own", "tired"}, .limit = 100}, 100},
      {"word, longest", {.text = "dance", .kinds = motion, .limit = 100, .order = longest}, 100},
      {"last by name", {.text = "walk 9", .kinds = motion, .limit = 100, .order = relevance}, 100},
  };
  double worst = 0;
  for (const Case& c : cases) {
    double least = 1e9, first = 0;
    std::size_t found = 0, total = 0;
    for (int repeat = 0; repeat < 15; ++repeat) {
      const auto start = clock::now();
      const auto page = library.find(c.query);
      const double took = ms(clock::now() - start);
      ASSERT_TRUE(page) << page.error().text();
      if (repeat == 0) first = took;
      least = std::min(least, took);
      found = page->entries.size();
      total = page->total;
    }
    EXPECT_GE(found, c.least) << c.what;
    std::printf("%-16s %6.1f ms (the first time %6.1f)  %zu of %zu\n", c.what, least, first, found, total);
    worst = std::max(worst, least);
  }
  // Page after page to the end of a long answer.
  LibraryQuery query{.text = "walk", .kinds = usual, .limit = 500, .order = relevance};
  double slowest = 0;
  std::size_t all = 0;
  do {
    double least = 1e9;
    Result<LibraryPage> page;
    for (int repeat = 0; repeat < 3; ++repeat) {
      const auto start = clock::now();
      page = library.find(query);
      least = std::min(least, ms(clock::now() - start));
      ASSERT_TRUE(page) << page.error().text();
    }
    slowest = std::max(slowest, least);
    all += page->entries.size();
    query.after = page->next;
  } while (!query.after.empty());
  std::printf("the slowest of the pages of 500 of %zu found: %.1f ms; the slowest of all questions above: %.1f ms\n", all, slowest, worst);
  EXPECT_GT(all, 5000u);
  const auto start = clock::now();
  ASSERT_TRUE(library.tags(usual));
  std::printf("all tags with their counts: %.1f ms\n", ms(clock::now() - start));
}
INSTANTIATE_TEST_SUITE_P(Slow_Databases, SpeedTest, ::testing::Values(Which::sqlite, Which::postgres), name_of_database);

}  // namespace
}  // namespace ugoki::store
