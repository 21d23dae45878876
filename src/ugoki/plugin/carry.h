#pragma once
// Finds the installed libraries whose LSIs a circuit uses, for programs that carry them along (`ugoki export --native --carry-lsis`).

#include <span>
#include <string>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/circuit/circuit.h"
#include "ugoki/circuit/library.h"
#include "ugoki/plugin/shelf.h"

namespace ugoki::plugin {

/// The file of an installed library.
struct CarriedFile {
  std::string library;  ///< name of the library
  std::string name;     ///< name of the file
  std::string hash;     ///< SHA-256 of the file, 64 hexadecimal digits
  std::string bytes;
};

/// Returns the files of the libraries whose LSIs `circuit` uses at any level, sorted by the name of the library. Runs no code of them.
/// @param own the program's own LSIs @param shelf the installed libraries
/// Errors: the circuit is unfinished or uses an unknown LSI; a library is an FMU, which programs cannot carry; a file is missing or was
/// changed after its installation.
[[nodiscard]] Result<std::vector<CarriedFile>> libraries_of(const circuit::Circuit& circuit, const circuit::Library& own,
                                                            std::span<const ShelfEntry> shelf);

}  // namespace ugoki::plugin
