#pragma once
// Random trees for the kernels, which treat what lies along the coordinate axes in ways of their own: joint axes, offsets, centres
// of mass, principal axes.

#include "random_mechanism.h"

namespace ugoki::testing {

/// Some of the coordinates zero, or all, or none.
inline Vec3 thinned(RandomSource& random, const Vec3& v) {
  const int kept = random.below(8);
  return {(kept & 1) != 0 ? v.x : 0, (kept & 2) != 0 ? v.y : 0, (kept & 4) != 0 ? v.z : 0};
}
/// Also of boxes that are not turned, and of such with their centre on an axis or at the origin.
inline Inertia varied_inertia(RandomSource& random) {
  if (random.below(3) == 0) return random_inertia(random);
  const Vec3 edges{random.uniform(0.05, 0.3), random.uniform(0.05, 0.3), random.uniform(0.05, 0.3)};
  const Shape box = Shape::box(edges, {Mat3::identity(), thinned(random, random.vec(0.3))});
  return solid_inertia(box, random.uniform(200, 2000));
}

/// All joint types; coordinate axes and their opposites among the others, joint frames turned and not.
/// @param only the joint types to draw from; empty: all
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

/// A trunk that carries limbs in twos: the same joints, axes perhaps the other way round, other places, inertias and armatures. Links
/// of both limbs follow each other in turn.
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
        for (Freedom& f : twin.joint.freedoms) f.armature = random.below(3) == 0 ? random.uniform(0, 0.1) : 0;
        twin.inertia = varied_inertia(random);
        spec.links.push_back(twin);
      }
  }
  return spec;
}

}  // namespace ugoki::testing
