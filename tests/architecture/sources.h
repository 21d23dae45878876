#pragma once
// The source files of the project as text, with the parts that the rules check.

#include <string>
#include <utility>
#include <vector>

namespace ugoki::architecture {

struct SourceFile {
  std::string path;    ///< relative to the project's root: "src/ugoki/base/result.h"
  std::string module;  ///< name of the module, such as "base"; empty outside src/ugoki
  bool header = false;
  std::vector<std::string> lines;

  /// "path:line".
  [[nodiscard]] std::string location(std::size_t line) const { return path + ":" + std::to_string(line + 1); }
};

/// An #include directive: its line (from 0) and the text between the quotes or brackets.
struct Include {
  std::size_t line = 0;
  std::string target;
};

/// All .h and .cpp files below `folder` (relative to the root), sorted by path.
std::vector<SourceFile> read_sources(const std::string& root, const std::string& folder);

std::vector<Include> includes_of(const SourceFile& file);

/// Module of an include: "base" for "ugoki/base/result.h"; empty for other libraries.
std::string module_of_include(const std::string& target);

/// The line without its // comment and with blanked contents of string literals.
std::string code_of(const std::string& line);

}  // namespace ugoki::architecture
