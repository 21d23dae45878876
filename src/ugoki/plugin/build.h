#pragma once
// The LSI builder: from a C or C++ file to a library of LSIs.

#include <string>
#include <vector>

#include "ugoki/base/result.h"

namespace ugoki::plugin {

struct BuildRequest {
  std::string source;    ///< *.c, or *.cpp, *.cc, *.cxx
  std::string output;    ///< empty: the source's name with .so, beside it
  std::string name;      ///< of the library; empty: `@library NAME` in the first comment, or the file's name
  std::string compiler;  ///< empty: the first of clang-19, clang, gcc (clang++-19, clang++, g++) that is there
};

struct BuildReport {
  std::string output, name, compiler;
  std::vector<std::string> notes;     ///< what was not made an LSI, and why
  std::vector<std::string> warnings;  ///< of the compiler, "spring.c:12:3: ..."
};

/// Errors of the compiler have the user's line as their place.
[[nodiscard]] Result<BuildReport> build_library(const BuildRequest& request);

/// Path of the compiler, or an error that says what to install.
[[nodiscard]] Result<std::string> find_compiler(bool cpp, const std::string& wanted = {});

/// The public headers as they are in the repository: ("ugoki/lsi.h", text).
struct Header {
  const char* path;
  const char* text;
};
[[nodiscard]] const std::vector<Header>& public_headers();

}  // namespace ugoki::plugin
