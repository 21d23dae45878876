#include "ugoki/dynamics/centroidal.h"

#include "ugoki/base/check.h"

namespace ugoki::dynamics {
namespace {

/// Computes ws.Ic: the composite inertia of each link and all its descendants, about p0.
void calc_composites(const Mechanism& m, Workspace& ws) {
  const std::span<const Link> links = m.links();
  UGOKI_CHECK(ws.I.size() == links.size());
  for (std::size_t i = 0; i < links.size(); ++i) ws.Ic[i] = ws.I[i];
  for (std::size_t i = links.size(); i-- > 0;)
    if (links[i].parent >= 0) ws.Ic[static_cast<std::size_t>(links[i].parent)] += ws.Ic[i];
}

/// Changes the reference point of the wrench `f` from p0 to p0 + r.
Vec6 force_at(const Vec6& f, const Vec3& r) { return {f.w - cross(r, f.v), f.v}; }

Inertia total_inertia(const Workspace& ws) {
  Inertia total;
  for (const Inertia& I : ws.I) total += I;
  return total;
}

}  // namespace

Centroidal calc_centroidal(const Mechanism& m, const Workspace& ws) {
  UGOKI_CHECK(ws.I.size() == m.links().size());
  const Inertia total = total_inertia(ws);
  Vec6 h;
  for (std::size_t i = 0; i < ws.I.size(); ++i) h += ws.I[i] * ws.V[i];
  Centroidal out;
  out.mass = total.mass;
  const Vec3 r = total.centre();
  out.centre = ws.p0 + r;
  out.momentum = force_at(h, r);
  if (total.mass > 0) out.velocity = h.v / total.mass;
  out.inertia = total.about_centre();
  return out;
}

void calc_centroidal_matrix(const Mechanism& m, Workspace& ws, std::span<Vec6> A_G) {
  UGOKI_CHECK(A_G.size() == ws.S.size());
  calc_composites(m, ws);
  const Vec3 r = total_inertia(ws).centre();
  for (std::size_t f = 0; f < A_G.size(); ++f)
    A_G[f] = force_at(ws.Ic[static_cast<std::size_t>(m.link_of_dof(static_cast<int>(f)))] * ws.S[f], r);
}

// About a fixed point the rate is the sum of I A + V x* I V over the links (I inertia, V velocity, A acceleration). Changing the reference
// point to the centre of mass c adds -c x h_lin'. The term -c' x h_lin is zero because the linear momentum h_lin is parallel to c'.
Vec6 calc_centroidal_momentum_rate(const Mechanism& m, Workspace& ws, std::span<const double> vdot) {
  const std::span<const Link> links = m.links();
  UGOKI_CHECK(ws.I.size() == links.size() && (vdot.empty() || vdot.size() == ws.S.size()));
  Vec6 rate;
  for (std::size_t i = 0; i < links.size(); ++i) {
    const Link& link = links[i];
    Vec6 A = ws.C[i];
    if (link.parent >= 0) A += ws.A[static_cast<std::size_t>(link.parent)];
    if (!vdot.empty()) {
      const auto first = static_cast<std::size_t>(link.v_index);
      for (std::size_t f = first; f < first + static_cast<std::size_t>(link.joint.nv()); ++f) A += ws.S[f] * vdot[f];
    }
    ws.A[i] = A;
    rate += ws.I[i] * A + cross_force(ws.V[i], ws.I[i] * ws.V[i]);
  }
  return force_at(rate, total_inertia(ws).centre());
}

void calc_potential_gradient(const Mechanism& m, Workspace& ws, const Vec3& gravity, std::span<double> gradient) {
  UGOKI_CHECK(gradient.size() == ws.S.size());
  calc_composites(m, ws);
  for (std::size_t f = 0; f < gradient.size(); ++f) {
    const Inertia& I = ws.Ic[static_cast<std::size_t>(m.link_of_dof(static_cast<int>(f)))];
    gradient[f] = -dot(gravity, ws.S[f].v * I.mass - cross(I.h, ws.S[f].w));
  }
}

}  // namespace ugoki::dynamics
