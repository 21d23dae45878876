#pragma once
// The library as the page sees it: lists, entries, versions, thumbnails, drawings. Has a connection of its own; one thread at a time.

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/formats/asf.h"
#include "ugoki/store/library.h"
#include "ugoki/studio/server.h"
#include "ugoki/studio/session.h"

namespace ugoki::studio {

class LibraryService {
 public:
  /// @param place file or address of the library
  explicit LibraryService(std::string place) : place_(std::move(place)) {}

  /// True for the addresses below that answer() knows: /api/library..., /api/entry/..., /api/thumbnail/...
  [[nodiscard]] static bool answers(std::string_view path);
  /// docs/studio-protocol.md.
  /// @param project entries of the open project; those that the library lacks stand in lists as well (tag "project")
  /// @param changed set to true if other pages should ask for the list again
  [[nodiscard]] ApiReply answer(const ApiRequest& request, const std::vector<ProjectEntry>& project, bool& changed);

  /// @param id of a mechanism's data ("content"), or of its entry
  [[nodiscard]] Result<MechanismPtr> mechanism(std::string_view id);

  /// A dropped file: BVH, AMC (with the ASF that was sent before), ASF, or a mechanism's JSON. What is wrong with it leaves
  /// the library as it was.
  /// @return {"entries": [...], "report": [...]}
  [[nodiscard]] Result<std::string> import(std::string_view file_name, std::string_view bytes);

 private:
  [[nodiscard]] Result<store::Library*> library();
  [[nodiscard]] Result<std::string> list(std::string_view query, const std::vector<ProjectEntry>& project);
  [[nodiscard]] Result<std::string> tags(std::string_view query);
  [[nodiscard]] Result<std::string> entry(std::string_view id, const std::vector<ProjectEntry>& project);
  /// @param action "", "restore", "duplicate", "remove" or "undelete"
  [[nodiscard]] Result<store::LibraryEntry> change(std::string_view id, std::string_view action, std::string_view body);
  [[nodiscard]] Result<store::LibraryEntry> edit(std::string_view id, std::string_view body);
  [[nodiscard]] ApiReply thumbnail(const ApiRequest& request, std::string_view id);
  [[nodiscard]] Result<std::string> import_skeleton(std::string_view file_name, std::string_view bytes);
  [[nodiscard]] std::string entry_json(const store::LibraryEntry& entry, bool with_curve);

  std::string place_;
  std::optional<store::Library> library_;
  std::map<std::string, formats::Asf, std::less<>> skeletons_;  ///< ASF files sent so far, by file name in lower case
  std::string last_skeleton_;
  std::map<std::string, std::string, std::less<>> curves_;  ///< JSON by a motion's content
};

}  // namespace ugoki::studio
