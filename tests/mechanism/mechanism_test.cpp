#include "ugoki/mechanism/mechanism.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

namespace ugoki {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
const double nan_value = std::numeric_limits<double>::quiet_NaN();

LinkSpec link(const char* name, const char* parent, JointType type = JointType::revolute) {
  LinkSpec l;
  l.name = name;
  l.parent = parent;
  l.joint.type = type;
  l.joint.X_PJ.p = {0, 0, 0.5};
  l.inertia = Inertia::from_centre(2, {0, 0, 0.2}, {0.1, 0.1, 0.05, 0, 0, 0});
  l.shapes = {Shape::sphere(0.1)};
  return l;
}

/// A trunk with two arms, one of which carries a hand with a finger.
MechanismSpec tree() {
  return {
      "tree",
      {link("trunk", "", JointType::floating), link("left", "trunk", JointType::spherical), link("right", "trunk", JointType::universal),
       link("hand", "left"), link("plate", "hand", JointType::fixed), link("finger", "plate", JointType::cylindrical)}};
}

TEST(Mechanism, ParentChildAndSiblingIndices) {
  const auto made = Mechanism::make(tree());
  ASSERT_TRUE(made.has_value()) << made.error().text();
  const Mechanism& m = **made;
  EXPECT_EQ(m.name(), "tree");
  ASSERT_EQ(m.link_count(), 6);
  const int trunk = m.find_link("trunk"), left = m.find_link("left"), right = m.find_link("right"), hand = m.find_link("hand"),
            finger = m.find_link("finger"), plate = m.find_link("plate");
  EXPECT_EQ(m.link(trunk).parent, -1);
  EXPECT_EQ(m.link(trunk).child, left);
  EXPECT_EQ(m.link(trunk).sibling, -1);
  EXPECT_EQ(m.link(left).parent, trunk);
  EXPECT_EQ(m.link(left).sibling, right);
  EXPECT_EQ(m.link(left).child, hand);
  EXPECT_EQ(m.link(right).sibling, -1);
  EXPECT_EQ(m.link(right).child, -1);
  EXPECT_EQ(m.link(finger).parent, plate);
  EXPECT_EQ(m.link(finger).real, -1);
  EXPECT_EQ(m.find_link("tail"), -1);
  EXPECT_FALSE(m.has_loops());
  EXPECT_DOUBLE_EQ(m.mass(), 12);
}

TEST(Mechanism, CoordinatesAndDofs) {
  const auto made = Mechanism::make(tree());
  ASSERT_TRUE(made.has_value());
  const Mechanism& m = **made;
  EXPECT_EQ(m.nq(), 7 + 4 + 2 + 1 + 0 + 2);
  EXPECT_EQ(m.nv(), 6 + 3 + 2 + 1 + 0 + 2);
  const int right = m.find_link("right"), hand = m.find_link("hand"), finger = m.find_link("finger"), left = m.find_link("left");
  EXPECT_EQ(m.link(right).v_index, 9);
  EXPECT_EQ(m.link(right).q_index, 11);
  EXPECT_EQ(m.link_of_dof(0), 0);
  EXPECT_EQ(m.link_of_dof(m.link(finger).v_index + 1), finger);
  const auto parents = m.dof_parents();
  ASSERT_EQ(parents.size(), 14U);
  const auto parent_of = [&](int i) { return parents[static_cast<std::size_t>(i)]; };
  EXPECT_EQ(parent_of(0), -1);
  EXPECT_EQ(parent_of(5), 4);
  EXPECT_EQ(parent_of(m.link(left).v_index), 5);
  EXPECT_EQ(parent_of(m.link(right).v_index), 5);
  EXPECT_EQ(parent_of(m.link(hand).v_index), m.link(left).v_index + 2);
  EXPECT_EQ(parent_of(m.link(finger).v_index), m.link(hand).v_index);  // the fixed plate has no DOF
  const std::vector<double> q = m.neutral();
  EXPECT_EQ(q, (std::vector<double>{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0}));
}

TEST(Mechanism, PlacesAreThoseOfTheLinks) {
  const MechanismPtr m = Mechanism::make(tree()).value();
  ASSERT_EQ(m->places().size(), m->links().size());
  for (std::size_t i = 0; i < m->links().size(); ++i) {
    const Link& l = m->links()[i];
    const LinkPlace& place = m->places()[i];
    EXPECT_EQ(place.parent, l.parent) << l.name;
    EXPECT_EQ(place.q_index, l.q_index) << l.name;
    EXPECT_EQ(place.v_index, l.v_index) << l.name;
    EXPECT_EQ(place.type, l.joint.type) << l.name;
    EXPECT_EQ(place.nv, l.joint.nv()) << l.name;
  }
}

TEST(Mechanism, ParentsComeFirstForAnyInputOrder) {
  MechanismSpec spec = tree();
  std::reverse(spec.links.begin(), spec.links.end());
  const auto made = Mechanism::make(std::move(spec));
  ASSERT_TRUE(made.has_value()) << made.error().text();
  for (int i = 0; i < (*made)->link_count(); ++i) EXPECT_LT((*made)->link(i).parent, i);
  EXPECT_EQ((*made)->link((*made)->find_link("finger")).parent, (*made)->find_link("plate"));
}

TEST(Mechanism, SeveralRootsAreSiblings) {
  MechanismSpec spec{"pair", {link("a", "", JointType::floating), link("b", "", JointType::floating), link("c", "a")}};
  const auto made = Mechanism::make(std::move(spec));
  ASSERT_TRUE(made.has_value());
  const Mechanism& m = **made;
  EXPECT_EQ(m.link(m.find_link("a")).sibling, m.find_link("b"));
  EXPECT_EQ(m.link(m.find_link("b")).sibling, -1);
  EXPECT_EQ(m.link(m.find_link("a")).child, m.find_link("c"));
}

TEST(Mechanism, VirtualLinkMakesAWeldToItsRealLink) {
  MechanismSpec spec = tree();
  LinkSpec virtual_link = link("right again", "hand");
  virtual_link.real = "right";
  virtual_link.inertia = {};  // no mass of its own
  virtual_link.X_RV.p = {0, 0, 1};
  spec.links.push_back(virtual_link);
  const auto made = Mechanism::make(std::move(spec));
  ASSERT_TRUE(made.has_value()) << made.error().text();
  const Mechanism& m = **made;
  EXPECT_TRUE(m.has_loops());
  EXPECT_EQ(m.link(m.find_link("right again")).real, m.find_link("right"));
  EXPECT_EQ(m.link(m.find_link("right again")).X_RV.p, (Vec3{0, 0, 1}));
  ASSERT_EQ(m.loops().size(), 1U);
  const Loop& loop = m.loops()[0];
  EXPECT_TRUE(loop.of_virtual_link);
  EXPECT_EQ(loop.type, LoopType::weld);
  EXPECT_EQ(loop.rows(), 6);
  EXPECT_EQ(loop.link_a, m.find_link("right"));
  EXPECT_EQ(loop.link_b, m.find_link("right again"));
  EXPECT_EQ(loop.X_AJ.p, (Vec3{0, 0, 1}));
  EXPECT_EQ(m.spec().loops.size(), 0U) << "the loop of a virtual link is not listed in the spec";
}

TEST(Mechanism, LoopsResolveLinkAndDofIndices) {
  MechanismSpec spec = tree();
  spec.loops.push_back({.name = "grip", .type = LoopType::ball, .link_a = "left", .link_b = "finger"});
  spec.loops.push_back({.name = "tether", .type = LoopType::distance, .link_b = "hand", .length = 2, .closed = false});
  spec.loops.push_back(
      {.name = "teeth", .type = LoopType::gear, .link_a = "right", .link_b = "hand", .dof_a = 1, .polynomial = {0, -2, 0, 0, 0}});
  const auto made = Mechanism::make(spec);
  ASSERT_TRUE(made.has_value()) << made.error().text();
  const Mechanism& m = **made;
  ASSERT_EQ(m.loops().size(), 3U);
  EXPECT_EQ(m.find_loop("tether"), 1);
  EXPECT_EQ(m.find_loop("rope"), -1);
  EXPECT_EQ(m.loops()[1].link_a, -1);
  EXPECT_FALSE(m.loops()[1].closed);
  EXPECT_EQ(m.loops()[2].dof_a, m.link(m.find_link("right")).v_index + 1);
  EXPECT_EQ(m.loops()[2].dof_b, m.link(m.find_link("hand")).v_index);
  const auto again = Mechanism::make(m.spec());
  ASSERT_TRUE(again.has_value()) << again.error().text();
  EXPECT_EQ((*again)->loops()[2].dof_a, m.loops()[2].dof_a);
  EXPECT_EQ((*again)->loops()[0].link_b, m.loops()[0].link_b);
}

TEST(Mechanism, ImpossibleLoopsAreReported) {
  const LoopSpec good{.name = "grip", .type = LoopType::ball, .link_a = "left", .link_b = "finger"};
  const std::pair<std::function<void(LoopSpec&)>, const char*> spoiled[] = {
      {[](LoopSpec& l) { l.name.clear(); }, "no name"},
      {[](LoopSpec& l) { l.link_a = "nobody"; }, "'nobody' does not exist"},
      {[](LoopSpec& l) { l.link_a = "finger"; }, "link with itself"},
      {[](LoopSpec& l) { l.X_BJ.p.x = infinity; }, "frame"},
      {[](LoopSpec& l) { l.X_AJ.R = Mat3::diagonal(1, 1, -1); }, "frame"},
      {[](LoopSpec& l) { l.type = LoopType::revolute, l.axis = {}; }, "axis"},
      {[](LoopSpec& l) { l.type = LoopType::universal, l.axis2 = {0, nan_value, 0}; }, "second axis"},
      {[](LoopSpec& l) { l.type = LoopType::distance; }, "length"},
      {[](LoopSpec& l) { l.type = LoopType::gear, l.dof_a = 9; }, "first degree of freedom"},
      {[](LoopSpec& l) { l.type = LoopType::gear, l.link_b = ""; }, "second degree of freedom"},
      {[](LoopSpec& l) { l.type = LoopType::gear, l.link_a = "hand", l.link_b = "hand"; }, "with itself"},
      {[](LoopSpec& l) { l.type = LoopType::gear, l.link_a = "right", l.link_b = "hand", l.polynomial[2] = nan_value; }, "coefficient"},
  };
  for (const auto& [spoil, words] : spoiled) {
    MechanismSpec spec = tree();
    spec.loops.push_back(good);
    spoil(spec.loops.back());
    const auto made = Mechanism::make(std::move(spec));
    ASSERT_FALSE(made.has_value()) << words;
    EXPECT_NE(made.error().text().find(words), std::string::npos) << made.error().text();
  }
  MechanismSpec twice = tree();
  twice.loops = {good, good};
  EXPECT_FALSE(Mechanism::make(std::move(twice)).has_value());
}

TEST(Mechanism, SpecRoundTripPreservesTheMechanism) {
  MechanismSpec spec = tree();
  spec.links[1].label = "left arm";
  spec.links[1].joint.dofs[2].damping = 3;
  spec.links.push_back(link("again", "hand"));
  spec.links.back().real = "right";
  const auto first = Mechanism::make(spec);
  ASSERT_TRUE(first.has_value());
  const auto second = Mechanism::make((*first)->spec());
  ASSERT_TRUE(second.has_value());
  ASSERT_EQ((*first)->link_count(), (*second)->link_count());
  for (int i = 0; i < (*first)->link_count(); ++i) {
    const Link &a = (*first)->link(i), &b = (*second)->link(i);
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.label, b.label);
    EXPECT_EQ(a.parent, b.parent);
    EXPECT_EQ(a.child, b.child);
    EXPECT_EQ(a.sibling, b.sibling);
    EXPECT_EQ(a.real, b.real);
    EXPECT_EQ(a.inertia, b.inertia);
    EXPECT_EQ(a.joint.dofs, b.joint.dofs);
    EXPECT_EQ(a.shapes.size(), b.shapes.size());
  }
}

