#include "ugoki/robot_formats/inertia_repair.h"

#include <algorithm>
#include <cmath>

#include "ugoki/robot_formats/symmetric_eigen.h"

namespace ugoki::robot_formats {

std::optional<double> make_physical(Inertia& inertia) {
  const Sym3 I = inertia.about_centre();
  const double half_trace = 0.5 * (I.xx + I.yy + I.zz);
  const SymmetricEigen P = symmetric_eigen({half_trace - I.xx, half_trace - I.yy, half_trace - I.zz, -I.xy, -I.xz, -I.yz});
  // Stricter than Mechanism::make, which tolerates 1e-9 of the moments about the origin, so that it accepts every repaired inertia.
  const double slack = 1e-10 * std::max({std::fabs(inertia.I.xx), std::fabs(inertia.I.yy), std::fabs(inertia.I.zz)});
  if (P.values.x >= -slack && P.values.y >= -slack && P.values.z >= -slack) return std::nullopt;

  const Vec3 kept{std::max(P.values.x, 0.0), std::max(P.values.y, 0.0), std::max(P.values.z, 0.0)};
  const Sym3 Q = symmetric_part(P.V * Mat3::diagonal(kept.x, kept.y, kept.z) * P.V.transposed());
  const double trace = Q.xx + Q.yy + Q.zz;
  const Sym3 nearest{trace - Q.xx, trace - Q.yy, trace - Q.zz, -Q.xy, -Q.xz, -Q.yz};
  const Sym3 d = nearest - I;
  const double change = std::max({std::fabs(d.xx), std::fabs(d.yy), std::fabs(d.zz), std::fabs(d.xy), std::fabs(d.xz), std::fabs(d.yz)});
  const double largest_moment =
      std::max({std::fabs(I.xx), std::fabs(I.yy), std::fabs(I.zz), std::fabs(I.xy), std::fabs(I.xz), std::fabs(I.yz), 1e-300});
  inertia = Inertia::from_centre(inertia.mass, inertia.centre(), nearest);
  return change / largest_moment;
}

}  // namespace ugoki::robot_formats
