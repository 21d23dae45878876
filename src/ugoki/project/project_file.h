#pragma once
// The tables of an integration file. Internal to project. Layout: docs/files.md.

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/store/sqlite.h"
#include "ugoki/store/stamp.h"

namespace ugoki::project {

inline constexpr std::int64_t project_application_id = 0x55474b50;  // "UGKP" in ASCII: marks the file as a project
inline constexpr std::int64_t project_version = 2;

/// One command in the history of the project.
struct Step {
  std::int64_t number = 0;  ///< number of the step, from 1
  std::string label;
};

/// A command of the history with the deltas for redo and undo.
struct StepData {
  std::string label;
  std::string command;            ///< the command as JSON
  std::string forward, backward;  ///< deltas for redo and undo (content/delta.h), JSON
};

struct ResourceRow {
  std::string id;
  std::string kind;  ///< "mechanism" or "motion"
  std::vector<std::byte> data;
};

/// How the file of an open project was lost.
struct Loss {
  std::string what;      ///< description as a sentence without its full stop
  bool readable = true;  ///< true: the open connection can still read the project
};

/// Reads and writes the tables of one integration file.
class ProjectFile {
 public:
  /// Creates a new file with the tables. The file must not exist.
  [[nodiscard]] static Result<ProjectFile> create(const std::string& path);
  /// Opens a file. A file that is not a project, is damaged, or was saved by a newer version is refused and not changed.
  [[nodiscard]] static Result<ProjectFile> open(const std::string& path, bool read_only);

  /// The value of a property; an error if it is missing.
  [[nodiscard]] Result<std::string> property(std::string_view name);
  /// The value of a property; empty optional if it is missing.
  [[nodiscard]] Result<std::optional<std::string>> find_property(std::string_view name);
  [[nodiscard]] Result<void> set_property(std::string_view name, std::string_view value);
  /// All resources, their data checked against their checksums.
  [[nodiscard]] Result<std::vector<ResourceRow>> resources();
  [[nodiscard]] Result<void> put_resource(std::string_view id, std::string_view kind, std::string_view name,
                                          std::span<const std::byte> data);
  /// All steps of the history, oldest first.
  [[nodiscard]] Result<std::vector<Step>> steps();
  [[nodiscard]] Result<StepData> step(std::int64_t number);
  /// Adds a step with number `position` + 1. Deletes the later steps, which can no longer be redone, and all but the last `keep` steps.
  [[nodiscard]] Result<void> add_step(std::int64_t position, const StepData& step, std::int64_t keep);

  /// Runs `work` in one transaction with a new stamp (store/stamp.h). The transaction is rolled back if `work` fails.
  [[nodiscard]] Result<void> write(const std::function<Result<void>()>& work);
  /// Describes the loss if another program replaced, removed or overwrote the project file or its log since the file was opened for
  /// editing; empty optional if the files are still those that were opened. O(1): three system calls and one page read.
  [[nodiscard]] std::optional<Loss> lost();
  /// True if some transactions are only in the write-ahead log and not yet in the project file.
  [[nodiscard]] bool has_unmerged() const { return merged_stamp_ != stamp_; }
  /// Prepares to close a lost file: call it after lost(), when another file may be at path(). Closing then writes to no file at path().
  /// Removes the -wal and -shm files if they still belong to the open file.
  void abandon();

  [[nodiscard]] store::Database& database() { return database_; }
  [[nodiscard]] const std::string& path() const { return database_.path(); }
  /// What could not be read although the file could be opened; see store::check_log_damage().
  [[nodiscard]] const std::optional<Problem>& warning() const { return warning_; }

 private:
  /// Device and inode of a file; zeros if it does not exist.
  struct Identity {
    std::uint64_t device = 0, inode = 0;
    friend bool operator==(const Identity&, const Identity&) = default;
  };
  static Identity identity_of(const std::string& path);
  explicit ProjectFile(store::Database database) : database_(std::move(database)) {}
  /// Remembers the identities of the files and the position of the stamp, for lost().
  Result<void> remember();
  /// The stamp in the file without its log; empty optional if its page contains something else.
  Result<std::optional<store::StampRow>> stamp_in_file();

  store::Database database_;
  std::optional<Problem> warning_;
  std::string real_path_;                 ///< path without symbolic links; SQLite's names of the -wal and -shm files begin with it
  std::array<Identity, 3> identities_{};  ///< identities of the project file, its -wal file and its -shm file
  std::int64_t page_size_ = 0, stamp_page_ = 0;
  /// Begin and size of the write-ahead log. SQLite does not read them again, so a change by another program goes unnoticed until the next
  /// start.
  struct LogBegin {
    std::array<unsigned char, 32> header{};  // header of the log (SQLite, "WAL file format"), zeros if it is shorter
    std::uint64_t size = 0;                  // bytes
    /// True if frames of this log can belong to `now`: same header, not shorter.
    [[nodiscard]] bool continues_in(const LogBegin& now) const { return now.header == header && now.size >= size; }
  };
  [[nodiscard]] LogBegin log_begin() const;
  LogBegin log_;                                         ///< after the last transaction
  std::optional<store::StampRow> merged_stamp_, stamp_;  ///< stamp in the file without its log; stamp of the last transaction
};

}  // namespace ugoki::project
