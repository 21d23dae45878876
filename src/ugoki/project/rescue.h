#pragma once
// Rescue copies: the work on a project whose file another program replaced or removed. Internal to project.

#include <functional>
#include <string>

#include "ugoki/base/result.h"

namespace ugoki::project {

/// Calls `make` with the path of a new, empty file of mode 0600, "NAME (rescued DATE TIME).ugoki", until it succeeds: in the folder of
/// `path`, then in the folder of the library, then in the folder of temporary files. A file that `make` could not complete is removed.
/// @return the path of the copy, or the last error
[[nodiscard]] Result<std::string> make_rescue_copy(const std::string& path,
                                                   const std::function<Result<void>(const std::string& file)>& make);

}  // namespace ugoki::project
