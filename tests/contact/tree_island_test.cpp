// Large systems by TreeIsland, compared with the solution by whitened rows and a dense basis of the loop rows (velocity_solver.h,
// stepper_loops.cpp), which is the reference.

#include "ugoki/contact/tree_island.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "../dynamics/random_loops.h"
#include "allocation_count.h"
#include "ugoki/contact/anderson_mixing.h"
#include "ugoki/contact/guarded_step.h"
#include "ugoki/world/world.h"

namespace ugoki::contact {
namespace {

/// A capsule from the link's origin to `end`, of density 1000 kg/m^3, on a revolute joint about y, or floating if it has no parent.
LinkSpec bar(const std::string& name, const std::string& parent, const Vec3& at, const Vec3& end, bool touches) {
  LinkSpec l;
  l.name = name;
  l.parent = parent;
  l.joint.type = parent.empty() ? JointType::floating : JointType::revolute;
  l.joint.axis = {0, 1, 0};
  l.joint.X_PJ.p = at;
  l.joint.dofs[0].damping = parent.empty() ? 0 : 0.5;
  const Shape shape = Shape::capsule(0.01, {0, 0, 0}, end);
  l.inertia = solid_inertia(shape, 1000);
  if (touches) l.shapes.push_back(shape);
  return l;
}

/// A four-bar linkage on the bar `below`: two legs and a top bar, whose far end is pinned to the front leg.
void add_linkage(MechanismSpec& spec, const std::string& i, const std::string& below) {
  spec.links.push_back(bar("front" + i, below, {0.2, 0, 0}, {0, 0, 0.1}, false));
  spec.links.push_back(bar("rear" + i, below, {0, 0, 0}, {0, 0, 0.1}, false));
  spec.links.push_back(bar("top" + i, "rear" + i, {0, 0, 0.1}, {0.2, 0, 0}, false));
  LoopSpec pin;
  pin.name = "pin" + i;
  pin.type = LoopType::revolute;
  pin.link_a = "front" + i;
  pin.link_b = "top" + i;
  pin.X_AJ.p = {0, 0, 0.1};
  pin.X_BJ.p = {0.2, 0, 0};
  pin.axis = {0, 1, 0};
  spec.loops.push_back(pin);
}

/// `n` four-bar linkages in series on the ground: the top bar of each carries a foot with the base bar of the next.
MechanismPtr series(int n) {
  MechanismSpec spec;
  spec.name = "series";
  spec.links = {bar("base", "", {}, {0.2, 0, 0}, true)};
  std::string below = "base";
  for (int k = 0; k < n; ++k) {
    const std::string i = std::to_string(k);
    add_linkage(spec, i, below);
    spec.links.push_back(bar("foot" + i, "top" + i, {0.2, 0, 0}, {0, 0, -0.1}, false));
    spec.links.push_back(bar("next" + i, "foot" + i, {0, 0, -0.1}, {0.2, 0, 0}, true));
    below = "next" + i;
  }
  return Mechanism::make(std::move(spec)).value();
}

/// A random tree of links with up to three loops of random types, limits, dry friction, springs and a shape on every second link.
MechanismPtr random_mechanism(unsigned seed, const testing::RandomLoops& closed) {
  testing::RandomSource same(seed), random(seed + 1000);
  MechanismSpec spec = testing::random_spec(same, 12);
  for (int k = 0; k < static_cast<int>(seed % 4); ++k) {
    const Loop& l = closed.loops[static_cast<std::size_t>(random.below(static_cast<int>(closed.loops.size())))];
    if (l.type == LoopType::gear || l.link_a < 0) continue;
    spec.loops.push_back({.name = "loop " + std::to_string(k),
                          .type = l.type,
                          .link_a = spec.links[static_cast<std::size_t>(l.link_a)].name,
                          .link_b = spec.links[static_cast<std::size_t>(l.link_b)].name,
                          .X_AJ = l.X_AJ,
                          .X_BJ = l.X_BJ,
                          .axis = l.axis,
                          .axis2 = l.axis2,
                          .length = l.length});
  }
  for (LinkSpec& l : spec.links) {
    if (random.below(2) == 0) l.shapes.push_back(Shape::capsule(0.05, random.vec(0.2), random.vec(0.2)));
    if (l.joint.type == JointType::floating) continue;
    for (Dof& f : l.joint.dofs) {
      f.damping = random.uniform(0, 0.5);
      if (random.below(3) == 0) f.friction = random.uniform(0, 2);
      if (random.below(3) == 0) f.stiffness = random.uniform(0, 20);
      if (random.below(3) == 0 && l.joint.type == JointType::revolute) {
        f.lower = -0.3;
        f.upper = 0.3;
      }
    }
  }
  return Mechanism::make(std::move(spec)).value();
}

world::WorldOptions by_tree() {
  world::WorldOptions o;
  o.stepper.min_tree_dofs = 0;
  o.stepper.min_tree_work = 0;
  return o;
}
world::WorldOptions by_rows() {
  world::WorldOptions o;
  o.stepper.min_tree_dofs = 1 << 20;
  return o;
}

struct Comparison {
  int steps = 0, compared = 0, contacts = 0, limits = 0;
  int apart = 0;     // compared steps after which a velocity differs by more than 1e-4 m/s | rad/s
  int finished = 0;  // steps that the tree method finished without a hand-over
  double worst = 0;  // m/s | rad/s: largest difference of the other steps
};

/// Steps the mechanism by the tree method, and each step also by the reference method from the same state. Steps that one method did not
/// solve to the tolerance, or that were split, are not compared.
void compare(const MechanismPtr& m, const world::WorldState& begin, int steps, double dt, Comparison& sum) {
  const world::World one({m}, by_tree()), two({m}, by_rows());
  world::WorldStepper tree(one), rows(two);
  world::WorldState s(one), t(two);
  std::ranges::copy(begin.q(0), s.q(0).begin());
  std::ranges::copy(begin.v(0), s.v(0).begin());
  for (int i = 0; i < steps; ++i) {
    SCOPED_TRACE("step " + std::to_string(i));
    std::ranges::copy(s.q(0), t.q(0).begin());
    std::ranges::copy(s.v(0), t.v(0).begin());
    tree.load(s);
    rows.load(s);
    const StepReport a = tree.step({}, dt), b = rows.step({}, dt);
    ASSERT_EQ(a.status, StepStatus::ok);
    ASSERT_EQ(b.status, StepStatus::ok);
    tree.store(s);
    rows.store(t);
    ++sum.steps;
    sum.contacts += a.contacts;
    sum.limits += a.limits;
    EXPECT_EQ(a.contacts, b.contacts);
    EXPECT_EQ(a.not_converged, 0);
    if (a.handed_over > 0) continue;
    ++sum.finished;
    if (b.not_converged > 0 || a.substeps > 1 || b.substeps > 1) continue;
    ++sum.compared;
    double difference = 0;
    for (std::size_t k = 0; k < s.v(0).size(); ++k) difference = std::max(difference, std::fabs(s.v(0)[k] - t.v(0)[k]));
    if (difference > 1e-4)
      ++sum.apart;
    else
      sum.worst = std::max(sum.worst, difference);
  }
}

// With redundant contacts and friction, some steps have several solutions; the methods may find different ones.
constexpr double max_apart = 0.04;

TEST(TreeIsland, FourBarsInSeriesMatchTheReference) {
  Comparison sum;
  const MechanismPtr m = series(8);
  const world::World world({m}, {});
  world::WorldState s(world);
  s.q(0)[2] = 0.03;
  s.v(0)[3] = 0.5;
  compare(m, s, 150, 0.002, sum);
  EXPECT_GE(sum.finished, 0.95 * sum.steps);
  EXPECT_GT(sum.compared, 120);
  EXPECT_GT(sum.contacts, 1000);
  EXPECT_LE(sum.apart, max_apart * sum.compared) << sum.worst;
}

TEST(TreeIsland, RandomMechanismsMatchTheReference) {
  Comparison sum;
  for (const unsigned seed : {34U, 35U, 36U, 37U, 38U, 40U, 43U, 47U}) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const testing::RandomLoops closed(seed);
    const MechanismPtr m = random_mechanism(seed, closed);
    const world::World world({m}, {});
    world::WorldState s(world);
    testing::RandomSource random(seed);
    std::ranges::copy(closed.state.q, s.q(0).begin());
    s.q(0)[2] = 0.8;
    for (double& x : s.v(0)) x = random.uniform(-0.5, 0.5);
    compare(m, s, 100, 0.002, sum);
  }
  EXPECT_GT(sum.contacts, 3000);
  EXPECT_GT(sum.limits, 2000);
  EXPECT_GT(sum.finished, 0.9 * sum.steps);
  EXPECT_GT(sum.compared, 0.8 * sum.steps);
  EXPECT_LE(sum.apart, max_apart * sum.compared) << sum.worst;
}

// A system of 1506 DOFs, which whitened rows solve in seconds, must not fail, must carry its weight, and must not allocate.
TEST(TreeIsland, LongSeriesStandsOnTheGround) {
  const MechanismPtr m = series(300);
  const world::World world({m}, {});
  world::WorldStepper stepper(world);
  world::WorldState s(world);
  s.q(0)[2] = 0.01;
  stepper.load(s);
  for (int i = 0; i < 30; ++i) {
    const long before = allocations_so_far();
    const StepReport report = stepper.step({}, 0.002);
    if (i >= 10) EXPECT_EQ(allocations_so_far(), before) << i;
    ASSERT_EQ(report.status, StepStatus::ok);
    EXPECT_EQ(report.not_converged, 0);
    EXPECT_LT(report.loop_gap, 1e-11);
    EXPECT_EQ(report.contacts, 602);
  }
  double weight = 0;
  for (const Vec3& f : stepper.forces()) weight += f.z;
  EXPECT_NEAR(weight, 9.81 * m->mass(), 1e-3 * 9.81 * m->mass());
}

/// A chain of `links` capsules, with hinges about y and z in turn; the base floats in the middle.
MechanismPtr open_chain(int links) {
  MechanismSpec spec;
  spec.name = "chain";
  const int root = links / 2;
  const auto add = [&](int i, int parent) {
    LinkSpec link;
    link.name = "link " + std::to_string(i);
    const bool before = i < root;
    if (parent < 0) {
      link.joint.type = JointType::floating;
    } else {
      link.parent = "link " + std::to_string(parent);
      link.joint.type = JointType::revolute;
      link.joint.axis = i % 2 == 0 ? Vec3{0, 1, 0} : Vec3{0, 0, 1};
      link.joint.X_PJ.p = {!before ? 0.1 : i == root - 1 ? 0.0 : -0.1, 0, 0};
      link.joint.dofs[0].damping = 0.01;
    }
    Shape shape = Shape::capsule(0.03, {before ? -0.1 : 0.0, 0, 0}, {before ? 0.0 : 0.1, 0, 0});
    shape.friction = 0.8;
    link.inertia = solid_inertia(shape, 1000);
    link.shapes.push_back(shape);
    spec.links.push_back(link);
  };
  add(root, -1);
  for (int i = root + 1; i < links; ++i) add(i, i - 1);
  for (int i = root - 1; i >= 0; --i) add(i, i + 1);
  return Mechanism::make(std::move(spec)).value();
}

// An open system that lands: its contacts slide, and the tree method hands it over after few Newton steps. At rest the tree method needs none.
TEST(TreeIsland, LandingChainIsHandedOverAndReturns) {
  const MechanismPtr m = open_chain(60);
  const world::World world({m}, {});
  world::WorldStepper stepper(world);
  world::WorldState s(world);
  s.q(0)[2] = 0.12;
  s.q(0)[7] = 0.05;
  stepper.load(s);
  int handed_over = 0, max_steps = 0, at_end = 0;
  for (int i = 0; i < 400; ++i) {
    const StepReport report = stepper.step({}, 0.002);
    ASSERT_EQ(report.status, StepStatus::ok);
    EXPECT_EQ(report.not_converged, 0);
    handed_over += report.handed_over;
    if (report.handed_over == 0) max_steps = std::max(max_steps, report.newton_steps);
    if (i >= 300) at_end += report.handed_over;
  }
  EXPECT_GT(handed_over, 0);
  EXPECT_LE(max_steps, 80);
  EXPECT_EQ(at_end, 0);
}

TEST(AndersonMixing, SolvesAnAffineMapInAFewSteps) {
  // x <- A x + b with 40 unknowns, three slow directions with rates 0.9999, 0.999 and 0.99, and 0.1 in all others.
  constexpr std::size_t n = 40;
  const auto rate = [](std::size_t i) { return i == 7 ? 0.9999 : i == 20 ? 0.999 : i == 33 ? 0.99 : 0.1; };
  std::vector<double> x(n, 0.0), g(n);
  AndersonMixing mixing;
  mixing.begin(n);
  double error = 0;
  for (int k = 0; k < 12; ++k) {
    error = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const double solution = 1 + 0.1 * static_cast<double>(i % 3);
      g[i] = solution + rate(i) * (x[i] - solution);
      error = std::max(error, std::fabs(x[i] - solution));
    }
    mixing.next(x, g);
  }
  EXPECT_LT(error, 1e-9);  // 0.9988 without acceleration
}

}  // namespace
}  // namespace ugoki::contact
