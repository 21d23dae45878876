#include "ugoki/intake/intake.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "ugoki/formats/bvh.h"
#include "ugoki/formats/mechanism_json.h"
#include "ugoki/formats/motion_binary.h"
#include "ugoki/samples/samples.h"

namespace ugoki::intake {
namespace {

TEST(Intake, KindAndSkeletonFollowFromTheName) {
  EXPECT_EQ(file_kind("a/b/walk.BVH"), FileKind::bvh);
  EXPECT_EQ(file_kind("12_01.amc"), FileKind::amc);
  EXPECT_EQ(file_kind("12.asf"), FileKind::asf);
  EXPECT_EQ(file_kind("m.json"), FileKind::mechanism_json);
  EXPECT_EQ(file_kind("r.URDF"), FileKind::robot);
  EXPECT_EQ(file_kind("m.sdf"), FileKind::robot);
  EXPECT_EQ(file_kind("humanoid.xml"), FileKind::robot);
  EXPECT_EQ(file_kind("bvh"), std::nullopt);
  EXPECT_EQ(file_kind("walk.bvh.zip"), std::nullopt);
  EXPECT_EQ(skeleton_name_for("data/12_01.amc"), "data/12.asf");
  EXPECT_EQ(skeleton_name_for("a_b/walk.amc"), "a_b/walk.asf");
}

TEST(Intake, ItemsCanBeReadAndReferToEachOther) {
  const std::string text = formats::write_bvh(samples::make_human_walk());
  IntakeOptions options;
  options.name = "stroll";
  options.tags = {"own"};
  options.mass = 81;
  const auto intake = take_in(text, "folder/walk.bvh", nullptr, options);
  ASSERT_TRUE(intake) << intake.error().text();
  ASSERT_EQ(intake->items.size(), 3u);
  for (const store::LibraryItem& item : intake->items) {
    EXPECT_EQ(item.name, "stroll");
    EXPECT_EQ(item.tags, options.tags);
    EXPECT_NE(item.summary.find("\"source\":\"walk.bvh\""), std::string::npos) << item.summary;
  }
  EXPECT_NEAR(intake->mechanism->mass(), 81, 81 * 1e-9);
  const std::string mechanism_id = intake->id_of(store::EntryKind::mechanism), measured_id = intake->id_of(store::EntryKind::measured);
  EXPECT_NE(intake->items[2].summary.find("\"mechanism\":\"" + mechanism_id + "\""), std::string::npos);
  EXPECT_NE(intake->items[2].summary.find("\"measured\":\"" + measured_id + "\""), std::string::npos);
  const auto mechanism =
      formats::read_mechanism({reinterpret_cast<const char*>(intake->items[0].data.data()), intake->items[0].data.size()}, "mechanism");
  const auto motion = formats::read_motion(intake->items[2].data, "motion");
  ASSERT_TRUE(mechanism && motion);
  EXPECT_TRUE(check_motion(*motion, **mechanism).empty());
  EXPECT_EQ(motion->q, intake->motion->q);

  auto library = store::Library::open(":memory:");
  ASSERT_TRUE(library) << library.error().text();
  const auto ids = put(*library, *intake);
  ASSERT_TRUE(ids) << ids.error().text();
  EXPECT_EQ((*ids)[0], mechanism_id);
  EXPECT_EQ(library->resolve("stroll", "motion")->id, intake->id_of(store::EntryKind::motion));
}

TEST(Intake, MechanismFileGivesOneEntry) {
  const auto intake = take_in(formats::write_mechanism(*samples::make_ball()), "ball.json");
  ASSERT_TRUE(intake) << intake.error().text();
  ASSERT_EQ(intake->items.size(), 1u);
  EXPECT_EQ(intake->items[0].kind, store::EntryKind::mechanism);
  EXPECT_TRUE(intake->id_of(store::EntryKind::motion).empty());
}

TEST(Intake, RobotFileGivesAReadableMechanismEntry) {
  const auto intake =
      take_in("<robot name='rod'><link name='rod'><inertial><mass value='3'/><inertia ixx='1' iyy='1' izz='3'/></inertial></link></robot>",
              "folder/rod.urdf");
  ASSERT_TRUE(intake) << intake.error().text();
  ASSERT_EQ(intake->items.size(), 1u);
  EXPECT_EQ(intake->items[0].name, "rod");
  EXPECT_FALSE(intake->report.empty()) << "the inertia was repaired";
  const auto reread =
      formats::read_mechanism({reinterpret_cast<const char*>(intake->items[0].data.data()), intake->items[0].data.size()}, "mechanism");
  ASSERT_TRUE(reread) << reread.error().text();
  EXPECT_EQ((*reread)->mass(), 3);
  EXPECT_FALSE(take_in("<html/>", "page.xml"));
}

TEST(Intake, CancelledImportsGiveTheirError) {
  const std::string bvh = formats::write_bvh(samples::make_human_walk());
  int calls = 0;
  IntakeOptions options;
  options.cancelled = [&] { return ++calls < 0; };
  ASSERT_TRUE(take_in(bvh, "walk.bvh", nullptr, options));
  const int steps = calls;
  EXPECT_GE(steps, 3) << "before reading, before the body, before the motion";
  for (int stop = 1; stop <= steps; ++stop) {
    calls = 0;
    options.cancelled = [&] { return ++calls == stop; };
    const auto out = take_in(bvh, "walk.bvh", nullptr, options);
    ASSERT_FALSE(out);
    EXPECT_EQ(out.error().problems[0].code, ErrorCode::cancelled);
    EXPECT_EQ(out.error().problems[0].location, "walk.bvh");
    EXPECT_EQ(calls, stop) << "no step follows";
  }
}

TEST(Intake, TwoCharactersInOneFileAreReported) {
  const auto nodes = [](int characters) {  // each character is a chain of five nodes
    std::string list;
    for (int i = 0; i < 5 * characters; ++i) {
      const std::string next = i % 5 < 4 ? R"(, "children": [)" + std::to_string(i + 1) + "]" : "";
      list += (i ? ", " : "") + std::string(R"({"translation": [0, 0.3, 0])") + next + "}";
    }
    return R"({"asset": {"version": "2.0"}, "nodes": [)" + list + "]}";
  };
  const auto reported = [](const std::string& text) {
    const auto intake = take_in(text, "chains.gltf");
    EXPECT_TRUE(intake) << intake.error().text();
    return intake && std::ranges::any_of(intake->conversion.check, [](const std::string& line) {
             return line.find("2 unconnected characters (roots node_0 and node_5)") != std::string::npos &&
                    line.find("--character") != std::string::npos;
           });
  };
  EXPECT_TRUE(reported(nodes(2)));
  EXPECT_FALSE(reported(nodes(1)));
}

TEST(Intake, ErrorsHaveLocationAndRemedy) {
  for (const char* name : {"walk.bvh", "walk.amc", "walk.asf", "walk.json", "walk.urdf", "walk.sdf", "walk.xml", "walk.png", "walk"}) {
    const auto intake = take_in("nonsense", name);
    ASSERT_FALSE(intake) << name;
    EXPECT_TRUE(intake.error().problems.front().location.starts_with(name)) << intake.error().text();
    EXPECT_FALSE(intake.error().problems.front().remedy.empty()) << intake.error().text();
  }
}

}  // namespace
}  // namespace ugoki::intake
