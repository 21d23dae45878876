#pragma once
// Detects that another program replaced, removed or overwrote the SQLite file of an open library, or opened it under another name.
// Internal to store.
//
// Several programs use a library at once, so other programs may change its stamp (stamp.h) at any time. SQLite itself does not notice that
// a file was replaced. It would acknowledge changes that are lost afterwards, or merge its log into the wrong file.

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "ugoki/store/stamp.h"

namespace ugoki::store {

/// How the file of an open library was lost.
struct FileLoss {
  std::string what;       ///< description as a sentence without its full stop
  bool readable = true;   ///< true: the open connection can still read the library
  bool unlinked = false;  ///< the open file no longer has a name, so that its contents are lost when it is closed
};

/// Observes the files of one connection.
class FileWatch {
 public:
  /// Begins to observe the file of `database`, a library with a stamp. Error `conflict`: another program has the file open under another
  /// name (hard link); SQLite would then use two write-ahead logs for one file.
  [[nodiscard]] static Result<FileWatch> begin(Database& database);

  /// Returns the loss if the path no longer names the open file, or if the -wal or -shm file was replaced. O(1): three system calls.
  [[nodiscard]] std::optional<FileLoss> moved() const;
  /// Returns the loss if another program overwrote the file in place. Call it within a write transaction, or after its commit with the new
  /// stamp. O(1) unless another program has changed the library since the last call.
  /// @param committed stamp that this connection just committed
  [[nodiscard]] std::optional<FileLoss> overwritten(Database& database, const std::optional<StampRow>& committed = std::nullopt);
  /// Removes the -wal and -shm files if they belong to the lost file, so that they are not applied to the file that is now at the path.
  void remove_side_files() const;

 private:
  struct Identity {
    std::uint64_t device = 0, inode = 0;  // identity of a file; zeros: the file does not exist
    friend auto operator<=>(const Identity&, const Identity&) = default;
  };
  static Identity identity_of(const std::string& path);
  /// The stamp in the file without its log; empty optional if its page contains something else.
  [[nodiscard]] Result<std::optional<StampRow>> stamp_in_file(Database& database) const;

  std::string path_, real_path_;          ///< path as given; path without symbolic links, to which SQLite appends "-wal" and "-shm"
  std::array<Identity, 3> identities_{};  ///< identities of the file, its -wal file and its -shm file
  class NameMark;
  std::shared_ptr<const NameMark> mark_;  ///< shared by the connections of this process; null: the file system has no such locks
  std::int64_t page_size_ = 0, stamp_page_ = 0;
  std::int64_t data_version_ = 0;           ///< PRAGMA data_version when `last_` was read
  std::optional<StampRow> in_file_, last_;  ///< last known stamp in the file without its log; stamp of the last known transaction
};

}  // namespace ugoki::store
