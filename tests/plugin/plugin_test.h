#pragma once
// What the tests of plug-ins share: a folder of their own, and libraries built from text.

#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "ugoki/circuit/interpreter.h"
#include "ugoki/circuit/signal_lsis.h"
#include "ugoki/plugin/build.h"
#include "ugoki/plugin/live_library.h"
#include "ugoki/plugin/load.h"

namespace ugoki::plugin {

class PluginTest : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = (std::filesystem::temp_directory_path() / "ugoki-plugin-test-XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
    circuit::add_signal_lsis(signals_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ + "/" + name, std::ios::binary) << text;
    return folder_ + "/" + name;
  }
  /// @return path of the library
  std::string build(const std::string& name, const std::string& text, const std::string& compiler = {}) const {
    const Result<BuildReport> report = build_library({write(name, text), {}, {}, compiler});
    EXPECT_TRUE(report) << (report ? "" : report.error().text());
    return report ? report->output : "";
  }
  static circuit::Circuit parse(const std::string& text) {
    auto c = circuit::read_circuit(text);
    EXPECT_TRUE(c) << (c ? "" : c.error().text());
    return c ? *c : circuit::Circuit{};
  }
  static double value(const circuit::Interpreter& i, const std::string& pin) {
    const auto view = i.find_output(pin);
    EXPECT_TRUE(view) << pin;
    return view ? view->numbers()[0] : -1e99;
  }

  std::string folder_;
  circuit::Library signals_;
};

}  // namespace ugoki::plugin
