#pragma once
// The LSI builder's second half: from what a file offers to the C code that describes it to a host.

#include <string>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/plugin/source.h"

namespace ugoki::plugin {

struct Wrapper {
  std::string code;                ///< a file that includes the user's
  std::vector<std::string> lsis;   ///< names, in the order of the file
  std::vector<std::string> notes;  ///< "spring.c:12: 'load' was not made an LSI: ..."
};

/// @param path of the user's file, absolute; @param name of the library
/// Errors: nothing can be made an LSI; an annotation names nothing, or contradicts the declaration.
[[nodiscard]] Result<Wrapper> make_wrapper(const CSource& source, const std::string& path, const std::string& name, bool cpp);

}  // namespace ugoki::plugin
