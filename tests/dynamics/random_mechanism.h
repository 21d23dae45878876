#pragma once
// Random trees of links for property tests.

#include <random>
#include <string>

#include "ugoki/mechanism/state.h"

namespace ugoki::testing {

/// Seeded source of random values.
class RandomSource {
 public:
  explicit RandomSource(unsigned seed) : engine_(seed) {}
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine_); }
  int below(int n) { return std::uniform_int_distribution<int>(0, n - 1)(engine_); }
  Vec3 vec(double size) { return {uniform(-size, size), uniform(-size, size), uniform(-size, size)}; }
  Vec3 direction() { return normalized(vec(1) + Vec3{0, 0, 1e-3}); }
  Mat3 rotation() { return to_matrix(exp_map(vec(3))); }

 private:
  std::mt19937_64 engine_;
};

/// Inertia of a random box with random density, pose and size: always physically possible.
inline Inertia random_inertia(RandomSource& random) {
  const Vec3 edges{random.uniform(0.05, 0.3), random.uniform(0.05, 0.3), random.uniform(0.05, 0.3)};
  const Shape box = Shape::box(edges, {random.rotation(), random.vec(0.3)});
  return solid_inertia(box, random.uniform(200, 2000));
}

/// A random tree of links with random joints and inertias. @param only joint types to choose from; empty: all
inline MechanismSpec random_spec(RandomSource& random, int links, std::span<const JointType> only = {}, bool floating_base = true) {
  MechanismSpec spec;
  spec.name = "random";
  for (int i = 0; i < links; ++i) {
    LinkSpec l;
    l.name = "link" + std::to_string(i);
    if (i > 0) l.parent = "link" + std::to_string(random.below(4) == 0 ? random.below(i) : i - 1);
    l.joint.type = only.empty() ? static_cast<JointType>(random.below(9))
                                : only[static_cast<std::size_t>(random.below(static_cast<int>(only.size())))];
    if (i == 0) l.joint.type = floating_base ? JointType::floating : JointType::revolute;
    l.joint.X_PJ = {random.rotation(), random.vec(0.4)};
    l.joint.axis = random.direction();
    l.joint.axis2 = normalized(cross(l.joint.axis, random.direction()) + l.joint.axis * 0.2);
    l.joint.pitch = random.uniform(-0.2, 0.2);
    for (Dof& f : l.joint.dofs) f.armature = random.below(3) == 0 ? random.uniform(0, 0.1) : 0;
    l.inertia = random_inertia(random);
    spec.links.push_back(std::move(l));
  }
  return spec;
}

inline MechanismSpec without_armature(MechanismSpec spec) {
  for (LinkSpec& l : spec.links)
    for (Dof& f : l.joint.dofs) f.armature = 0;
  return spec;
}

/// Sets a random configuration, velocity, joint forces and external wrenches.
inline void randomize(RandomSource& random, const Mechanism& m, State& s) {
  std::vector<double> step(static_cast<std::size_t>(m.nv()));
  for (double& x : step) x = random.uniform(-1.5, 1.5);
  integrate(m, m.neutral(), step, 1.0, s.q);
  for (double& x : s.v) x = random.uniform(-3, 3);
  for (double& x : s.tau) x = random.uniform(-20, 20);
  for (Vec6& f : s.external) f = {random.vec(5), random.vec(10)};
}

}  // namespace ugoki::testing
