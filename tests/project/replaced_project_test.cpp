// Project files that other programs replace, remove or overwrite while they are open or after a crash, hard links, side files, permissions.
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <functional>
#include <map>

#include "project_fixture.h"
#include "ugoki/store/sqlite.h"

namespace ugoki::project {
namespace {

namespace fs = std::filesystem;

class ReplacedProjectTest : public ProjectFixture {
 protected:
  void make_closed() const { const Project project = make(); }
  /// Creates a closed project with other content. @return its path
  std::string make_other() const {
    content::Scenario scenario = content::testing::make_scenario();
    scenario.name = "other";
    const std::string path = folder_ + "/other.ugoki";
    const auto project = Project::create(path, scenario, content::testing::make_resources());
    EXPECT_TRUE(project) << (project ? "" : project.error().text());
    return path;
  }
  /// Path of the only rescue copy in the folder; empty if there is none.
  std::string rescue() const {
    std::string found;
    for (const auto& entry : fs::directory_iterator(folder_)) {
      const std::string name = entry.path().filename();
      if (name.find("rescued") == std::string::npos || !name.ends_with(".ugoki")) continue;
      EXPECT_EQ(found, "") << "a second rescue copy: " << name;
      found = entry.path();
    }
    return found;
  }
  /// Runs `work` in a child process that is killed afterwards, so that nothing is closed.
  static void in_killed_process(const std::function<bool()>& work) {
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      const bool done = work();
      if (done) ::kill(::getpid(), SIGKILL);
      ::_exit(1);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    ASSERT_TRUE(WIFSIGNALED(status)) << "the work of the child process failed";
  }
  /// Leaves a project with `edits` edits in a write-ahead log, as after a crash. @return the document with the edits
  std::string make_crashed(int edits) const {
    const std::string note = folder_ + "/document";
    in_killed_process([&] {
      auto& project = *new Result<Project>(Project::open(path_));  // never closed
      for (int i = 0; project && i < edits; ++i)
        if (!project->execute(move_clip(i % 2 == 0 ? 4.6 : 4.7))) return false;
      if (project) write(note, project->document());
      return project.has_value();
    });
    const std::string document = read(note);
    fs::remove(note);
    return document;
  }
  /// Makes an edit, lets `replace` change the file, and expects that the next edits are refused and that the work is in a rescue copy.
  void expect_rescued(const std::function<void()>& replace) const {
    std::string document;
    {
      Project project = make();
      ASSERT_TRUE(project.execute(move_clip(4.5)));
      document = project.document();
      replace();
      for (int i = 0; i < 2; ++i) {
        const auto change = project.execute(move_clip(4.6));
        ASSERT_FALSE(change) << "edit " << i << " was acknowledged";
        const Problem& p = change.error().problems.front();
        EXPECT_EQ(static_cast<int>(p.code), static_cast<int>(ErrorCode::conflict));
        EXPECT_NE(p.location.find("park.ugoki"), std::string::npos) << p.text();
        ASSERT_NE(rescue(), "") << p.text();
        EXPECT_NE(p.text().find(rescue()), std::string::npos) << p.text();
      }
      EXPECT_EQ(project.document(), document);
      EXPECT_FALSE(project.undo());
      EXPECT_FALSE(project.save());
      EXPECT_FALSE(project.keep("breakpoints", "[]"));
    }
    const auto rescued = Project::open(rescue());
    ASSERT_TRUE(rescued) << rescued.error().text();
    EXPECT_EQ(rescued->document(), document);
    EXPECT_EQ(rescued->resources().motions.size(), content::testing::make_resources().motions.size());
  }
  void expect_other_is_at_path() const {
    for (const char* suffix : {"-wal", "-shm"}) EXPECT_FALSE(fs::exists(path_ + suffix)) << suffix;
    const auto now = Project::open(path_);
    ASSERT_TRUE(now) << now.error().text();
    EXPECT_EQ(now->scenario().name, "other");
  }
  static void expect_foreign_log(const Result<Project>& project) {
    ASSERT_FALSE(project);
    const Problem& p = project.error().problems.front();
    EXPECT_EQ(static_cast<int>(p.code), static_cast<int>(ErrorCode::conflict)) << p.text();
    EXPECT_NE(p.text().find("park.ugoki-wal"), std::string::npos) << p.text();
    EXPECT_FALSE(p.remedy.empty());
  }
};

TEST_F(ReplacedProjectTest, ReplacedFileRefusesEditsAndKeepsTheWork) {
  const std::string other = make_other();
  expect_rescued([&] { fs::rename(other, path_); });
  const auto rescued = Project::open(rescue());
  ASSERT_TRUE(rescued);
  EXPECT_TRUE(rescued->can_undo()) << "the history is rescued too";
  expect_other_is_at_path();
}

TEST_F(ReplacedProjectTest, RemovedFileRefusesEditsAndKeepsTheWork) {
  expect_rescued([&] { fs::remove(path_); });
  EXPECT_FALSE(fs::exists(path_ + "-wal"));
}

TEST_F(ReplacedProjectTest, OverwrittenFileRefusesEditsAndKeepsTheWork) {
  const std::string bytes = read(make_other());
  expect_rescued([&] { write(path_, bytes); });
  EXPECT_EQ(read(path_), bytes) << "closing should not write to the file of the other program";
  expect_other_is_at_path();
}

TEST_F(ReplacedProjectTest, RemovedLogRefusesEditsAndKeepsTheWork) {
  expect_rescued([&] { fs::remove(path_ + "-wal"); });
}

TEST_F(ReplacedProjectTest, EmptiedLogRefusesEditsAndKeepsTheWork) {
  expect_rescued([&] { fs::resize_file(path_ + "-wal", 0); });
}

TEST_F(ReplacedProjectTest, LogOverwrittenInPlaceRefusesEditsAndKeepsTheWork) {
  expect_rescued([&] {
    std::fstream log(path_ + "-wal", std::ios::binary | std::ios::in | std::ios::out);
    log << std::string(5000, 'x');
  });
}

TEST_F(ReplacedProjectTest, ClosingAReplacedProjectKeepsTheWork) {
  const std::string other = make_other();
  std::string document;
  {
    Project project = make();
    ASSERT_TRUE(project.execute(move_clip(4.5)));
    document = project.document();
    fs::rename(other, path_);
  }
  ASSERT_NE(rescue(), "");
  const auto rescued = Project::open(rescue());
  ASSERT_TRUE(rescued) << rescued.error().text();
  EXPECT_EQ(rescued->document(), document);
  expect_other_is_at_path();
}

TEST_F(ReplacedProjectTest, KilledAfterTheRefusalLeavesTheNewFileUsable) {
  const std::string other = make_other();
  make_closed();
  in_killed_process([&] {
    auto& project = *new Result<Project>(Project::open(path_));  // never closed
    if (!project || !project->execute(move_clip(4.5))) return false;
    fs::rename(other, path_);
    return !project->execute(move_clip(4.6));
  });
  EXPECT_NE(rescue(), "");
  expect_other_is_at_path();
}

TEST_F(ReplacedProjectTest, SaveAsContinuesWithACopy) {
  const std::string other = make_other();
  Project project = make();
  ASSERT_TRUE(project.execute(move_clip(4.5)));
  fs::rename(other, path_);
  EXPECT_FALSE(project.execute(move_clip(4.6)));
  const auto saved = project.save_as(folder_ + "/mine.ugoki");
  ASSERT_TRUE(saved) << saved.error().text();
  EXPECT_TRUE(project.execute(move_clip(4.6)));
  EXPECT_NE(rescue(), "");
}

TEST_F(ReplacedProjectTest, LogOfAnotherFileIsRefused) {
  const std::string bytes = read(make_other());
  make_closed();
  make_crashed(3);
  ASSERT_GT(fs::file_size(path_ + "-wal"), 0u);
  write(path_, bytes);  // as `cp other.ugoki park.ugoki` does
  expect_foreign_log(Project::open_read_only(path_));
  expect_foreign_log(Project::open(path_));
  EXPECT_EQ(read(path_), bytes) << "the file must be left untouched";
  EXPECT_GT(fs::file_size(path_ + "-wal"), 0u) << "the log may be needed to recover the other file";
  for (const char* suffix : {"-wal", "-shm"}) fs::remove(path_ + suffix);
  expect_other_is_at_path();
}

TEST_F(ReplacedProjectTest, LogOfALaterStateOfTheProjectIsRefused) {
  make_closed();
  const std::string first = read(path_);
  {
    auto project = Project::open(path_);
    ASSERT_TRUE(project && project->execute(move_clip(4.5)));
  }
  const std::string second = read(path_);
  ASSERT_NE(first, second);
  const std::string document = make_crashed(3);
  const std::string log = read(path_ + "-wal");
  write(path_, first);
  expect_foreign_log(Project::open(path_));
  write(path_, second);  // restore the file to which the log belongs
  ASSERT_EQ(read(path_ + "-wal"), log);
  const auto project = Project::open(path_);
  ASSERT_TRUE(project) << project.error().text();
  EXPECT_EQ(project->document(), document);
}

TEST_F(ReplacedProjectTest, CrashDuringALongSessionLosesNothing) {
  make_closed();
  for (int round = 0; round < 3; ++round) {
    const std::string document = make_crashed(150 * (round + 1));  // the log is merged and restarted several times
    const auto project = Project::open_read_only(path_);
    ASSERT_TRUE(project) << project.error().text();
    EXPECT_EQ(project->document(), document);
  }
}

TEST_F(ReplacedProjectTest, HardLinkSharesTheLock) {
  const Project project = make();
  fs::create_directory(folder_ + "/below");
  const std::string link = folder_ + "/below/link.ugoki";
  fs::create_hard_link(path_, link);
  const auto again = Project::open(link);
  ASSERT_FALSE(again);
  EXPECT_EQ(static_cast<int>(again.error().problems.front().code), static_cast<int>(ErrorCode::conflict));
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    char program[] = "/proc/self/exe", filter[] = "--gtest_filter=ReplacedProjectTest.OpensFileOfEnvironment";
    ::setenv("UGOKI_TEST_OPEN", link.c_str(), 1);
    char* arguments[] = {program, filter, nullptr};
    ::execv(program, arguments);
    ::_exit(126);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 1) << "the other process should not open the file";
}

/// Runs in a process of its own: fails unless the file named by UGOKI_TEST_OPEN can be opened.
TEST_F(ReplacedProjectTest, OpensFileOfEnvironment) {
  const char* path = std::getenv("UGOKI_TEST_OPEN");
  if (path == nullptr) GTEST_SKIP() << "only for HardLinkSharesTheLock";
  ASSERT_TRUE(Project::open(path));
}

/// A crash while the log is merged leaves a database file with some pages of the log. Without its log, this file is not a valid database.
TEST_F(ReplacedProjectTest, CrashDuringTheMergeOfTheLogLosesNothing) {
  make_closed();
  const std::string document = make_crashed(3);
  const std::string file = read(path_), log = read(path_ + "-wal");
  constexpr std::size_t page_size = 4096, frame_size = 24 + page_size;
  std::map<std::uint32_t, std::string> pages;  // the newest version of each page in the log
  for (std::size_t at = 32; at + frame_size <= log.size(); at += frame_size) {
    std::uint32_t number = 0;
    for (std::size_t i = 0; i < 4; ++i) number = number << 8 | static_cast<unsigned char>(log[at + i]);
    pages[number] = log.substr(at + 24, page_size);
  }
  ASSERT_GT(pages.size(), 3u);
  std::string merged = file;
  for (const auto& [number, page] : pages) {
    merged.resize(std::max(merged.size(), number * page_size));
    merged.replace((number - 1) * page_size, page_size, page);
    write(path_, merged);
    write(path_ + "-wal", log);
    fs::remove(path_ + "-shm");
    const auto project = Project::open(path_);
    ASSERT_TRUE(project) << "after page " << number << ": " << project.error().text();
    EXPECT_EQ(project->document(), document);
  }
}

TEST_F(ReplacedProjectTest, ReadingLeavesNoSideFiles) {
  make_closed();
  {
    const auto project = Project::open_read_only(path_);
    ASSERT_TRUE(project) << project.error().text();
    const auto second = Project::open_read_only(path_);
    ASSERT_TRUE(second);
  }
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder_)) names.push_back(entry.path().filename());
  EXPECT_EQ(names, std::vector<std::string>{"park.ugoki"});
}

