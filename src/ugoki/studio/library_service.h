#pragma once
// The library's HTTP interface for the page: lists, entries, versions, thumbnails, curves.

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/formats/asf.h"
#include "ugoki/store/library.h"
#include "ugoki/studio/server.h"
#include "ugoki/studio/session.h"

namespace ugoki::studio {

/// Answers requests about the library, with its own connection. To be used by one thread at a time.
class LibraryService {
 public:
  /// @param location file or address of the library
  explicit LibraryService(std::string location) : location_(std::move(location)) {}

  /// True for the paths that answer() serves: /api/library..., /api/entry/..., /api/thumbnail/...
  [[nodiscard]] static bool answers(std::string_view path);
  /// Answers a request as described in docs/studio-protocol.md.
  /// @param project entries of the open project; lists include the entries that only the project has, with the tag "project"
  /// @param changed set to true if the library changed, so that all pages should request the list again
  [[nodiscard]] ApiReply answer(const ApiRequest& request, const std::vector<ProjectEntry>& project, bool& changed);

  /// The library, which is opened at the first call.
  [[nodiscard]] Result<store::Library*> library();
  /// The warning of a library that was opened since the last call; see store::Library::warning().
  [[nodiscard]] std::optional<Problem> take_warning() { return std::exchange(warning_, std::nullopt); }
  /// Result of poll().
  struct Poll {
    bool responds = true;  ///< false: the library cannot be opened or read
    bool changed = false;  ///< true: all pages should request the list again
  };
  /// Asks whether another program or user changed the library since the last call, or whether it responds again after a failure. Does
  /// nothing before the first use of the library. To be called every few seconds.
  [[nodiscard]] Poll poll();

  /// Loads a mechanism. @param id content id of the mechanism's data, or id of its entry
  [[nodiscard]] Result<MechanismPtr> mechanism(std::string_view id);

  /// Imports a file: BVH, AMC (its ASF must have been sent before), ASF, a mechanism's JSON or another format of intake::file_kind.
  /// On an error the library is unchanged.
  /// @return {"entries": [...], "report": [...]}
  [[nodiscard]] Result<std::string> import(std::string_view file_name, std::string_view bytes);

 private:
  [[nodiscard]] Result<std::string> list(std::string_view query, const std::vector<ProjectEntry>& project);
  [[nodiscard]] Result<std::string> tags(std::string_view query);
  [[nodiscard]] Result<std::string> entry(std::string_view id, const std::vector<ProjectEntry>& project);
  /// @param action "", "restore", "duplicate", "remove" or "undelete"
  [[nodiscard]] Result<store::LibraryEntry> change(std::string_view id, std::string_view action, std::string_view body);
  [[nodiscard]] Result<store::LibraryEntry> edit(std::string_view id, std::string_view body);
  [[nodiscard]] ApiReply thumbnail(const ApiRequest& request, std::string_view id);
  [[nodiscard]] Result<std::string> import_skeleton(std::string_view file_name, std::string_view bytes);
  [[nodiscard]] std::string entry_json(const store::LibraryEntry& entry, bool with_curve);

  std::string location_;
  std::optional<store::Library> library_;
  std::optional<Problem> warning_;
  bool wanted_ = false;                                         ///< true: the library has been requested by a call of library()
  bool away_ = false;                                           ///< true: the last poll() or opening failed
  std::map<std::string, formats::Asf, std::less<>> skeletons_;  ///< received ASF files, by file name in lower case
  std::string last_skeleton_;
  std::map<std::string, std::string, std::less<>> curves_;  ///< JSON of thumbnail curves, by content id of the motion
};

}  // namespace ugoki::studio
