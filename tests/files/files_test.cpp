#include "ugoki/files/files.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>

namespace ugoki::files {
namespace {

namespace fs = std::filesystem;

class Files : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (fs::temp_directory_path() / "ugoki-files-XXXXXX").string();
    ASSERT_NE(::mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
  }
  void TearDown() override { fs::remove_all(folder_); }
  [[nodiscard]] std::string path(const std::string& name) const { return folder_ + "/" + name; }
  [[nodiscard]] std::size_t entries() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }
  std::string folder_;
};

template <class T>
void expect_refused(const Result<T>& r, const std::string& location) {
  ASSERT_FALSE(r.has_value());
  EXPECT_EQ(r.error().problems.at(0).location, location);
  EXPECT_FALSE(r.error().problems[0].message.empty());
  EXPECT_FALSE(r.error().problems[0].remedy.empty());
}

TEST_F(Files, WriteThenReadRestoresEveryByte) {
  std::string all;
  for (int i = 0; i < 1'000'000; ++i) all += static_cast<char>(i * 7 + i / 256);
  for (const std::string& text : {std::string(), std::string("\0\r\n\xFF", 4), all}) {
    ASSERT_TRUE(write_file(path("a"), text).has_value());
    const auto back = read_file(path("a"));
    ASSERT_TRUE(back.has_value());
    EXPECT_TRUE(*back == text);
  }
  EXPECT_EQ(entries(), 1U) << "the temporary file is removed";
}

TEST_F(Files, ErrorsNameTheFileAndARemedy) {
  expect_refused(read_file(path("none")), path("none"));
  expect_refused(read_file(folder_), folder_);
  expect_refused(write_file(folder_, "x"), folder_);
  expect_refused(write_file(path("no/such/folder"), "x"), path("no/such/folder"));
  expect_refused(write_file("", "x"), "");
  ASSERT_TRUE(write_file(path("file"), "12345").has_value());
  expect_refused(write_file(path("file/inside"), "x"), path("file/inside"));
  expect_refused(read_file(path("file/inside")), path("file/inside"));
  expect_refused(read_file(path("file"), 4), path("file"));
  EXPECT_TRUE(read_file(path("file"), 5).has_value());
  expect_refused(write_file(path(std::string(300, 'a')), "x"), path(std::string(300, 'a')));
}

TEST_F(Files, ReadingAnEndlessFileStopsAtTheSizeLimit) { expect_refused(read_file("/dev/zero", 1'000'000), "/dev/zero"); }

TEST_F(Files, FailedWriteKeepsTheOldFile) {
  ASSERT_TRUE(write_file(path("a"), "old").has_value());
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit small = before;
  small.rlim_cur = 4096;
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  const auto result = write_file(path("a"), std::string(100'000, 'x'));
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  expect_refused(result, path("a"));
  EXPECT_EQ(*read_file(path("a")), "old");
  EXPECT_EQ(entries(), 1U) << "the temporary file is removed";
}

TEST_F(Files, WritingKeepsPermissionsAndSymbolicLinks) {
  ASSERT_TRUE(write_file(path("real"), "1").has_value());
  fs::permissions(path("real"), fs::perms::owner_read | fs::perms::owner_write | fs::perms::group_read);
  fs::create_symlink("real", path("link"));
  ASSERT_TRUE(write_file(path("link"), "2").has_value());
  EXPECT_TRUE(fs::is_symlink(path("link")));
  EXPECT_EQ(*read_file(path("real")), "2");
  EXPECT_EQ(fs::status(path("real")).permissions(), fs::perms::owner_read | fs::perms::owner_write | fs::perms::group_read);
}

TEST_F(Files, WritingWithoutPermissionIsRefused) {
  if (::geteuid() == 0) GTEST_SKIP() << "root may write anywhere";
  fs::permissions(folder_, fs::perms::owner_read | fs::perms::owner_exec);
  expect_refused(write_file(path("a"), "x"), path("a"));
  fs::permissions(folder_, fs::perms::owner_all);
}

}  // namespace
}  // namespace ugoki::files
