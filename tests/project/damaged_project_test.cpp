#include <sys/wait.h>
#include <unistd.h>

#include <random>

#include "project_fixture.h"
#include "ugoki/store/sqlite.h"

namespace ugoki::project {
namespace {

namespace fs = std::filesystem;

class DamagedProjectTest : public ProjectFixture {
 protected:
  /// Creates a project with one command in its history and closes it.
  void make_closed() const {
    Project project = make();
    ASSERT_TRUE(project.execute(move_clip(4.5)));
  }
  void run_sql(const std::string& sql) const {
    auto database = store::Database::open(path_, store::OpenMode::read_write);
    ASSERT_TRUE(database);
    const auto done = database->run(sql);
    ASSERT_TRUE(done) << done.error().text();
    ASSERT_TRUE(database->run("PRAGMA wal_checkpoint(TRUNCATE)"));
  }
  /// Opening must fail with a message and a remedy, and must not change the file.
  void expect_refused(ErrorCode code) const {
    const std::string before = read(path_);
    for (const bool read_only : {false, true}) {
      const auto project = read_only ? Project::open_read_only(path_) : Project::open(path_);
      ASSERT_FALSE(project);
      const Problem& p = project.error().problems.front();
      EXPECT_EQ(static_cast<int>(p.code), static_cast<int>(code)) << p.text();
      EXPECT_NE(p.location.find("park.ugoki"), std::string::npos) << p.text();
      EXPECT_FALSE(p.message.empty());
      EXPECT_FALSE(p.remedy.empty()) << p.text();
    }
    EXPECT_EQ(read(path_), before) << "the file must be left untouched";
    EXPECT_FALSE(fs::exists(folder_ + "/.~park.ugoki.lock"));
  }
};

TEST_F(DamagedProjectTest, RefusesFilesThatAreNotProjects) {
  expect_refused(ErrorCode::io);  // no such file
  write(path_, "");
  expect_refused(ErrorCode::syntax);
  write(path_, std::string(5000, 'x'));
  expect_refused(ErrorCode::syntax);
  fs::remove(path_);
  {
    auto library = store::Library::open(path_);
    ASSERT_TRUE(library);
  }
  expect_refused(ErrorCode::syntax);
  fs::remove(path_);
  fs::create_directory(path_);
  EXPECT_FALSE(Project::open(path_));
}

TEST_F(DamagedProjectTest, RefusesNewerVersions) {
  make_closed();
  run_sql("PRAGMA user_version = 3");
  expect_refused(ErrorCode::unsupported);
}

TEST_F(DamagedProjectTest, RefusesTruncatedFiles) {
  make_closed();
  const std::string whole = read(path_);
  for (const double part : {0.001, 0.02, 0.2, 0.5, 0.8, 0.99}) {
    write(path_, whole.substr(0, static_cast<std::size_t>(part * static_cast<double>(whole.size()))));
    expect_refused(ErrorCode::syntax);
  }
}

TEST_F(DamagedProjectTest, RefusesHostileContents) {
  make_closed();
  const std::string whole = read(path_);
  const std::pair<const char*, ErrorCode> cases[] = {
      {"UPDATE property SET value = '{' WHERE name = 'document'", ErrorCode::truncated},
      {"UPDATE property SET value = '{\"version\": 7}' WHERE name = 'document'", ErrorCode::unsupported},
      {"DELETE FROM property WHERE name = 'saved'", ErrorCode::structure},
      {"UPDATE property SET value = 'many' WHERE name = 'position'", ErrorCode::syntax},
      {"UPDATE property SET value = '-5' WHERE name = 'next_id'", ErrorCode::syntax},
      {"DELETE FROM resource WHERE id = 'n-walk'", ErrorCode::unknown},
      {"UPDATE resource SET data = x'00' WHERE id = 'n-walk'", ErrorCode::syntax},
      {"UPDATE resource SET checksum = 'af63bd4c8601b7df', data = x'00' WHERE id = 'n-walk'", ErrorCode::truncated},
      {"UPDATE resource SET id = '../x' WHERE id = 'm-ball'", ErrorCode::syntax},
      {"CREATE TRIGGER evil AFTER UPDATE ON property BEGIN DELETE FROM resource; END", ErrorCode::structure},
      {"CREATE VIEW v AS SELECT 1", ErrorCode::structure},
      {"DROP TABLE history", ErrorCode::io},
  };
  for (const auto& [sql, code] : cases) {
    SCOPED_TRACE(sql);
    write(path_, whole);
    run_sql(sql);
    const auto project = Project::open(path_);
    ASSERT_FALSE(project);
    if (code != ErrorCode::io) {
      EXPECT_EQ(static_cast<int>(project.error().problems.front().code), static_cast<int>(code)) << project.error().text();
    }
    EXPECT_FALSE(project.error().problems.front().remedy.empty());
  }
}

TEST_F(DamagedProjectTest, DamagedHistoryPreventsUndoButNotOpening) {
  make_closed();
  for (const char* sql : {"UPDATE history SET backward = '{\"o\": {\"nothing\": {\"v\": 1}}}'", "UPDATE history SET backward = 'x'",
                          "UPDATE history SET backward = '{\"o\": {\"duration\": {\"v\": -1}}}'"}) {
    SCOPED_TRACE(sql);
    run_sql(sql);
    auto project = Project::open(path_);
    ASSERT_TRUE(project) << project.error().text();
    const std::string before = project->document();
    EXPECT_FALSE(project->undo());
    EXPECT_EQ(project->document(), before);
  }
}

TEST_F(DamagedProjectTest, NeverCrashesOnFlippedBytes) {
  make_closed();
  const std::string whole = read(path_);
  std::mt19937 random(20260303);
  int refused = 0;
  for (int round = 0; round < 60; ++round) {
    std::string bytes = whole;
    for (int i = 0; i < 8; ++i) bytes[random() % bytes.size()] = static_cast<char>(random());
    write(path_, bytes);
    for (const char* suffix : {"-wal", "-shm"}) fs::remove(path_ + suffix);
    auto project = Project::open(path_);
    if (!project) {
      ++refused;
      EXPECT_FALSE(project.error().problems.front().remedy.empty());
      continue;
    }
    (void)project->undo();
    (void)project->execute(move_clip(4.6));
  }
  EXPECT_GT(refused, 20);
}

TEST_F(DamagedProjectTest, ReadsAFileWhoseFolderCannotBeWritten) {
  make_closed();
  fs::permissions(path_, fs::perms(0644));
  fs::permissions(folder_, fs::perms(0555));
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    if (::geteuid() == 0 && ::setuid(65534) != 0) ::_exit(3);  // the superuser may write everywhere
    const auto read_only = Project::open_read_only(path_);
    if (!read_only || !read_only->generate()) ::_exit(1);
    const auto editing = Project::open(path_);
    ::_exit(!editing && !editing.error().problems.front().remedy.empty() ? 0 : 2);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

}  // namespace
}  // namespace ugoki::project
