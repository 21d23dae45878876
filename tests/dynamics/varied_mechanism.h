#pragma once
// Random trees for the kernels, which treat axes along the coordinate axes in ways of their own.

#include "random_mechanism.h"

namespace ugoki::testing {

/// All joint types; coordinate axes and their opposites among the others, joint frames turned and not.
/// @param only the joint types to draw from; empty: all
inline MechanismSpec varied_spec(RandomSource& random, int links, bool floating_base, std::span<const JointType> only = {}) {
  MechanismSpec spec = random_spec(random, links, only, floating_base);
  for (LinkSpec& l : spec.links) {
    if (random.below(3) > 0) l.joint.X_PJ.R = Mat3::identity();
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
        twin.joint.X_PJ.p = random.vec(0.4);
        if (random.below(2) == 0) twin.joint.axis = -l.joint.axis;
        for (Freedom& f : twin.joint.freedoms) f.armature = random.below(3) == 0 ? random.uniform(0, 0.1) : 0;
        twin.inertia = random_inertia(random);
        spec.links.push_back(twin);
      }
  }
  return spec;
}

}  // namespace ugoki::testing
