#include "ugoki/files/files.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <thread>

#include "ugoki/files/temporary_folder.h"

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

/// Whether the error message contains `part`.
template <class T>
bool message_has(const Result<T>& r, const char* part) {
  return !r.has_value() && r.error().problems.at(0).message.contains(part);
}

TEST_F(Files, ReadingAnEndlessFileStopsAtTheSizeLimit) {
  ASSERT_EQ(::mkfifo(path("pipe").c_str(), 0600), 0);
  std::signal(SIGPIPE, SIG_IGN);
  std::thread endless([&] {
    const int fd = ::open(path("pipe").c_str(), O_WRONLY | O_CLOEXEC);
    const std::string some(65536, 'x');
    while (::write(fd, some.data(), some.size()) > 0) {
    }
    ::close(fd);
  });
  const auto result = read_file(path("pipe"), 1'000'000);
  endless.join();
  expect_refused(result, path("pipe"));
  EXPECT_TRUE(message_has(result, "larger than 1000000 bytes"));
}

TEST_F(Files, DevicesAndSocketsAreNotRead) {
  for (const char* device : {"/dev/zero", "/dev/urandom"}) {
    expect_refused(read_file(device, 1000), device);
    EXPECT_TRUE(message_has(read_file(device, 1000), "device")) << device;
    EXPECT_TRUE(message_has(check_readable(device), "device")) << device;
  }
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  ASSERT_LT(path("socket").size(), sizeof address.sun_path);
  std::ranges::copy(path("socket"), address.sun_path);
  const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  ASSERT_EQ(::bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  expect_refused(read_file(path("socket")), path("socket"));
  EXPECT_TRUE(message_has(read_file(path("socket")), "socket"));
  expect_refused(write_file(path("socket"), "x"), path("socket"));
  EXPECT_TRUE(fs::is_socket(path("socket")));
  ::close(fd);
}

TEST_F(Files, RegularFilesAreReadAndPipesAreNotWaitedFor) {
  ASSERT_EQ(::mkfifo(path("pipe").c_str(), 0600), 0);
  expect_refused(read_regular_file(path("pipe")), path("pipe"));
  ASSERT_TRUE(write_file(path("file"), "12345").has_value());
  EXPECT_EQ(*read_regular_file(path("file")), "12345");
}

TEST_F(Files, TemporaryFoldersOfEndedProcessesAreRemoved) {
  ::setenv("TMPDIR", folder_.c_str(), 1);
  const auto made_by_child = [&](bool wait) {  // makes a folder in a child process, which ends without its destructor, or waits
    int ends[2];
    EXPECT_EQ(::pipe(ends), 0);
    const pid_t child = ::fork();
    if (child == 0) {
      const auto folder = TemporaryFolder::make("child", "here");
      (void)write_file(folder->path() + "/file", "x");
      (void)!::write(ends[1], "x", 1);
      while (wait) ::pause();
      ::_exit(0);
    }
    char byte;
    EXPECT_EQ(::read(ends[0], &byte, 1), 1);
    ::close(ends[0]);
    ::close(ends[1]);
    if (!wait) ::waitpid(child, nullptr, 0);
    return child;
  };
  const pid_t alive = made_by_child(true), ended = made_by_child(false);
  for (const char* other : {"ugoki-child", "ugoki-child-x-AAAAAA", "other-child-1-AAAAAA"}) fs::create_directory(path(other));
  const std::string locked = path("ugoki-child-" + std::to_string(ended) + "-AAAAAA");  // in use by a process of another container
  fs::create_directory(locked);
  const int fd = ::open(locked.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  ASSERT_EQ(::flock(fd, LOCK_EX), 0);
  EXPECT_EQ(entries(), 6U);
  std::string own;
  {
    const auto folder = TemporaryFolder::make("own", "here");
    ASSERT_TRUE(folder.has_value());
    own = folder->path();
    EXPECT_TRUE(fs::is_directory(own));
    EXPECT_EQ(entries(), 6U) << "the folder of the ended process was removed, and one was added";
    EXPECT_TRUE(fs::exists(locked));
  }
  EXPECT_FALSE(fs::exists(own));
  ::kill(alive, SIGKILL);
  ::waitpid(alive, nullptr, 0);
  ::close(fd);
  (void)TemporaryFolder::make("own", "here");
  EXPECT_EQ(entries(), 3U) << "only the folders with other names remain";
  ::setenv("TMPDIR", path("none").c_str(), 1);
  expect_refused(TemporaryFolder::make("own", "here"), "here");
  ::unsetenv("TMPDIR");
}

TEST_F(Files, PipesAndDevicesAreWrittenIntoAndStay) {
  ASSERT_EQ(::mkfifo(path("pipe").c_str(), 0600), 0);
  const std::string text(1'000'000, 'y');  // larger than the buffer of a pipe
  std::string got;
  std::thread reader([&] { got = read_file(path("pipe")).value_or("error"); });
  const int writer = ::open(path("pipe").c_str(), O_WRONLY | O_CLOEXEC);  // waits for the reader, and lets it end if the pipe is replaced
  EXPECT_TRUE(write_file(path("pipe"), text).has_value());
  ::close(writer);
  reader.join();
  EXPECT_TRUE(fs::is_fifo(path("pipe")));
  EXPECT_TRUE(got == text);
  EXPECT_EQ(entries(), 1U);
  // The device is a terminal: a faulty write_file() cannot replace it, because nobody can create files there. /dev/null would be lost.
  const int terminal = ::posix_openpt(O_RDWR | O_NOCTTY);
  ASSERT_TRUE(terminal >= 0 && ::grantpt(terminal) == 0 && ::unlockpt(terminal) == 0);
  const std::string device = ::ptsname(terminal);
  const int open_device = ::open(device.c_str(), O_RDWR | O_NOCTTY);  // keeps the written bytes until they are read
  EXPECT_TRUE(write_file(device, "line").has_value());
  char line[8] = {};
  pollfd wait{terminal, POLLIN, 0};
  ASSERT_EQ(::poll(&wait, 1, 10'000), 1) << "nothing was written to the device";
  EXPECT_EQ(::read(terminal, line, sizeof line), 4);
  EXPECT_STREQ(line, "line");
  EXPECT_TRUE(fs::is_character_file(device));
  ::close(open_device);
  ::close(terminal);
}

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

TEST_F(Files, SeveralFilesAreReplacedTogetherOrNotAtAll) {
  ASSERT_TRUE(write_file(path("a"), "old a"));
  ASSERT_TRUE(write_file(path("b"), "old b"));
  std::filesystem::create_directory(path("folder"));
  const std::vector<FileText> refused = {{path("a"), "new a"}, {path("b"), "new b"}, {path("folder"), "text"}};
  EXPECT_FALSE(write_files(refused));
  EXPECT_EQ(*read_file(path("a")), "old a");
  EXPECT_EQ(*read_file(path("b")), "old b");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(path("")), {}), 3) << "temporary files are removed";
  EXPECT_TRUE(write_files(std::span(refused).first(2)));
  EXPECT_EQ(*read_file(path("a")), "new a");
  EXPECT_EQ(*read_file(path("b")), "new b");
}

}  // namespace
}  // namespace ugoki::files
