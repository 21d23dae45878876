// Upgrade of libraries of schema version 1, which had one table of data and no versions.

#include <fstream>

#include "on_both.h"
#include "ugoki/store/sqlite.h"

namespace ugoki::store {
namespace {

/// The tables of schema version 1.
constexpr const char* version_1 = R"(
CREATE TABLE entry (id TEXT PRIMARY KEY NOT NULL, kind TEXT NOT NULL CHECK (kind IN ('mechanism', 'motion', 'measured')),
  name TEXT NOT NULL CHECK (length(name) > 0), summary TEXT NOT NULL DEFAULT '{}', created TEXT NOT NULL, size INTEGER NOT NULL) STRICT;
CREATE INDEX entry_by_name ON entry (kind, name);
CREATE TABLE tag (entry TEXT NOT NULL REFERENCES entry (id) ON DELETE CASCADE, tag TEXT NOT NULL CHECK (length(tag) > 0),
  PRIMARY KEY (entry, tag)) STRICT, WITHOUT ROWID;
CREATE TABLE data (entry TEXT PRIMARY KEY NOT NULL REFERENCES entry (id) ON DELETE CASCADE, bytes BLOB NOT NULL) STRICT;
CREATE VIRTUAL TABLE entry_text USING fts5(id UNINDEXED, words, prefix='2 3');
PRAGMA application_id = 1430735692; PRAGMA user_version = 1; PRAGMA journal_mode = WAL;
)";

class MigrationTest : public ::testing::Test {
 protected:
  void SetUp() override {
    auto database = Database::open(path(), OpenMode::create);
    ASSERT_TRUE(database && database->run(version_1));
    auto entry = database->prepare(
        "INSERT INTO entry VALUES (?1, 'motion', ?2, '{\"frames\": 3, \"source\": \"old.bvh\"}', '2026-03-01T12:00:00Z', 5)");
    auto data = database->prepare("INSERT INTO data VALUES (?1, ?2)");
    auto tag = database->prepare("INSERT INTO tag VALUES (?1, 'old')");
    ASSERT_TRUE(entry && data && tag);
    for (int i = 0; i < 250; ++i) {
      const std::vector<std::byte> bytes = bytes_of("data " + std::to_string(i));
      const std::string id =
          entry_id(EntryKind::motion, i == 7 ? bytes_of("what it was") : bytes);  // the data of entry 7 do not match its id
      ASSERT_TRUE(entry->bind(1, id).bind(2, "motion " + std::to_string(i)).run() && data->bind(1, id).bind_blob(2, bytes).run() &&
                  tag->bind(1, id).run());
    }
  }
  std::string path() const { return folder_.path() + "/library.db"; }
  TemporaryFolder folder_;
};

TEST_F(MigrationTest, UpgradeKeepsAllEntries) {
  std::ifstream before(path(), std::ios::binary);
  const std::string bytes(std::istreambuf_iterator<char>(before), {});
  {
    const auto read_only = Library::open_read_only(path());
    ASSERT_TRUE(read_only) << read_only.error().text();
    EXPECT_EQ(read_only->find()->entries.size(), 250u);
  }
  std::ifstream after(path(), std::ios::binary);
  EXPECT_TRUE(bytes == std::string(std::istreambuf_iterator<char>(after), {})) << "reading must not change the file";
  auto library = Library::open(path());
  ASSERT_TRUE(library) << library.error().text();
  EXPECT_EQ(library->find()->entries.size(), 250u);
  for (int i = 0; i < 250; i += 13) {
    const std::string id = entry_id(EntryKind::motion, bytes_of("data " + std::to_string(i)));
    const auto entry = library->get(id);
    ASSERT_TRUE(entry) << entry.error().text();
    EXPECT_EQ(entry->name, "motion " + std::to_string(i));
    EXPECT_EQ(entry->created, "2026-03-01T12:00:00Z");
    EXPECT_EQ(entry->tags, std::vector<std::string>{"old"});
    EXPECT_EQ(entry->version, 1);
    EXPECT_EQ(entry->content, id);
    EXPECT_EQ(library->data(id), bytes_of("data " + std::to_string(i)));
    EXPECT_EQ(library->content(id), bytes_of("data " + std::to_string(i)));
  }
  EXPECT_EQ(names_of(library->find({.text = "motion 249", .tags = {"old"}})), std::vector<std::string>{"motion 249"});
  EXPECT_EQ(library->find({.text = "old.bvh"})->total, 250u);
  const auto damaged = library->data(entry_id(EntryKind::motion, bytes_of("what it was")));
  ASSERT_FALSE(damaged) << "data that were damaged before the upgrade must not be returned";
  const auto check = library->check(false);
  ASSERT_TRUE(check);
  EXPECT_EQ(check->problems.problems.size(), 1u) << check->problems.text();
  const std::string id = entry_id(EntryKind::motion, bytes_of("data 0"));
  EXPECT_TRUE(library->save({.id = id, .base = 1, .data = bytes_of("new")}));
}

TEST_F(MigrationTest, FailedUpgradeLeavesTheOldLibraryUnchanged) {
  {
    auto database = Database::open(path(), OpenMode::read_write);
    ASSERT_TRUE(database && database->run("CREATE TABLE blob (in_the_way)"));
  }
  EXPECT_FALSE(Library::open(path()));
  auto database = Database::open(path(), OpenMode::read_write);
  ASSERT_TRUE(database && database->run("DROP TABLE blob"));
  EXPECT_EQ(*database->integer("SELECT count(*) FROM data"), 250);
  EXPECT_EQ(*database->integer("PRAGMA user_version"), 1);
  EXPECT_TRUE(Library::open(path()));
}

}  // namespace
}  // namespace ugoki::store