TEST_F(ReplacedProjectTest, NewFilesArePrivate) {
  Project project = make();
  ASSERT_TRUE(project.save_as(folder_ + "/copy.ugoki"));
  EXPECT_EQ(fs::status(folder_ + "/copy.ugoki").permissions(), fs::perms(0600));
  write(folder_ + "/shared.ugoki", "");
  fs::permissions(folder_ + "/shared.ugoki", fs::perms(0640));
  ASSERT_TRUE(project.save_as(folder_ + "/shared.ugoki", true));
  EXPECT_EQ(fs::status(folder_ + "/shared.ugoki").permissions(), fs::perms(0640)) << "a replaced file keeps its mode";
  ASSERT_TRUE(project.save_as(path_, true));
  for (const char* suffix : {"", "-wal", "-shm"}) {
    struct stat info{};
    ASSERT_EQ(::stat((path_ + suffix).c_str(), &info), 0);
    EXPECT_EQ(info.st_mode & 0777, 0600u) << path_ << suffix;
  }
}

TEST_F(ReplacedProjectTest, UpgradesFilesOfVersionOne) {
  make_closed();
  {
    auto database = store::Database::open(path_, store::OpenMode::read_write);
    ASSERT_TRUE(database && database->run("DROP TABLE IF EXISTS stamp; PRAGMA user_version = 1"));
  }
  EXPECT_TRUE(Project::open_read_only(path_));
  {
    auto project = Project::open(path_);
    ASSERT_TRUE(project) << project.error().text();
    EXPECT_TRUE(project->execute(move_clip(4.5)));
  }
  const auto project = Project::open_read_only(path_);
  ASSERT_TRUE(project) << project.error().text();
  EXPECT_TRUE(project->can_undo());
}

}  // namespace
}  // namespace ugoki::project
