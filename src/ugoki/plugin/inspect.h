#pragma once
// Reads what the file of an LSI library states about itself, so that the user can decide whether to trust it. The file is read as data:
// nothing in it is loaded or executed.

#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"

namespace ugoki::plugin {

/// What the file of a library states about itself. Texts are from an untrusted file; control characters are replaced by '?'.
struct Inspection {
  std::string hash;                 ///< SHA-256 of the file, 64 hexadecimal digits
  bool fmu = false;                 ///< the file is an FMU; the fields below are empty then
  std::string name;                 ///< name of the library; empty: the file does not state it
  std::vector<std::string> lsis;    ///< names of the LSIs; empty: the file does not state them
  std::vector<std::string> needed;  ///< further libraries that are loaded with it, without those of C and C++; the hash does not cover them
  std::string search_path;          ///< folders in which these are searched first (DT_RUNPATH, DT_RPATH); may be empty
  std::vector<std::string> writable;  ///< global and static variables that the code can change, sorted
};

/// Inspects the file `path`. Errors: it cannot be read; it is neither an FMU nor an ELF shared library for this machine that exports
/// ugoki_lsi_library; its ELF tables are damaged.
[[nodiscard]] Result<Inspection> inspect_library(const std::string& path);

/// Inspects the bytes of an ELF file as inspect_library() does; `hash` stays empty. @param location name of the file in error messages
[[nodiscard]] Result<Inspection> inspect_elf(std::string_view bytes, const std::string& location);

/// A sentence for each writable variable: such a variable keeps its value when a circuit restarts, so a second run may give other results.
[[nodiscard]] std::vector<std::string> writable_warnings(const Inspection& inspection, const std::string& location);

}  // namespace ugoki::plugin
