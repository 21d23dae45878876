#pragma once
// A library of LSIs in this process: opened, its declarations checked. Opening runs foreign code (of an FMU: its first use in a circuit
// does), so it is done in a process that may end (run_guarded, the studio's interpreter), never in the one that holds a project.

#include <memory>
#include <string>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/circuit/lsi_class.h"

namespace ugoki::plugin {

/// Names of classes get the library's name in front: "springs/damper".
struct LoadedLibrary {
  std::string name, version, doc;
  std::string hash;  ///< SHA-256 of the file
  std::vector<circuit::LsiClass> classes;
  std::shared_ptr<void> code;  ///< the functions of `classes` live as long as this
};

/// A shared library, or an FMU.
/// Errors (place: the path, or the LSI and pin): it cannot be opened, it is no library of LSIs, its interface has another version, its
/// declarations contradict themselves. The file may be replaced while it is loaded: what runs is a copy.
/// @param hash not empty: refused if the file has another one
[[nodiscard]] Result<LoadedLibrary> load_library(const std::string& path, const std::string& hash = {});

/// Starts an FMU and ends it again; a shared library is only opened.
[[nodiscard]] Result<void> try_library(const std::string& path);

}  // namespace ugoki::plugin
