// Tests of imports in two steps: a staged file is not in the library until it is stored.

#include "ugoki/studio/import_service.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "ugoki/base/base64.h"
#include "ugoki/formats/bvh.h"
#include "ugoki/samples/samples.h"
#include "ugoki/store/library.h"

namespace ugoki::studio {
namespace {

using Json = nlohmann::json;

class ImportServiceTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("ugoki-import-" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
    path_ = (folder_ / "library.db").string();
    service_ = std::make_unique<ImportService>();
  }
  void TearDown() override {
    service_.reset();
    std::filesystem::remove_all(folder_);
  }
  [[nodiscard]] std::size_t entries() const {
    const auto library = store::Library::open(path_);
    std::size_t count = 0;
    for (const store::EntryKind kind : store::entry_kinds) count += *library->count(kind);
    return count;
  }

  std::filesystem::path folder_;
  std::string path_;
  /// Stores a stage in the library and drops it, as the studio does.
  Result<std::string> store(const std::string& id, const std::string& name, const std::vector<std::string>& tags) {
    const Result<intake::Intake> entries = service_->prepare(id, name, tags);
    if (!entries) return fail(entries.error());
    Result<store::Library> library = store::Library::open(path_);
    if (!library) return fail(std::move(library.error()));
    Result<std::string> stored = ImportService::store(*entries, *library);
    if (stored) service_->drop(id);
    return stored;
  }

  std::unique_ptr<ImportService> service_;
};

TEST_F(ImportServiceTest, StageIsShownCorrectedAndStored) {
  formats::BvhWriteOptions z_up;
  z_up.z_up = true;
  const auto first = service_->stage("folder/walk.bvh", formats::write_bvh(samples::make_human_walk(), z_up), {});
  ASSERT_TRUE(first) << first.error().text();
  Json shown = Json::parse(*first);
  EXPECT_EQ(shown["file"], "walk.bvh");
  EXPECT_EQ(shown["settings"]["up"], "z") << "up follows from the posture of the character";
  EXPECT_FALSE(shown["report"]["guessed"].empty());
  EXPECT_EQ(entries(), 0u);

  const std::string id = shown["stage"];
  EXPECT_FALSE(service_->restage(id, {0, "z", "z", 0})) << "up and forward must be different axes";
  EXPECT_FALSE(service_->restage(id, {0, "up", "z", 0}));
  const auto second = service_->restage(id, {0, "z", "x", 60});
  ASSERT_TRUE(second) << second.error().text();
  shown = Json::parse(*second);
  EXPECT_TRUE(shown["report"]["check"].empty()) << shown["report"]["check"].dump();
  EXPECT_EQ(shown["settings"]["rate"], 60);
  EXPECT_NEAR(shown["mechanism"]["height"].get<double>(), 1.75, 0.08);
  const Json& motion = shown["motion"];
  const auto bytes = from_base64(motion["poses"].get<std::string>());
  ASSERT_TRUE(bytes);
  EXPECT_EQ(bytes->size(), motion["count"].get<std::size_t>() * motion["links"].get<std::size_t>() * 7 * sizeof(float));
  EXPECT_EQ(entries(), 0u);

  const auto stored = store(id, "Stroll", {"own"});
  ASSERT_TRUE(stored) << stored.error().text();
  EXPECT_EQ(Json::parse(*stored)["entries"].size(), 2u);
  EXPECT_EQ(entries(), 3u) << "expected a mechanism, measured data and a motion";
  const auto library = store::Library::open(path_);
  const auto body = library->resolve("Stroll", "mechanism");
  ASSERT_TRUE(body) << body.error().text();
  EXPECT_EQ(Json::parse(body->summary)["height"], shown["mechanism"]["height"]) << "preview and library show the same height";
  const auto entry = library->resolve("Stroll", "motion");
  ASSERT_TRUE(entry) << entry.error().text();
  EXPECT_EQ(entry->tags, std::vector<std::string>{"own"});
  EXPECT_FALSE(store(id, "", {})) << "the stage has ended";
}

TEST_F(ImportServiceTest, RejectedOrDroppedStagesStoreNothing) {
  const auto broken = service_->stage("broken.bvh", "HIERARCHY\nROOT Hips\n{\n  OFFSET 0 0\n", {});
  ASSERT_FALSE(broken);
  EXPECT_FALSE(broken.error().problems.front().message.empty());
  EXPECT_FALSE(service_->stage("12_01.amc", ":FULLY-SPECIFIED\n1\n", {})) << "an AMC file without skeleton must be rejected";
  EXPECT_FALSE(service_->companion("12.asf", "not a skeleton"));
  const auto staged = service_->stage("walk.bvh", formats::write_bvh(samples::make_human_walk()), {});
  ASSERT_TRUE(staged);
  const std::string id = Json::parse(*staged)["stage"];
  service_->drop(id);
  service_->drop(id);
  EXPECT_FALSE(store(id, "", {}));
  EXPECT_EQ(entries(), 0u);
}

TEST_F(ImportServiceTest, RobotUsesMeshesSentAsCompanions) {
  const std::string robot =
      "<robot name='r'><link name='a'><inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial>"
      "<collision><geometry><mesh filename='package://r/meshes/Part.OBJ'/></geometry></collision></link></robot>";
  const std::string obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
  const auto without = service_->stage("r.urdf", robot, {});
  ASSERT_TRUE(without) << without.error().text();
  const auto shapes = [](const std::string& answer) { return Json::parse(answer)["mechanism"]["links"][0]["shapes"].size(); };
  EXPECT_EQ(shapes(*without), 0u);
  ASSERT_TRUE(service_->companion("meshes/part.obj", obj));
  const auto with = service_->stage("r.urdf", robot, {});
  ASSERT_TRUE(with) << with.error().text();
  EXPECT_EQ(shapes(*with), 1u);
}

TEST_F(ImportServiceTest, ReferenceCharacterHasRequestedHeight) {
  for (const double height : {1.8, 1.2}) {
    const auto character = reference_character_json(height);
    ASSERT_TRUE(character) << character.error().text();
    EXPECT_NEAR(Json::parse(*character)["height"].get<double>(), height, 0.02 * height);
  }
}

}  // namespace
}  // namespace ugoki::studio
