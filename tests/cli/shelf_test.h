#pragma once
// Test fixture for installed LSIs on the command line: a folder with its own shelf (the folder of installed libraries).

#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "program.h"

namespace ugoki::cli {

class ShelfTest : public ::testing::Test {
 protected:
  using Json = nlohmann::json;

  void SetUp() override {
    std::string name = (std::filesystem::temp_directory_path() / "ugoki-lsi-cli-XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  Output ugoki(const std::vector<std::string>& arguments) const { return run_program(arguments, {"UGOKI_LSI=" + folder_ + "/shelf"}); }
  Json json(std::vector<std::string> arguments) const {
    arguments.emplace_back("--json");
    const Output o = ugoki(arguments);
    EXPECT_EQ(o.status, 0) << o.out << o.err;
    Json j = Json::parse(o.out, nullptr, false);
    EXPECT_FALSE(j.is_discarded()) << o.out;
    return j;
  }
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ + "/" + name, std::ios::binary) << text;
    return folder_ + "/" + name;
  }
  /// Runs the program and expects exit status 1. @return the text of the error
  std::string fails(const std::vector<std::string>& arguments, const std::string& part = {}) const {
    const Output o = ugoki(arguments);
    EXPECT_EQ(o.status, 1) << o.out;
    EXPECT_NE(o.err.find(part), std::string::npos) << o.err;
    return o.err;
  }

  std::string folder_;
};

}  // namespace ugoki::cli
