#include "ugoki/store/library.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

namespace ugoki::store {
namespace {

namespace fs = std::filesystem;

class LibraryTest : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "ugoki-store-XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
    path_ = name + "/deep/library.db";
  }
  void TearDown() override { fs::remove_all(folder_); }
  static std::vector<std::byte> bytes(std::string_view text) {
    const auto* p = reinterpret_cast<const std::byte*>(text.data());
    return {p, p + text.size()};
  }
  static LibraryItem item(EntryKind kind, std::string name, std::string_view data, std::vector<std::string> tags = {},
                          std::string summary = "{}") {
    return {kind, std::move(name), std::move(summary), std::move(tags), bytes(data)};
  }
  static std::vector<std::string> names(const Result<std::vector<LibraryEntry>>& entries) {
    std::vector<std::string> out;
    if (entries)
      for (const LibraryEntry& e : *entries) out.push_back(e.name);
    return out;
  }

  std::string folder_, path_;
};

TEST_F(LibraryTest, PutsAndGets) {
  auto library = Library::open(path_);
  ASSERT_TRUE(library) << library.error().text();
  const std::vector<LibraryItem> items = {item(EntryKind::mechanism, "walker", "body", {"human", "b"}, R"({"mass": 70.5})"),
                                          item(EntryKind::motion, "walk", "motion", {"b"})};
  const auto ids = library->put(items);
  ASSERT_TRUE(ids) << ids.error().text();
  ASSERT_EQ(ids->size(), 2u);
  EXPECT_TRUE((*ids)[0].starts_with("m-"));
  EXPECT_TRUE((*ids)[1].starts_with("n-"));
  const auto entry = library->get((*ids)[0]);
  ASSERT_TRUE(entry);
  EXPECT_EQ(entry->name, "walker");
  EXPECT_EQ(entry->kind, EntryKind::mechanism);
  EXPECT_EQ(entry->summary, R"({"mass": 70.5})");
  EXPECT_EQ(entry->tags, (std::vector<std::string>{"b", "human"}));
  EXPECT_EQ(entry->size, 4u);
  EXPECT_EQ(entry->created.size(), 20u);
  EXPECT_EQ(library->data((*ids)[1]), bytes("motion"));
  EXPECT_FALSE(library->get("m-none"));
}

TEST_F(LibraryTest, SurvivesReopening) {
  std::string id;
  {
    auto library = Library::open(path_);
    ASSERT_TRUE(library);
    id = library->put(std::vector{item(EntryKind::motion, "walk", "abc")})->front();
  }
  auto again = Library::open(path_);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->data(id), bytes("abc"));
  auto looking = Library::open_read_only(path_);
  ASSERT_TRUE(looking) << looking.error().text();
  EXPECT_EQ(names(looking->find()), std::vector<std::string>{"walk"});
  EXPECT_FALSE(looking->rename(id, "other"));
}

TEST_F(LibraryTest, EqualDataAreOneEntry) {
  auto library = Library::open(path_);
  ASSERT_TRUE(library);
  const auto first = library->put(std::vector{item(EntryKind::motion, "walk", "abc", {"one"})});
  const auto second = library->put(std::vector{item(EntryKind::motion, "other name", "abc", {"two"})});
  ASSERT_TRUE(first && second);
  EXPECT_EQ(*first, *second);
  EXPECT_EQ(names(library->find()), std::vector<std::string>{"walk"});
  EXPECT_EQ(library->get(first->front())->tags, (std::vector<std::string>{"one", "two"}));
}

TEST_F(LibraryTest, AllItemsOrNone) {
  auto library = Library::open(path_);
  ASSERT_TRUE(library);
  EXPECT_FALSE(library->put(std::vector{item(EntryKind::motion, "good", "abc"), item(EntryKind::motion, "", "def")}));
  EXPECT_FALSE(
      library->put(std::vector{item(EntryKind::motion, "good", "abc"), item(EntryKind::motion, "summary is no JSON", "def", {}, "{")}));
  EXPECT_TRUE(names(library->find()).empty());
}

TEST_F(LibraryTest, FindsByTextKindAndTag) {
  auto library = Library::open(path_);
  ASSERT_TRUE(library);
  ASSERT_TRUE(library->put(
      std::vector{item(EntryKind::motion, "12_01 Walk", "1", {"cmu", "slow"}, R"({"source": "cmu_12_01_walk.bvh", "frames": 524})"),
                  item(EntryKind::motion, "run", "2", {"cmu"}, R"({"source": "02_03.amc"})"), item(EntryKind::mechanism, "Walker", "3")}));
  const auto find = [&](std::string text, std::vector<std::string> kinds = {}, std::vector<std::string> tags = {}) {
    return names(library->find({std::move(text), std::move(kinds), std::move(tags), 100}));
  };
  EXPECT_EQ(find(""), (std::vector<std::string>{"Walker", "12_01 Walk", "run"}));
  EXPECT_EQ(find("walk"), (std::vector<std::string>{"Walker", "12_01 Walk"}));
  EXPECT_EQ(find("WALK", {"motion"}), std::vector<std::string>{"12_01 Walk"});
  EXPECT_EQ(find("12_01"), std::vector<std::string>{"12_01 Walk"});
  EXPECT_EQ(find("amc"), std::vector<std::string>{"run"});
  EXPECT_EQ(find("", {}, {"cmu"}), (std::vector<std::string>{"12_01 Walk", "run"}));
  EXPECT_EQ(find("", {}, {"cmu", "slow"}), std::vector<std::string>{"12_01 Walk"});
  EXPECT_TRUE(find("frames").empty()) << "names of summary fields are not text to find";
  EXPECT_TRUE(find("\" OR 1 --").empty());
  EXPECT_TRUE(find("%").empty());
  EXPECT_FALSE(library->find({"", {"nonsense"}, {}, 10}));
}

