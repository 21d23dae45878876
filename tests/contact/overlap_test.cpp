// Scenes that begin with overlaps: characters inside each other, heaps inside walls, links inside each other, bodies in the ground.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <ctime>

#include "../dynamics/random_mechanism.h"
#include "ugoki/contact/guarded_step.h"
#include "world.h"

namespace ugoki::contact {
namespace {

constexpr double dt = 0.002;

/// A character of capsules: pelvis, spine, head, and limbs of two links with limited joints.
MechanismPtr character(testing::RandomSource& random) {
  MechanismSpec spec;
  spec.name = "character";
  const double size = random.uniform(0.5, 1.2);
  const auto add = [&](const std::string& name, const std::string& parent, const Vec3& at, const Vec3& end, double radius) {
    LinkSpec l;
    l.name = name;
    l.parent = parent;
    l.joint.type = parent.empty() ? JointType::floating : JointType::spherical;
    l.joint.X_PJ.p = at * size;
    for (std::size_t k = 0; k < 3 && !parent.empty(); ++k) {
      l.joint.dofs[k].lower = -0.8;
      l.joint.dofs[k].upper = 0.8;
      l.joint.dofs[k].damping = 1;
    }
    l.shapes.push_back(Shape::capsule(radius * size, normalized(end) * (radius * size), end * size));
    l.inertia = solid_inertia(l.shapes[0], 1000);
    spec.links.push_back(l);
  };
  add("pelvis", "", {}, {0, 0, 0.2}, 0.12);
  add("chest", "pelvis", {0, 0, 0.25}, {0, 0, 0.25}, 0.13);
  add("head", "chest", {0, 0, 0.42}, {0, 0, 0.15}, 0.09);
  for (const double side : {-1.0, 1.0}) {
    const std::string s = side < 0 ? "right " : "left ";
    add(s + "thigh", "pelvis", {0, 0.1 * side, 0}, {0, 0, -0.4}, 0.07);
    add(s + "shank", s + "thigh", {0, 0, -0.42}, {0, 0, -0.4}, 0.05);
    add(s + "arm", "chest", {0, 0.2 * side, 0.22}, {0, 0.05 * side, -0.27}, 0.045);
    add(s + "forearm", s + "arm", {0, 0.05 * side, -0.3}, {0.1, 0, -0.22}, 0.04);
  }
  return Mechanism::make(std::move(spec)).value();
}

MechanismPtr wall() {
  MechanismSpec spec;
  spec.name = "wall";
  LinkSpec l;
  l.name = "wall";
  l.joint.type = JointType::fixed;
  l.shapes.push_back(Shape::box({0.1, 2, 2}, {Mat3::identity(), {0, 0, 2}}));
  spec.links.push_back(l);
  return Mechanism::make(std::move(spec)).value();
}

/// s: processor time of the calling thread, which other programs on the machine do not lengthen.
double processor_time() {
  timespec t{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

struct Outcome {
  bool ok = true;
  double depth = 0;    ///< m: maximum overlap at the end
  double speed = 0;    ///< m/s: maximum speed of a link's origin
  double slowest = 0;  ///< processor time of the most expensive step as a multiple of the mean; printed, not tested
};

/// Runs a random scene without gravity for 2 s, so that only the overlaps cause speeds.
Outcome run(unsigned seed) {
  testing::RandomSource random(seed);
  std::vector<MechanismPtr> systems;
  std::vector<Vec3> places;
  const int kind = static_cast<int>(seed % 4);
  if (kind == 0) {  // copies of one character at the same position or up to 10 cm apart
    const MechanismPtr m = character(random);
    const int count = 2 + random.below(2);
    for (int i = 0; i < count; ++i) {
      systems.push_back(m);
      places.push_back(Vec3{0, 0, 3} + (i == 0 || random.below(3) == 0 ? Vec3{} : random.vec(0.1)));
    }
  } else if (kind == 1) {  // a heap of bodies inside each other, and inside a wall
    systems.push_back(wall());
    places.push_back({});
    for (int i = 0; i < 12; ++i) {
      const double edge = random.uniform(0.05, 0.2);
      const Shape shape = random.below(2) == 0   ? Shape::sphere(edge)
                          : random.below(2) == 0 ? Shape::box({edge, 0.7 * edge, 0.5 * edge})
                                                 : Shape::capsule(0.4 * edge, {0, 0, -edge}, {0, 0, edge});
      systems.push_back(body("body" + std::to_string(i), shape, std::pow(10, random.uniform(2, 4))));
      places.push_back(Vec3{0.15, 0, 1.5} + random.vec(0.25));
    }
  } else if (kind == 2) {  // a character hip-deep in the ground
    systems.push_back(character(random));
    places.push_back({0, 0, random.uniform(0, 0.6)});
  } else {  // links of a random tree inside each other
    MechanismSpec spec = testing::random_spec(random, 4 + random.below(8), std::array{JointType::revolute, JointType::spherical});
    spec.links[0].joint.X_PJ = {};
    for (LinkSpec& l : spec.links) {
      const double radius = random.uniform(0.03, 0.12);
      if (&l != &spec.links[0]) l.joint.X_PJ.p = random.vec(0.15);
      l.shapes = {Shape::capsule(radius, random.vec(0.1), random.vec(0.1))};
      l.inertia = solid_inertia(l.shapes[0], random.uniform(300, 3000));
    }
    systems.push_back(Mechanism::make(std::move(spec)).value());
    places.push_back({0, 0, 3});
  }
  StepperOptions options;
  options.gravity = {};
  World w(systems, {}, options);
  for (std::size_t s = 0; s < systems.size(); ++s)
    if (!w.states[s].q.empty()) put(w.states[s], places[s]);
  if (kind == 3) w.scene.set_self_collision(0, true);
  GuardedStep guard(w.scene, w.stepper);
  Outcome out;
  double total = 0, slowest = 0;
  const int steps = static_cast<int>(2 / dt);
  for (int i = 0; i < steps; ++i) {
    w.find();
    const double begin = processor_time();
    out.ok = guard.step(w.systems, w.contacts, dt).status == StepStatus::ok;
    const double cost = processor_time() - begin;
    total += cost;
    slowest = std::max(slowest, cost);
    if (!out.ok) return out;
    for (std::size_t s = 0; s < systems.size(); ++s) {
      const dynamics::Workspace& ws = w.stepper.workspace(static_cast<int>(s));
      for (int l = 0; l < systems[s]->link_count(); ++l)
        out.speed = std::max(out.speed, norm(dynamics::point_velocity(ws, l, ws.X_WB[static_cast<std::size_t>(l)].p)));
    }
  }
  w.find();
  out.depth = std::max(0.0, -w.lowest());
  out.slowest = slowest / (total / steps);
  return out;
}

void check(unsigned first, unsigned last) {
  const bool print = std::getenv("UGOKI_PRINT") != nullptr;
  for (unsigned seed = first; seed < last; ++seed) {
    const Outcome out = run(seed);
    if (print)
      std::printf("seed %u: ok %d depth %.4f m speed %.2f m/s slowest step %.0f times the mean\n", seed, out.ok, out.depth, out.speed,
                  out.slowest);
    EXPECT_TRUE(out.ok) << "seed " << seed;
    EXPECT_LT(out.depth, 5e-3) << "seed " << seed;
    EXPECT_LT(out.speed, 3) << "seed " << seed;
  }
}

TEST(Overlap, BodiesThatBeginInsideEachOtherComeApart) { check(0, 24); }
// Scenes in which links were thrown at 14 to 54 m/s, characters stayed inside each other, or the simulation ended.
TEST(Overlap, HardScenesComeApart) {
  for (const unsigned seed : {72U, 112U, 208U, 505U, 861U}) check(seed, seed + 1);
}
TEST(Slow_Overlap, BodiesThatBeginInsideEachOtherComeApart) { check(24, 1000); }

}  // namespace
}  // namespace ugoki::contact
