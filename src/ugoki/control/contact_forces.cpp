#include "ugoki/control/contact_forces.h"

#include <cmath>

#include "ugoki/base/check.h"
#include "ugoki/control/force_kernels.h"
#include "ugoki/spatial/heading.h"

namespace ugoki::control {
namespace {

using Array6 = std::array<double, 6>;
/// Four numbers in SIMD lanes. Lanes do not affect each other.
typedef double Four __attribute__((vector_size(32), aligned(8), may_alias));
inline Four& lanes(std::vector<double>& x, std::size_t i) { return *reinterpret_cast<Four*>(x.data() + 4 * i); }
inline double sum(const Four& a) { return (a[0] + a[1]) + (a[2] + a[3]); }

Array6 to_array(const Vec6& x) { return {x.w.x, x.w.y, x.w.z, x.v.x, x.v.y, x.v.z}; }

/// Solves the symmetric positive definite H x = b by Cholesky.
Array6 solve_equation(const NewtonEquation& equation) {
  double L[6][6], inverse[6];  // factor of H, and the inverses of its diagonal
  Array6 x;
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      double rest = equation.H[i][j];
      for (std::size_t k = 0; k < j; ++k) rest -= L[i][k] * L[j][k];
      if (i == j)
        inverse[i] = 1 / std::sqrt(rest);
      else
        L[i][j] = rest * inverse[j];
    }
    x[i] = equation.b[i];
    for (std::size_t k = 0; k < i; ++k) x[i] -= L[i][k] * x[k];
    x[i] *= inverse[i];
  }
  for (std::size_t i = 6; i-- > 0;) {
    for (std::size_t k = i + 1; k < 6; ++k) x[i] -= L[k][i] * x[k];
    x[i] *= inverse[i];
  }
  return x;
}

}  // namespace

ContactForceProblem::ContactForceProblem(std::size_t capacity) {
  edges_.reserve(12 * capacity);
  columns_.reserve(24 * capacity);
  scaled_.reserve(24 * capacity);
  pressed_.reserve(4 * capacity);
  loaded_.reserve(4 * capacity);
}

Vec6 ContactForceProblem::solve(std::span<const Support> supports, const Vec3& origin, const Vec6& wrench, double lever, double softness,
                                std::span<Vec3> forces) {
  UGOKI_CHECK(forces.size() == supports.size() && lever > 0 && softness > 0);
  iterations_ = 0;
  if (supports.empty()) return wrench;
  const std::size_t count = supports.size();
  edges_.resize(12 * count);
  columns_.resize(24 * count);
  scaled_.resize(24 * count);
  pressed_.assign(4 * count, 0.0);
  loaded_.resize(4 * count);
  const double per_lever = 1 / lever;
  for (std::size_t i = 0; i < count; ++i) {
    const Support& s = supports[i];
    const Vec3 t1 = perpendicular_along(s.n, s.along) * s.friction, t2 = cross(s.n, t1), r = (s.p - origin) * per_lever;
    const double scale = 1 / std::sqrt(s.cost);  // scales columns and edges, so that all costs are 1
    Four e[3];
    for (int k = 0; k < 3; ++k)
      lanes(edges_, 3 * i + static_cast<std::size_t>(k)) = e[k] = (Four{t1[k], -t1[k], t2[k], -t2[k]} + s.n[k]) * scale;
    Four* const g = &lanes(columns_, 6 * i);
    g[0] = e[2] * r.y - e[1] * r.z;
    g[1] = e[0] * r.z - e[2] * r.x;
    g[2] = e[1] * r.x - e[0] * r.y;
    for (int k = 0; k < 3; ++k) g[3 + k] = e[k];
  }
  const Array6 w = to_array({wrench.w * per_lever, wrench.v});
  double squared_w = 0;
  for (const double x : w) squared_w += x * x;
  const double stiffness = 1 / softness;
  const ForceKernels& kernels = force_kernels();

  // Minimize phi(y) = |y|^2 / 2 + |max(0, G^T y)|^2 / (2 eps) - w.y; then beta = max(0, G^T y) / eps, and the missing wrench is y. Symbols:
  // contact_forces.h.
  const auto objective = [&](const Array6& y) {  // also sets pressed_
    double value = 0;
    for (std::size_t i = 0; i < 6; ++i) value += y[i] * (0.5 * y[i] - w[i]);
    return value + 0.5 * stiffness * kernels.press(columns_.data(), count, y.data(), pressed_.data());
  };
  Array6 y{};
  // First iteration (y = 0): assume that an edge bears load if its wrench has a positive dot product with the wanted one.
  (void)kernels.press(columns_.data(), count, w.data(), loaded_.data());
  for (double& x : loaded_) x = x > 0 ? 1 : 0;
  double value = 0;
  bool exact = false;  // phi is quadratic between y and its minimum, so that a full Newton step has reached the minimum
  for (iterations_ = 0; iterations_ < 50 && !exact; ++iterations_) {
    NewtonEquation equation{};
    for (std::size_t i = 0; i < 6; ++i) {
      equation.H[i][i] = 1;
      equation.b[i] = w[i] - y[i];
    }
    kernels.add_columns(columns_.data(), count, loaded_.data(), pressed_.data(), stiffness, scaled_.data(), equation);
    const Array6 step = solve_equation(equation);
    double slope = 0, size = 0;
    for (std::size_t i = 0; i < 6; ++i) size += step[i] * step[i];
    if (size < 1e-18 * (1 + squared_w)) break;
    for (std::size_t i = 0; i < 6; ++i) slope -= equation.b[i] * step[i];
    double length = 1;
    for (int tries = 0; tries < 30; ++tries, length *= 0.5) {
      Array6 next;
      for (std::size_t i = 0; i < 6; ++i) next[i] = y[i] + length * step[i];
      const double next_value = objective(next);
      if (next_value <= value + 1e-4 * length * slope || tries == 29) {
        y = next;
        value = next_value;
        break;
      }
    }
    exact = length == 1;
    for (std::size_t k = 0; k < loaded_.size(); ++k) {
      const double loaded = pressed_[k] > 0 ? 1 : 0;
      exact = exact && loaded == loaded_[k];
      loaded_[k] = loaded;
    }
  }
  Vec6 missing = wrench;
  for (std::size_t i = 0; i < count; ++i) {
    const Four b = lanes(pressed_, i), beta = (b > 0 ? b : Four{}) * stiffness, *const e = &lanes(edges_, 3 * i);
    const Vec3 force{sum(e[0] * beta), sum(e[1] * beta), sum(e[2] * beta)};
    forces[i] = force;
    missing -= Vec6{cross(supports[i].p - origin, force), force};
  }
  return missing;
}

}  // namespace ugoki::control
