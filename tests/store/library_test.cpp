#include "ugoki/store/library.h"

#include "on_both.h"

namespace ugoki::store {
namespace {

class LibraryTest : public OnBoth {};
UGOKI_ON_BOTH(LibraryTest);

TEST_P(LibraryTest, ReturnsTheEntriesThatWerePut) {
  Library library = open();
  const std::vector<LibraryItem> items = {make_item(EntryKind::mechanism, "walker", "body", {"human", "b"}, R"({"mass": 70.5})"),
                                          make_item(EntryKind::motion, "walk", "motion", {"b"})};
  library.set_author("anna");
  const auto ids = library.put(items);
  ASSERT_TRUE(ids) << ids.error().text();
  ASSERT_EQ(ids->size(), 2u);
  EXPECT_TRUE((*ids)[0].starts_with("m-"));
  EXPECT_TRUE((*ids)[1].starts_with("n-"));
  const auto entry = library.get((*ids)[0]);
  ASSERT_TRUE(entry) << entry.error().text();
  EXPECT_EQ(entry->name, "walker");
  EXPECT_EQ(entry->kind, EntryKind::mechanism);
  EXPECT_EQ(entry->summary, R"({"mass": 70.5})");
  EXPECT_EQ(entry->tags, (std::vector<std::string>{"b", "human"}));
  EXPECT_EQ(entry->size, 4u);
  EXPECT_EQ(entry->created.size(), 24u) << entry->created;
  EXPECT_EQ(entry->changed, entry->created);
  EXPECT_EQ(entry->author, "anna");
  EXPECT_EQ(entry->version, 1);
  EXPECT_EQ(entry->content, entry->id);
  EXPECT_EQ(library.data((*ids)[1]), bytes_of("motion"));
  EXPECT_FALSE(library.get("m-none"));
}

TEST_P(LibraryTest, SurvivesReopening) {
  std::string id;
  {
    Library library = open();
    id = library.put(std::vector{make_item(EntryKind::motion, "walk", "abc")})->front();
  }
  Library again = open();
  EXPECT_EQ(again.data(id), bytes_of("abc"));
  auto read_only = Library::open_read_only(location_);
  ASSERT_TRUE(read_only) << read_only.error().text();
  EXPECT_EQ(names_of(read_only->find()), std::vector<std::string>{"walk"});
  EXPECT_FALSE(read_only->rename(id, "other"));
  EXPECT_FALSE(read_only->put(std::vector{make_item(EntryKind::motion, "run", "def")}));
}

TEST_P(LibraryTest, EqualDataAreOneEntry) {
  Library library = open();
  const auto first = library.put(std::vector{make_item(EntryKind::motion, "walk", "abc", {"one"})});
  const auto second = library.put(std::vector{make_item(EntryKind::motion, "other name", "abc", {"two"})});
  ASSERT_TRUE(first && second);
  EXPECT_EQ(*first, *second);
  EXPECT_EQ(names_of(library.find()), std::vector<std::string>{"walk"});
  EXPECT_EQ(library.get(first->front())->tags, (std::vector<std::string>{"one", "two"}));
  EXPECT_EQ(library.history(first->front())->size(), 1u);
}

TEST_P(LibraryTest, PutAddsAllItemsOrNone) {
  Library library = open();
  EXPECT_FALSE(library.put(std::vector{make_item(EntryKind::motion, "good", "abc"), make_item(EntryKind::motion, "", "def")}));
  EXPECT_FALSE(library.put(
      std::vector{make_item(EntryKind::motion, "good", "abc"), make_item(EntryKind::motion, "summary is no JSON", "def", {}, "{")}));
  EXPECT_TRUE(names_of(library.find()).empty());
  const auto check = library.check(false);
  ASSERT_TRUE(check);
  EXPECT_EQ(check->blobs, 0u);
}

TEST_P(LibraryTest, InvalidCharactersOfTextsAreReplaced) {
  Library library = open();
  using namespace std::string_literals;
  const std::string id = library.put(std::vector{make_item(EntryKind::motion, "a\xff\0b "s, "1", {" tag\x01 "})})->front();
  EXPECT_EQ(library.get(id)->name, "a\xef\xbf\xbd"s + "b");
  EXPECT_EQ(library.get(id)->tags, std::vector<std::string>{"tag"});
  const std::string empty = library.put(std::vector{make_item(EntryKind::motion, "no bytes", "")})->front();
  EXPECT_EQ(library.data(empty), std::vector<std::byte>());
}

TEST_P(LibraryTest, NamesHaveAMaximumLength) {
  Library library = open();
  std::string longest, too_long;  // the characters have two bytes, because the limit counts characters
  for (std::size_t i = 0; i < max_name_length; ++i) longest += "\u00e9";
  too_long = longest + "x";
  const auto id = library.put(std::vector{make_item(EntryKind::motion, longest, "1")});
  ASSERT_TRUE(id) << id.error().text();
  const auto refused = [](const auto& result) {
    return !result && result.error().problems.at(0).message.contains("201 characters; at most 200") &&
           !result.error().problems[0].location.empty() && !result.error().problems[0].remedy.empty();
  };
  EXPECT_TRUE(refused(library.put(std::vector{make_item(EntryKind::motion, too_long, "2")})));
  EXPECT_TRUE(refused(library.rename(id->front(), too_long)));
  EXPECT_TRUE(refused(library.duplicate(id->front(), too_long)));
  EXPECT_TRUE(refused(library.save({.id = id->front(), .base = 1, .name = too_long})));
  EXPECT_EQ(library.get(id->front())->name, longest);
  EXPECT_TRUE(library.rename(id->front(), "short"));
}

TEST_P(LibraryTest, RenamesTagsRemoves) {
  Library library = open();
  const std::string id = library.put(std::vector{make_item(EntryKind::motion, "walk", "1", {"a"})})->front();
  ASSERT_TRUE(library.rename(id, "stroll"));
  EXPECT_EQ(names_of(library.find({.text = "stroll"})), std::vector<std::string>{"stroll"});
  EXPECT_TRUE(names_of(library.find({.text = "walk"})).empty());
  const std::vector<std::string> add = {"x", "y"}, remove = {"a", "never there"};
  ASSERT_TRUE(library.set_tags(id, add, remove));
  EXPECT_EQ(library.get(id)->tags, add);
  EXPECT_FALSE(library.rename(id, ""));
  EXPECT_FALSE(library.rename("n-none", "name"));
  EXPECT_FALSE(library.set_tags("n-none", add, {}));
  ASSERT_TRUE(library.remove(id));
  EXPECT_FALSE(library.remove(id));
  EXPECT_FALSE(library.data(id));
  EXPECT_TRUE(names_of(library.find({.text = "stroll"})).empty());
}

TEST_P(LibraryTest, ResolvesNamesIdsAndBeginningsOfIds) {
  Library library = open();
  const auto ids = library.put(std::vector{make_item(EntryKind::motion, "walk", "1"), make_item(EntryKind::mechanism, "walk", "2"),
                                           make_item(EntryKind::motion, "run", "3")});
  ASSERT_TRUE(ids);
  EXPECT_EQ(library.resolve("run")->id, (*ids)[2]);
  EXPECT_EQ(library.resolve((*ids)[1])->id, (*ids)[1]);
  EXPECT_EQ(library.resolve((*ids)[0].substr(0, 10))->id, (*ids)[0]);
  EXPECT_EQ(library.resolve("walk", "motion")->id, (*ids)[0]);
  const auto several = library.resolve("walk");
  ASSERT_FALSE(several);
  EXPECT_EQ(several.error().problems.front().code, ErrorCode::duplicate);
  EXPECT_FALSE(library.resolve("nothing"));
  EXPECT_FALSE(library.resolve("Walk", "motion")) << "a name must match exactly";
}

TEST_P(LibraryTest, KeepsThumbnailsUntilTheDataChange) {
  Library library = open();
  const std::string id = library.put(std::vector{make_item(EntryKind::motion, "walk", "1")})->front();
  EXPECT_EQ(library.thumbnail(id), std::vector<std::byte>());
  EXPECT_FALSE(library.get(id)->thumbnail);
  const std::vector<std::byte> png = bytes_of("\x89PNG\r\n\x1a\n and so on"), webp = bytes_of("RIFFxxxxWEBPVP8 ");
  ASSERT_TRUE(library.set_thumbnail(id, png));
  EXPECT_TRUE(library.get(id)->thumbnail);
  EXPECT_EQ(library.thumbnail(id), png);
  ASSERT_TRUE(library.set_thumbnail(id, webp));
  EXPECT_EQ(library.thumbnail(id), webp);
  EXPECT_FALSE(library.set_thumbnail(id, bytes_of("GIF89a"))) << "neither PNG nor WebP";
  EXPECT_FALSE(library.set_thumbnail(id, std::vector<std::byte>(Library::max_thumbnail + 1, std::byte{0x89})));
  ASSERT_TRUE(library.rename(id, "stroll"));
  EXPECT_EQ(library.thumbnail(id), webp) << "the data are the same";
  LibrarySave save;
  save.id = id;
  save.base = 2;
  save.data = bytes_of("2");
  ASSERT_TRUE(library.save(save));
  EXPECT_FALSE(library.get(id)->thumbnail);
}

TEST_P(LibraryTest, ListsTagsWithTheirCounts) {
  Library library = open();
  ASSERT_TRUE(
      library.put(std::vector{make_item(EntryKind::motion, "a", "1", {"cmu", "walk"}), make_item(EntryKind::motion, "b", "2", {"cmu"}),
                              make_item(EntryKind::mechanism, "c", "3", {"cmu", "body"})}));
  const auto all = library.tags();
  ASSERT_TRUE(all) << all.error().text();
  EXPECT_EQ(*all, (std::vector<std::pair<std::string, std::size_t>>{{"cmu", 3}, {"body", 1}, {"walk", 1}}));
  const auto motions = library.tags(std::vector<std::string>{"motion"});
  ASSERT_TRUE(motions);
  EXPECT_EQ(motions->front().second, 2u);
  EXPECT_EQ(library.count(EntryKind::motion), 2u);
}

TEST_P(LibraryTest, StoresLargeData) {
  Library library = open();
  LibraryItem large = make_item(EntryKind::motion, "large", "");
  large.data.resize(20 << 20);
  for (std::size_t i = 0; i < large.data.size(); ++i) large.data[i] = static_cast<std::byte>(i * 2654435761u >> 13);
  const auto ids = library.put(std::vector{large});
  ASSERT_TRUE(ids) << ids.error().text();
  EXPECT_EQ(library.data(ids->front()), large.data);
}

TEST(LibraryLocation, DefaultComesFromTheEnvironment) {
  const char* before = std::getenv("UGOKI_LIBRARY");
  const std::string kept = before ? before : "";
  ::setenv("UGOKI_LIBRARY", "/somewhere/library.db", 1);
  EXPECT_EQ(Library::default_path(), "/somewhere/library.db");
  ::unsetenv("UGOKI_LIBRARY");
  EXPECT_TRUE(Library::default_path().ends_with("/ugoki/library.db"));
  EXPECT_EQ(Library::folder_of("/somewhere/library.db"), "/somewhere");
  EXPECT_TRUE(Library::folder_of("postgresql://host/db").ends_with("/ugoki"));
  EXPECT_TRUE(Library::exists("postgres://host/db"));
  if (before) ::setenv("UGOKI_LIBRARY", kept.c_str(), 1);
}

}  // namespace
}  // namespace ugoki::store
