#pragma once
// Random trees for the kernels, which treat axes along the coordinate axes in ways of their own.

#include "random_mechanism.h"

namespace ugoki::testing {

/// All joint types; coordinate axes and their opposites among the others, joint frames turned and not.
inline MechanismSpec varied_spec(RandomSource& random, int links, bool floating_base) {
  MechanismSpec spec = random_spec(random, links, {}, floating_base);
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

}  // namespace ugoki::testing
