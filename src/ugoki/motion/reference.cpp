#include "ugoki/motion/reference.h"

#include <algorithm>
#include <cmath>

#include "ugoki/mechanism/state.h"
#include "ugoki/motion/contact_labels.h"

namespace ugoki {
namespace {

/// Lowest point of the link's colliding shapes, in the world.
Vec3 lowest_point(const Link& link, const Pose& X_WB) {
  Vec3 lowest{0, 0, 1e300};
  const auto consider = [&](const Vec3& p) {
    if (p.z < lowest.z) lowest = p;
  };
  for (const Shape& s : link.shapes) {
    if (!s.collides) continue;
    const Pose X = X_WB * s.X_BS;
    if (s.type == ShapeType::box) {
      const Vec3 h = s.half_extents;
      consider(X * Vec3{X.R.zx > 0 ? -h.x : h.x, X.R.zy > 0 ? -h.y : h.y, X.R.zz > 0 ? -h.z : h.z});
    } else {
      const double end = s.type == ShapeType::capsule ? (X.R.zz > 0 ? -s.half_length : s.half_length) : 0.0;
      consider(X * Vec3{0, 0, end} - Vec3{0, 0, s.radius});
    }
  }
  return lowest;
}

}  // namespace

Motion with_soles_above(const Motion& motion, const Mechanism& m, double floor) {
  constexpr double reached = 2e-4;       // m
  constexpr double greatest_turn = 0.1;  // rad in one iteration
  Motion out = motion;
  std::vector<int> soles;  // parents first
  for (const int link : find_feet(m))
    if (link > 0 && m.link(link).joint.nv() > 0) soles.push_back(link);
  std::vector<Pose> X(static_cast<std::size_t>(m.link_count()));
  for (int f = 0; f < motion.frames && !soles.empty(); ++f) {
    double* q = out.frame(f);
    calc_poses(m, std::span<const double>(q, static_cast<std::size_t>(m.nq())), X);
    for (const int i : soles) {
      const Link& link = m.link(i);
      double* qj = q + link.q_index;
      Pose& X_WB = X[static_cast<std::size_t>(i)];
      const Pose X_WJ = X[static_cast<std::size_t>(link.parent)] * link.joint.X_PJ;
      X_WB = X_WJ * joint_pose(link.joint, qj);
      for (int iteration = 0; iteration < 12; ++iteration) {
        const Vec3 p = lowest_point(link, X_WB);
        const double depth = floor - p.z;
        if (depth < reached) break;
        Vec6 S[6];
        double lift[6], size = 0;
        const int n = joint_subspace(link.joint, qj, S);
        for (int k = 0; k < n; ++k) {
          lift[k] = cross(X_WB.R * S[k].w, p - X_WB.p).z;
          size += lift[k] * lift[k];
        }
        if (size < 0.02 * 0.02) break;
        double turn = depth / size;
        turn = std::min(turn, greatest_turn / std::sqrt(size));
        for (int k = 0; k < n; ++k) lift[k] *= turn;
        joint_integrate(link.joint, qj, lift, 1.0, qj);
        X_WB = X_WJ * joint_pose(link.joint, qj);
      }
    }
  }
  return out;
}

SmoothMotion make_reference(const Motion& motion, const Mechanism& mechanism, double floor) {
  return SmoothMotion(with_soles_above(motion, mechanism, floor), mechanism, 6.0);
}

}  // namespace ugoki