/// A spec with one defect, the location that the problem must name, and words that the message must contain.
struct Spoiled {
  const char* name;
  std::function<void(MechanismSpec&)> spoil;
  const char* location;
  const char* words;
  ErrorCode code;
};

const Spoiled spoiled_specs[] = {
    {"no links", [](MechanismSpec& s) { s.links.clear(); }, "mechanism tree", "no links", ErrorCode::structure},
    {"no name", [](MechanismSpec& s) { s.links[2].name.clear(); }, "link 2", "no name", ErrorCode::structure},
    {"double name", [](MechanismSpec& s) { s.links[2].name = "left"; }, "link left", "Two links", ErrorCode::duplicate},
    {"unknown parent", [](MechanismSpec& s) { s.links[3].parent = "leg"; }, "link hand", "'leg' does not exist", ErrorCode::unknown},
    {"own parent", [](MechanismSpec& s) { s.links[3].parent = "hand"; }, "link hand", "cycle", ErrorCode::structure},
    {"cycle of parents", [](MechanismSpec& s) { s.links[1].parent = "finger"; }, "link left", "cycle", ErrorCode::structure},
    {"unknown real link", [](MechanismSpec& s) { s.links[5].real = "nobody"; }, "link finger", "'nobody' does not exist",
     ErrorCode::unknown},
    {"own real link", [](MechanismSpec& s) { s.links[5].real = "finger"; }, "link finger", "its own real link", ErrorCode::structure},
    {"real link virtual", [](MechanismSpec& s) { s.links[5].real = "right", s.links[2].real = "trunk"; }, "link finger", "itself virtual",
     ErrorCode::structure},
    {"loop frame", [](MechanismSpec& s) { s.links[5].real = "right", s.links[5].X_RV.p.x = infinity; }, "link finger", "loop's frame",
     ErrorCode::structure},
    {"joint frame mirrored", [](MechanismSpec& s) { s.links[1].joint.X_PJ.R = Mat3::diagonal(1, 1, -1); }, "link left", "joint's frame",
     ErrorCode::structure},
    {"joint frame scaled", [](MechanismSpec& s) { s.links[1].joint.X_PJ.R = Mat3::diagonal(2, 1, 1); }, "link left", "joint's frame",
     ErrorCode::structure},
    {"joint frame not finite", [](MechanismSpec& s) { s.links[1].joint.X_PJ.p.y = nan_value; }, "link left", "joint's frame",
     ErrorCode::structure},
    {"axis without direction", [](MechanismSpec& s) { s.links[3].joint.axis = {}; }, "link hand", "axis", ErrorCode::structure},
    {"axis not unit", [](MechanismSpec& s) { s.links[3].joint.axis = {0, 0, 2}; }, "link hand", "axis", ErrorCode::structure},
    {"axis not a number", [](MechanismSpec& s) { s.links[3].joint.axis = {0, nan_value, 1}; }, "link hand", "axis", ErrorCode::structure},
    {"second axis", [](MechanismSpec& s) { s.links[2].joint.axis2 = {0, 0, 0}; }, "link right", "second axis", ErrorCode::structure},
    {"parallel axes", [](MechanismSpec& s) { s.links[2].joint.axis2 = s.links[2].joint.axis; }, "link right", "parallel",
     ErrorCode::structure},
    {"pitch", [](MechanismSpec& s) { s.links[3].joint.type = JointType::helical, s.links[3].joint.pitch = infinity; }, "link hand", "pitch",
     ErrorCode::structure},
    {"limits", [](MechanismSpec& s) { s.links[3].joint.dofs[0].lower = 1, s.links[3].joint.dofs[0].upper = 0; }, "link hand", "limit",
     ErrorCode::structure},
    {"limit not a number", [](MechanismSpec& s) { s.links[3].joint.dofs[0].lower = nan_value; }, "link hand", "limit",
     ErrorCode::structure},
    {"negative damping", [](MechanismSpec& s) { s.links[3].joint.dofs[0].damping = -1; }, "link hand", "damping", ErrorCode::structure},
    {"negative stiffness", [](MechanismSpec& s) { s.links[5].joint.dofs[1].stiffness = -1; }, "link finger", "stiffness",
     ErrorCode::structure},
    {"negative armature", [](MechanismSpec& s) { s.links[3].joint.dofs[0].armature = -1; }, "link hand", "armature", ErrorCode::structure},
    {"negative friction", [](MechanismSpec& s) { s.links[3].joint.dofs[0].friction = -1; }, "link hand", "friction", ErrorCode::structure},
    {"negative effort", [](MechanismSpec& s) { s.links[3].joint.dofs[0].effort = -1; }, "link hand", "effort", ErrorCode::structure},
    {"infinite damping", [](MechanismSpec& s) { s.links[3].joint.dofs[0].damping = infinity; }, "link hand", "damping",
     ErrorCode::structure},
    {"rest not a number", [](MechanismSpec& s) { s.links[3].joint.dofs[0].rest = nan_value; }, "link hand", "damping",
     ErrorCode::structure},
    {"negative mass", [](MechanismSpec& s) { s.links[3].inertia.mass = -1; }, "link hand", "mass is negative", ErrorCode::structure},
    {"mass not a number", [](MechanismSpec& s) { s.links[3].inertia.mass = nan_value; }, "link hand", "not finite", ErrorCode::structure},
    {"centre without mass", [](MechanismSpec& s) { s.links[3].inertia.mass = 0; }, "link hand", "no mass", ErrorCode::structure},
    {"negative moment", [](MechanismSpec& s) { s.links[3].inertia = Inertia::from_centre(1, {}, {-1, 1, 1, 0, 0, 0}); }, "link hand",
     "moments of inertia", ErrorCode::structure},
    {"triangle inequality", [](MechanismSpec& s) { s.links[3].inertia = Inertia::from_centre(1, {}, {1, 1, 3, 0, 0, 0}); }, "link hand",
     "moments of inertia", ErrorCode::structure},
    {"indefinite inertia", [](MechanismSpec& s) { s.links[3].inertia = Inertia::from_centre(1, {}, {1, 1, 1, 1.5, 0, 0}); }, "link hand",
     "moments of inertia", ErrorCode::structure},
    {"no mass carried by joint", [](MechanismSpec& s) { s.links[5].inertia = {}; }, "link finger", "no link that it carries has mass",
     ErrorCode::structure},
    {"shape without size", [](MechanismSpec& s) { s.links[3].shapes[0].radius = 0; }, "link hand", "no size", ErrorCode::structure},
    {"shape of negative size", [](MechanismSpec& s) { s.links[3].shapes = {Shape::box({1, -1, 1})}; }, "link hand", "no size",
     ErrorCode::structure},
    {"shape of infinite size", [](MechanismSpec& s) { s.links[3].shapes[0].radius = infinity; }, "link hand", "no size",
     ErrorCode::structure},
    {"shape frame", [](MechanismSpec& s) { s.links[3].shapes[0].X_BS.R = Mat3{}; }, "link hand", "shape's frame", ErrorCode::structure},
    {"shape friction", [](MechanismSpec& s) { s.links[3].shapes[0].friction = -0.1; }, "link hand", "friction", ErrorCode::range},
    {"shape restitution", [](MechanismSpec& s) { s.links[3].shapes[0].restitution = 1.1; }, "link hand", "restitution", ErrorCode::range},
};

