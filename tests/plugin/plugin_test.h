#pragma once
// Fixture for tests of plug-ins: builds libraries from source text.

#include "folder_test.h"
#include "ugoki/plugin/build.h"
#include "ugoki/plugin/live_library.h"
#include "ugoki/plugin/load.h"

namespace ugoki::plugin {

class PluginTest : public FolderTest {
 protected:
  /// Builds a library. @param name name of the source file @param text text of the source file @return path of the library
  std::string build(const std::string& name, const std::string& text, const std::string& compiler = {}) const {
    const Result<BuildReport> report = build_library({write(name, text), {}, {}, compiler});
    EXPECT_TRUE(report) << (report ? "" : report.error().text());
    return report ? report->output : "";
  }
};

}  // namespace ugoki::plugin
