#include "sources.h"

#include <algorithm>
#include <filesystem>
#include <fstream>

namespace ugoki::architecture {

namespace fs = std::filesystem;

std::vector<SourceFile> read_sources(const std::string& root, const std::string& folder) {
  std::vector<SourceFile> files;
  if (!fs::is_directory(fs::path(root) / folder)) return files;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(fs::path(root) / folder)) {
    const std::string extension = entry.path().extension().string();
    if (!entry.is_regular_file() || (extension != ".h" && extension != ".cpp")) continue;
    SourceFile file;
    file.path = fs::relative(entry.path(), root).generic_string();
    file.header = extension == ".h";
    constexpr std::string_view modules = "src/ugoki/";
    if (file.path.starts_with(modules)) {
      const std::string below = file.path.substr(modules.size());
      if (below.find('/') != std::string::npos) file.module = below.substr(0, below.find('/'));
    }
    std::ifstream stream(entry.path());
    for (std::string line; std::getline(stream, line);) file.lines.push_back(line);
    files.push_back(std::move(file));
  }
  std::sort(files.begin(), files.end(), [](const SourceFile& a, const SourceFile& b) { return a.path < b.path; });
  return files;
}

std::vector<Include> includes_of(const SourceFile& file) {
  std::vector<Include> includes;
  for (std::size_t i = 0; i < file.lines.size(); ++i) {
    const std::string& line = file.lines[i];
    const std::size_t hash = line.find_first_not_of(" \t");
    if (hash == std::string::npos || line[hash] != '#') continue;
    const std::size_t word = line.find_first_not_of(" \t", hash + 1);
    if (word == std::string::npos || line.compare(word, 7, "include") != 0) continue;
    const std::size_t open = line.find_first_of("\"<", word);
    const std::size_t close = open == std::string::npos ? open : line.find_first_of("\">", open + 1);
    if (close == std::string::npos) continue;
    includes.push_back({i, line.substr(open + 1, close - open - 1)});
  }
  return includes;
}

std::string module_of_include(const std::string& target) {
  constexpr std::string_view ours = "ugoki/";
  if (!target.starts_with(ours)) return {};
  const std::size_t end = target.find('/', ours.size());
  return end == std::string::npos ? std::string() : target.substr(ours.size(), end - ours.size());
}

std::string code_of(const std::string& line) {
  std::string code;
  bool in_string = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (!in_string && line.compare(i, 2, "//") == 0) break;
    if (in_string && line[i] == '\\') {
      ++i;
      continue;
    }
    const bool digit_separator = line[i] == '\'';
    if (line[i] == '"' && !digit_separator && (i == 0 || line[i - 1] != '\'')) {
      in_string = !in_string;
      code += '"';
    } else if (!in_string) {
      code += line[i];
    }
  }
  return code;
}

}  // namespace ugoki::architecture
