#pragma once
// A world of fast bodies without gravity, for tests that no body passes through another.

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "../dynamics/random_mechanism.h"
#include "ugoki/contact/guarded_step.h"
#include "ugoki/geometry/prepare.h"
#include "world.h"

namespace ugoki::contact {

/// A random ball, box, capsule, cylinder, ellipsoid or hull; r [m] sets its size.
inline Shape any_shape(testing::RandomSource& random, double r) {
  std::vector<Vec3> points;
  for (int k = 0; k < 16; ++k) points.push_back(random.direction() * (2 * r));
  const Shape shapes[] = {Shape::sphere(r),
                          Shape::box({r, 0.6 * r, 2 * r}),
                          Shape::capsule(0.5 * r, {0, 0, -2 * r}, {0, 0, 2 * r}),
                          Shape::cylinder(r, 0.5 * r),
                          Shape::ellipsoid({r, 0.5 * r, 1.5 * r}),
                          Shape::mesh(geometry::make_hull_geometry(points, "hull").value())};
  return shapes[random.below(6)];
}

/// A world that is stepped as the dynamics LSI does: contacts by distance, swept contacts, guarded step.
struct Fast {
  World w;
  SweptContacts swept;
  GuardedStep guard;
  std::vector<collision::SystemMotion> motions;
  StepReport report;  ///< report of the last step

  static StepperOptions weightless() {
    StepperOptions options;
    options.gravity = {};
    return options;
  }
  explicit Fast(const std::vector<MechanismPtr>& bodies)
      : w(bodies, {-1000, 0, 0}, weightless()), swept(w.scene), guard(w.scene, w.stepper) {}
  void step(double dt) {
    w.find();
    motions.clear();
    for (State& s : w.states) motions.push_back({s.q, s.v});
    swept.add(motions, w.spans, dt, 0.02, w.contacts);
    report = guard.step(w.systems, w.contacts, dt);
    ASSERT_EQ(report.status, StepStatus::ok);
  }
  /// Whether body s turns by less than 1 rad in a step. For a plate that turns further, the side of a body is not defined.
  [[nodiscard]] bool turns_little(std::size_t s, double dt) const {
    const std::vector<double>& v = w.states[s].v;
    return v.size() < 6 || dt * norm(Vec3{v[0], v[1], v[2]}) < 1;
  }
  [[nodiscard]] Pose pose(std::size_t s) {
    Pose X;
    calc_poses(w.stepper.mechanism(static_cast<int>(s)), w.states[s].q, {&X, 1});
    return X;
  }
};

}  // namespace ugoki::contact
