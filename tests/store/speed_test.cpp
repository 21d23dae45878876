// Measures browsing and searching 100,000 motions on both databases. The target is 50 ms per page; the test prints the times and does not
// check them.

#include <chrono>
#include <functional>
#include <random>

#include "on_both.h"

namespace ugoki::store {
namespace {

constexpr int motions = 100'000;

/// Motion number `i` with a name and tags as in motion capture libraries: subject_trial, action, style, source.
LibraryItem motion_number(int i, std::mt19937& random) {
  const char* actions[] = {"walk", "run", "jump", "turn", "sit", "dance", "kick", "climb", "throw", "fall"};
  const char* styles[] = {"slow", "fast", "left", "right", "old", "child", "happy", "tired", "sneak", "limp"};
  const char* action = actions[random() % 10];
  const std::string subject = std::to_string(i / 100), trial = std::to_string(i % 100);
  std::string name = subject + "_" + trial;
  if (random() % 3) name = std::string(action) + " " + name;
  std::vector<std::string> tags = {random() % 2 ? "cmu" : "own", styles[random() % 10]};
  if (i % 1000 == 0) tags.push_back("checked");
  // Tags of motions that were added together, so that they are adjacent in the order of time.
  if (i >= motions - 5000) tags.push_back("late");
  if (i >= motions - 20'000) tags.push_back("second half");
  if (i < motions / 2) tags.push_back("came first");
  const std::string summary = R"({"mechanism": "m-0123456789abcdef", "frames": )" + std::to_string(random() % 5000) +
                              R"(, "joints": 31, "rate": 120, "duration": )" +
                              std::to_string(static_cast<double>(random() % 100'000) / 1000) + R"(, "cyclic": false, "source": "cmu_)" +
                              subject + "_" + trial + "_" + action + R"(.bvh"})";
  return make_item(EntryKind::motion, name, "data " + std::to_string(i), tags, summary);
}

class SpeedTest : public OnBoth {
 protected:
  struct Pages {
    double first = 0, deep = 0;        ///< time of the first page, and of the slowest later page, ms
    std::size_t found = 0, total = 0;  ///< found: entries on all pages; total: LibraryPage::total of the first page
  };
  /// Minimum time of `repeats` runs, ms.
  static double ms_of(const std::function<void()>& work, int repeats) {
    using clock = std::chrono::steady_clock;
    double minimum = 1e9;
    for (int i = 0; i < repeats; ++i) {
      const auto start = clock::now();
      work();
      minimum = std::min(minimum, std::chrono::duration<double, std::milli>(clock::now() - start).count());
    }
    return minimum;
  }
  /// Measures pages of 100 entries: the first, and one after every 5000 entries.
  static Pages measure(const Library& library, LibraryQuery query) {
    Pages out;
    query.limit = 100;
    Result<LibraryPage> page;
    out.first = ms_of([&] { page = library.find(query); }, 7);
    for (bool first = true;; first = false) {
      if (!page) {
        ADD_FAILURE() << page.error().text();
        return out;
      }
      if (first) out.total = page->total;
      LibraryQuery stride = query;
      stride.limit = 5000;
      const Result<LibraryPage> next = library.find(stride);
      if (!next) {
        ADD_FAILURE() << next.error().text();
        return out;
      }
      out.found += next->entries.size();
      if (next->next.empty()) return out;
      query.after = next->next;
      out.deep = std::max(out.deep, ms_of([&] { page = library.find(query); }, 3));
    }
  }
};

TEST_P(SpeedTest, BrowsesAndSearchesAHundredThousandMotions) {
  const double filling = ms_of(
      [&] {
        Library library = open();
        std::mt19937 random(20260601);
        std::vector<LibraryItem> items;
        for (int i = 0; i < motions; ++i) {
          items.push_back(motion_number(i, random));
          if (items.size() < 5000) continue;
          ASSERT_TRUE(library.put(items));
          items.clear();
        }
      },
      1);
  std::printf("adding %d motions: %.1f s\n", motions, filling / 1000);
  const Library library = open();
  struct Case {
    const char* name;
    LibraryQuery query;
    std::size_t minimum;  ///< lower bound of the count of entries found
  };
  const std::vector<std::string> motion = {"motion"}, usual = {"mechanism", "motion"};
  using enum LibraryOrder;
  const Case cases[] = {
      {"all", {.kinds = usual}, 100'000},
      {"all kinds", {}, 100'000},
      {"a letter", {.text = "w", .kinds = usual}, 5000},
      {"one in ten", {.text = "walk", .kinds = usual}, 5000},
      {"one in ten", {.text = "dance", .kinds = motion}, 5000},
      {"in all sources", {.text = "bvh", .kinds = usual}, 100'000},
      {"one in two", {.text = "cmu own", .kinds = usual}, 20'000},
      {"two words", {.text = "walk slow", .kinds = usual}, 500},
      {"phrase", {.text = "\"walk 51\"", .kinds = usual}, 5},
      {"rare", {.text = "512_7", .kinds = usual}, 1},
      {"numbers", {.text = "51", .kinds = usual}, 100},
      {"nothing", {.text = "xylophone", .kinds = usual}, 0},
      {"frequent tag", {.kinds = usual, .tags = {"cmu"}}, 20'000},
      {"rare tag", {.kinds = usual, .tags = {"checked"}}, 100},
      {"tags", {.text = "jump", .kinds = motion, .tags = {"own", "tired"}}, 100},
      {"came last", {.text = "late", .kinds = usual}, 5000},
      {"came last, many", {.text = "second", .kinds = usual}, 20'000},
      {"tag came last", {.kinds = usual, .tags = {"second half"}}, 20'000},
      {"tag came first", {.kinds = usual, .tags = {"came first"}}, 50'000},
      {"came first", {.text = "came", .kinds = usual}, 50'000},
      {"phrase, first", {.text = "\"came first\"", .kinds = usual}, 50'000},
      {"word came last", {.text = "jump", .kinds = usual, .tags = {"second half"}}, 1000},
  };
  constexpr std::pair<const char*, LibraryOrder> orders[] = {{"relevance", relevance}, {"name", name},       {"newest", newest},
                                                             {"oldest", oldest},       {"longest", longest}, {"shortest", shortest}};
  double worst = 0;
  std::printf("%-16s %-10s  first page  later pages [ms]\n", "search", "order");
  for (const Case& c : cases)
    for (const auto& [order_name, order] : orders) {
      LibraryQuery query = c.query;
      query.order = order;
      const Pages pages = measure(library, query);
      EXPECT_GE(pages.found, c.minimum) << c.name;
      std::printf("%-16s %-10s  %10.1f  %11.1f  %zu found, total %zu\n", c.name, order_name, pages.first, pages.deep, pages.found,
                  pages.total);
      worst = std::max({worst, pages.first, pages.deep});
    }
  std::printf("the slowest page: %.1f ms\n", worst);
  std::printf("all tags with their counts: %.1f ms\n", ms_of([&] { ASSERT_TRUE(library.tags(usual)); }, 3));
}
INSTANTIATE_TEST_SUITE_P(Slow_Databases, SpeedTest, ::testing::Values(DatabaseKind::sqlite, DatabaseKind::postgres), name_of_database);

}  // namespace
}  // namespace ugoki::store
