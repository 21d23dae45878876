#include "ugoki/motion/skeleton.h"

#include <algorithm>

namespace ugoki {

void MeasuredMotion::calc_joint_poses(int frame, std::vector<Pose>& X) const {
  const std::size_t n = skeleton.joints.size();
  X.resize(n);
  const std::size_t at = static_cast<std::size_t>(frame) * n;
  for (std::size_t i = 0; i < n; ++i) {
    const Pose local{to_matrix(rotations[at + i]), translations[at + i]};
    const int parent = skeleton.joints[i].parent;
    X[i] = parent < 0 ? local : X[static_cast<std::size_t>(parent)] * local;
  }
}

std::vector<Vec3> rest_positions(const Skeleton& skeleton) {
  std::vector<Vec3> p(skeleton.joints.size());
  for (std::size_t i = 0; i < p.size(); ++i) {
    const SkeletonJoint& j = skeleton.joints[i];
    p[i] = j.parent < 0 ? j.offset : p[static_cast<std::size_t>(j.parent)] + j.offset;
  }
  return p;
}

double rest_height(const Skeleton& skeleton) {
  const std::vector<Vec3> p = rest_positions(skeleton);
  if (p.empty()) return 0;
  double low = p[0].z, high = p[0].z;
  for (std::size_t i = 0; i < p.size(); ++i) {
    low = std::min(low, p[i].z);
    high = std::max(high, p[i].z);
    for (const Vec3& e : skeleton.joints[i].end_sites) {
      low = std::min(low, p[i].z + e.z);
      high = std::max(high, p[i].z + e.z);
    }
  }
  return high - low;
}

}  // namespace ugoki
