// A damaged write-ahead log of a project that was not closed.

#include <algorithm>

#include "project_fixture.h"
#include "ugoki/store/log_damage.h"
#include "ugoki/store/sqlite.h"

namespace ugoki::project {
namespace {

namespace fs = std::filesystem;

class DamagedLogTest : public ProjectFixture {
 protected:
  /// Makes the files that a killed program leaves after five commands: crashed_ with its log.
  void make_crashed() {
    Project project = make();
    before_ = project.document();
    for (int i = 0; i < 5; ++i) ASSERT_TRUE(project.execute(move_clip(4.5 + 0.1 * i)));
    after_ = project.document();
    copy_crashed();
  }
  void copy_crashed() {
    fs::create_directory(folder_ + "/crashed");
    crashed_ = folder_ + "/crashed/park.ugoki";
    fs::copy_file(path_, crashed_);
    fs::copy_file(path_ + "-wal", crashed_ + "-wal");
    log_ = read(crashed_ + "-wal");
    file_ = read(crashed_);
  }
  /// Restores the files of make_crashed() with another log.
  void put(const std::string& log) const {
    fs::remove_all(folder_ + "/crashed");
    fs::create_directory(folder_ + "/crashed");
    write(crashed_, file_);
    write(crashed_ + "-wal", log);
  }
  std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder_ + "/crashed")) names.push_back(entry.path().filename());
    std::ranges::sort(names);
    return names;
  }

  std::string before_, after_, crashed_, log_, file_;
};

TEST_F(DamagedLogTest, IsReportedAndKept) {
  make_crashed();
  ASSERT_GT(log_.size(), 30000u);
  const std::size_t frame = 24 + 4096;
  for (const std::size_t at :
       {std::size_t{0}, std::size_t{16}, std::size_t{40}, std::size_t{20000}, log_.size() - frame, log_.size() - 100}) {
    SCOPED_TRACE("damaged at byte " + std::to_string(at));
    std::string damaged = log_;
    for (std::size_t i = at; i < at + 64; ++i) damaged[i] = 0x55;
    put(damaged);
    {
      const auto look = Project::open_read_only(crashed_);
      ASSERT_TRUE(look) << look.error().text();
      ASSERT_TRUE(look->warning());
      EXPECT_NE(look->warning()->message.find("park.ugoki-wal is damaged"), std::string::npos) << look->warning()->text();
      EXPECT_FALSE(look->warning()->remedy.empty());
    }
    EXPECT_EQ(read(crashed_ + "-wal"), damaged) << "reading must not change the log";
    {
      const auto project = Project::open(crashed_);
      ASSERT_TRUE(project) << project.error().text();
      EXPECT_NE(project->document(), after_);
      ASSERT_TRUE(project->warning());
      const std::string& text = project->warning()->message;
      const std::size_t begin = text.find("kept: ") + 6, end = text.find(" and ", begin);
      ASSERT_NE(end, std::string::npos) << text;
      const std::string copy = text.substr(begin, end - begin);
      EXPECT_EQ(read(copy), file_);
      EXPECT_EQ(read(copy + "-wal"), damaged);
    }
    const auto again = Project::open(crashed_);
    ASSERT_TRUE(again) << again.error().text();
    EXPECT_FALSE(again->warning());
    EXPECT_EQ(std::ranges::count_if(files(), [](const std::string& name) { return name.find("rescued") != std::string::npos; }), 2);
  }
}

TEST_F(DamagedLogTest, CountsTheUnreadableTransactions) {
  make_crashed();
  std::string damaged = log_;
  damaged[32 + 24 + 10] ^= 1;  // the first page: all transactions, of which creating the project was one and each command another
  put(damaged);
  const auto damage = store::find_log_damage(crashed_ + "-wal");
  ASSERT_TRUE(damage);
  EXPECT_EQ(damage->offset, 32u);
  EXPECT_GE(damage->transactions, 5u);
  damaged = log_;
  damaged.back() ^= 1;
  put(damaged);
  EXPECT_EQ(store::find_log_damage(crashed_ + "-wal")->transactions, 1u);
}

TEST_F(DamagedLogTest, LogsOfKilledProgramsAreNotDamaged) {
  make_crashed();
  put(log_);
  EXPECT_FALSE(store::find_log_damage(crashed_ + "-wal"));
  {
    const auto project = Project::open(crashed_);
    ASSERT_TRUE(project) << project.error().text();
    EXPECT_FALSE(project->warning());
    EXPECT_EQ(project->document(), after_);
  }
  // A killed program leaves a part of what it wrote.
  for (std::size_t size = 0; size < log_.size(); size += 997) {
    put(log_.substr(0, size));
    EXPECT_FALSE(store::find_log_damage(crashed_ + "-wal")) << size << " bytes";
  }
}

TEST_F(DamagedLogTest, FramesOfEarlierTransactionsAreNotDamage) {
  {
    Project project = make();
    for (int i = 0; i < 5; ++i) ASSERT_TRUE(project.execute(move_clip(4.5 + 0.1 * i)));
    const auto full = fs::file_size(path_ + "-wal");
    {
      auto other = store::Database::open(path_, store::OpenMode::read_write);
      ASSERT_TRUE(other);
      ASSERT_TRUE(other->run("PRAGMA wal_checkpoint(RESTART)"));
    }
    ASSERT_TRUE(project.execute(move_clip(5.5)));  // begins the log again
    ASSERT_EQ(fs::file_size(path_ + "-wal"), full) << "the old frames are still in the file";
    copy_crashed();
  }
  EXPECT_FALSE(store::find_log_damage(crashed_ + "-wal"));
  const auto project = Project::open(crashed_);
  ASSERT_TRUE(project) << project.error().text();
  EXPECT_FALSE(project->warning());
}

}  // namespace
}  // namespace ugoki::project
