#include "ugoki/mechanism_edit/edit.h"

#include <gtest/gtest.h>

#include "random_loops.h"
#include "whole.h"

namespace ugoki {
namespace {

MechanismPtr arm() {
  MechanismSpec spec{.name = "arm", .links = {}};
  LinkSpec upper = testing::link_of("upper:arm", "", JointType::revolute);
  upper.shapes = {Shape::capsule(0.05, {}, {0, 0, -0.3})};
  upper.inertia = solid_inertia(upper.shapes[0], 1000);
  LinkSpec lower = upper;
  lower.name = "lower";
  lower.parent = upper.name;
  lower.joint.X_PJ.p = {0, 0, -0.3};
  spec.links = {upper, lower};
  spec.loops = {{.name = "stay", .type = LoopType::ball, .link_a = "", .link_b = "lower"}};
  spec.exclusions = {{"lower", "upper:arm"}};
  return *Mechanism::make(spec);
}

Result<Edited> edit_with(const Mechanism& m, std::initializer_list<std::string_view> texts) {
  std::vector<Assignment> list;
  for (const std::string_view text : texts) list.push_back(*parse_assignment(text));
  return edit(m, list);
}

TEST(Edit, SetsEveryField) {
  const MechanismPtr m = arm();
  const auto e = edit_with(
      *m, {"lower:joint.lower=-0.5", "lower:joint.upper=2.5", "lower:joint.damping=0.3", "lower:joint.stiffness=4", "lower:joint.rest=0.1",
           "lower:joint.armature=0.01", "lower:joint.friction=0.2", "lower:joint.effort.0=50", "lower:joint.axis=0, 3,0",
           "lower:joint.position=0,0,-0.25", "lower:joint.rotation=1,0,0,1", "upper:arm:joint.type=universal",
           "upper:arm:label=upper arm left", "lower:shapes.friction=0.4", "lower:shapes.collides=false", "lower:name=forearm"});
  ASSERT_TRUE(e.has_value()) << e.error().text();
  const Link& l = e->mechanism->link(e->mechanism->find_link("forearm"));
  const Dof& f = l.joint.dofs[0];
  EXPECT_EQ(f, (Dof{-0.5, 2.5, 0.3, 4, 0.1, 0.01, 0.2, 50}));
  EXPECT_EQ(l.joint.axis, (Vec3{0, 1, 0}));
  EXPECT_EQ(l.joint.X_PJ.p, (Vec3{0, 0, -0.25}));
  EXPECT_NEAR(l.joint.X_PJ.R.yx, 1, 1e-15);
  EXPECT_EQ(l.shapes[0].friction, 0.4);
  EXPECT_FALSE(l.shapes[0].collides);
  EXPECT_EQ(e->mechanism->link(0).joint.type, JointType::universal);
  EXPECT_EQ(e->mechanism->link(0).label, "upper arm left");
  EXPECT_EQ(e->mechanism->loops()[0].link_b, e->mechanism->find_link("forearm"));
  EXPECT_EQ(e->mechanism->exclusions().size(), 1u);
  const auto back = edit_with(*e->mechanism, {"forearm:joint.upper=none", "forearm:joint.effort=none"});
  ASSERT_TRUE(back.has_value());
  EXPECT_EQ(back->mechanism->link(1).joint.dofs[0].upper, INFINITY);
}

TEST(Edit, InertiaFieldsKeepTheOtherProperties) {
  const MechanismPtr m = arm();
  const Inertia was = m->link(1).inertia;
  const auto heavy = edit_with(*m, {"lower:inertia.mass=5"});
  const double f = 5 / was.mass;
  EXPECT_LT(testing::difference({5, was.h * f, was.I * f}, heavy->mechanism->link(1).inertia), 1e-14);
  const auto moved = edit_with(*m, {"lower:inertia.centre=0.1,0,-0.2"});
  EXPECT_LT(testing::difference(Inertia::from_centre(was.mass, {0.1, 0, -0.2}, was.about_centre()), moved->mechanism->link(1).inertia),
            1e-14);
  const auto filled = edit_with(*heavy->mechanism, {"lower:inertia.density=1000"});
  EXPECT_LT(testing::difference(was, filled->mechanism->link(1).inertia), 1e-14);
  const auto turned = edit_with(*m, {"lower:inertia.about_centre=0.02,0.02,0.001,0,0,0"});
  EXPECT_NEAR(turned->mechanism->link(1).inertia.about_centre().zz, 0.001, 1e-12);
}

TEST(Edit, AllInvalidAssignmentsAreReportedAndNoneIsApplied) {
  const MechanismPtr m = arm();
  const auto e =
      edit_with(*m, {"hand:joint.lower=0", "lower:joint.lower=low", "lower:joint.lower.3=1", "lower:colour=red", "lower:joint.axis=0,0,0",
                     "lower:inertia.centre=1,2", "lower:joint.type=elbow", "lower:shapes.visible=maybe"});
  ASSERT_FALSE(e.has_value());
  EXPECT_EQ(e.error().problems.size(), 8u);
  for (const Problem& p : e.error().problems) EXPECT_FALSE(p.location.empty() || p.message.empty() || p.remedy.empty());
  EXPECT_FALSE(edit_with(*m, {"lower:inertia.mass=-1"}).has_value());                       // negative mass
  EXPECT_FALSE(edit_with(*m, {"lower:joint.lower=3", "lower:joint.upper=2"}).has_value());  // crossed limits
  EXPECT_FALSE(edit_with(*m, {"lower:inertia.about_centre=1,0.1,0.1,0,0,0"}).has_value());  // triangle inequality
  EXPECT_FALSE(parse_assignment("lower.joint=3").has_value());
  EXPECT_FALSE(parse_assignment("nothing").has_value());
}

}  // namespace
}  // namespace ugoki
