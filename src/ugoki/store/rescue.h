#pragma once
// Rescue copies save the contents of an open project or library whose file another program replaced or removed. Used by `store` and
// `project`.

#include <functional>
#include <string>

#include "ugoki/base/result.h"

namespace ugoki::store {

/// Calls `make` with the path of a new, empty file of mode 0600 in one folder after the other until `make` succeeds: in the folder of
/// `path`, in the folder of the library, in the folder of temporary files. The file has the name "NAME (rescued DATE TIME)" and the
/// extension of `path`. A file that `make` could not complete is removed.
/// @return the path of the copy, or the last error
[[nodiscard]] Result<std::string> make_rescue_copy(const std::string& path,
                                                   const std::function<Result<void>(const std::string& file)>& make);

}  // namespace ugoki::store
