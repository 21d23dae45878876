#include "ugoki/intake/joined_motion.h"

namespace ugoki::intake {

MeasuredMotion joined(const std::vector<MeasuredMotion>& motions) {
  MeasuredMotion all = motions[0];
  for (std::size_t i = 1; i < motions.size(); ++i) {
    const MeasuredMotion& m = motions[i];
    all.frames += m.frames;
    all.translations.insert(all.translations.end(), m.translations.begin(), m.translations.end());
    all.rotations.insert(all.rotations.end(), m.rotations.begin(), m.rotations.end());
    for (std::size_t j = 0; j < m.skeleton.joints.size(); ++j)
      all.skeleton.joints[j].translates = all.skeleton.joints[j].translates || m.skeleton.joints[j].translates;
  }
  return all;
}

}  // namespace ugoki::intake
