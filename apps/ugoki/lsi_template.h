#pragma once
// What `ugoki lsi new` writes.

#include <string>
#include <vector>

#include "ugoki/base/result.h"

namespace ugoki::cli {

/// Makes the folder `path` with a source, a test and a README, named after its last part. @return the files
[[nodiscard]] Result<std::vector<std::string>> make_template(const std::string& path, bool cpp);

}  // namespace ugoki::cli
