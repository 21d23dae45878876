#include "ugoki/dynamics/jacobian.h"

#include "ugoki/base/check.h"
#include "ugoki/dynamics/dynamics.h"

namespace ugoki::dynamics {
namespace {

/// Changes the reference point of the motion `m` from p0 to p0 + r.
Vec6 at_point(const Vec6& m, const Vec3& r) { return {m.w, m.v + cross(m.w, r)}; }

Vec6 to_axes(const Mat3& R_W, const Vec6& m) { return {transpose_times(R_W, m.w), transpose_times(R_W, m.v)}; }

/// A moving and rotating frame, used to express motion vectors that are given about p0 in world axes.
struct MovingFrame {
  Mat3 R_W;     // axes of the frame, in world axes
  Vec3 r;       // m: origin relative to p0
  Vec3 omega;   // rad/s: angular velocity of the axes
  Vec3 r_rate;  // m/s: velocity of the origin

  /// The motion `m`, in the frame's axes about its origin.
  Vec6 express(const Vec6& m) const { return to_axes(R_W, at_point(m, r)); }
  /// Time derivative of express(m), where m_dot is the derivative of m.
  Vec6 express_rate(const Vec6& m, const Vec6& m_dot) const {
    const Vec6 here = at_point(m, r);
    const Vec6 rate{m_dot.w - cross(omega, here.w), m_dot.v + cross(m_dot.w, r) + cross(m.w, r_rate) - cross(omega, here.v)};
    return to_axes(R_W, rate);
  }
};

MovingFrame frame_of(const Workspace& ws, int link, JacobianFrame frame, const Vec3& p_W) {
  const auto i = static_cast<std::size_t>(link);
  const Vec6& V = ws.V[i];
  if (frame == JacobianFrame::world) {
    const Vec3 r = p_W - ws.p0;
    return {Mat3::identity(), r, {}, at_point(V, r).v};
  }
  const Vec3 r = ws.X_WB[i].p - ws.p0;
  return {ws.X_WB[i].R, r, V.w, at_point(V, r).v};
}

MovingFrame relative_frame(const Workspace& ws, int a, int b, const Vec3& p_W) {
  const Vec3 r = p_W - ws.p0;
  MovingFrame frame{Mat3::identity(), r, {}, {}};
  if (a >= 0) {
    frame.R_W = ws.X_WB[static_cast<std::size_t>(a)].R;
    frame.omega = ws.V[static_cast<std::size_t>(a)].w;
  }
  if (b >= 0) frame.r_rate = at_point(ws.V[static_cast<std::size_t>(b)], r).v;
  return frame;
}

/// Chain of a link; empty for the world (-1).
std::span<const int> checked_chain(const Workspace& ws, int link) {
  UGOKI_CHECK(!ws.chain.empty() || ws.S.empty());  // if this fails, call Workspace::make_rows() first (needed for very long chains)
  return link < 0 ? std::span<const int>{} : chain_of_link(ws, link);
}

/// Fills J: +column(k) for a DOF k that moves only link b, -column(k) for a DOF k that moves only link a, and zero for all other DOFs.
template <class Column>
void fill_relative(const Workspace& ws, int a, int b, std::span<double> J, Column column) {
  const std::size_t n = ws.S.size();
  UGOKI_CHECK(J.size() == 6 * n);
  for (double& x : J) x = 0;
  const std::span<const int> chain_a = checked_chain(ws, a), chain_b = checked_chain(ws, b);
  std::size_t common = 0;
  while (common < chain_a.size() && common < chain_b.size() && chain_a[common] == chain_b[common]) ++common;
  const auto put = [&](int dof, double sign) {
    const auto k = static_cast<std::size_t>(dof);
    const Vec6 c = column(k) * sign;
    for (int row = 0; row < 3; ++row) {
      J[static_cast<std::size_t>(row) * n + k] = c.w[row];
      J[static_cast<std::size_t>(row + 3) * n + k] = c.v[row];
    }
  };
  for (const int k : chain_a.subspan(common)) put(k, -1);
  for (const int k : chain_b.subspan(common)) put(k, 1);
}

}  // namespace

bool axis_moves_with_link(JointType type, int k) {
  switch (type) {
    case JointType::universal: return k == 1;
    case JointType::planar: return k == 2;
    case JointType::floating: return k < 3;
    default: return true;
  }
}

void calc_subspace_rates(const Mechanism& m, const Workspace& ws, std::span<Vec6> S_dot) {
  UGOKI_CHECK(S_dot.size() == ws.S.size());
  const std::span<const Link> links = m.links();
  for (std::size_t i = 0; i < links.size(); ++i) {
    const Link& link = links[i];
    for (int k = 0; k < link.joint.nv(); ++k) {
      const auto f = static_cast<std::size_t>(link.v_index + k);
      if (axis_moves_with_link(link.joint.type, k))
        S_dot[f] = cross_motion(ws.V[i], ws.S[f]);
      else
        S_dot[f] = link.parent < 0 ? Vec6{} : cross_motion(ws.V[static_cast<std::size_t>(link.parent)], ws.S[f]);
    }
  }
}

void calc_jacobian(const Workspace& ws, int link, JacobianFrame frame, const Vec3& p_W, std::span<Vec6> columns) {
  const std::span<const int> chain = checked_chain(ws, link);
  UGOKI_CHECK(columns.size() >= chain.size());
  const MovingFrame to = frame_of(ws, link, frame, p_W);
  for (std::size_t k = 0; k < chain.size(); ++k) columns[k] = to.express(ws.S[static_cast<std::size_t>(chain[k])]);
}

void calc_jacobian_rate(const Workspace& ws, std::span<const Vec6> S_dot, int link, JacobianFrame frame, const Vec3& p_W,
                        std::span<Vec6> columns) {
  const std::span<const int> chain = checked_chain(ws, link);
  UGOKI_CHECK(columns.size() >= chain.size() && S_dot.size() == ws.S.size());
  const MovingFrame to = frame_of(ws, link, frame, p_W);
  for (std::size_t k = 0; k < chain.size(); ++k) {
    const auto f = static_cast<std::size_t>(chain[k]);
    columns[k] = to.express_rate(ws.S[f], S_dot[f]);
  }
}

Vec6 calc_jacobian_bias(const Mechanism& m, const Workspace& ws, int link, JacobianFrame frame, const Vec3& p_W) {
  Vec6 bias;
  for (int i = link; i >= 0; i = m.link(i).parent) bias += ws.C[static_cast<std::size_t>(i)];
  return frame_of(ws, link, frame, p_W).express_rate(ws.V[static_cast<std::size_t>(link)], bias);
}

void calc_relative_jacobian(const Workspace& ws, int a, int b, const Vec3& p_W, std::span<double> J) {
  const MovingFrame to = relative_frame(ws, a, b, p_W);
  fill_relative(ws, a, b, J, [&](std::size_t k) { return to.express(ws.S[k]); });
}

void calc_relative_jacobian_rate(const Workspace& ws, std::span<const Vec6> S_dot, int a, int b, const Vec3& p_W, std::span<double> J_dot) {
  UGOKI_CHECK(S_dot.size() == ws.S.size());
  const MovingFrame to = relative_frame(ws, a, b, p_W);
  fill_relative(ws, a, b, J_dot, [&](std::size_t k) { return to.express_rate(ws.S[k], S_dot[k]); });
}

void expand_columns(const Workspace& ws, int link, std::span<const Vec6> columns, std::span<double> J) {
  const std::size_t n = ws.S.size();
  const std::span<const int> chain = checked_chain(ws, link);
  UGOKI_CHECK(J.size() == 6 * n && columns.size() >= chain.size());
  for (double& x : J) x = 0;
  for (std::size_t k = 0; k < chain.size(); ++k) {
    const auto f = static_cast<std::size_t>(chain[k]);
    for (int row = 0; row < 3; ++row) {
      J[static_cast<std::size_t>(row) * n + f] = columns[k].w[row];
      J[static_cast<std::size_t>(row + 3) * n + f] = columns[k].v[row];
    }
  }
}

}  // namespace ugoki::dynamics
