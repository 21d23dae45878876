#include "ugoki/project/file_lock.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "ugoki/base/number.h"

namespace ugoki::project {
namespace {

std::mutex held_mutex;  // protects FileLock::held()

constexpr std::chrono::milliseconds retry_period{20};

/// True if no process has this id, or if the text is no process id.
bool has_ended(const std::string& process) {
  const std::optional<long> id = parse_long(process);
  return !id || *id <= 0 || (::kill(static_cast<pid_t>(*id), 0) != 0 && errno == ESRCH);
}

}  // namespace

Result<FileLock> FileLock::take(const std::string& path) {
  namespace fs = std::filesystem;
  std::error_code unresolved;
  const fs::path real = fs::weakly_canonical(path, unresolved);  // different names (links) of one file share a lock
  const fs::path file = unresolved ? fs::path(path) : real;
  const std::string lock_path = (file.parent_path() / (".~" + file.filename().string() + ".lock")).string();
  std::string ended_holder;
  for (int attempt = 0; attempt < 100; ++attempt) {
    if (!ended_holder.empty()) std::this_thread::sleep_for(retry_period);
    const int descriptor = ::open(lock_path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666);
    if (descriptor < 0)
      return fail(ErrorCode::io, path, "The lock file next to the project cannot be created: " + std::string(std::strerror(errno)) + ".",
                  "Check that the folder exists and that you may write to it.");
    if (::flock(descriptor, LOCK_EX | LOCK_NB) != 0) {
      const int error = errno;
      char holder[32] = {};
      const ssize_t size = ::pread(descriptor, holder, sizeof holder - 1, 0);
      ::close(descriptor);
      if (error != EWOULDBLOCK)
        return fail(ErrorCode::io, path, "The file cannot be locked: " + std::string(std::strerror(error)) + ".",
                    "Copy it to a local disk and open the copy.");
      // A process that the holder was starting when it was killed has the lock until its exec.
      if (size > 0 && has_ended(holder)) {
        ended_holder = holder;
        continue;
      }
      const std::string by = size > 0 ? " (process " + std::string(holder) + ")" : "";
      return fail(ErrorCode::conflict, path, "The project is already open in another program" + by + ".",
                  "Close it there first, or work on a copy.");
    }
    // The previous holder may have removed the lock file between open() and flock(). The locked file then no longer has this name, other
    // programs cannot see the lock, and the attempt must be repeated.
    struct stat ours{}, theirs{};
    if (::fstat(descriptor, &ours) == 0 && ::stat(lock_path.c_str(), &theirs) == 0 && ours.st_ino == theirs.st_ino &&
        ours.st_dev == theirs.st_dev) {
      const std::string number = std::to_string(::getpid());
      if (::ftruncate(descriptor, 0) != 0 || ::pwrite(descriptor, number.data(), number.size(), 0) < 0) {
        // The lock is held. Only the process id in other programs' conflict messages is missing.
      }
      return FileLock(descriptor, lock_path);
    }
    ::close(descriptor);
  }
  if (!ended_holder.empty())
    return fail(ErrorCode::conflict, path, "The project is locked by a program that the ended process " + ended_holder + " has started.",
                "Wait until that program ends, or work on a copy.");
  return fail(ErrorCode::conflict, path, "Another program keeps opening and closing the project.", "Try again.");
}

std::set<FileLock::Identity>& FileLock::held() {
  static std::set<Identity> files;
  return files;
}

Result<void> FileLock::take_file(const std::string& path) {
  const auto conflict = [&](const std::string& by) {
    return fail(ErrorCode::conflict, path, "The project is already open in another program under another name (hard link)" + by + ".",
                "Close it there first, or work on a copy.");
  };
  struct stat info{};
  if (::stat(path.c_str(), &info) != 0) return {};  // opening the file will report the error
  const Identity identity{info.st_dev, info.st_ino};
  // Closing any descriptor of a file releases this process's POSIX locks of the file, which SQLite uses. A file that this process has
  // locked is therefore not opened.
  const std::lock_guard guard(held_mutex);
  if (held().contains(identity)) return conflict(" (process " + std::to_string(::getpid()) + ")");
  const int descriptor = ::open(path.c_str(), O_RDWR | O_CLOEXEC);
  if (descriptor < 0) return {};  // opening the file will report the error
  struct flock range{};           // one byte, far behind the bytes that SQLite locks; the lock belongs to `descriptor`
  range.l_type = F_WRLCK;
  range.l_whence = SEEK_SET;
  range.l_start = off_t{1} << 40;
  range.l_len = 1;
  for (int attempt = 0; ::fcntl(descriptor, F_OFD_SETLK, &range) != 0 && (errno == EAGAIN || errno == EACCES); ++attempt) {
    if (attempt == 10) {
      ::close(descriptor);
      return conflict("");
    }
    std::this_thread::sleep_for(retry_period);  // as in take(): the process of a killed holder may be about to release it
  }
  // On file systems without such locks, only the lock file of take() protects the project.
  file_ = descriptor;
  identity_ = identity;
  held().insert(identity);
  return {};
}

FileLock::FileLock(FileLock&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)),
      lock_path_(std::move(other.lock_path_)),
      file_(std::exchange(other.file_, -1)),
      identity_(other.identity_) {}
FileLock& FileLock::operator=(FileLock&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  std::swap(lock_path_, other.lock_path_);
  std::swap(file_, other.file_);
  std::swap(identity_, other.identity_);
  return *this;
}
FileLock::~FileLock() {
  if (file_ >= 0) {
    const std::lock_guard guard(held_mutex);
    held().erase(identity_);
    ::close(file_);
  }
  if (descriptor_ < 0) return;
  ::unlink(lock_path_.c_str());  // before the lock is released, so that the file of the next holder is not removed
  ::close(descriptor_);
}

}  // namespace ugoki::project
