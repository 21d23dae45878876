#pragma once
// LSI builder: compiles a C or C++ file to a library of software LSIs (components of circuits).

#include <functional>
#include <string>
#include <vector>

#include "ugoki/base/result.h"

namespace ugoki::plugin {

/// Inputs of build_library().
struct BuildRequest {
  std::string source;    ///< path of the user's file: *.c, *.cpp, *.cc, *.cxx or *.C
  std::string output;    ///< path of the library; empty: as `source`, with the extension .so
  std::string name;      ///< name of the library; empty: `@library NAME` in the first comment, or the file's name
  std::string compiler;  ///< name or path; empty: the first installed one of clang-19, clang, gcc (C++: clang++-19, clang++, g++)
  std::function<bool()> cancelled = {};  ///< true: the compiler is stopped, and build_library() fails with `cancelled`; may be empty
};

/// Result of build_library().
struct BuildReport {
  std::string output, name, compiler;  ///< path and name of the library; path of the compiler
  std::vector<std::string> notes;      ///< sentences about functions that do not become LSIs, with the reason
  std::vector<std::string> warnings;   ///< warnings of the compiler: "spring.c:12:3: ..."
};

/// Builds a library. Runs the compiler as a child process, for at most 300 s.
/// Errors: the file cannot be read or has no function that can be an LSI; an annotation is wrong (see make_wrapper); there is no
/// compiler; the compiler failed.
/// The location of a compiler's error is the line in the user's file.
[[nodiscard]] Result<BuildReport> build_library(const BuildRequest& request);

/// Path of a compiler for C or C++. @param wanted name or path; empty: the first installed one, as in BuildRequest::compiler
/// Error: none is installed; the remedy names the package to install.
[[nodiscard]] Result<std::string> find_compiler(bool cpp, const std::string& wanted = {});

/// A header that source files of LSIs include, as it is in the repository.
struct Header {
  const char* path;  ///< path below the include folder: "ugoki/lsi.h"
  const char* text;
};
/// The headers ugoki/lsi.h and ugoki/lsi.hpp.
[[nodiscard]] const std::vector<Header>& public_headers();

}  // namespace ugoki::plugin
