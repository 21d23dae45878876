#pragma once
// A lock that one program holds on a file while it edits it. It vanishes with the program, however that ends.

#include <string>

#include "ugoki/base/result.h"

namespace ugoki::project {

class FileLock {
 public:
  FileLock() = default;
  /// Holds a lock file beside `path` (".~NAME.lock", with the holder's process number). A conflict names the holder.
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
