// Dynamics of combined mechanisms: all methods agree, and momentum and energy are conserved.
#include <gtest/gtest.h>

#include "random_mechanism.h"
#include "ugoki/dynamics/centroidal.h"
#include "ugoki/dynamics/closed_reference.h"
#include "ugoki/dynamics/closed_system.h"
#include "ugoki/dynamics/dynamics.h"
#include "ugoki/dynamics/integrators.h"
#include "ugoki/mechanism_edit/combine.h"
#include "ugoki/mechanism_edit/cut.h"
#include "ugoki/mechanism_edit/growth.h"
#include "ugoki/samples/samples.h"
#include "whole.h"

namespace ugoki {
namespace {

using namespace dynamics;

MechanismPtr human() { return samples::make_sample().resources.mechanisms.at("human"); }

/// The sample's dog scaled to the size of a horse: 2.6 times its height, 450 kg.
MechanismPtr horse() {
  const MechanismPtr dog = samples::make_dog();
  MechanismPtr out = grow(*dog, {.height = 2.6 * standing_height(*dog), .mass = 450})->mechanism;
  MechanismSpec spec = out->spec();
  spec.name = "horse";
  return *Mechanism::make(spec);
}

std::string labelled(const Mechanism& m, std::string_view label) {
  for (const Link& l : m.links())
    if (l.label == label) return l.name;
  return {};
}

/// A human combined with a horse, without armature at the joints.
MechanismPtr rider_on_horse(Attachment attachment, LoopType type) {
  const MechanismPtr man = human(), mount = horse();
  CombineOptions options{.name = "rider on horse",
                         .link_a = mount->link(0).name,
                         .link_b = labelled(*man, "pelvis"),
                         .X_AB = {Mat3::identity(), {0.2, 0, 0.45}},
                         .attachment = attachment};
  options.loop.type = type;
  options.prefix_b = "rider ";
  auto made = combine(*mount, *man, options);
  EXPECT_TRUE(made.has_value()) << made.error().text();
  return *Mechanism::make(testing::without_armature(made->mechanism->spec()));  // without armature the momentum is the sum over the links
}

TEST(Riding, HasMassAndLinksOfBoth) {
  const MechanismPtr man = human(), mount = horse(), both = rider_on_horse(Attachment::loop, LoopType::weld);
  EXPECT_NEAR(both->mass(), man->mass() + mount->mass(), 1e-9);
  EXPECT_EQ(both->link_count(), man->link_count() + mount->link_count());
  for (const Link& l : man->links()) EXPECT_GE(both->find_link("rider " + l.name), 0);
}

TEST(Riding, AllMethodsAgreeOnTheClosedSystem) {
  for (const LoopType type : {LoopType::weld, LoopType::ball, LoopType::revolute}) {
    SCOPED_TRACE(name_of(type));
    const MechanismPtr m = rider_on_horse(Attachment::loop, type);
    testing::RandomSource random(5);
    State s(*m);
    for (std::size_t i = 0; i < s.tau.size(); ++i)
      s.tau[i] = m->link(m->link_of_dof(static_cast<int>(i))).parent < 0 ? 0 : random.uniform(-5, 5);
    for (double& v : s.v) v = random.uniform(-1, 1);
    const std::vector<Loop> loops(m->loops().begin(), m->loops().end());
    ClosedWorkspace cw(*m, loops);
    find_full_rank(*m, s.q, cw);
    close_velocities(*m, s.q, s.v, cw);
    update_closed(*m, s.q, s.v, cw);
    EXPECT_LT(measure_gap(cw).gap, 1e-12);  // closed in the neutral position
    std::vector<double> reference(s.v.size()), fast(s.v.size()), staged(s.v.size());
    const Vec3 gravity{0, 0, -9.81};
    ASSERT_TRUE(calc_closed_forward_dynamics_by_unit_vectors(*m, cw, s.tau, gravity, {}, reference));
    ClosedLinks links(*m);
    ASSERT_EQ(calc_closed_forward_dynamics(*m, links, s.q, s.v, s.tau, gravity, {}, fast), ClosedStatus::ok);
    Workspace ws(*m);
    ClosedLinks links2(*m);
    update_kinematics(*m, s.q, s.v, ws);
    ASSERT_EQ(factor_closed_links(*m, ws, links2, s.q, s.v), ClosedStatus::ok);
    calc_closed_forward_dynamics(*m, ws, links2, s.tau, gravity, {}, staged);
    double size = 1, error = 0;
    for (std::size_t i = 0; i < fast.size(); ++i) {
      size = std::max(size, std::fabs(reference[i]));
      error = std::max({error, std::fabs(fast[i] - reference[i]), std::fabs(staged[i] - reference[i])});
    }
    EXPECT_LT(error / size, 1e-8);
    // Newton-Euler for the whole system: gravity alone changes the momentum.
    update_kinematics(*m, s.q, s.v, ws);
    const Vec6 rate = calc_centroidal_momentum_rate(*m, ws, fast);
    EXPECT_LT(norm(rate.v - gravity * m->mass()) / (m->mass() * 9.81), 1e-9);
    EXPECT_LT(norm(rate.w) / (m->mass() * 9.81), 1e-8);
  }
}

TEST(Riding, MomentumAndEnergyAreConservedInFreeFall) {
  const MechanismPtr m = rider_on_horse(Attachment::loop, LoopType::weld);
  OpenSystemOptions options;
  options.gravity = {};
  options.joint_forces_on = false;
  ClosedSystem system(m, options);
  testing::RandomSource random(9);
  State s(*m);
  for (double& v : s.v) v = random.uniform(-0.5, 0.5);
  Workspace ws(*m);
  ClosedLinks links(*m);
  update_kinematics(*m, s.q, s.v, ws);
  ASSERT_EQ(factor_closed_links(*m, ws, links, s.q, s.v), ClosedStatus::ok);
  project_velocity(*m, ws, links, s.v);
  IntegratorOptions how;
  how.relative_tolerance = how.absolute_tolerance = 1e-10;
  Integrator integrator(system, how);
  integrator.start(0, s.q, s.v);
  update_kinematics(*m, s.q, s.v, ws);
  const Vec6 before = momentum(*m, ws);
  const double energy = kinetic_energy(*m, ws);
  ASSERT_EQ(integrator.advance(0.5).status, IntegrationStatus::reached);
  update_kinematics(*m, integrator.q(), integrator.v(), ws);
  const Vec6 after = momentum(*m, ws);
  EXPECT_LT(norm(after.v - before.v) / norm(before.v), 1e-7);
  EXPECT_LT(norm(after.w - before.w) / norm(before.w), 1e-7);
  EXPECT_NEAR(kinetic_energy(*m, ws) / energy, 1, 1e-7);
}

/// Connected by a fixed joint, the two mechanisms form an open system. It must accelerate like the system closed by a weld loop.
TEST(Riding, FixedJointAndWeldLoopGiveEqualAccelerations) {
  const MechanismPtr tree = rider_on_horse(Attachment::joint, LoopType::weld), loop = rider_on_horse(Attachment::loop, LoopType::weld);
  EXPECT_EQ(tree->nv() + 6, loop->nv());
  testing::RandomSource random(3);
  State s(*tree), t(*loop);
  std::vector<double> joint_of_tree(s.v.size()), open(s.v.size()), closed(t.v.size());
  for (double& x : s.tau) x = random.uniform(-3, 3);
  for (const Link& l : tree->links()) {
    const Link& o = loop->link(loop->find_link(l.name));
    for (int k = 0; k < l.joint.nv(); ++k) t.tau[static_cast<std::size_t>(o.v_index + k)] = s.tau[static_cast<std::size_t>(l.v_index + k)];
  }
  Workspace ws(*tree);
  ClosedLinks links(*loop);
  ASSERT_TRUE(calc_forward_dynamics(*tree, ws, s.q, s.v, s.tau, {0, 0, -9.81}, {}, open));
  ASSERT_EQ(calc_closed_forward_dynamics(*loop, links, t.q, t.v, t.tau, {0, 0, -9.81}, {}, closed), ClosedStatus::ok);
  double size = 1;
  for (const double a : open) size = std::max(size, std::fabs(a));
  for (const Link& l : tree->links()) {
    const Link& o = loop->link(loop->find_link(l.name));
    for (int k = 0; k < l.joint.nv(); ++k)
      EXPECT_NEAR(open[static_cast<std::size_t>(l.v_index + k)], closed[static_cast<std::size_t>(o.v_index + k)], 1e-8 * size) << l.name;
  }
}

/// A centaur: a human trunk on a horse without its neck.
TEST(Riding, AllMethodsAgreeOnACentaur) {
  const MechanismPtr man = human(), mount = horse();
  const std::string belly = labelled(*man, "abdomen");
  ASSERT_FALSE(belly.empty());
  const auto trunk = cut(*man, belly, {.keep = Keep::part});
  std::string neck;
  for (const Link& l : mount->links())
    if (neck.empty() && (l.name.find("neck") != std::string::npos || l.label.starts_with("neck"))) neck = l.name;
  ASSERT_FALSE(neck.empty());
  const std::string chest = mount->link(mount->link(mount->find_link(neck)).parent).name;
  const auto body = cut(*mount, neck);
  ASSERT_TRUE(trunk && body);
  CombineOptions options{.name = "centaur", .link_a = chest, .link_b = belly, .X_AB = {Mat3::identity(), {0.3, 0, 0.2}}};
  options.joint.type = JointType::spherical;
  options.prefix_a = "horse ";
  const auto made = combine(*body->mechanism, *trunk->mechanism, options);
  ASSERT_TRUE(made.has_value()) << made.error().text();
  const Mechanism& m = *made->mechanism;
  EXPECT_NEAR(m.mass(), trunk->mechanism->mass() + body->mechanism->mass(), 1e-9);
  testing::RandomSource random(2);
  State s(m);
  testing::randomize(random, m, s);
  Workspace ws(m);
  std::vector<double> a(s.v.size()), b(s.v.size()), c(s.v.size());
  update_kinematics(m, s.q, s.v, ws);
  ASSERT_TRUE(calc_forward_dynamics(m, ws, s.tau, {0, 0, -9.81}, s.external, a));
  update_kinematics(m, s.q, s.v, ws);
  ASSERT_TRUE(calc_forward_dynamics_by_unit_vectors(m, ws, s.tau, {0, 0, -9.81}, s.external, b));
  ASSERT_TRUE(calc_forward_dynamics(m, ws, s.q, s.v, s.tau, {0, 0, -9.81}, s.external, c));
  double size = 1, error = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    size = std::max(size, std::fabs(b[i]));
    error = std::max({error, std::fabs(a[i] - b[i]), std::fabs(c[i] - b[i])});
  }
  EXPECT_LT(error / size, 1e-8);
}

}  // namespace
}  // namespace ugoki