class RefusedSpec : public testing::TestWithParam<Spoiled> {};

TEST_P(RefusedSpec, NamesTheLinkAtFault) {
  const Spoiled& p = GetParam();
  MechanismSpec spec = tree();
  p.spoil(spec);
  const auto made = Mechanism::make(std::move(spec));
  ASSERT_FALSE(made.has_value());
  bool found = false;
  for (const Problem& problem : made.error().problems) {
    found = found || (problem.location.find(p.location) != std::string::npos && problem.message.find(p.words) != std::string::npos &&
                      problem.code == p.code);
    EXPECT_FALSE(problem.remedy.empty()) << problem.message;
  }
  EXPECT_TRUE(found) << made.error().text();
}

INSTANTIATE_TEST_SUITE_P(Mechanism, RefusedSpec, testing::ValuesIn(spoiled_specs), [](const auto& p) {
  std::string name = p.param.name;
  for (char& c : name)
    if (c == ' ') c = '_';
  return name;
});

TEST(Mechanism, AllProblemsAreReportedNotOnlyTheFirst) {
  MechanismSpec spec = tree();
  spec.links[1].inertia.mass = -1;
  spec.links[3].joint.axis = {};
  spec.links[5].parent = "nobody";
  const auto made = Mechanism::make(std::move(spec));
  ASSERT_FALSE(made.has_value());
  EXPECT_EQ(made.error().problems.size(), 3U) << made.error().text();
}

