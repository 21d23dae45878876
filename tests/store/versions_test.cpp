// Versions, conflicts, the trash and checks, on both databases.

#include <algorithm>
#include <chrono>
#include <thread>

#include "on_both.h"
#include "ugoki/store/sqlite.h"

namespace ugoki::store {
namespace {

class VersionsTest : public OnBoth {
 protected:
  static Result<LibraryEntry> save(Library& library, const std::string& id, int base, std::string_view data, std::string author = "anna") {
    library.set_author(std::move(author));
    return library.save({.id = id, .base = base, .data = bytes_of(data)});
  }
};
/// Whether a change of another connection arrives within 20 s; PostgreSQL delivers notifications with a delay.
bool sees_a_change(Library& library) {
  for (int i = 0; i < 2000; ++i) {
    const Result<bool> changed = library.changed_elsewhere();
    if (!changed || *changed) return changed.has_value();
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

TEST_P(VersionsTest, ChangesOfOtherConnectionsAreReported) {
  Library mine = open(), other = open();
  EXPECT_EQ(mine.changed_elsewhere(), false);
  const auto id = other.put(std::vector{make_item(EntryKind::motion, "walk", "1")});
  ASSERT_TRUE(id);
  EXPECT_TRUE(sees_a_change(mine));
  EXPECT_EQ(mine.changed_elsewhere(), false);
  ASSERT_TRUE(mine.rename(id->front(), "run"));
  EXPECT_EQ(mine.changed_elsewhere(), false) << "a change of the connection itself";
  EXPECT_EQ(other.changed_elsewhere(), false) << "the first call";
  ASSERT_TRUE(mine.rename(id->front(), "jump"));
  EXPECT_TRUE(sees_a_change(other));
}

UGOKI_ON_BOTH(VersionsTest);

TEST_P(VersionsTest, EachSaveAddsAnImmutableVersion) {
  Library library = open();
  const std::string id = library.put(std::vector{make_item(EntryKind::motion, "walk", "one", {"t"}, R"({"duration": 1})")})->front();
  const auto second = save(library, id, 1, "two");
  ASSERT_TRUE(second) << second.error().text();
  EXPECT_EQ(second->id, id);
  EXPECT_EQ(second->version, 2);
  EXPECT_EQ(second->author, "anna");
  EXPECT_NE(second->content, id);
  EXPECT_EQ(second->tags, std::vector<std::string>{"t"});
  library.set_author("ben");
  const auto third =
      library.save({.id = id, .base = 2, .name = "stroll", .summary = R"({"duration": 2, "source": "x.bvh"})", .note = "slower"});
  ASSERT_TRUE(third) << third.error().text();
  EXPECT_EQ(third->version, 3);
  EXPECT_EQ(third->content, second->content) << "the data are the same";
  EXPECT_EQ(library.data(id), bytes_of("two"));
  EXPECT_EQ(library.data(id, 1), bytes_of("one"));
  EXPECT_EQ(library.data(id, 3), bytes_of("two"));
  EXPECT_FALSE(library.data(id, 4));
  EXPECT_EQ(library.content(id), bytes_of("one")) << "a content id identifies the data, not the entry";
  EXPECT_EQ(library.content(second->content), bytes_of("two"));
  EXPECT_EQ(library.get(second->content)->id, id) << "an entry is found by the content id of any version";
  EXPECT_FALSE(library.content("n-0000000000000000"));

  const auto history = library.history(id);
  ASSERT_TRUE(history);
  ASSERT_EQ(history->size(), 3u);
  EXPECT_EQ((*history)[0].version, 3);
  EXPECT_EQ((*history)[0].author, "ben");
  EXPECT_EQ((*history)[0].note, "slower");
  EXPECT_EQ((*history)[2].name, "walk");
  EXPECT_EQ((*history)[2].content, id);
  EXPECT_GE((*history)[0].saved, (*history)[1].saved);
  EXPECT_EQ(names_of(library.find({.text = "slower"})), std::vector<std::string>{"stroll"});
  EXPECT_EQ(names_of(library.find({.text = "x.bvh"})), std::vector<std::string>{"stroll"});

  const auto same = library.save({.id = id, .base = 3, .name = "stroll", .data = bytes_of("two")});
  ASSERT_TRUE(same);
  EXPECT_EQ(same->version, 3) << "a save without changes adds no version";

  const auto restored = library.restore(id, 3, 1);
  ASSERT_TRUE(restored) << restored.error().text();
  EXPECT_EQ(restored->version, 4);
  EXPECT_EQ(restored->name, "walk");
  EXPECT_EQ(restored->summary, R"({"duration": 1})");
  EXPECT_EQ(library.data(id), bytes_of("one"));
  EXPECT_FALSE(library.restore(id, 4, 9));
  // Importing known data again changes nothing.
  EXPECT_EQ(library.put(std::vector{make_item(EntryKind::motion, "walk", "one")})->front(), id);
  EXPECT_EQ(library.get(id)->version, 4);
}

TEST_P(VersionsTest, SecondOfTwoSavesIsAConflictThatNamesTheFirst) {
  Library anna = open(), ben = open();
  const std::string id = anna.put(std::vector{make_item(EntryKind::motion, "walk", "one")})->front();
  ASSERT_TRUE(save(anna, id, 1, "of anna", "anna"));
  const auto lost = save(ben, id, 1, "of ben", "ben");
  ASSERT_FALSE(lost);
  const Problem& p = lost.error().problems.front();
  EXPECT_EQ(p.code, ErrorCode::conflict);
  EXPECT_NE(p.message.find("anna"), std::string::npos) << p.message;
  EXPECT_NE(p.message.find("version 2"), std::string::npos) << p.message;
  EXPECT_NE(p.message.find(anna.get(id)->changed), std::string::npos) << p.message;
  EXPECT_NE(p.location.find(id), std::string::npos) << p.location;
  EXPECT_FALSE(p.remedy.empty());
  EXPECT_EQ(ben.data(id), bytes_of("of anna"));
  EXPECT_EQ(ben.history(id)->size(), 2u);
  ASSERT_TRUE(save(ben, id, 2, "of ben", "ben"));
  EXPECT_EQ(anna.data(id), bytes_of("of ben"));
  EXPECT_EQ(anna.data(id, 2), bytes_of("of anna"));
  EXPECT_FALSE(anna.save({.id = id, .base = 2, .name = "renamed"})) << "a rename is a save and can conflict";
  EXPECT_FALSE(anna.save({.id = id, .base = 0, .name = "renamed"}));
  EXPECT_FALSE(anna.save({.id = id, .base = 4, .name = "renamed"}));
  EXPECT_FALSE(anna.save({.id = "n-none", .base = 1, .name = "x"}));
  EXPECT_FALSE(anna.save({.id = id, .base = 3, .name = ""}));
  EXPECT_FALSE(anna.save({.id = id, .base = 3, .summary = "[]"}));
  EXPECT_EQ(anna.history(id)->size(), 3u);
}

TEST_P(VersionsTest, ConcurrentWritersLoseNoSave) {
  constexpr int writers = 4, saves = 15;
  std::string id;
  {
    Library library = open();
    id = library.put(std::vector{make_item(EntryKind::motion, "counted", "0")})->front();
  }
  std::vector<int> conflicts(writers), failures(writers);
  std::vector<std::thread> threads;
  for (int w = 0; w < writers; ++w)
    threads.emplace_back([&, w] {
      Result<Library> library = Library::open(location_);
      if (!library) {
        failures[static_cast<std::size_t>(w)] = 1000;
        return;
      }
      library->set_author("writer " + std::to_string(w));
      for (int i = 0; i < saves;) {
        const auto now = library->get(id);
        const auto saved =
            library->save({.id = id, .base = now ? now->version : 0, .data = bytes_of(std::to_string(w) + ":" + std::to_string(i))});
        if (saved)
          ++i;
        else if (saved.error().problems.front().code == ErrorCode::conflict)
          ++conflicts[static_cast<std::size_t>(w)];
        else
          ++failures[static_cast<std::size_t>(w)];
        if (failures[static_cast<std::size_t>(w)] > 3) return;
        // Each writer also sets tags and adds entries.
        const std::vector<std::string> tag = {"w" + std::to_string(w) + "-" + std::to_string(i)};
        if (!library->set_tags(id, tag, {})) ++failures[static_cast<std::size_t>(w)];
        if (!library->put(std::vector{make_item(EntryKind::motion, "shared", "shared " + std::to_string(i))}))
          ++failures[static_cast<std::size_t>(w)];
      }
    });
  for (std::thread& t : threads) t.join();
  EXPECT_EQ(failures, std::vector<int>(writers));
  Library library = open();
  const auto history = library.history(id);
  ASSERT_TRUE(history);
  ASSERT_EQ(history->size(), 1u + writers * saves);
  std::vector<int> seen(writers);
  for (auto v = history->rbegin(); v != history->rend(); ++v) {  // oldest first: all saves of each writer must be present in their order
    if (v->version == 1) continue;
    const auto data = library.data(id, v->version);
    ASSERT_TRUE(data);
    const std::string text(reinterpret_cast<const char*>(data->data()), data->size());
    const int w = std::stoi(text);
    EXPECT_EQ(text, std::to_string(w) + ":" + std::to_string(seen[static_cast<std::size_t>(w)]++));
    EXPECT_EQ(v->author, "writer " + std::to_string(w));
  }
  const std::vector<std::string> tags = library.get(id)->tags;
  for (int w = 0; w < writers; ++w)
    for (int i = 1; i <= saves; ++i)
      EXPECT_NE(std::ranges::find(tags, "w" + std::to_string(w) + "-" + std::to_string(i)), tags.end()) << w << " " << i;
  EXPECT_EQ(names_of(library.find({.text = "shared"})).size(), static_cast<std::size_t>(saves) + 1);
  EXPECT_TRUE(library.check(false)->problems.empty()) << library.check(false)->problems.text();
}

TEST_P(VersionsTest, TrashCanBeRestoredOrEmptied) {
  Library library = open();
  const auto ids =
      library.put(std::vector{make_item(EntryKind::motion, "walk", "1", {"t"}), make_item(EntryKind::motion, "run", "2", {"t"})});
  const std::string walk = (*ids)[0], run = (*ids)[1];
  ASSERT_TRUE(library.set_thumbnail(walk, bytes_of("\x89PNG\r\n\x1a\n")));
  library.set_author("ben");
  ASSERT_TRUE(library.remove(walk));
  EXPECT_EQ(names_of(library.find()), std::vector<std::string>{"run"});
  EXPECT_EQ(names_of(library.find({.text = "walk"})), std::vector<std::string>{});
  EXPECT_EQ(names_of(library.find({.tags = {"t"}})), std::vector<std::string>{"run"});
  EXPECT_EQ(names_of(library.find({.removed = true})), std::vector<std::string>{"walk"});
  EXPECT_EQ(names_of(library.find({.text = "wal", .removed = true})), std::vector<std::string>{"walk"});
  const auto refused = library.get(walk);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().text().find("undelete"), std::string::npos);
  EXPECT_EQ(library.get_removed(walk)->removed_by, "ben");
  EXPECT_FALSE(library.get_removed(run));
  EXPECT_FALSE(library.save({.id = walk, .base = 1, .name = "x"}));
  EXPECT_TRUE(library.content(walk)) << "data in the trash are still found by their content id";
  EXPECT_EQ(library.resolve("walk", {}, true)->id, walk);
  EXPECT_FALSE(library.resolve("walk"));
  ASSERT_TRUE(library.undelete(walk));
  EXPECT_FALSE(library.undelete(walk));
  EXPECT_EQ(names_of(library.find({.text = "walk", .tags = {"t"}})), std::vector<std::string>{"walk"});
  EXPECT_TRUE(library.get(walk)->thumbnail);
  EXPECT_EQ(library.data(walk), bytes_of("1"));

  ASSERT_TRUE(library.remove(walk));
  EXPECT_EQ(library.empty_trash("2000-01-01"), 0u);
  EXPECT_EQ(library.collect_garbage(), 0u) << "the trash keeps its data";
  EXPECT_EQ(library.empty_trash(), 1u);
  EXPECT_FALSE(library.get_removed(walk));
  EXPECT_EQ(library.collect_garbage(), 9u) << "the data and the thumbnail";
  EXPECT_FALSE(library.content(walk));
  EXPECT_EQ(library.data(run), bytes_of("2"));
  // Importing the data again restores the entry from the trash.
  ASSERT_TRUE(library.remove(run));
  EXPECT_EQ(library.put(std::vector{make_item(EntryKind::motion, "run", "2", {"again"})})->front(), run);
  EXPECT_EQ(library.get(run)->tags, (std::vector<std::string>{"again", "t"}));
  EXPECT_EQ(names_of(library.find({.text = "run"})), std::vector<std::string>{"run"});
  EXPECT_TRUE(library.check(false)->problems.empty()) << library.check(false)->problems.text();
}

TEST_P(VersionsTest, DuplicateHasItsOwnHistory) {
  Library library = open();
  const std::string id = library.put(std::vector{make_item(EntryKind::motion, "walk", "1", {"t"}, R"({"mechanism": "m-1"})")})->front();
  const auto copy = library.duplicate(id, "walk copy");
  ASSERT_TRUE(copy) << copy.error().text();
  EXPECT_NE(copy->id, id);
  EXPECT_EQ(copy->content, id);
  EXPECT_EQ(copy->tags, std::vector<std::string>{"t"});
  EXPECT_EQ(copy->summary, R"({"mechanism": "m-1"})");
  ASSERT_TRUE(save(library, copy->id, 1, "2"));
  EXPECT_EQ(library.data(id), bytes_of("1"));
  EXPECT_EQ(library.data(copy->id), bytes_of("2"));
  EXPECT_EQ(library.content(id), bytes_of("1"));
  EXPECT_EQ(library.get(id)->name, "walk");
  EXPECT_EQ(library.check(false)->blobs, 2u) << "equal data are stored once";
}

TEST_P(VersionsTest, CheckNamesTheDamagedEntry) {
  Library library = open();
  const auto ids = library.put(std::vector{make_item(EntryKind::motion, "walk", "12345"), make_item(EntryKind::motion, "run", "67890")});
  ASSERT_TRUE(library.check(false)->problems.empty()) << library.check(false)->problems.text();
  if (on_postgres()) {
    EXPECT_EQ(PostgresServer::get()->psql("UPDATE ugoki.blob SET bytes = 'x12345' WHERE bytes = '12345'"), "");
  } else {
    auto database = Database::open(location_, OpenMode::read_write);
    ASSERT_TRUE(database && database->run("UPDATE blob SET bytes = x'7831' WHERE bytes = CAST('12345' AS BLOB)"));
  }
  const auto damaged = library.data((*ids)[0]);
  ASSERT_FALSE(damaged);
  EXPECT_NE(damaged.error().text().find("walk"), std::string::npos) << damaged.error().text();
  EXPECT_EQ(library.data((*ids)[1]), bytes_of("67890"));
  const auto check = library.check(false);
  ASSERT_TRUE(check);
  ASSERT_EQ(check->problems.problems.size(), 1u) << check->problems.text();
  EXPECT_NE(check->problems.text().find((*ids)[0]), std::string::npos) << check->problems.text();
}

}  // namespace
}  // namespace ugoki::store
