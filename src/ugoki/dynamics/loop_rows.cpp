#include "ugoki/dynamics/loop_rows.h"

#include <algorithm>

#include "ugoki/base/check.h"
#include "ugoki/dynamics/dynamics.h"

namespace ugoki::dynamics {
namespace {

/// Arguments of update_loop_rows() that describe the links.
struct Links {
  Vec3 p0;
  std::span<const Pose> X_WB;
  std::span<const Vec6> V;
  bool gaps;
};

/// A loop's two frames J_A and J_B in world axes, and the velocities of its two links about p0.
struct Ends {
  Pose X_WA, X_WB;  ///< poses of J_A and J_B; positions relative to p0
  Vec6 V_a, V_b, V_ba;

  Ends(const Links& links, const Loop& loop) {
    X_WA = frame(links, loop.link_a, loop.X_AJ);
    X_WB = frame(links, loop.link_b, loop.X_BJ);
    if (loop.link_a >= 0) V_a = links.V[static_cast<std::size_t>(loop.link_a)];
    if (loop.link_b >= 0) V_b = links.V[static_cast<std::size_t>(loop.link_b)];
    V_ba = V_b - V_a;
  }
  static Pose frame(const Links& links, int link, const Pose& X_LJ) {
    Pose X = link >= 0 ? links.X_WB[static_cast<std::size_t>(link)] * X_LJ : X_LJ;
    X.p -= links.p0;
    return X;
  }
};

/// Writes the rows of one loop, one after another.
class RowWriter {
 public:
  RowWriter(const Ends& ends, LoopRows& rows, std::size_t first) : ends_(ends), rows_(rows), k_(first) {
    d_ = ends.X_WB.p - ends.X_WA.p;
    velocity_B_ = ends.V_b.v + cross(ends.V_b.w, ends.X_WB.p);
  }

  void position(const Vec3& e) {
    const Vec3 r = ends_.X_WB.p;
    const Vec3 edot = cross(ends_.V_a.w, e);
    add(dot(e, d_), {cross(r, e), e}, {cross(velocity_B_, e) + cross(r, edot), edot});
  }
  void rotation(const Vec3& e, const Vec3& error_W) { add(dot(error_W, e), {e, {}}, {cross(ends_.V_a.w, e), {}}); }
  /// Writes the row that keeps two axes perpendicular: e is fixed in link a, b in link b. @param e, b world axes
  void right_angle(const Vec3& e, const Vec3& b) {
    const Vec3 edot = cross(ends_.V_a.w, e), bdot = cross(ends_.V_b.w, b);
    add(dot(e, b), {cross(b, e), {}}, {cross(bdot, e) + cross(b, edot), {}});
  }
  void distance(double length) {
    const double now = norm(d_);
    const Vec3 n = now > 1e-12 ? d_ / now : ends_.X_WA.R.column(0);
    const Vec3 r = ends_.X_WB.p;
    const Vec3 velocity_A = ends_.V_a.v + cross(ends_.V_a.w, ends_.X_WA.p);
    const Vec3 ddot = velocity_B_ - velocity_A;
    const Vec3 ndot = (ddot - n * dot(n, ddot)) / std::max(now, 1e-12);
    add(now - length, {cross(r, n), n}, {cross(velocity_B_, n) + cross(r, ndot), ndot});
  }

 private:
  void add(double gap, const Vec6& w, const Vec6& wdot) {
    rows_.gap[k_] = gap;
    rows_.W[k_] = w;
    rows_.drift[k_] = dot(wdot, ends_.V_ba);
    ++k_;
  }

