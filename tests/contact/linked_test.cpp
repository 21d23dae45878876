// Chains and rings of links with contacts: energy, the laws of contact, falling.

#include <gtest/gtest.h>

#include <cmath>

#include "../dynamics/random_mechanism.h"
#include "laws.h"
#include "ugoki/contact/guarded_step.h"
#include "world.h"

namespace ugoki::contact {
namespace {

/// A heap of capsule chains with free joints, chains with limited joints, and rings closed by loops, above the ground.
World linked_heap(int count, unsigned seed, bool limited) {
  testing::RandomSource random(seed);
  std::vector<MechanismPtr> systems;
  for (int i = 0; i < count; ++i) {
    MechanismSpec spec;
    spec.name = "linked";
    const int links = 4 + random.below(3);
    const double length = random.uniform(0.15, 0.25);
    for (int k = 0; k < links; ++k) {
      LinkSpec l;
      l.name = "link" + std::to_string(k);
      if (k > 0) {
        l.parent = "link" + std::to_string(k - 1);
        l.joint.X_PJ.p = {length, 0, 0};
      }
      l.joint.type = k == 0 ? JointType::floating : i % 3 == 0 ? JointType::spherical : JointType::revolute;
      l.joint.axis = {0, 0, 1};
      if (i % 3 == 1 && k > 0 && limited) {
        l.joint.axis = random.direction();
        l.joint.dofs[0].lower = -0.5;
        l.joint.dofs[0].upper = 0.7;
      }
      const Shape shape = Shape::capsule(0.03, {0.04, 0, 0}, {length - 0.04, 0, 0});
      l.inertia = solid_inertia(shape, random.uniform(300, 1000));
      l.shapes.push_back(shape);
      spec.links.push_back(l);
    }
    if (i % 3 == 2)
      spec.loops.push_back({.name = "pin",
                            .type = LoopType::revolute,
                            .link_a = "link0",
                            .link_b = spec.links.back().name,
                            .X_BJ = {Mat3::identity(), {length, 0, 0}},
                            .axis = {0, 0, 1}});
    systems.push_back(Mechanism::make(std::move(spec)).value());
  }
  World w(systems, {}, {});
  for (int i = 0; i < count; ++i) {
    State& s = w.states[static_cast<std::size_t>(i)];
    put(s, {1.3 * (i % 2), 1.3 * (i / 2 % 2), 1.5 + 1.5 * (i / 4)});
    const Quat turn = exp_map(random.vec(1));
    s.q[3] = turn.w;
    s.q[4] = turn.x;
    s.q[5] = turn.y;
    s.q[6] = turn.z;
    if (i % 3 == 2)
      for (std::size_t k = 7; k < s.q.size(); ++k) s.q[k] = 2 * 3.14159265358979323846 / static_cast<double>(s.q.size() - 6);
  }
  return w;
}

/// Kinetic and potential energy of all systems, J.
double energy_of(const World& w) {
  double sum = 0;
  for (std::size_t s = 0; s < w.states.size(); ++s) {
    const Mechanism& m = w.stepper.mechanism(static_cast<int>(s));
    dynamics::Workspace ws(m);
    dynamics::update_kinematics(m, w.states[s].q, w.states[s].v, ws);
    sum += dynamics::kinetic_energy(m, ws) + dynamics::potential_energy(m, ws, w.stepper.options().gravity);
  }
  return sum;
}

TEST(Linked, UndampedChainsAndRingsKeepTheirEnergyWithinBounds) {
  StepperOptions options;
  options.gravity = {};
  for (const double dt : {0.002, 1.0 / 60})
    for (const double spin : {1.0, 10.0, 40.0})  // rad/s
      for (unsigned seed = 1; seed <= 4; ++seed) {
        const World heap = linked_heap(3, seed, false);
        for (int i = 0; i < 3; ++i) {
          MechanismSpec spec = heap.stepper.mechanism(i).spec();
          for (LinkSpec& l : spec.links) l.shapes.clear();
          World w({Mechanism::make(spec).value()}, {-1e9, 0, 0}, options);
          w.states[0].q = heap.states[static_cast<std::size_t>(i)].q;
          testing::RandomSource random(seed);
          for (double& x : w.states[0].v) x = random.uniform(-spin, spin);
          ASSERT_EQ(w.step(dt).status, StepStatus::ok);  // the first step closes the rings
          const double begin = energy_of(w);
          double maximum = 0, minimum = 1e300;
          for (double t = 0; t < 5; t += dt) {
            ASSERT_EQ(w.step(dt).status, StepStatus::ok) << "spin " << spin << " dt " << dt << " family " << i << " at " << t;
            maximum = std::max(maximum, energy_of(w) / begin);
            minimum = std::min(minimum, energy_of(w) / begin);
          }
          EXPECT_LT(maximum, 1.04) << "spin " << spin << " dt " << dt << " family " << i << " seed " << seed;
          EXPECT_GT(minimum, 0.97) << "spin " << spin << " dt " << dt << " family " << i << " seed " << seed;
        }
      }
}

TEST(Linked, ContactsObeyUnilateralContactAndCoulomb) {
  World w = linked_heap(9, 5, true);
  const auto fastest = [&] {
    double maximum = 0;
    for (const State& s : w.states)
      for (const double x : s.v) maximum = std::max(maximum, std::fabs(x));
    return maximum;
  };
  int checked = 0;
  for (int i = 0; i < 1500; ++i) {
    const double before = fastest();
    const StepReport report = w.step(0.002);
    ASSERT_EQ(report.status, StepStatus::ok);
    ASSERT_LT(report.loop_gap, 1e-9);
    if (report.residual > 1e-7 || std::max(before, fastest()) > 9)
      continue;  // skip: faster systems move in inertial substeps after the contacts have acted
    check_laws(w, 0.002, 1e-4);
    if (HasFailure()) FAIL() << "step " << i;
    ++checked;
  }
  EXPECT_GT(checked, 300);
}

TEST(Linked, FallAndComeToRest) {
  for (const double dt : {0.002, 1.0 / 60})
    for (unsigned seed = 41; seed <= 43; ++seed) {
      World w = linked_heap(9, seed, true);
      GuardedStep guard(w.scene, w.stepper);
      const double begin = energy_of(w);
      double maximum = 0, lowest = 0;
      for (double t = 0; t < 3; t += dt) {
        w.find();
        const StepReport report = guard.step(w.systems, w.contacts, dt);
        ASSERT_EQ(report.status, StepStatus::ok);
        ASSERT_LT(report.loop_gap, 1e-9);
        lowest = std::min(lowest, w.lowest());
        maximum = std::max(maximum, energy_of(w) / begin);
      }
      EXPECT_GT(lowest, -1e-3) << "dt " << dt << " seed " << seed;
      EXPECT_LT(maximum, 1.001) << "dt " << dt << " seed " << seed;
      EXPECT_LT(energy_of(w), 0.03 * begin) << "dt " << dt << " seed " << seed;
    }
}

}  // namespace
}  // namespace ugoki::contact
