#include "ugoki/motion/reference.h"

#include <algorithm>
#include <cmath>

#include "ugoki/mechanism/state.h"
#include "ugoki/motion/contact_labels.h"

namespace ugoki {
namespace {

/// The surface under a foot: its support points that lie lowest in the neutral position, within a centimetre.
std::vector<SupportPoint> sole_of(const Link& link, const Pose& X_WB) {
  std::vector<SupportPoint> points = support_points(link);
  double low = 1e300;
  for (const SupportPoint& s : points) low = std::min(low, (X_WB * s.p).z - s.radius);
  std::erase_if(points, [&](const SupportPoint& s) { return (X_WB * s.p).z - s.radius > low + 0.01; });
  return points;
}

struct Sole {
  int link;
  std::vector<SupportPoint> points;
};

}  // namespace

Motion with_soles_above(const Motion& motion, const Mechanism& m, double floor) {
  constexpr double reached = 2e-4;       // m
  constexpr double greatest_turn = 0.1;  // rad in one iteration
  Motion out = motion;
  std::vector<Pose> X(static_cast<std::size_t>(m.link_count()));
  calc_poses(m, m.neutral(), X);
  std::vector<Sole> soles;  // parents first
  for (const int link : find_feet(m))
    if (link > 0 && m.link(link).joint.nv() > 0) soles.push_back({link, sole_of(m.link(link), X[static_cast<std::size_t>(link)])});
  for (int f = 0; f < motion.frames && !soles.empty(); ++f) {
    double* q = out.frame(f);
    calc_poses(m, std::span<const double>(q, static_cast<std::size_t>(m.nq())), X);
    for (const Sole& sole : soles) {
      const int i = sole.link;
      const Link& link = m.link(i);
      double* qj = q + link.q_index;
      Pose& X_WB = X[static_cast<std::size_t>(i)];
      const Pose X_WJ = X[static_cast<std::size_t>(link.parent)] * link.joint.X_PJ;
      X_WB = X_WJ * joint_pose(link.joint, qj);
      for (int iteration = 0; iteration < 12; ++iteration) {
        Vec3 p{0, 0, 1e300};
        double highest = -1e300;
        for (const SupportPoint& s : sole.points) {
          const Vec3 at = X_WB * s.p - Vec3{0, 0, s.radius};
          if (at.z < p.z) p = at;
          highest = std::max(highest, at.z);
        }
        const double depth = std::min(floor, highest) - p.z;  // a sole that is deep but level stays level
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
  std::vector<double> cutoffs;
  for (const Link& link : mechanism.links()) {
    const bool light = link.label.starts_with("hand") || link.label.starts_with("fingers") || link.label.starts_with("thumb");
    cutoffs.push_back(light ? 15.0 : 6.0);
  }
  return SmoothMotion(with_soles_above(motion, mechanism, floor), mechanism, cutoffs);
}

}  // namespace ugoki
