#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>

#include "ugoki/store/library.h"
#include "ugoki/store/sqlite.h"

namespace ugoki::store {
namespace {

namespace fs = std::filesystem;

class DamagedLibraryTest : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "ugoki-store-XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
    path_ = name + "/library.db";
  }
  void TearDown() override {
    fs::permissions(folder_, fs::perms::owner_all);
    fs::remove_all(folder_);
  }
  std::string read() const {
    std::ifstream in(path_, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  void write(const std::string& bytes) const { std::ofstream(path_, std::ios::binary) << bytes; }
  /// Creates a library with 30 entries and closes it.
  void make() const {
    auto library = Library::open(path_);
    ASSERT_TRUE(library);
    std::vector<LibraryItem> items;
    for (int i = 0; i < 30; ++i)
      items.push_back({EntryKind::motion, "motion " + std::to_string(i), "{}", {"tag"}, std::vector<std::byte>(3000, std::byte(i))});
    ASSERT_TRUE(library->put(items));
  }
  /// Opening must fail with a message and a remedy, and must not change the file.
  void expect_refused(ErrorCode code) const {
    const std::string before = read();
    const auto library = Library::open(path_);
    ASSERT_FALSE(library);
    const Problem& p = library.error().problems.front();
    EXPECT_EQ(p.code, code) << p.text();
    EXPECT_NE(p.location.find("library.db"), std::string::npos) << p.text();
    EXPECT_FALSE(p.message.empty());
    EXPECT_FALSE(p.remedy.empty()) << p.text();
    EXPECT_EQ(read(), before);
  }

  std::string folder_, path_;
};

TEST_F(DamagedLibraryTest, RefusesTextAndForeignDatabases) {
  write("this is no database, but it is longer than a hundred bytes, so that it could be taken for a header by somebody careless");
  expect_refused(ErrorCode::syntax);
  fs::remove(path_);
  {
    auto other = Database::open(path_, OpenMode::create);
    ASSERT_TRUE(other && other->run("CREATE TABLE foreign_table (x)"));
  }
  expect_refused(ErrorCode::syntax);
}

TEST_F(DamagedLibraryTest, RefusesNewerVersions) {
  make();
  {
    auto database = Database::open(path_, OpenMode::read_write);
    ASSERT_TRUE(database && database->run("PRAGMA user_version = 99; PRAGMA wal_checkpoint(TRUNCATE)"));
  }
  expect_refused(ErrorCode::unsupported);
}

TEST_F(DamagedLibraryTest, RefusesTruncatedFiles) {
  make();
  const std::string whole = read();
  for (const double part : {0.01, 0.1, 0.3, 0.5, 0.9}) {
    write(whole.substr(0, static_cast<std::size_t>(part * static_cast<double>(whole.size()))));
    expect_refused(ErrorCode::syntax);
  }
}

TEST_F(DamagedLibraryTest, NeverCrashesOnFlippedBytes) {
  make();
  const std::string whole = read();
  std::mt19937 random(20260301);
  int refused = 0, damaged = 0, fine = 0;
  for (int round = 0; round < 60; ++round) {
    std::string bytes = whole;
    for (int i = 0; i < 20; ++i) bytes[random() % bytes.size()] = static_cast<char>(random());
    write(bytes);
    for (const char* suffix : {"-wal", "-shm"}) fs::remove(path_ + suffix);
    const auto library = Library::open(path_);
    if (!library) {
      ++refused;
      EXPECT_FALSE(library.error().problems.front().remedy.empty());
      continue;
    }
    const auto page = library->find();
    bool good = page.has_value();
    if (page)
      for (const LibraryEntry& e : page->entries) good = library->data(e.id).has_value() && good;  // data() must check the hash
    ++(good ? fine : damaged);
  }
  EXPECT_EQ(refused + damaged + fine, 60);
  EXPECT_GT(refused, 0);
  EXPECT_GT(damaged, 0);
}

TEST_F(DamagedLibraryTest, ReadingDamagedDataFails) {
  make();
  std::string bytes = read();
  const std::string run(1000, '\x07');
  const auto at = bytes.find(run);
  ASSERT_NE(at, std::string::npos);
  bytes[at + 5] = 'X';
  write(bytes);
  const auto library = Library::open(path_);
  ASSERT_TRUE(library) << library.error().text();
  const auto entry = library->resolve("motion 7");
  ASSERT_TRUE(entry);
  const auto data = library->data(entry->id);
  ASSERT_FALSE(data);
  EXPECT_EQ(data.error().problems.front().code, ErrorCode::syntax);
}

TEST_F(DamagedLibraryTest, FullDiskIsReportedAsAnError) {
  make();
  auto database = Database::open(path_, OpenMode::read_write);
  ASSERT_TRUE(database);
  const auto pages = database->integer("PRAGMA page_count");
  ASSERT_TRUE(pages && database->run("PRAGMA max_page_count = " + std::to_string(*pages)));  // the file cannot grow, as on a full disk
  auto transaction = Transaction::begin(*database);
  ASSERT_TRUE(transaction);
  const auto full = database->run("INSERT INTO blob (hash, size, bytes) SELECT id, 1, zeroblob(1000000) FROM entry");
  ASSERT_FALSE(full);
  EXPECT_EQ(full.error().problems.front().code, ErrorCode::io);
  EXPECT_NE(full.error().text().find("full"), std::string::npos);
}

TEST_F(DamagedLibraryTest, LockedLibraryIsAConflict) {
  make();
  auto holder = Database::open(path_, OpenMode::read_write);
  ASSERT_TRUE(holder && holder->run("PRAGMA locking_mode = EXCLUSIVE; PRAGMA journal_mode = DELETE; BEGIN EXCLUSIVE"));
  auto library = Library::open_read_only(path_);
  ASSERT_FALSE(library);
  EXPECT_EQ(library.error().problems.front().code, ErrorCode::conflict) << library.error().text();
}

TEST_F(DamagedLibraryTest, ReadingLeavesNoSideFiles) {
  make();
  {
    auto library = Library::open_read_only(path_);
    ASSERT_TRUE(library) << library.error().text();
    EXPECT_EQ(library->find()->entries.size(), 30u);
    const std::vector<LibraryItem> items = {{EntryKind::motion, "more", "{}", {}, {std::byte(1)}}};
    EXPECT_FALSE(library->put(items)) << "a library opened read-only should not be changed";
  }
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder_)) names.push_back(entry.path().filename());
  EXPECT_EQ(names, std::vector<std::string>{"library.db"});
}

