#include "ugoki/files/temporary_folder.h"

#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <optional>
#include <utility>

#include "ugoki/base/number.h"

namespace ugoki::files {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view prefix = "ugoki-";
constexpr std::size_t random_length = 6;  // characters that mkdtemp chooses

/// Process in the name of a temporary folder, "ugoki-KIND-PROCESS-RANDOM"; std::nullopt for other names.
std::optional<pid_t> process_in(std::string_view name) {
  if (!name.starts_with(prefix)) return std::nullopt;
  name.remove_prefix(prefix.size());
  const std::size_t kind = name.find_first_not_of("abcdefghijklmnopqrstuvwxyz");
  if (kind == 0 || kind == std::string_view::npos || name[kind] != '-') return std::nullopt;
  name.remove_prefix(kind + 1);
  const std::size_t digits = name.find('-');
  if (digits == std::string_view::npos || name.size() != digits + 1 + random_length) return std::nullopt;
  const std::optional<long> process = parse_long(name.substr(0, digits));
  if (!process || *process <= 1) return std::nullopt;
  return static_cast<pid_t>(*process);
}

/// Opens and locks the folder. Returns -1 if another process has locked it, or if it is not a folder of this user. The lock ends with the
/// last process that has the descriptor.
int lock_folder(const std::string& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
  struct stat info{};
  if (fd >= 0 && ::fstat(fd, &info) == 0 && info.st_uid == ::geteuid() && ::flock(fd, LOCK_EX | LOCK_NB) == 0) return fd;
  if (fd >= 0) ::close(fd);
  return -1;
}

/// Removes temporary folders of processes that no longer exist. The process id alone does not suffice, because containers with process ids
/// of their own may share the folder: so the lock decides. The lock alone does not suffice either, because a new folder is not locked yet.
void remove_abandoned(const fs::path& parent) {
  std::error_code ec;
  for (fs::directory_iterator i(parent, ec), end; !ec && i != end; i.increment(ec)) {
    const std::optional<pid_t> process = process_in(i->path().filename().string());
    if (!process || ::kill(*process, 0) == 0 || errno != ESRCH) continue;
    const int lock = lock_folder(i->path().string());
    if (lock < 0) continue;
    std::error_code ignored;
    fs::remove_all(i->path(), ignored);
    ::close(lock);
  }
}

}  // namespace

Result<TemporaryFolder> TemporaryFolder::make(std::string_view kind, std::string_view location) {
  std::error_code ec;
  const fs::path parent = fs::temp_directory_path(ec);
  if (!ec) remove_abandoned(parent);
  std::string path = (parent / (std::string(prefix) + std::string(kind) + "-" + std::to_string(::getpid()) + "-XXXXXX")).string();
  if (ec || ::mkdtemp(path.data()) == nullptr)
    return fail(ErrorCode::io, std::string(location), "No temporary folder can be created.",
                "Set TMPDIR to a folder that you may write to.");
  const int lock = lock_folder(path);
  return TemporaryFolder(std::move(path), lock);
}

TemporaryFolder::TemporaryFolder(TemporaryFolder&& other) noexcept
    : path_(std::exchange(other.path_, {})), lock_(std::exchange(other.lock_, -1)) {}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ec;
  if (!path_.empty()) fs::remove_all(path_, ec);
  if (lock_ >= 0) ::close(lock_);
}

}  // namespace ugoki::files