  const Ends& ends_;
  LoopRows& rows_;
  std::size_t k_;
  Vec3 d_, velocity_B_;
};

double displacement(const Mechanism& m, int dof, std::span<const double> q) {
  const Link& link = m.link(m.link_of_dof(dof));
  double x[6];
  joint_displacement(link.joint, q.data() + link.q_index, x);
  return x[dof - link.v_index];
}

void write_gear(const Mechanism& m, const Loop& loop, std::span<const double> q, std::span<const double> v, LoopRows& rows, std::size_t i) {
  const double x = displacement(m, loop.dof_b, q);
  double value = 0, slope = 0, curvature = 0;  // Horner's scheme for the polynomial and its derivatives
  for (std::size_t k = loop.polynomial.size(); k-- > 0;) {
    curvature = curvature * x + 2 * slope;
    slope = slope * x + value;
    value = value * x + loop.polynomial[k];
  }
  const auto k = static_cast<std::size_t>(rows.first[i]);
  const double v_b = v[static_cast<std::size_t>(loop.dof_b)];
  rows.gap[k] = displacement(m, loop.dof_a, q) - value;
  rows.W[k] = {};
  rows.slope[i] = slope;
  rows.drift[k] = -curvature * v_b * v_b;
}

void write_rows(const Links& links, const Loop& loop, LoopRows& rows, std::size_t first) {
  const Ends ends(links, loop);
  RowWriter write(ends, rows, first);
  const Mat3& R = ends.X_WA.R;
  const Vec3 axis = R * loop.axis;
  Vec3 across[2];
  if (loop.type != LoopType::weld && loop.type != LoopType::ball && loop.type != LoopType::distance) {
    const Vec3 u = any_perpendicular(loop.axis);  // chosen in the axes of J_A, so that the rows rotate with link a
    across[0] = R * u;
    across[1] = R * cross(loop.axis, u);
  }
  const auto positions = [&] {
    for (int k = 0; k < 3; ++k) write.position(R.column(k));
  };
  const auto rotations = [&] {
    const Vec3 error = links.gaps ? R * log_map(to_quat(R.transposed() * ends.X_WB.R)) : Vec3{};
    for (int k = 0; k < 3; ++k) write.rotation(R.column(k), error);
  };
  const auto alignment = [&] {
    const Vec3 b = ends.X_WB.R * loop.axis;
    for (const Vec3& e : across) write.right_angle(e, b);
  };
  switch (loop.type) {
    case LoopType::weld:
      positions();
      rotations();
      break;
    case LoopType::ball: positions(); break;
    case LoopType::revolute:
      positions();
      alignment();
      break;
    case LoopType::prismatic:
      for (const Vec3& e : across) write.position(e);
      rotations();
      break;
    case LoopType::cylindrical:
      for (const Vec3& e : across) write.position(e);
      alignment();
      break;
    case LoopType::planar:
      write.position(axis);
      alignment();
      break;
    case LoopType::universal:
      positions();
      write.right_angle(axis, ends.X_WB.R * loop.axis2);
      break;
    case LoopType::distance: write.distance(loop.length); break;
    case LoopType::gear: break;
  }
}

}  // namespace

LoopRows::LoopRows(std::span<const Loop> loops) {
  first.push_back(0);
  for (const Loop& loop : loops) first.push_back(first.back() + loop.rows());
  const auto n = static_cast<std::size_t>(first.back());
  W.resize(n);
  gap.resize(n);
  drift.resize(n);
  slope.resize(loops.size());
}

void update_loop_rows(const Mechanism& m, const Vec3& p0, std::span<const Pose> X_WB, std::span<const Vec6> V, std::span<const Loop> loops,
                      std::span<const double> q, std::span<const double> v, bool gaps, LoopRows& rows) {
  UGOKI_CHECK(rows.first.size() == loops.size() + 1);
  const Links links{p0, X_WB, V, gaps};
  for (std::size_t i = 0; i < loops.size(); ++i) {
    if (loops[i].type == LoopType::gear)
      write_gear(m, loops[i], q, v, rows, i);
    else
      write_rows(links, loops[i], rows, static_cast<std::size_t>(rows.first[i]));
  }
}

void update_loop_rows(const Mechanism& m, const Workspace& ws, std::span<const Loop> loops, std::span<const double> q,
                      std::span<const double> v, LoopRows& rows) {
  update_loop_rows(m, ws.p0, ws.X_WB, ws.V, loops, q, v, true, rows);
}

void calc_loop_jacobian_row(const Mechanism& m, const Workspace& ws, const Loop& loop, const LoopRows& rows, int i, int r,
                            std::span<double> J) {
  std::ranges::fill(J, 0.0);
  const auto loop_index = static_cast<std::size_t>(i);
  if (loop.type == LoopType::gear) {
    J[static_cast<std::size_t>(loop.dof_a)] = 1;
    J[static_cast<std::size_t>(loop.dof_b)] -= rows.slope[loop_index];
    return;
  }
  // Walk from both links to their closest common ancestor. Above this ancestor, the contributions of the two branches cancel. Each step
  // goes from the link with the larger index to its parent: that link cannot be the ancestor, because parents have smaller indices.
  const Vec6& w = rows.W[static_cast<std::size_t>(rows.first[loop_index] + r)];
  int a = loop.link_a, b = loop.link_b;
  while (a != b) {
    const double sign = a > b ? -1 : 1;
    int& deeper = a > b ? a : b;
    const Link& link = m.link(deeper);
    for (int k = link.v_index; k < link.v_index + link.joint.nv(); ++k) {
      const auto f = static_cast<std::size_t>(k);
      J[f] += sign * dot(w, ws.S[f]);
    }
    deeper = link.parent;
  }
}

void calc_loop_velocity_products(const Mechanism& m, Workspace& ws, std::span<const Loop> loops, const LoopRows& rows,
                                 std::span<double> products) {
  for (std::size_t i = 0; i < ws.A.size(); ++i) {
    const int parent = m.places()[i].parent;
    ws.A[i] = parent >= 0 ? ws.A[static_cast<std::size_t>(parent)] + ws.C[i] : ws.C[i];
  }
  for (std::size_t i = 0; i < loops.size(); ++i) {
    Vec6 A_ba;
    if (const int b = loops[i].link_b; b >= 0) A_ba = ws.A[static_cast<std::size_t>(b)];
    if (const int a = loops[i].link_a; a >= 0) A_ba -= ws.A[static_cast<std::size_t>(a)];
    for (auto k = static_cast<std::size_t>(rows.first[i]); k < static_cast<std::size_t>(rows.first[i + 1]); ++k)
      products[k] = rows.drift[k] + dot(rows.W[k], A_ba);
  }
}

std::string_view row_name(LoopType type, int r) {
  static constexpr std::string_view positions[] = {"translation along x", "translation along y", "translation along z"};
  static constexpr std::string_view rotations[] = {"rotation about x", "rotation about y", "rotation about z"};
  static constexpr std::string_view across[] = {"translation across the axis (first)", "translation across the axis (second)"};
  static constexpr std::string_view tilts[] = {"tilt of the axis (first)", "tilt of the axis (second)"};
  const auto k = static_cast<std::size_t>(r);
  switch (type) {
    case LoopType::weld: return k < 3 ? positions[k] : rotations[k - 3];
    case LoopType::ball: return positions[k];
    case LoopType::revolute: return k < 3 ? positions[k] : tilts[k - 3];
    case LoopType::prismatic: return k < 2 ? across[k] : rotations[k - 2];
    case LoopType::cylindrical: return k < 2 ? across[k] : tilts[k - 2];
    case LoopType::planar: return k < 1 ? "translation along the axis" : tilts[k - 1];
    case LoopType::universal: return k < 3 ? positions[k] : "twist between the two axes";
    case LoopType::distance: return "distance";
    case LoopType::gear: return "gear";
  }
  return "";
}

}  // namespace ugoki::dynamics
