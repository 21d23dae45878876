#pragma once
// Fixture for tests of the whole service over real sockets. The interpreter's process runs a fake simulation.

#include <gtest/gtest.h>
#include <unistd.h>
#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include "../content/fixture.h"
#include "client.h"
#include "fake_simulation.h"
#include "page.h"
#include "ugoki/content/display_frame.h"
#include "ugoki/formats/mechanism_json.h"
#include "ugoki/formats/motion_binary.h"
#include "ugoki/store/library.h"
#include "ugoki/studio/studio.h"

namespace ugoki::studio::test {

using nlohmann::json;

class StudioTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (std::filesystem::temp_directory_path() / "ugoki-studio-XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    folder_ = name;
    Result<store::Library> library = store::Library::open(library_path());
    ASSERT_TRUE(library);
    const Motion run = content::testing::make_walk("run", 1, 3, 0, false);
    const std::string walker = formats::write_mechanism(*content::testing::make_walker());
    store::LibraryItem body{store::EntryKind::mechanism, "walker", R"({"dofs":7,"mass":12})", {}, bytes(walker)};
    const std::string body_id = store::entry_id(store::EntryKind::mechanism, body.data);
    store::LibraryItem motion{store::EntryKind::motion,
                              "run",
                              R"({"duration":1,"rate":100,"frames":101,"mechanism":")" + body_id + R"("})",
                              {"quick"},
                              formats::write_motion(run)};
    const auto put = library->put(std::vector{body, motion});
    ASSERT_TRUE(put) << put.error().text();
    library_mechanism_ = (*put)[0];
    library_motion_ = (*put)[1];
    start(project::Project::create(path(), content::testing::make_scenario(), content::testing::make_resources()));
  }
  void start(Result<project::Project> project) {
    ASSERT_TRUE(project) << project.error().text();
    StudioOptions options;
    options.library_path = library_path();
    options.interpreter = {"/proc/self/exe", {"interpret-fake"}};
    Result<std::unique_ptr<Studio>> started = Studio::start(options, std::move(*project));
    ASSERT_TRUE(started) << started.error().text();
    studio_ = std::move(*started);
  }
  void TearDown() override {
    studio_.reset();
    std::filesystem::remove_all(folder_);
  }
  static std::vector<std::byte> bytes(const std::string& text) {
    const auto* p = reinterpret_cast<const std::byte*>(text.data());
    return {p, p + text.size()};
  }
  std::string path() const { return folder_ + "/park.ugoki"; }
  std::string library_path() const { return folder_ + "/library.db"; }
  Page page() { return {studio_->port(), studio_->token()}; }
  Reply api(const std::string& method, const std::string& target, const std::string& body = "") {
    return request(studio_->port(), method, target, {"Authorization: Bearer " + studio_->token()}, body);
  }
  static json move_clip(double start) {
    return {{"op", "command"}, {"command", {{"type", "clip.set"}, {"character", "human"}, {"id", "k1"}, {"start", start}}}};
  }
  static json rename(const std::string& name) { return {{"op", "command"}, {"command", {{"type", "scenario.set"}, {"name", name}}}}; }

  std::string folder_, library_mechanism_, library_motion_;
  std::unique_ptr<Studio> studio_;
};

}  // namespace ugoki::studio::test
