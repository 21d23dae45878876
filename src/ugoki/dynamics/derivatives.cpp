#include "ugoki/dynamics/derivatives.h"

#include "ugoki/base/check.h"
#include "ugoki/dynamics/dynamics.h"
#include "ugoki/dynamics/jacobian.h"

namespace ugoki::dynamics {
namespace {

/// Angular block E of D = V x* I - I V x + (I V) x~* about p0 (derivatives.h). D = [[E, 0], [-2 p x, 0]] with the linear momentum p.
///   E = 2 (tr(K) 1 - K),  K = integral of u r^T dm = v h^T + w x J,  J = tr(I)/2 1 - I
/// V = (w, v), u is the velocity of the mass element dm, r its position from p0, and h the first moment of mass.
Mat3 coriolis_block(const Inertia& inertia, const Vec6& V) {
  const Sym3& I = inertia.I;
  const double half_trace = 0.5 * (I.xx + I.yy + I.zz);
  const Sym3 J{half_trace - I.xx, half_trace - I.yy, half_trace - I.zz, -I.xy, -I.xz, -I.yz};
  const Vec3& h = inertia.h;
  const Vec3 w2 = V.w * 2.0, v2 = V.v * 2.0;
  const Mat3 K = Mat3::columns(v2 * h.x + cross(w2, Vec3{J.xx, J.xy, J.xz}), v2 * h.y + cross(w2, Vec3{J.xy, J.yy, J.yz}),
                               v2 * h.z + cross(w2, Vec3{J.xz, J.yz, J.zz}));
  const double trace = K.trace();
  return {trace - K.xx, -K.xy, -K.xz, -K.yx, trace - K.yy, -K.yz, -K.zx, -K.zy, trace - K.zz};
}

/// Product of D with a motion whose angular part is w. @param E, p blocks of D, see coriolis_block()
Vec6 coriolis_times(const Mat3& E, const Vec3& p, const Vec3& w) { return {E * w, cross(p, w) * -2.0}; }

/// Outward sweep: motion of links and joint axes, and the force that the motion of each link needs, without its children.
void sweep_out(const Mechanism& m, const Workspace& ws, std::span<const double> v, std::span<const double> vdot, const Vec3& gravity,
               std::span<const Vec6> external, InverseDerivatives& d) {
  const std::span<const Link> links = m.links();
  for (std::size_t i = 0; i < links.size(); ++i) {
    const Link& link = links[i];
    const bool based = link.parent >= 0;
    const auto parent = static_cast<std::size_t>(link.parent);
    Vec6 W = based ? ws.V[parent] : Vec6{};
    Vec6 Y = based ? d.A[parent] : Vec6{{}, -gravity};
    Vec6 A = Y + ws.C[i];
    const auto first = static_cast<std::size_t>(link.v_index);
    const int n = link.joint.nv();
    for (int k = 0; k < n; ++k) {
      const std::size_t f = first + static_cast<std::size_t>(k);
      const Vec6& S = ws.S[f];
      const Vec6 S_vdot = vdot.empty() ? Vec6{} : S * vdot[f];
      A += S_vdot;
      if (axis_moves_with_link(link.joint.type, k)) continue;
      W += S * v[f];
      Y += d.S_dot[f] * v[f] + S_vdot;
    }
    for (std::size_t f = first; f < first + static_cast<std::size_t>(n); ++f) {
      d.psi1[f] = cross_motion(W, ws.S[f]);
      d.psi2[f] = cross_motion(Y, ws.S[f]) + cross_motion(W, d.psi1[f]);
    }
    const Vec6 h = ws.I[i] * ws.V[i];
    d.A[i] = A;
    d.I[i] = ws.I[i];
    d.f[i] = ws.I[i] * A + cross_force(ws.V[i], h);
    d.E[i] = coriolis_block(ws.I[i], ws.V[i]);
    d.p[i] = h.v;
    if (!external.empty()) d.f_ext[i] = {external[i].w - cross(ws.p0, external[i].v), external[i].v};
  }
}

/// Fills the entries between the DOFs of one joint. @param k DOF of the joint @param start entry of the joint's first DOF in row k
void fill_own_joint(const Workspace& ws, const Link& link, int k, std::size_t start, const Vec6& force, InverseDerivatives& d) {
  const auto first = static_cast<std::size_t>(link.v_index);
  const std::size_t fk = first + static_cast<std::size_t>(k);
  for (int j = 0; j <= k; ++j) {
    const std::size_t fj = first + static_cast<std::size_t>(j), at = start + static_cast<std::size_t>(j);
    const double carried = dot(cross_motion(ws.S[fj], ws.S[fk]), force);
    d.below_q[at] = dot(ws.S[fk], d.df_dq[fj]) + (axis_moves_with_link(link.joint.type, k) ? carried : 0);
    d.above_q[at] = dot(ws.S[fj], d.df_dq[fk]) - (axis_moves_with_link(link.joint.type, j) ? carried : 0);
    d.below_v[at] = dot(ws.S[fk], d.df_dv[fj]);
    d.above_v[at] = dot(ws.S[fj], d.df_dv[fk]);
  }
}

}  // namespace

InverseDerivatives::InverseDerivatives(const Mechanism& m, Workspace& ws) {
  if (ws.chain.empty()) ws.make_rows(m);
  for (std::vector<double>* x : {&below_q, &above_q, &below_v, &above_v}) x->resize(ws.chain.size());
  for (std::vector<Vec6>* x : {&S_dot, &psi1, &psi2, &df_dq, &df_dv}) x->resize(ws.S.size());
  for (std::vector<Vec6>* x : {&A, &f, &f_ext}) x->resize(ws.V.size());
  I.resize(ws.V.size());
  E.resize(ws.V.size());
  p.resize(ws.V.size());
}

void calc_inverse_dynamics_derivatives(const Mechanism& m, Workspace& ws, std::span<const double> v, std::span<const double> vdot,
                                       const Vec3& gravity, std::span<const Vec6> external, InverseDerivatives& d) {
  UGOKI_CHECK(static_cast<int>(v.size()) == m.nv() && (vdot.empty() || vdot.size() == v.size()) && d.below_q.size() == ws.chain.size());
  calc_subspace_rates(m, ws, d.S_dot);
  sweep_out(m, ws, v, vdot, gravity, external, d);
  const std::span<const Link> links = m.links();
  const bool pushed = !external.empty();
  for (std::size_t i = links.size(); i-- > 0;) {
    const Link& link = links[i];
    const Inertia& I = d.I[i];
    const Mat3& E = d.E[i];
    const Vec3& p = d.p[i];
    const Vec6 force = pushed ? d.f[i] - d.f_ext[i] : d.f[i];
    for (int k = 0; k < link.joint.nv(); ++k) {
      const auto f = static_cast<std::size_t>(link.v_index + k);
      const Vec6& S = ws.S[f];
      const Vec6 IS = I * S;
      const Vec3 DS = transpose_times(E, S.w) + cross(p, S.v) * 2.0;  // angular part of D^T S; the linear part is zero
      const Vec6 push = pushed ? cross_force(S, d.f_ext[i]) : Vec6{};
      d.df_dq[f] = cross_force(S, d.f[i]) + I * d.psi2[f] + coriolis_times(E, p, d.psi1[f].w);
      d.df_dv[f] = I * (d.psi1[f] + d.S_dot[f]) + coriolis_times(E, p, S.w);
      const auto start = static_cast<std::size_t>(ws.row_start[f]);
      const auto own = start + static_cast<std::size_t>(ws.depth[f] - k);
      for (std::size_t at = start; at < own; ++at) {
        const auto j = static_cast<std::size_t>(ws.chain[at]);
        const Vec6& S_j = ws.S[j];
        d.above_q[at] = dot(S_j, d.df_dq[f]);
        d.above_v[at] = dot(S_j, d.df_dv[f]);
        d.below_q[at] = dot(IS, d.psi2[j]) + dot(DS, d.psi1[j].w) - dot(S_j, push);
        d.below_v[at] = dot(IS, d.psi1[j] + d.S_dot[j]) + dot(DS, S_j.w);
      }
      fill_own_joint(ws, link, k, own, force, d);
      const std::size_t end = own + static_cast<std::size_t>(k) + 1;
      for (std::size_t at = start; at < end; ++at) ws.M[at] = dot(ws.S[static_cast<std::size_t>(ws.chain[at])], IS);
      ws.M[end - 1] += ws.armature[f];
    }
    if (link.parent >= 0) {
      const auto parent = static_cast<std::size_t>(link.parent);
      d.I[parent] += I;
      d.E[parent] += E;
      d.p[parent] += p;
      d.f[parent] += d.f[i];
      if (pushed) d.f_ext[parent] += d.f_ext[i];
    }
  }
}

void expand(const Workspace& ws, std::span<const double> below, std::span<const double> above, std::span<double> out) {
  const std::size_t n = ws.depth.size();
  UGOKI_CHECK(out.size() == n * n && below.size() == ws.chain.size() && above.size() == ws.chain.size());
  for (double& x : out) x = 0;
  for (std::size_t k = 0; k < n; ++k) {
    const auto end = static_cast<std::size_t>(ws.row_start[k + 1]);
    for (auto at = static_cast<std::size_t>(ws.row_start[k]); at < end; ++at) {
      const auto j = static_cast<std::size_t>(ws.chain[at]);
      out[k * n + j] = below[at];
      out[j * n + k] = above[at];
    }
  }
}

}  // namespace ugoki::dynamics
