#include "ugoki/robot_formats/symmetric_eigen.h"

#include <cmath>
#include <utility>

namespace ugoki::robot_formats {

SymmetricEigen symmetric_eigen(const Sym3& s) {
  double a[3][3] = {{s.xx, s.xy, s.xz}, {s.xy, s.yy, s.yz}, {s.xz, s.yz, s.zz}};
  double v[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const double scale = std::fabs(s.xx) + std::fabs(s.yy) + std::fabs(s.zz) + std::fabs(s.xy) + std::fabs(s.xz) + std::fabs(s.yz);
  for (int sweep = 0; sweep < 30; ++sweep) {
    if (std::fabs(a[0][1]) + std::fabs(a[0][2]) + std::fabs(a[1][2]) <= 1e-17 * scale) break;
    for (const auto& [p, q] : {std::pair{0, 1}, {0, 2}, {1, 2}}) {
      if (a[p][q] == 0) continue;
      const double theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
      const double t = std::fabs(theta) > 1e150 ? 0.5 / theta : std::copysign(1 / (std::fabs(theta) + std::sqrt(theta * theta + 1)), theta);
      const double c = 1 / std::sqrt(t * t + 1), d = t * c;
      for (auto& row : a) {
        const double rp = row[p], rq = row[q];
        row[p] = c * rp - d * rq;
        row[q] = d * rp + c * rq;
      }
      for (int k = 0; k < 3; ++k) {
        const double pk = a[p][k], qk = a[q][k];
        a[p][k] = c * pk - d * qk;
        a[q][k] = d * pk + c * qk;
      }
      for (auto& row : v) {
        const double rp = row[p], rq = row[q];
        row[p] = c * rp - d * rq;
        row[q] = d * rp + c * rq;
      }
    }
  }
  return {{a[0][0], a[1][1], a[2][2]}, {v[0][0], v[0][1], v[0][2], v[1][0], v[1][1], v[1][2], v[2][0], v[2][1], v[2][2]}};
}

}  // namespace ugoki::robot_formats
