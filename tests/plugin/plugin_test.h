#pragma once
// What the tests of plug-ins share: libraries built from text.

#include "folder_test.h"
#include "ugoki/plugin/build.h"
#include "ugoki/plugin/live_library.h"
#include "ugoki/plugin/load.h"

namespace ugoki::plugin {

class PluginTest : public FolderTest {
 protected:
  /// @return path of the library
  std::string build(const std::string& name, const std::string& text, const std::string& compiler = {}) const {
    const Result<BuildReport> report = build_library({write(name, text), {}, {}, compiler});
    EXPECT_TRUE(report) << (report ? "" : report.error().text());
    return report ? report->output : "";
  }
};

}  // namespace ugoki::plugin
