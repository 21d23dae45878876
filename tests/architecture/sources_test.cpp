// Project rules that a compiler does not check: public headers include no heavy libraries, the core uses neither the operating system nor
// transcendental functions of libm, files are short, and each module has a README.

#include "sources.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <regex>
#include <set>

#include "layers.h"

namespace ugoki::architecture {
namespace {

const std::string root = UGOKI_SOURCE_DIR;

std::set<std::string> core_modules() {
  std::set<std::string> core;
  for (const Layer& layer : read_layers(root + "/tests/architecture/layers.txt"))
    if (layer.core) core.insert(layer.module);
  return core;
}

// The public headers of a module: those that other modules and programs include, directly or indirectly.
std::set<std::string> public_headers(const std::vector<SourceFile>& modules, const std::vector<SourceFile>& programs) {
  std::map<std::string, const SourceFile*> headers;
  for (const SourceFile& file : modules)
    if (file.header) headers[file.path] = &file;
  std::vector<std::string> open;
  const auto note = [&](const SourceFile& file) {
    for (const Include& include : includes_of(file)) {
      const std::string used = module_of_include(include.target);
      if (!used.empty() && used != file.module) open.push_back("src/" + include.target);
    }
  };
  for (const SourceFile& file : modules) note(file);
  for (const SourceFile& file : programs) note(file);
  std::set<std::string> met;
  while (!open.empty()) {
    const std::string path = open.back();
    open.pop_back();
    if (!headers.contains(path) || !met.insert(path).second) continue;
    for (const Include& include : includes_of(*headers[path])) open.push_back("src/" + include.target);
  }
  return met;
}

TEST(Sources, PublicHeadersAreLight) {
  // The module json may include the JSON library, because other modules use JSON through it.
  const std::set<std::string> shared_inside = {"src/ugoki/json/json.h"};
  const std::regex heavy("(Eigen|nlohmann|boost|sqlite3|CLI|mujoco|iostream|fstream|regex).*");
  const std::vector<SourceFile> modules = read_sources(root, "src/ugoki");
  const std::set<std::string> met = public_headers(modules, read_sources(root, "apps"));
  EXPECT_FALSE(met.empty());
  for (const SourceFile& file : modules) {
    if (!met.contains(file.path) || shared_inside.contains(file.path)) continue;
    for (const Include& include : includes_of(file)) {
      EXPECT_FALSE(std::regex_match(include.target, heavy))
          << file.location(include.line) << ": other modules include this header, so it may not include " << include.target;
    }
  }
}

TEST(Sources, HeadersAreIncludedOnce) {
  for (const char* folder : {"src", "apps", "tests", "benchmarks"}) {
    for (const SourceFile& file : read_sources(root, folder)) {
      if (!file.header) continue;
      EXPECT_TRUE(!file.lines.empty() && file.lines[0] == "#pragma once") << file.location(0) << ": must begin with #pragma once";
    }
  }
}

TEST(Sources, CoreUsesNoFilesThreadsOrExceptions) {
  const std::set<std::string> core = core_modules();
  const std::set<std::string> forbidden = {
      "thread",   "mutex",   "shared_mutex", "condition_variable", "future",    "filesystem", "fstream", "iostream",
      "unistd.h", "fcntl.h", "chrono",       "stdexcept",          "exception", "random",     "atomic"};
  const std::regex exceptional("\\b(throw|try|catch)\\b");
  for (const SourceFile& file : read_sources(root, "src/ugoki")) {
    if (!core.contains(file.module)) continue;
    for (const Include& include : includes_of(file)) {
      EXPECT_FALSE(forbidden.contains(include.target))
          << file.location(include.line) << ": <" << include.target << "> may not be used in a core module";
    }
    for (std::size_t i = 0; i < file.lines.size(); ++i) {
      EXPECT_FALSE(std::regex_search(code_of(file.lines[i]), exceptional)) << file.location(i) << ": core modules build without exceptions";
    }
  }
}

// libm's transcendental functions differ between machines; those of ugoki/spatial/elementary.h have the same bits everywhere.
TEST(Sources, CoreUsesItsOwnElementaryFunctions) {
  const std::set<std::string> core = core_modules();
  const std::regex libm(
      "\\bstd::(sin|cos|tan|asin|acos|atan|atan2|sinh|cosh|tanh|exp|exp2|expm1|log|log2|log10|log1p|pow|cbrt|hypot|fma)\\b");
  for (const SourceFile& file : read_sources(root, "src/ugoki")) {
    if (!core.contains(file.module)) continue;
    for (std::size_t i = 0; i < file.lines.size(); ++i) {
      EXPECT_FALSE(std::regex_search(code_of(file.lines[i]), libm))
          << file.location(i) << ": use ugoki/spatial/elementary.h, which has the same bits on all machines";
    }
  }
}

TEST(Sources, FilesAreShort) {
  constexpr std::size_t maximum = 600;
  for (const char* folder : {"src", "apps", "tests", "benchmarks"}) {
    for (const SourceFile& file : read_sources(root, folder)) {
      EXPECT_LE(file.lines.size(), maximum) << file.path << ": longer than " << maximum << " lines; split the file";
    }
  }
}

TEST(Sources, NoUnfinishedWorkIsMarked) {
  const std::regex later("\\b(TO[D]O|FIX[M]E)\\b");
  for (const char* folder : {"src", "apps", "tests", "benchmarks"}) {
    for (const SourceFile& file : read_sources(root, folder)) {
      for (std::size_t i = 0; i < file.lines.size(); ++i) {
        EXPECT_FALSE(std::regex_search(file.lines[i], later)) << file.location(i) << ": finish it, or open an issue";
      }
    }
  }
}

TEST(Sources, EveryModuleHasAReadme) {
  for (const Layer& layer : read_layers(root + "/tests/architecture/layers.txt")) {
    const std::filesystem::path folder = std::filesystem::path(root) / "src/ugoki" / layer.module;
    if (!std::filesystem::exists(folder / "CMakeLists.txt")) continue;
    EXPECT_TRUE(std::filesystem::exists(folder / "README.md")) << "src/ugoki/" << layer.module << "/README.md is missing";
  }
}

TEST(Sources, ReadsIncludesAndCode) {
  SourceFile file;
  file.lines = {"#include <cmath>", "  #  include \"ugoki/base/result.h\"", "// #include <thread>", "x = \"throw \\\" try\";  // catch"};
  const std::vector<Include> includes = includes_of(file);
  ASSERT_EQ(includes.size(), 2u);
  EXPECT_EQ(includes[0].target, "cmath");
  EXPECT_EQ(module_of_include(includes[1].target), "base");
  EXPECT_EQ(includes[1].line, 1u);
  EXPECT_EQ(code_of(file.lines[3]), "x = \"\";  ");
}

}  // namespace
}  // namespace ugoki::architecture
