#pragma once
// Animated previews of motions, and the intervals in which their feet are on the ground.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/store/library.h"
#include "ugoki/studio/session.h"

namespace ugoki::studio {

/// Opens its own connection to the library. To be used by one thread at a time.
class PreviewService {
 public:
  explicit PreviewService(std::string library_path) : path_(std::move(library_path)) {}

  /// Poses of a motion on its mechanism. @param id id of the entry or of its content
  /// @return motion_json with the field "mechanism": the id for GET /api/mechanism/ID
  [[nodiscard]] Result<std::string> motion(std::string_view id, const std::vector<ProjectEntry>& project);
  /// Intervals with the number of feet on the ground. @return the answer of GET /api/contacts/ID
  [[nodiscard]] Result<std::string> contacts(std::string_view id, const std::vector<ProjectEntry>& project);

 private:
  Result<ProjectEntry> find(std::string_view id, const std::vector<ProjectEntry>& project);
  std::string path_;
  std::optional<store::Library> library_;
};

}  // namespace ugoki::studio
