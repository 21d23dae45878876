#pragma once
// The shelf: a folder with the libraries of LSIs that the user has installed. For each library it contains a copy of the file and a
// manifest (NAME.json) with its SHA-256 and declarations. Reading the shelf runs no foreign code.

#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/circuit/lsi_class.h"

namespace ugoki::plugin {

/// An installed library of LSIs.
struct ShelfEntry {
  std::string name, version, doc;
  std::string hash;                        ///< SHA-256 of the copy, 64 hexadecimal digits
  std::string file;                        ///< path of the copy on the shelf
  std::string source;                      ///< path of the file that was installed
  std::vector<circuit::LsiClass> classes;  ///< declarations only: calling their functions stops the circuit with a message
};

/// Folder of the shelf: $UGOKI_LSI if set, else $XDG_DATA_HOME/ugoki/lsi if set, else ~/.local/share/ugoki/lsi.
[[nodiscard]] std::string default_shelf();

/// The installed libraries, sorted by name. A missing folder is an empty shelf. @param problems [out] faults of damaged entries, which are
/// left out; null: ignored
[[nodiscard]] std::vector<ShelfEntry> read_shelf(const std::string& folder, Error* problems = nullptr);

/// The declarations of a library as JSON text: {"name", "version", "doc", "sha256", "classes"}. Loads the library; call it only in a
/// process that may crash. Errors: see load_library. @param hash expected SHA-256 of the file; empty: any file
[[nodiscard]] Result<std::string> describe_library(const std::string& path, const std::string& hash = {});

/// Installs a copy of the file `path` on the shelf; replaces an installed library of the same name.
/// Errors: the file has changed since it was described; the shelf cannot be written. @param description result of describe_library
[[nodiscard]] Result<ShelfEntry> put_on_shelf(const std::string& folder, const std::string& path, std::string_view description);
/// Removes an installed library. Errors: no library has this name; its file cannot be removed.
[[nodiscard]] Result<void> remove_from_shelf(const std::string& folder, const std::string& name);

}  // namespace ugoki::plugin
