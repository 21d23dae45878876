#pragma once
// The template of an LSI library that `ugoki lsi new` writes.

#include <string>
#include <vector>

#include "ugoki/base/result.h"

namespace ugoki::cli {

/// Creates the folder `path` with a source, a test and a README; the library is named after the folder.
/// @return paths of the created files
[[nodiscard]] Result<std::vector<std::string>> make_template(const std::string& path, bool cpp);

}  // namespace ugoki::cli
