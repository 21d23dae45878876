#pragma once
// The source files of the project as text, cut into what the rules speak of.

#include <string>
#include <utility>
#include <vector>

namespace ugoki::architecture {

struct SourceFile {
  std::string path;    ///< from the project's root, "src/ugoki/base/result.h"
  std::string module;  ///< "base"; empty outside src/ugoki
  bool header = false;
  std::vector<std::string> lines;

  /// "path:line".
  [[nodiscard]] std::string place(std::size_t line) const { return path + ":" + std::to_string(line + 1); }
};

/// An #include directive: its line (from 0) and what stands between the quotes or brackets.
struct Include {
  std::size_t line = 0;
  std::string target;
};

/// Every .h and .cpp below `folder` (relative to the root), in the order of their paths.
std::vector<SourceFile> read_sources(const std::string& root, const std::string& folder);

std::vector<Include> includes_of(const SourceFile& file);

/// "base" of "ugoki/base/result.h"; empty for what is not ours.
std::string module_of_include(const std::string& target);

/// The line without its // comment and with the contents of its string literals blanked.
std::string code_of(const std::string& line);

}  // namespace ugoki::architecture
