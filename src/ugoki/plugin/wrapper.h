#pragma once
// Second half of the LSI builder: writes C or C++ code that describes the functions of a source file in tables, which host programs read.

#include <string>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/plugin/source.h"

namespace ugoki::plugin {

/// Generated wrapper code of a source file.
struct Wrapper {
  std::string code;                ///< text of a file that includes the user's file
  std::vector<std::string> lsis;   ///< names of the LSIs, in the order of the source file
  std::vector<std::string> notes;  ///< functions that are not LSIs: "spring.c:12: 'load' does not become an LSI: ..."
};

/// File name in the compiler's messages about generated code.
inline constexpr const char* generated_file = "generated-lsis";

/// Writes the wrapper of a source file. @param path absolute path of the user's file @param name name of the library
/// Errors (location: "spring.c:12"): no function can be an LSI; an annotation names no parameter, or contradicts the declaration.
[[nodiscard]] Result<Wrapper> make_wrapper(const CSource& source, const std::string& path, const std::string& name, bool cpp);

}  // namespace ugoki::plugin
