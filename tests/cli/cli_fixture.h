#pragma once
// A folder with a library of its own, in which the program runs as a user runs it.

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
  /// Expects success and JSON on stdout, nothing on stderr.
  Json json(std::vector<std::string> arguments) const;  // NOLINT(modernize-use-nodiscard)
  /// Expects success.
  void does(const std::vector<std::string>& arguments) const;
  /// Expects status 1, an error with this part (its place, or what is wrong) and a remedy on stderr, and every file as it was. The library
  /// is compared by what it lists.
  void fails(const std::vector<std::string>& arguments, const std::string& part) const;
  /// Expects status 2 and nothing on stdout, every file as it was.
  void misunderstands(const std::vector<std::string>& arguments) const;

  [[nodiscard]] std::vector<std::string> environment() const { return {"UGOKI_LIBRARY=" + library_, "UGOKI_AUTHOR=anna"}; }
  [[nodiscard]] std::string path(const std::string& name) const { return folder_ + "/" + name; }
  /// Makes the folders above it. @return its path
  std::string write(const std::string& name, const std::string& text) const;  // NOLINT(modernize-use-nodiscard)
  [[nodiscard]] static std::string read(const std::string& path);
  /// The sample human's walk as a measured file.
  [[nodiscard]] std::string walk(const std::string& name = "walk.bvh") const;
  [[nodiscard]] std::size_t entries() const { return json({"db", "list"})["entries"].size(); }

  std::string folder_, library_;

 private:
  /// Content of every file of the folder but the library.
  [[nodiscard]] std::map<std::string, std::string> contents() const;
};

}  // namespace ugoki::cli
