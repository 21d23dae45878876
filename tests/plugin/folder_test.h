#pragma once
// Fixture for tests of installed LSIs and FMUs: a temporary folder, the signal LSIs, and functions to parse circuits and read pins.

#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "ugoki/circuit/interpreter.h"
#include "ugoki/circuit/signal_lsis.h"

namespace ugoki::plugin {

class FolderTest : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = (std::filesystem::temp_directory_path() / "ugoki-lsi-test-XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
    circuit::add_signal_lsis(signals_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  /// Writes a file into the folder. @return its path
  std::string write(const std::string& name, const std::string& bytes) const {
    std::ofstream(folder_ + "/" + name, std::ios::binary) << bytes;
    return folder_ + "/" + name;
  }
  static circuit::Circuit parse(const std::string& text) {
    auto c = circuit::read_circuit(text);
    EXPECT_TRUE(c) << (c ? "" : c.error().text());
    return c ? *c : circuit::Circuit{};
  }
  /// First number of an output, "id.pin".
  static double value(const circuit::Interpreter& i, const std::string& pin) {
    const auto view = i.find_output(pin);
    EXPECT_TRUE(view) << pin;
    return view ? view->numbers()[0] : -1e99;
  }

  std::string folder_;
  circuit::Library signals_;
};

}  // namespace ugoki::plugin
