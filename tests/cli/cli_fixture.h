#pragma once
// Test fixture: a folder with its own library, in which the program runs as a child process.

#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "program.h"

namespace ugoki::cli {

using Json = nlohmann::json;

class CliTest : public ::testing::Test {
 protected:
  void SetUp() override;
  void TearDown() override;

  [[nodiscard]] Output ugoki(const std::vector<std::string>& arguments) const { return run_program(arguments, environment()); }
  /// Runs the program and expects exit status 0, JSON on stdout and nothing on stderr.
  Json json(std::vector<std::string> arguments) const;  // NOLINT(modernize-use-nodiscard)
  /// Runs the program and expects exit status 0.
  void does(const std::vector<std::string>& arguments) const;
  /// Runs the program and expects exit status 1, an error on stderr that contains `part` and a remedy, and unchanged files. The library is
  /// compared by its listing.
  void fails(const std::vector<std::string>& arguments, const std::string& part) const;
  /// Runs the program and expects exit status 2, nothing on stdout, and unchanged files.
  void misunderstands(const std::vector<std::string>& arguments) const;

  [[nodiscard]] std::vector<std::string> environment() const { return {"UGOKI_LIBRARY=" + library_, "UGOKI_AUTHOR=anna"}; }
  [[nodiscard]] std::string path(const std::string& name) const { return folder_ + "/" + name; }
  /// Writes a file and creates its parent folders. @return its path
  std::string write(const std::string& name, const std::string& text) const;  // NOLINT(modernize-use-nodiscard)
  [[nodiscard]] static std::string read(const std::string& path);
  /// Path of the sample human's walk as a BVH file.
  [[nodiscard]] std::string walk(const std::string& name = "walk.bvh") const;
  [[nodiscard]] std::size_t entries() const { return json({"db", "list"})["entries"].size(); }

  std::string folder_, library_;

 private:
  /// Contents of all files in the folder except the library, by name.
  [[nodiscard]] std::map<std::string, std::string> contents() const;
};

}  // namespace ugoki::cli
