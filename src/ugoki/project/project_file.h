#pragma once
// The tables of an integration file. Internal to project. Layout: docs/files.md.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/store/sqlite.h"

namespace ugoki::project {

inline constexpr std::int64_t project_application_id = 0x55474b50;  // "UGKP"
inline constexpr std::int64_t project_version = 1;

/// One command of the history.
struct Step {
  std::int64_t number = 0;  ///< counts from 1
  std::string label;
};

/// A command of the history with the deltas for redo and undo.
struct StepData {
  std::string label;
  std::string command;            ///< JSON
  std::string forward, backward;  ///< deltas (content/delta.h), JSON
};

struct ResourceRow {
  std::string id;
  std::string kind;  ///< "mechanism" or "motion"
  std::vector<std::byte> data;
};

/// The tables of one integration file.
class ProjectFile {
 public:
  /// Creates a new file with the tables. The file must not exist.
  [[nodiscard]] static Result<ProjectFile> create(const std::string& path);
  /// Opens a file. A file that is not a project, is damaged, or was saved by a newer version is refused and not changed.
  [[nodiscard]] static Result<ProjectFile> open(const std::string& path, bool read_only);

  /// The value of a property; a problem if it is missing.
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

  [[nodiscard]] store::Database& database() { return database_; }
  [[nodiscard]] const std::string& path() const { return database_.path(); }

 private:
  explicit ProjectFile(store::Database database) : database_(std::move(database)) {}
  store::Database database_;
};

}  // namespace ugoki::project