TEST(Mechanism, PossibleInertiasAreAccepted) {
  for (const Inertia& inertia : {Inertia::from_centre(1, {5, 5, 5}, {}),                           // a point
                                 Inertia::from_centre(1, {}, {1, 1, 0, 0, 0, 0}),                  // a rod
                                 Inertia::from_centre(1, {}, {1, 1, 2, 0, 0, 0}),                  // a plate
                                 solid_inertia(Shape::capsule(1e-4, {0, 0, 0}, {3, 2, 1}), 1000),  // thin
                                 Inertia::from_centre(1e-12, {}, {1e-18, 1e-18, 1e-18, 0, 0, 0}),  // tiny
                                 Inertia::from_centre(1e6, {0, 0, 1e3}, {1e6, 1e6, 1e6, 0, 0, 0})}) {
    MechanismSpec spec{"one", {link("body", "", JointType::floating)}};
    spec.links[0].inertia = inertia;
    const auto made = Mechanism::make(std::move(spec));
    EXPECT_TRUE(made.has_value()) << made.error().text();
  }
}

TEST(Mechanism, MovableJointNeedsOnlyArmature) {
  MechanismSpec spec = tree();
  spec.links[5].inertia = {};
  spec.links[5].joint.dofs[0].armature = spec.links[5].joint.dofs[1].armature = 0.01;
  EXPECT_TRUE(Mechanism::make(std::move(spec)).has_value());
}