TEST_F(DamagedLibraryTest, NewLibrariesArePrivate) {
  const auto library = Library::open(path_);
  ASSERT_TRUE(library);
  for (const char* suffix : {"", "-wal", "-shm"}) {
    struct stat info{};
    ASSERT_EQ(::stat((path_ + suffix).c_str(), &info), 0) << suffix;
    EXPECT_EQ(info.st_mode & 0777, 0600u) << suffix;
  }
}

TEST_F(DamagedLibraryTest, UnreachableLocationsAreReported) {
  const auto missing = Library::open_read_only(folder_ + "/none.db");
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().problems.front().code, ErrorCode::io);
  EXPECT_NE(missing.error().text().find("does not exist"), std::string::npos) << missing.error().text();
  for (const bool read_only : {false, true}) {
    const auto folder = read_only ? Library::open_read_only(folder_) : Library::open(folder_);
    ASSERT_FALSE(folder);
    EXPECT_NE(folder.error().text().find("folder"), std::string::npos) << folder.error().text();
  }
  const auto below_file = Library::open("/dev/null/library.db");
  ASSERT_FALSE(below_file);
  EXPECT_FALSE(below_file.error().problems.front().remedy.empty());
}

TEST_F(DamagedLibraryTest, DamagedLogIsReportedAndKept) {
  const std::string crashed = folder_ + "/crashed.db";
  {
    auto library = Library::open(path_);
    ASSERT_TRUE(library);
    EXPECT_FALSE(library->warning());
    for (int i = 0; i < 5; ++i)
      ASSERT_TRUE(library->put(std::vector<LibraryItem>{
          {EntryKind::motion, "motion " + std::to_string(i), "{}", {"tag"}, std::vector<std::byte>(3000, std::byte(i))}}));
    fs::copy_file(path_, crashed);
    fs::copy_file(path_ + "-wal", crashed + "-wal");
  }
  std::fstream log(crashed + "-wal", std::ios::binary | std::ios::in | std::ios::out);
  log.seekp(static_cast<std::streamoff>(fs::file_size(crashed + "-wal") / 2));
  log << std::string(64, 'U');
  log.close();
  {
    const auto look = Library::open_read_only(crashed);
    ASSERT_TRUE(look) << look.error().text();
    ASSERT_TRUE(look->warning());
  }
  const auto library = Library::open(crashed);
  ASSERT_TRUE(library) << library.error().text();
  ASSERT_TRUE(library->warning());
  EXPECT_NE(library->warning()->message.find("kept: " + folder_ + "/crashed (rescued "), std::string::npos) << library->warning()->text();
}

}  // namespace
}  // namespace ugoki::store
