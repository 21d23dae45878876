#pragma once
// Files of the studio's web page.

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "ugoki/base/result.h"

namespace ugoki::studio {

struct StaticFile {
  std::string bytes;
  std::string_view content_type;
  bool immutable = false;  ///< the name contains a hash of the content, so the browser may cache the file without expiry
};

/// Content type (MIME) for the extension of `path`; "application/octet-stream" if the extension is unknown.
[[nodiscard]] std::string_view content_type_of(std::string_view path);

/// Reads the file at the decoded request path `path` in the folder `root` ("/" is index.html). Paths and symbolic links that lead outside
/// of `root` are rejected.
[[nodiscard]] Result<StaticFile> read_static_file(const std::filesystem::path& root, std::string_view path);

/// Finds the folder of the built page: ../share/ugoki/web for an installed program, or web/dist in one of the parent folders for a program
/// in the source tree. Returns nullopt if there is none.
[[nodiscard]] std::optional<std::filesystem::path> find_web_folder(const std::filesystem::path& executable);

}  // namespace ugoki::studio
