#pragma once
// The page's files.

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "ugoki/base/result.h"

namespace ugoki::studio {

struct StaticFile {
  std::string bytes;
  std::string_view content_type;
  bool immutable = false;  ///< its name holds a hash of its content, so it may be kept for ever
};

/// Content type by the name's ending; "application/octet-stream" where it is unknown.
[[nodiscard]] std::string_view content_type_of(std::string_view path);

/// The file that decoded request path `path` names below `root` ("/" names index.html). Nothing outside of `root` is
/// ever read, whatever the path or a symbolic link says.
[[nodiscard]] Result<StaticFile> read_static_file(const std::filesystem::path& root, std::string_view path);

/// Where the page's build lies: beside an installed program (../share/ugoki/web), or in the source tree of a built one
/// (web/dist in one of the folders above). Nothing where there is none.
[[nodiscard]] std::optional<std::filesystem::path> find_web_folder(const std::filesystem::path& executable);

}  // namespace ugoki::studio
