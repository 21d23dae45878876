#pragma once
// Fixture of tests with a project file in a temporary folder.

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "fixture.h"
#include "ugoki/project/project.h"

namespace ugoki::project {

class ProjectFixture : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = (std::filesystem::temp_directory_path() / "ugoki-project-XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
    path_ = name + "/park.ugoki";
  }
  void TearDown() override {
    std::filesystem::permissions(folder_, std::filesystem::perms::owner_all);
    std::filesystem::remove_all(folder_);
  }
  /// Creates the project of content/fixture.h.
  Project make() const {
    auto project = Project::create(path_, content::testing::make_scenario(), content::testing::make_resources());
    EXPECT_TRUE(project) << (project ? "" : project.error().text());
    return std::move(*project);
  }
  static std::string read(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  static void write(const std::string& path, const std::string& bytes) { std::ofstream(path, std::ios::binary) << bytes; }
  static std::string move_clip(double start) {
    return R"({"type": "clip.set", "character": "human", "id": "k3", "start": )" + std::to_string(start) + "}";
  }

  std::string folder_, path_;
};

}  // namespace ugoki::project
