#pragma once
// The library as the page sees it: lists, drawings, imports. Has a connection of its own; one thread at a time.

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/formats/asf.h"
#include "ugoki/store/library.h"
#include "ugoki/studio/session.h"

namespace ugoki::studio {

class LibraryService {
 public:
  explicit LibraryService(std::string path) : path_(std::move(path)) {}

  /// {"entries": [...]} of the library, and those of the open project that the library lacks (tag "project").
  /// @param kind "mechanism", "motion" or empty: both @param words all must be found in name, tags or summary
  [[nodiscard]] Result<std::string> list(std::string_view kind, std::string_view words, const std::vector<ProjectEntry>& project);
  [[nodiscard]] Result<MechanismPtr> mechanism(std::string_view id);

  /// A dropped file: BVH, AMC (with the ASF that was sent before), ASF, or a mechanism's JSON. What is wrong with it leaves
  /// the library as it was.
  /// @return {"entries": [...], "report": [...]}
  [[nodiscard]] Result<std::string> import(std::string_view file_name, std::string_view bytes);

 private:
  [[nodiscard]] Result<store::Library*> library();
  [[nodiscard]] Result<std::string> import_skeleton(std::string_view file_name, std::string_view bytes);
  [[nodiscard]] std::string entry_json(const store::LibraryEntry& entry, bool with_curve);

  std::string path_;
  std::optional<store::Library> library_;
  std::map<std::string, formats::Asf, std::less<>> skeletons_;  ///< ASF files sent so far, by file name in lower case
  std::string last_skeleton_;
  std::map<std::string, std::string, std::less<>> curves_;  ///< JSON by motion id
};

}  // namespace ugoki::studio
