#pragma once
// A lock that a program holds on a file while it edits the file. The system releases it when the program ends, also after a crash.

#include <set>
#include <string>

#include "ugoki/base/result.h"

namespace ugoki::project {

/// Exclusive lock of a file; the destructor releases it. A default-constructed lock holds nothing.
class FileLock {
 public:
  FileLock() = default;
  /// Locks a lock file in the folder of `path`: ".~NAME.lock", which contains the process id of the holder.
  /// Error `conflict`, with the holder's process id, if another program holds the lock. If the holder has ended, waits up to 2 s, because a
  /// process that it has started may have a copy of the lock until its exec.
  [[nodiscard]] static Result<FileLock> take(const std::string& path);
  /// Locks the file itself, so that its other names (hard links) share the lock. The file must exist and must not be open in this process;
  /// destroy the lock after closing the file. Error `conflict` as in take().
  [[nodiscard]] Result<void> take_file(const std::string& path);
  FileLock(FileLock&& other) noexcept;
  FileLock& operator=(FileLock&& other) noexcept;
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;
  ~FileLock();

 private:
  FileLock(int descriptor, std::string lock_path) : descriptor_(descriptor), lock_path_(std::move(lock_path)) {}
  int descriptor_ = -1;
  std::string lock_path_;
  int file_ = -1;  ///< descriptor of the locked file
  struct Identity {
    unsigned long device = 0, inode = 0;
    friend auto operator<=>(const Identity&, const Identity&) = default;
  };
  static std::set<Identity>& held();  ///< files that this process has locked
  Identity identity_;                 ///< identity of the locked file
};

}  // namespace ugoki::project
