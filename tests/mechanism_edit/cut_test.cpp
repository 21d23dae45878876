#include "ugoki/mechanism_edit/cut.h"

#include <gtest/gtest.h>

#include "random_loops.h"
#include "ugoki/samples/samples.h"
#include "whole.h"

namespace ugoki {
namespace {

using testing::RandomSource;

bool reports(const Edited& e, std::string_view text) {
  for (const std::string& line : e.report)
    if (line.find(text) != std::string::npos) return true;
  return false;
}

TEST(Cut, PartAndRestAddUpToTheMechanism) {
  for (unsigned seed = 1; seed <= 30; ++seed) {
    SCOPED_TRACE(seed);
    RandomSource random(seed);
    MechanismSpec spec = testing::without_armature(testing::random_spec(random, 12));
    for (int i = 1; i < 12; ++i) spec.exclusions.push_back({"link0", "link" + std::to_string(i)});
    const MechanismPtr m = *Mechanism::make(std::move(spec));
    const std::string at = "link" + std::to_string(1 + random.below(11));
    const auto rest = cut(*m, at), part = cut(*m, at, {.keep = Keep::part});
    ASSERT_TRUE(rest.has_value()) << rest.error().text();
    ASSERT_TRUE(part.has_value()) << part.error().text();
    EXPECT_EQ(rest->mechanism->link_count() + part->mechanism->link_count(), 12);
    EXPECT_EQ(part->mechanism->link(0).name, at);
    EXPECT_EQ(static_cast<int>(rest->mechanism->exclusions().size()), rest->mechanism->link_count() - 1);  // all with link0
    EXPECT_TRUE(part->mechanism->exclusions().empty());
    EXPECT_EQ(part->mechanism->link(0).joint.type, JointType::floating);
    const Inertia sum = testing::whole_inertia(*rest->mechanism, rest->mechanism->neutral()) +
                        testing::whole_inertia(*part->mechanism, part->mechanism->neutral());
    EXPECT_LT(testing::difference(testing::whole_inertia(*m, m->neutral()), sum), 1e-12);
  }
}

TEST(Cut, ReportsDroppedLoopsAndVirtualLinks) {
  RandomSource random(3);
  MechanismSpec spec;
  spec.name = "frame";
  for (const char* name : {"base", "arm", "hand", "leg"}) {
    const std::string parent = std::string(name) == "base" ? "" : std::string(name) == "hand" ? "arm" : "base";
    LinkSpec l = testing::link_of(name, parent, JointType::revolute);
    l.inertia = testing::random_inertia(random);
    spec.links.push_back(l);
  }
  LinkSpec twin = testing::link_of("twin", "leg", JointType::revolute);
  twin.inertia = testing::random_inertia(random);
  twin.real = "hand";
  spec.links.push_back(twin);
  spec.loops = {{.name = "bar", .type = LoopType::ball, .link_a = "hand", .link_b = "leg"},
                {.name = "gears", .type = LoopType::gear, .link_a = "arm", .link_b = "hand"},
                {.name = "rail", .type = LoopType::ball, .link_a = "", .link_b = "hand"},
                {.name = "stay", .type = LoopType::ball, .link_a = "", .link_b = "leg"}};
  const MechanismPtr m = *Mechanism::make(spec);

  const auto rest = cut(*m, "arm");
  ASSERT_TRUE(rest.has_value()) << rest.error().text();
  EXPECT_EQ(rest->mechanism->loops().size(), 1u);
  EXPECT_EQ(rest->mechanism->loops()[0].name, "stay");
  EXPECT_TRUE(reports(*rest, "ball bar between hand and leg was dropped"));
  EXPECT_TRUE(reports(*rest, "gear gears between arm and hand was dropped together"));
  EXPECT_TRUE(reports(*rest, "ball rail between the world and hand was dropped together"));
  EXPECT_TRUE(reports(*rest, "virtual link twin is a link of its own"));
  EXPECT_GE(rest->mechanism->find_link("twin"), 0);

  const auto part = cut(*m, "arm", {.keep = Keep::part});
  ASSERT_TRUE(part.has_value());
  EXPECT_TRUE(reports(*part, "gear gears was dropped"));  // the gear drives the joint at which the cut was made
  EXPECT_EQ(part->mechanism->find_loop("rail"), 0);
  EXPECT_TRUE(reports(*part, "loop at the virtual link twin was dropped"));
}

TEST(Cut, RefusesUnknownLinksEmptyResultsAndOtherBases) {
  const MechanismPtr ball = samples::make_ball();
  EXPECT_EQ(cut(*ball, "handle").error().problems[0].code, ErrorCode::unknown);
  EXPECT_EQ(cut(*ball, ball->link(0).name).error().problems[0].code, ErrorCode::structure);
  EXPECT_EQ(cut(*ball, ball->link(0).name, {.keep = Keep::part, .base = JointType::planar}).error().problems[0].code,
            ErrorCode::unsupported);
}

}  // namespace
}  // namespace ugoki
