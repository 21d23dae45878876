#include "ugoki/lsi/pull.h"

#include <array>

namespace ugoki::lsi {
namespace {

constexpr std::size_t max_chain = 256;  // maximum number of DOFs between ground and link, because the working memory is on the stack

/// Mobility J M^-1 J^T of a point (J: Jacobian, M: inertia), 1/kg; zero if the link cannot move or its chain has more than max_chain DOFs.
Mat3 mobility(const dynamics::Workspace& ws, int link, const Vec3& p) {
  const std::span<const int> chain = dynamics::chain_of_link(ws, link);
  if (chain.empty() || chain.size() > max_chain) return {};
  std::array<Vec3, max_chain> rows;
  dynamics::calc_point_jacobian(ws, link, p, std::span(rows).first(chain.size()));
  std::array<std::array<double, max_chain>, 3> y;
  for (int axis = 0; axis < 3; ++axis) {
    auto& column = y[static_cast<std::size_t>(axis)];
    for (std::size_t k = 0; k < chain.size(); ++k) column[k] = rows[k][axis];
    dynamics::apply_inverse_transposed_factor(ws, chain.back(), std::span(column).first(chain.size()));
  }
  double A[3][3] = {};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      for (std::size_t k = 0; k < chain.size(); ++k) A[i][j] += y[i][k] * y[j][k] * ws.D_inverse[static_cast<std::size_t>(chain[k])];
  return {A[0][0], A[0][1], A[0][2], A[1][0], A[1][1], A[1][2], A[2][0], A[2][1], A[2][2]};
}

}  // namespace

Vec3 calc_pull(const Mechanism& m, dynamics::Workspace& ws, std::span<const double> q, std::span<const double> v, int link, const Vec3& p_B,
               const Vec3& target, double dt, const PullOptions& options) {
  dynamics::update_kinematics(m, q, v, ws);
  dynamics::calc_inertia_rows(m, ws);
  if (dynamics::factor(ws, {}) >= 0) return {};
  const Vec3 p = ws.X_WB[static_cast<std::size_t>(link)] * p_B;
  const Vec3 u = dynamics::point_velocity(ws, link, p);
  const double k = m.mass() * options.frequency * options.frequency;
  const double c = 2 * options.damping * m.mass() * options.frequency;
  const double g = k * dt + c;
  const Mat3 left = Mat3::identity() + mobility(ws, link, p) * (g * dt);
  const Vec3 force = inverse(left) * ((target - p) * k - u * g);
  const double size = norm(force), maximum = options.max_weights * m.mass() * 9.81;
  return size > maximum ? force * (maximum / size) : force;
}

}  // namespace ugoki::lsi