TEST(Mechanism, BuildsAChainOf20000Links) {
  MechanismSpec spec{"chain", {}};
  for (int i = 0; i < 20000; ++i)
    spec.links.push_back(link(("l" + std::to_string(i)).c_str(), i == 0 ? "" : ("l" + std::to_string(i - 1)).c_str()));
  std::reverse(spec.links.begin(), spec.links.end());
  const auto made = Mechanism::make(std::move(spec));
  ASSERT_TRUE(made.has_value());
  EXPECT_EQ((*made)->nv(), 20000);
}

TEST(Shape, VolumesAndInertias) {
  const Shape ball = Shape::sphere(0.5), box = Shape::box({0.5, 1, 1.5});
  EXPECT_NEAR(volume(ball), pi / 6, 1e-15);
  EXPECT_DOUBLE_EQ(volume(box), 6);
  const Inertia b = solid_inertia(box, 10);
  EXPECT_DOUBLE_EQ(b.mass, 60);
  EXPECT_DOUBLE_EQ(b.I.xx, 60.0 / 12 * (4 + 9));
  // Reference for the capsule: the sum of thin discs.
  const Shape capsule = Shape::capsule(0.2, {0, 0, -0.3}, {0, 0, 0.5});
  double mass = 0, across = 0, along = 0, moment = 0;
  const int n = 200000;
  const double dz = 1.2 / n;
  for (int i = 0; i < n; ++i) {
    const double z = -0.5 + (i + 0.5) * dz;
    const double over = z < -0.3 ? -0.3 - z : z > 0.5 ? z - 0.5 : 0;
    const double r2 = 0.04 - over * over, m = 1000 * pi * r2 * dz;
    mass += m;
    moment += m * z;
    along += 0.5 * m * r2;
    across += m * (0.25 * r2 + z * z);
  }
  const Inertia c = solid_inertia(capsule, 1000);
  EXPECT_NEAR(c.mass, mass, 1e-7 * mass);
  EXPECT_NEAR(c.h.z, moment, 1e-6 * mass);
  EXPECT_NEAR(c.I.zz, along, 1e-7 * along);
  EXPECT_NEAR(c.I.xx, across, 1e-7 * across);
  EXPECT_NEAR(c.I.yy, across, 1e-7 * across);
}

TEST(Shape, CapsuleBetweenTwoPoints) {
  const Shape s = Shape::capsule(0.1, {1, 2, 3}, {1, 5, -1});
  EXPECT_DOUBLE_EQ(s.half_length, 2.5);
  EXPECT_LT(norm(s.X_BS * Vec3{0, 0, 2.5} - Vec3{1, 5, -1}), 1e-14);
  EXPECT_LT(norm(s.X_BS * Vec3{0, 0, -2.5} - Vec3{1, 2, 3}), 1e-14);
  const Shape down = Shape::capsule(0.1, {0, 0, 1}, {0, 0, 0});
  EXPECT_LT(norm(down.X_BS * Vec3{0, 0, 0.5}), 1e-14);
}

}  // namespace
}  // namespace ugoki
