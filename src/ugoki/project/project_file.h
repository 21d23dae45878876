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
  std::int64_t number = 0;
  std::string label;
};

struct StepData {
  std::string label, command, forward, backward;
};

struct ResourceRow {
  std::string id, kind;
  std::vector<std::byte> data;
};

class ProjectFile {
 public:
  /// Makes the tables in a new file. The file must not exist.
  [[nodiscard]] static Result<ProjectFile> create(const std::string& path);
  /// Refuses what is no project, damaged, or newer than this program, without writing to it.
  [[nodiscard]] static Result<ProjectFile> open(const std::string& path, bool read_only);

  [[nodiscard]] Result<std::string> property(std::string_view name);
  [[nodiscard]] Result<std::optional<std::string>> find_property(std::string_view name);
  [[nodiscard]] Result<void> set_property(std::string_view name, std::string_view value);
  /// Every resource, its data checked.
  [[nodiscard]] Result<std::vector<ResourceRow>> resources();
  [[nodiscard]] Result<void> put_resource(std::string_view id, std::string_view kind, std::string_view name,
                                          std::span<const std::byte> data);
  [[nodiscard]] Result<std::vector<Step>> steps();
  [[nodiscard]] Result<StepData> step(std::int64_t number);
  /// Adds a step after `position`; what came after it before is forgotten, and so are steps more than `keep` ago.
  [[nodiscard]] Result<void> add_step(std::int64_t position, const StepData& step, std::int64_t keep);

  [[nodiscard]] store::Database& database() { return database_; }
  [[nodiscard]] const std::string& path() const { return database_.path(); }

 private:
  explicit ProjectFile(store::Database database) : database_(std::move(database)) {}
  store::Database database_;
};

}  // namespace ugoki::project
