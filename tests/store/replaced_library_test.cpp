// Library files that other programs replace, remove or overwrite while they are open or after a crash, and hard links.

#include <sys/wait.h>

#include <csignal>
#include <filesystem>
#include <fstream>

#include "on_both.h"
#include "ugoki/store/sqlite.h"

namespace ugoki::store {
namespace {

namespace fs = std::filesystem;

class ReplacedLibraryTest : public ::testing::Test {
 protected:
  /// Creates a closed library with one entry of this name. @return its path
  std::string make(const std::string& file, const std::string& entry) const {
    const std::string path = folder_.path() + "/" + file;
    Result<Library> library = Library::open(path);
    EXPECT_TRUE(library) << library.error().text();
    add(*library, entry);
    return path;
  }
  static void add(Library& library, const std::string& entry) {
    const auto put = library.put(std::vector{make_item(EntryKind::motion, entry, "data of " + entry)});
    EXPECT_TRUE(put) << put.error().text();
  }
  static Error refused(Library& library, const std::string& entry) {
    const auto put = library.put(std::vector{make_item(EntryKind::motion, entry, "data of " + entry)});
    EXPECT_FALSE(put) << "the change was acknowledged";
    if (put) return {};
    EXPECT_EQ(static_cast<int>(put.error().problems[0].code), static_cast<int>(ErrorCode::conflict));
    return put.error();
  }
  static std::vector<std::string> names(const Library& library) { return names_of(library.find()); }
  static std::vector<std::string> names_at(const std::string& path) {
    const auto library = Library::open_read_only(path);
    return library ? names(*library) : std::vector{library.error().text()};
  }
  std::vector<std::string> rescue_copies() const {
    std::vector<std::string> out;
    for (const auto& entry : fs::directory_iterator(folder_.path()))
      if (entry.path().filename().string().find("rescued") != std::string::npos && entry.path().extension() == ".db")
        out.push_back(entry.path());
    return out;
  }
  /// Leaves a library with unmerged changes in its write-ahead log, as after a crash.
  static void crash_after_adding(const std::string& path, const std::string& entry) {
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      auto& library = *new Result<Library>(Library::open(path));
      if (library) add(*library, entry);
      ::kill(::getpid(), SIGKILL);
    }
    ::waitpid(child, nullptr, 0);
    ASSERT_GT(fs::file_size(path + "-wal"), 0u);
  }
  static void copy_over(const std::string& from, const std::string& to) {
    fs::copy_file(from, to, fs::copy_options::overwrite_existing);  // writes into the same inode, as cp does
  }
  TemporaryFolder folder_;
};

TEST_F(ReplacedLibraryTest, ReplacedFileIsReportedRescuedAndThenUsed) {
  const std::string path = make("library.db", "first"), other = make("other.db", "other");
  Result<Library> library = Library::open(path);
  ASSERT_TRUE(library);
  add(*library, "second");
  fs::rename(other, path);
  const Error error = refused(*library, "third");
  EXPECT_NE(error.text().find("replaced the library file"), std::string::npos) << error.text();
  ASSERT_EQ(rescue_copies().size(), 1u);
  EXPECT_NE(error.text().find(rescue_copies()[0]), std::string::npos) << error.text();
  EXPECT_EQ(names_at(rescue_copies()[0]), (std::vector<std::string>{"first", "second"}));
  add(*library, "third");
  EXPECT_EQ(names(*library), (std::vector<std::string>{"other", "third"}));
  library = fail(Error());
  EXPECT_EQ(names_at(path), (std::vector<std::string>{"other", "third"}));
  EXPECT_EQ(rescue_copies().size(), 1u);
}

TEST_F(ReplacedLibraryTest, ReadersSeeTheNewFile) {
  const std::string path = make("library.db", "first"), other = make("other.db", "other");
  Result<Library> library = Library::open(path);
  ASSERT_TRUE(library);
  EXPECT_FALSE(*library->changed_elsewhere());
  fs::rename(other, path);
  EXPECT_TRUE(*library->changed_elsewhere());
  EXPECT_EQ(names(*library), std::vector<std::string>{"other"});
  EXPECT_FALSE(*library->changed_elsewhere());
}

TEST_F(ReplacedLibraryTest, RemovedFileIsNotCreatedAgain) {
  const std::string path = make("library.db", "first");
  Result<Library> library = Library::open(path);
  ASSERT_TRUE(library);
  add(*library, "unmerged");
  fs::rename(path, path + ".away");
  EXPECT_NE(refused(*library, "second").text().find("removed or renamed"), std::string::npos);
  EXPECT_FALSE(library->find());
  EXPECT_FALSE(fs::exists(path));
  EXPECT_TRUE(rescue_copies().empty()) << "the file still has a name";
  EXPECT_EQ(names_at(path + ".away"), (std::vector<std::string>{"first", "unmerged"})) << "the log was merged";
  fs::rename(path + ".away", path);
  add(*library, "second");
  EXPECT_EQ(names(*library), (std::vector<std::string>{"first", "second", "unmerged"}));
}

TEST_F(ReplacedLibraryTest, OverwrittenFileIsNotDamagedFurther) {
  for (const bool unmerged : {true, false}) {
    const std::string path = make("library.db", "first"), other = make("other.db", "other");
    {
      Result<Library> library = Library::open(path);
      ASSERT_TRUE(library);
      if (unmerged) add(*library, "second");
      copy_over(other, path);
      EXPECT_NE(refused(*library, "third").text().find("overwrote the library file"), std::string::npos);
      EXPECT_EQ(names(*library), std::vector<std::string>{"other"});
      add(*library, "fourth");
    }
    EXPECT_EQ(names_at(path), (std::vector<std::string>{"fourth", "other"}));
    const auto check = Library::open(path)->check(false);
    EXPECT_TRUE(check && check->problems.empty());
    fs::remove(path);
    fs::remove(other);
  }
}

TEST_F(ReplacedLibraryTest, LogOfAnotherFileIsRefusedAndNothingIsChanged) {
  const std::string path = make("library.db", "first"), other = make("other.db", "other");
  crash_after_adding(path, "second");
  const std::string kept = folder_.path() + "/kept.db";
  fs::copy_file(path, kept);
  copy_over(other, path);
  const auto log_size = fs::file_size(path + "-wal");
  for (const bool read_only : {false, true}) {
    const auto opened = read_only ? Library::open_read_only(path) : Library::open(path);
    ASSERT_FALSE(opened);
    EXPECT_NE(opened.error().text().find("belongs to another database file"), std::string::npos) << opened.error().text();
  }
  EXPECT_EQ(fs::file_size(path + "-wal"), log_size);
  copy_over(kept, path);
  EXPECT_EQ(names_at(path), (std::vector<std::string>{"first", "second"})) << "the restored file has the changes of the log";
}

TEST_F(ReplacedLibraryTest, SeveralConnectionsChangeOneFile) {
  const std::string path = make("library.db", "0");
  Result<Library> a = Library::open(path), b = Library::open(path);
  ASSERT_TRUE(a && b);
  for (int i = 1; i < 40; ++i) {
    add(i % 3 == 0 ? *a : *b, std::to_string(i));
    if (i % 7 == 0) {
      auto shell = Database::open(path, OpenMode::read_write);  // as the sqlite3 shell does
      ASSERT_TRUE(shell && shell->run("PRAGMA wal_checkpoint(TRUNCATE)"));
    }
    if (i == 20) {
      auto shell = Database::open(path, OpenMode::read_write);
      ASSERT_TRUE(shell && shell->run("VACUUM"));
    }
  }
  EXPECT_EQ(names(*a).size(), 40u);
}

TEST_F(ReplacedLibraryTest, HardLinkSharesNoSecondLog) {
  const std::string path = make("library.db", "first"), link = folder_.path() + "/link.db";
  fs::create_hard_link(path, link);
  Result<Library> library = Library::open(path);
  ASSERT_TRUE(library);
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    const Result<Library> second = Library::open(link);  // the parent has the library open
    ::_exit(!second && second.error().text().find("hard link") != std::string::npos ? 0 : 1);
  }
  int status = -1;
  ::waitpid(child, &status, 0);
  EXPECT_EQ(status, 0) << "another process opened the library under its second name";
  EXPECT_FALSE(Library::open(link)) << "the same process opened the library under its second name";
  add(*library, "second");
  EXPECT_EQ(names(*library), (std::vector<std::string>{"first", "second"}));
}

TEST_F(ReplacedLibraryTest, HostileSchemaIsRefusedAndALostStampIsReplaced) {
  for (const char* sql : {"CREATE TRIGGER t AFTER INSERT ON entry BEGIN DELETE FROM blob; END",
                          "DROP TABLE stamp; CREATE VIEW stamp AS SELECT 1 AS number, 'ugoki stamp' AS mark, zeroblob(32) AS value"}) {
    const std::string path = make("library.db", "first");
    {
      auto database = Database::open(path, OpenMode::read_write);
      ASSERT_TRUE(database && database->run(sql));
    }
    EXPECT_FALSE(Library::open(path)) << sql;
    EXPECT_FALSE(Library::open_read_only(path)) << sql;
    fs::remove(path);
  }
  for (const char* sql : {"DELETE FROM stamp", "UPDATE stamp SET value = zeroblob(100000)"}) {
    const std::string path = make("library.db", "first");
    {
      auto database = Database::open(path, OpenMode::read_write);
      ASSERT_TRUE(database && database->run(sql));
    }
    auto library = Library::open(path);
    ASSERT_TRUE(library) << library.error().text();
    add(*library, "second");
    library = fail(Error());
    fs::remove(path);
  }
}

}  // namespace
}  // namespace ugoki::store
