#pragma once
// Conversion of the tables of a library of LSIs (include/ugoki/lsi.h) to classes of the circuit runtime. Sizes, names, types, ranges and
// offsets in the tables are checked; only the addresses in them are trusted.

#include <string>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/circuit/lsi_class.h"

namespace ugoki::plugin {

/// Contents of a library as its tables declare them.
struct Declared {
  std::string name, version, doc;
  std::vector<circuit::LsiClass> classes;  ///< LSIs, sorted by name ("library/lsi"); all functions are set except `make`
};

/// Reads the tables of a library. @param location path of the library, for messages
/// @param problems [out] every fault that was found is added; if there are any, the result must not be used
[[nodiscard]] Declared read_declarations(const ugoki_library* library, const std::string& location, Error& problems);

}  // namespace ugoki::plugin
