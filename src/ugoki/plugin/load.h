#pragma once
// Loads a library of LSIs into this process and checks its declarations. Loading a shared library runs foreign code; the code of an FMU
// runs when a circuit first uses it. Load only in a process that may crash (run_guarded, the studio's interpreter), never in a process
// that has an unsaved project.

#include <memory>
#include <string>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/circuit/lsi_class.h"

namespace ugoki::plugin {

/// A loaded library. The names of its classes begin with the library's name: "springs/damper".
struct LoadedLibrary {
  std::string name, version, doc;
  std::string hash;  ///< SHA-256 of the file
  std::vector<circuit::LsiClass> classes;
  std::shared_ptr<void> code;  ///< owner of the loaded code of `classes`
};

/// Checks the file of a library without loading it. Errors: the file is missing, is not a regular file, cannot be read, is larger than
/// 1 GiB, or has another hash. @param hash expected SHA-256 of the file, 64 hexadecimal digits; empty: any hash
[[nodiscard]] Result<void> check_library_file(const std::string& path, const std::string& hash);

/// Loads a shared library or an FMU. A shared library is loaded from a private copy, so its file may be replaced while the library is in
/// use. Errors (location: the path, or the LSI): those of check_library_file(); the file cannot be opened, is not a library of LSIs, was
/// built for another version of the interface, or has contradictory declarations.
/// @param hash expected SHA-256 of the file, 64 hexadecimal digits; another file is refused; empty: any file
[[nodiscard]] Result<LoadedLibrary> load_library(const std::string& path, const std::string& hash = {});

/// Tests whether a library works on this machine: starts an instance of an FMU and ends it; loads a shared library.
/// @param hash as in load_library
[[nodiscard]] Result<void> try_library(const std::string& path, const std::string& hash = {});

}  // namespace ugoki::plugin
