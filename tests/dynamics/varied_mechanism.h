#pragma once
// Random trees for the tests of the kernels. The kernels have special code for joint axes, offsets, centres of mass and principal axes
// along the coordinate axes, so these occur often here.

#include "random_mechanism.h"

namespace ugoki::testing {

/// v with a random subset of its coordinates (perhaps none or all) set to zero.
inline Vec3 thinned(RandomSource& random, const Vec3& v) {
  const int kept = random.below(8);
  return {(kept & 1) != 0 ? v.x : 0, (kept & 2) != 0 ? v.y : 0, (kept & 4) != 0 ? v.z : 0};
}
/// Inertia of a random box. Often the box is parallel to the axes, and its centre may be on an axis or at the origin.
inline Inertia varied_inertia(RandomSource& random) {
  if (random.below(3) == 0) return random_inertia(random);
  const Vec3 edges{random.uniform(0.05, 0.3), random.uniform(0.05, 0.3), random.uniform(0.05, 0.3)};
  const Shape box = Shape::box(edges, {Mat3::identity(), thinned(random, random.vec(0.3))});
  return solid_inertia(box, random.uniform(200, 2000));
}

/// A random tree in which many joint axes are coordinate axes or their opposites, and many joint frames are not rotated.
/// @param only joint types to choose from; empty: all
inline MechanismSpec varied_spec(RandomSource& random, int links, bool floating_base, std::span<const JointType> only = {}) {
  MechanismSpec spec = random_spec(random, links, only, floating_base);
  for (LinkSpec& l : spec.links) {
    if (random.below(3) > 0) l.joint.X_PJ.R = Mat3::identity();
    l.joint.X_PJ.p = thinned(random, l.joint.X_PJ.p);
    l.inertia = varied_inertia(random);
    if (random.below(3) > 0) {
      const double sign = random.below(2) == 0 ? 1 : -1;
      const int k = random.below(3);
      l.joint.axis = {k == 0 ? sign : 0, k == 1 ? sign : 0, k == 2 ? sign : 0};
      l.joint.axis2 = {k == 1 ? sign : 0, k == 2 ? sign : 0, k == 0 ? sign : 0};
    }
  }
  return spec;
}

/// A random trunk that carries pairs of limbs. Both limbs of a pair have the same joints; axes may be reversed, and positions, inertias
/// and armatures differ. In the order of links, the two limbs alternate.
inline MechanismSpec twins_spec(RandomSource& random, bool floating_base, std::span<const JointType> only = {}) {
  MechanismSpec spec = varied_spec(random, 2 + random.below(6), floating_base, only);
  const int trunk = static_cast<int>(spec.links.size());
  for (int limb = 0, limbs = 1 + random.below(6); limb < limbs; ++limb) {
    const MechanismSpec shape = varied_spec(random, 3 + random.below(6), false, only);
    const std::string base = spec.links[static_cast<std::size_t>(random.below(trunk))].name;
    for (const LinkSpec& l : shape.links)
      for (const char side : {'l', 'r'}) {
        LinkSpec twin = l;
        const auto name_of = [&](const std::string& name) { return name + "_" + std::to_string(limb) + side; };
        twin.name = name_of(l.name);
        twin.parent = l.parent.empty() ? base : name_of(l.parent);
        twin.joint.X_PJ.p = thinned(random, random.vec(0.4));
        if (random.below(2) == 0) twin.joint.axis = -l.joint.axis;
        for (Dof& f : twin.joint.dofs) f.armature = random.below(3) == 0 ? random.uniform(0, 0.1) : 0;
        twin.inertia = varied_inertia(random);
        spec.links.push_back(twin);
      }
  }
  return spec;
}

}  // namespace ugoki::testing
