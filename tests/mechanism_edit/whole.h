#pragma once
// Inertia of a whole mechanism as one rigid body, and comparisons; independent of the tested functions.

#include "ugoki/mechanism/state.h"

namespace ugoki::testing {

/// Total inertia about the world's origin, at q, of the links with an index in [first, last); last = -1: all from `first`.
inline Inertia whole_inertia(const Mechanism& m, std::span<const double> q, int first = 0, int last = -1) {
  std::vector<Pose> X(static_cast<std::size_t>(m.link_count()));
  calc_poses(m, q, X);
  Inertia sum;
  for (int i = first; i < (last < 0 ? m.link_count() : last); ++i) sum += m.link(i).inertia.in_parent(X[static_cast<std::size_t>(i)]);
  return sum;
}

/// Maximum difference of the components of two inertias, divided by the largest component of the first.
inline double difference(const Inertia& a, const Inertia& b) {
  const double x[10] = {a.mass, a.h.x, a.h.y, a.h.z, a.I.xx, a.I.yy, a.I.zz, a.I.xy, a.I.xz, a.I.yz};
  const double y[10] = {b.mass, b.h.x, b.h.y, b.h.z, b.I.xx, b.I.yy, b.I.zz, b.I.xy, b.I.xz, b.I.yz};
  double size = 1e-300, error = 0;
  for (int i = 0; i < 10; ++i) {
    size = std::max(size, std::fabs(x[i]));
    error = std::max(error, std::fabs(x[i] - y[i]));
  }
  return error / size;
}

/// A link with a name, a parent and a joint type; all other values are defaults.
inline LinkSpec link_of(std::string name, std::string parent, JointType type) {
  LinkSpec l;
  l.name = std::move(name);
  l.parent = std::move(parent);
  l.joint.type = type;
  return l;
}

inline double distance(const Pose& a, const Pose& b) {
  double worst = norm(a.p - b.p);
  for (int i = 0; i < 3; ++i) worst = std::max(worst, norm(a.R.row(i) - b.R.row(i)));
  return worst;
}

}  // namespace ugoki::testing
