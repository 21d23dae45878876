#pragma once
// The tables of a library of LSIs (include/ugoki/lsi.h) as classes of the runtime. Nothing in them is trusted but their addresses.

#include <string>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/circuit/lsi_class.h"

namespace ugoki::plugin {

struct Declared {
  std::string name, version, doc;
  std::vector<circuit::LsiClass> classes;  ///< by name; with functions, without `make`
};

/// Everything wrong is reported. @param place of the library, for messages
[[nodiscard]] Declared read_declarations(const ugoki_library* library, const std::string& place, Error& problems);

}  // namespace ugoki::plugin
