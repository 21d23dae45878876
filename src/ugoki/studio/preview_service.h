#pragma once
// Moving previews of the library's motions, and when their feet stand.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/store/library.h"
#include "ugoki/studio/session.h"

namespace ugoki::studio {

/// Has a connection of its own to the library; one thread at a time.
class PreviewService {
 public:
  explicit PreviewService(std::string library_path) : path_(std::move(library_path)) {}

  /// Poses of a motion on the mechanism that it was made for. @param id of the entry, or of its content
  /// @return motion_json with "mechanism": the id to ask GET /api/mechanism/ for
  [[nodiscard]] Result<std::string> motion(std::string_view id, const std::vector<ProjectEntry>& project);
  /// When how many of its feet stand. @return the answer of GET /api/contacts/ID
  [[nodiscard]] Result<std::string> contacts(std::string_view id, const std::vector<ProjectEntry>& project);

 private:
  Result<ProjectEntry> find(std::string_view id, const std::vector<ProjectEntry>& project);
  std::string path_;
  std::optional<store::Library> library_;
};

}  // namespace ugoki::studio
