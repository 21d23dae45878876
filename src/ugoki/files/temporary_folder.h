#pragma once
// Temporary folders that do not accumulate after crashes (native builds only).

#include <string>
#include <string_view>
#include <utility>

#include "ugoki/base/result.h"

namespace ugoki::files {

/// An empty temporary folder; the destructor removes it with all its files. Its name is "ugoki-KIND-PROCESS-RANDOM". If the process ends
/// without the destructor (Ctrl+C, crash), the next call of make() in any process of the same user removes the folder.
class TemporaryFolder {
 public:
  /// Makes a folder in $TMPDIR (default: /tmp), with access for the user only. First removes the folders that processes of this user have
  /// left behind. Error: no folder can be made. @param kind lower-case letters @param location location of the error
  [[nodiscard]] static Result<TemporaryFolder> make(std::string_view kind, std::string_view location);
  TemporaryFolder(TemporaryFolder&& other) noexcept;
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(TemporaryFolder&&) = delete;
  ~TemporaryFolder();
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  TemporaryFolder(std::string path, int lock) : path_(std::move(path)), lock_(lock) {}
  std::string path_;  // empty after a move
  int lock_ = -1;     // descriptor of the locked folder
};

}  // namespace ugoki::files