TEST_F(LibraryTest, RenamesTagsRemoves) {
  auto library = Library::open(path_);
  ASSERT_TRUE(library);
  const std::string id = library->put(std::vector{item(EntryKind::motion, "walk", "1", {"a"})})->front();
  ASSERT_TRUE(library->rename(id, "stroll"));
  EXPECT_EQ(names(library->find({"stroll", {}, {}, 100})), std::vector<std::string>{"stroll"});
  EXPECT_TRUE(names(library->find({"walk", {}, {}, 100})).empty());
  const std::vector<std::string> add = {"x", "y"}, remove = {"a", "never there"};
  ASSERT_TRUE(library->set_tags(id, add, remove));
  EXPECT_EQ(library->get(id)->tags, add);
  EXPECT_FALSE(library->rename(id, ""));
  EXPECT_FALSE(library->rename("n-none", "name"));
  EXPECT_FALSE(library->set_tags("n-none", add, {}));
  ASSERT_TRUE(library->remove(id));
  EXPECT_FALSE(library->remove(id));
  EXPECT_FALSE(library->data(id));
  EXPECT_TRUE(names(library->find({"stroll", {}, {}, 100})).empty());
}

TEST_F(LibraryTest, ResolvesNamesIdsAndBeginnings) {
  auto library = Library::open(path_);
  ASSERT_TRUE(library);
  const auto ids = library->put(
      std::vector{item(EntryKind::motion, "walk", "1"), item(EntryKind::mechanism, "walk", "2"), item(EntryKind::motion, "run", "3")});
  ASSERT_TRUE(ids);
  EXPECT_EQ(library->resolve("run")->id, (*ids)[2]);
  EXPECT_EQ(library->resolve((*ids)[1])->id, (*ids)[1]);
  EXPECT_EQ(library->resolve((*ids)[0].substr(0, 10))->id, (*ids)[0]);
  EXPECT_EQ(library->resolve("walk", "motion")->id, (*ids)[0]);
  const auto several = library->resolve("walk");
  ASSERT_FALSE(several);
  EXPECT_EQ(several.error().problems.front().code, ErrorCode::duplicate);
  EXPECT_FALSE(library->resolve("nothing"));
}

TEST_F(LibraryTest, DefaultPathFollowsTheEnvironment) {
  const char* before = std::getenv("UGOKI_LIBRARY");
  const std::string kept = before ? before : "";
  ::setenv("UGOKI_LIBRARY", "/somewhere/library.db", 1);
  EXPECT_EQ(Library::default_path(), "/somewhere/library.db");
  ::unsetenv("UGOKI_LIBRARY");
  EXPECT_TRUE(Library::default_path().ends_with("/ugoki/library.db"));
  if (before) ::setenv("UGOKI_LIBRARY", kept.c_str(), 1);
}

TEST_F(LibraryTest, KilledWriterLosesNothingAcknowledged) {
  ASSERT_TRUE(Library::open(path_));
  int pipe_ends[2];
  ASSERT_EQ(::pipe(pipe_ends), 0);
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    auto library = Library::open(path_);
    for (int i = 0; library; ++i) {
      if (!library->put(std::vector{item(EntryKind::motion, "motion " + std::to_string(i), std::string(20000, 'x') + std::to_string(i))}))
        break;
      if (::write(pipe_ends[1], "+", 1) != 1) break;
    }
    ::_exit(0);
  }
  ::close(pipe_ends[1]);
  char ack = 0;
  int acknowledged = 0;
  while (acknowledged < 25 && ::read(pipe_ends[0], &ack, 1) == 1) ++acknowledged;
  ::kill(child, SIGKILL);
  while (::read(pipe_ends[0], &ack, 1) == 1) ++acknowledged;
  ::close(pipe_ends[0]);
  ::waitpid(child, nullptr, 0);
  auto library = Library::open(path_);
  ASSERT_TRUE(library) << library.error().text();
  const auto entries = library->find();
  ASSERT_TRUE(entries);
  EXPECT_GE(entries->size(), static_cast<std::size_t>(acknowledged));
  EXPECT_LE(entries->size(), static_cast<std::size_t>(acknowledged) + 1);
  for (const LibraryEntry& e : *entries) EXPECT_TRUE(library->data(e.id));
}

}  // namespace
}  // namespace ugoki::store
