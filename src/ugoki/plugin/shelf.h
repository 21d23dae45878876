#pragma once
// The libraries of LSIs that the user has installed, by consent and by hash. Reading the shelf runs no foreign code.

#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/circuit/lsi_class.h"

namespace ugoki::plugin {

struct ShelfEntry {
  std::string name, version, doc;
  std::string hash;                        ///< SHA-256 of the library's file, 64 hexadecimal digits
  std::string file;                        ///< path of the copy on the shelf
  std::string source;                      ///< path that it was installed from
  std::vector<circuit::LsiClass> classes;  ///< declarations only: their functions stop with a sentence
};

/// $UGOKI_LSI, or ~/.local/share/ugoki/lsi.
[[nodiscard]] std::string default_shelf();

/// By name. A shelf that is not there is empty; damaged entries are reported and left out.
[[nodiscard]] std::vector<ShelfEntry> read_shelf(const std::string& folder, Error* problems = nullptr);

/// The declarations of a library as text, made in a process that may crash: {"name", "version", "doc", "sha256", "classes"}.
[[nodiscard]] Result<std::string> describe_library(const std::string& path);

/// Puts a copy of `path` on the shelf, in place of an older one of the same name.
/// @param description as describe_library gives it; refused if the file has another hash by now
[[nodiscard]] Result<ShelfEntry> put_on_shelf(const std::string& folder, const std::string& path, std::string_view description);
[[nodiscard]] Result<void> remove_from_shelf(const std::string& folder, const std::string& name);

}  // namespace ugoki::plugin
