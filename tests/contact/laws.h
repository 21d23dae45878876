#pragma once
// Checks the results of a step against the laws of unilateral contact and Coulomb friction.

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "world.h"

namespace ugoki::contact {

/// Checks the contact forces, and the velocities after a step at the contacts found before the step. No system may have moved in inertial
/// substeps, because these change the velocities after the contacts have acted.
/// @param tolerance m/s
inline void check_laws(World& w, double dt, double tolerance) {
  std::vector<dynamics::Workspace> before;
  for (int s = 0; s < w.stepper.system_count(); ++s) before.push_back(w.stepper.workspace(s));
  for (std::size_t i = 0; i < w.contacts.size(); ++i) {
    const collision::ContactPoint& c = w.contacts[i];
    Vec3 u;
    double inverse_mass = 0;
    for (int side = 0; side < 2; ++side) {
      const int at = side == 0 ? c.system_a : c.system_b;
      if (at < 0) continue;
      const auto s = static_cast<std::size_t>(at);
      dynamics::Workspace& ws = before[s];
      const Mechanism& m = w.stepper.mechanism(at);
      Vec6 V;
      const int link = side == 0 ? c.link_a : c.link_b;
      for (int l = link; l >= 0; l = m.link(l).parent)
        for (int f = m.link(l).v_index; f < m.link(l).v_index + m.link(l).joint.nv(); ++f)
          V += ws.S[static_cast<std::size_t>(f)] * w.states[s].v[static_cast<std::size_t>(f)];
      u += (V.v + cross(V.w, c.p - ws.p0)) * (side == 0 ? 1.0 : -1.0);
      inverse_mass += 1 / m.link(link).inertia.mass;
    }
    const Vec3 p = w.stepper.contact_forces()[i] * dt;
    const double pn = dot(p, c.n), un = dot(u, c.n);
    const Vec3 pt = p - c.n * pn, ut = u - c.n * un;
    const double wanted =
        c.distance > 0 ? -c.distance / dt : std::min(-c.distance / w.stepper.options().recovery_time, w.stepper.options().recovery_speed);
    EXPECT_GE(pn, 0);
    EXPECT_LE(norm(pt), c.friction * pn * (1 + 1e-9) + 1e-12);
    if (c.distance < 1e-3) {
      EXPECT_GT(un - wanted, -tolerance - 1e-3 * pn * inverse_mass) << i;
      if (pn * inverse_mass > tolerance) EXPECT_LT(un - wanted, tolerance) << i;
    }
    if (norm(ut) > 100 * tolerance && pn * inverse_mass > 100 * tolerance) {  // sliding: friction has its maximum and is opposed to u_t
      EXPECT_NEAR(norm(pt), c.friction * pn, 1e-2 * c.friction * pn + tolerance / inverse_mass) << i;
      EXPECT_LT(dot(pt, ut), -0.99 * norm(pt) * norm(ut)) << i;
    }
  }
}

}  // namespace ugoki::contact
