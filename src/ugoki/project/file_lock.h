#pragma once
// A lock that a program holds on a file while it edits the file. The system releases it when the program ends, also after a crash.

#include <string>

#include "ugoki/base/result.h"

namespace ugoki::project {

/// Exclusive lock of a file; the destructor releases it. A default-constructed lock holds nothing.
class FileLock {
 public:
  FileLock() = default;
  /// Locks a lock file in the folder of `path`: ".~NAME.lock", which contains the process id of the holder.
  /// Error `conflict`, with the holder's process id, if another program holds the lock.
  [[nodiscard]] static Result<FileLock> take(const std::string& path);
  FileLock(FileLock&& other) noexcept;
  FileLock& operator=(FileLock&& other) noexcept;
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;
  ~FileLock();

 private:
  FileLock(int descriptor, std::string lock_path) : descriptor_(descriptor), lock_path_(std::move(lock_path)) {}
  int descriptor_ = -1;
  std::string lock_path_;
};

}  // namespace ugoki::project
