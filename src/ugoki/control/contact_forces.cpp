#include "ugoki/control/contact_forces.h"

#include <cmath>

#include "ugoki/base/check.h"
#include "ugoki/spatial/heading.h"

namespace ugoki::control {
namespace {

using Array6 = std::array<double, 6>;
/// Two numbers in one SIMD register of every processor. Lanes do not affect each other.
typedef double Two __attribute__((vector_size(16)));

/// Newton's equation H x = b of the dual problem: H = 1 + sum g g^T / eps over the columns g that bear load, lower triangle. Row i is
/// stored as pairs of entries; its last pair may contain one entry above the diagonal.
struct NewtonEquation {
  std::array<std::array<Two, 3>, 6> H{};
  std::array<Two, 3> b{};

  /// @param rest minus the gradient without the columns
  explicit NewtonEquation(const Array6& rest) {
    for (std::size_t i = 0; i < 6; ++i) {
      H[i][i / 2][i % 2] = 1;
      b[i / 2][i % 2] = rest[i];
    }
  }
  /// Adds a column. @param pressed g . y @param stiffness 1 / eps
  void add(const Vec6& g, double pressed, double stiffness) {
    const Two pairs[3] = {{g.w.x, g.w.y}, {g.w.z, g.v.x}, {g.v.y, g.v.z}};
    const double force = pressed * stiffness;
    for (std::size_t p = 0; p < 3; ++p) b[p] -= pairs[p] * force;
    for (std::size_t i = 0; i < 6; ++i) {
      const double scaled = pairs[i / 2][i % 2] * stiffness;
      for (std::size_t p = 0; p <= i / 2; ++p) H[i][p] += pairs[p] * scaled;
    }
  }
  [[nodiscard]] double entry(std::size_t i, std::size_t j) const { return H[i][j / 2][j % 2]; }
};

Array6 to_array(const Vec6& x) { return {x.w.x, x.w.y, x.w.z, x.v.x, x.v.y, x.v.z}; }
Vec6 to_vec(const Array6& x) { return {{x[0], x[1], x[2]}, {x[3], x[4], x[5]}}; }

/// Solves the symmetric positive definite H x = b by Cholesky.
Array6 solve_equation(const NewtonEquation& equation) {
  double L[6][6], inverse[6];  // factor of H, and the inverses of its diagonal
  Array6 x;
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      double sum = equation.entry(i, j);
      for (std::size_t k = 0; k < j; ++k) sum -= L[i][k] * L[j][k];
      if (i == j)
        inverse[i] = 1 / std::sqrt(sum);
      else
        L[i][j] = sum * inverse[j];
    }
    x[i] = equation.b[i / 2][i % 2];
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
  columns_.reserve(4 * capacity);
  edges_.reserve(4 * capacity);
  pressed_.reserve(4 * capacity);
  loaded_.reserve(4 * capacity);
}

Vec6 ContactForceProblem::solve(std::span<const Support> supports, const Vec3& origin, const Vec6& wrench, double lever, double softness,
                                std::span<Vec3> forces) {
  UGOKI_CHECK(forces.size() == supports.size() && lever > 0 && softness > 0);
  iterations_ = 0;
  columns_.clear();
  edges_.clear();
  if (supports.empty()) return wrench;
  for (const Support& s : supports) {
    const Vec3 t1 = perpendicular_along(s.n, s.along), t2 = cross(s.n, t1);
    const double scale = 1 / std::sqrt(s.cost);  // scales columns and edges, so that all costs are 1
    for (const Vec3& t : {t1, -t1, t2, -t2}) {
      const Vec3 edge = (s.n + t * s.friction) * scale;
      edges_.push_back(edge);
      columns_.push_back({cross(s.p - origin, edge) / lever, edge});
    }
  }
  const Array6 w = to_array({wrench.w / lever, wrench.v});
  const double stiffness = 1 / softness;

  // Minimize phi(y) = |y|^2 / 2 + |max(0, G^T y)|^2 / (2 eps) - w.y; then beta = max(0, G^T y) / eps, and the missing wrench is y. Symbols:
  // contact_forces.h.
  const auto objective = [&](const Array6& y) {  // also sets pressed_
    double value = 0;
    for (std::size_t i = 0; i < 6; ++i) value += y[i] * (0.5 * y[i] - w[i]);
    const Vec6 yv = to_vec(y);
    for (std::size_t k = 0; k < columns_.size(); ++k) {
      const double b = pressed_[k] = dot(columns_[k], yv);
      if (b > 0) value += 0.5 * b * b * stiffness;
    }
    return value;
  };
  Array6 y{};
  pressed_.assign(columns_.size(), 0.0);
  // First iteration (y = 0): assume that an edge bears load if its wrench has a positive dot product with the wanted one.
  loaded_.resize(columns_.size());
  for (std::size_t k = 0; k < columns_.size(); ++k) loaded_[k] = dot(columns_[k], to_vec(w)) > 0 ? 1 : 0;
  double value = 0;
  bool exact = false;  // phi is quadratic between y and its minimum, so that a full Newton step has reached the minimum
  for (iterations_ = 0; iterations_ < 50 && !exact; ++iterations_) {
    Array6 rest;
    for (std::size_t i = 0; i < 6; ++i) rest[i] = w[i] - y[i];
    NewtonEquation equation(rest);
    for (std::size_t k = 0; k < columns_.size(); ++k)
      if (loaded_[k] != 0) equation.add(columns_[k], pressed_[k], stiffness);
    const Array6 step = solve_equation(equation);
    double slope = 0, size = 0;
    for (std::size_t i = 0; i < 6; ++i) size += step[i] * step[i];
    if (size < 1e-18 * (1 + dot(to_vec(w), to_vec(w)))) break;
    for (std::size_t i = 0; i < 6; ++i) slope -= equation.b[i / 2][i % 2] * step[i];
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
    for (std::size_t k = 0; k < columns_.size(); ++k) {
      const unsigned char loaded = pressed_[k] > 0 ? 1 : 0;
      exact = exact && loaded == loaded_[k];
      loaded_[k] = loaded;
    }
  }
  Vec6 missing = wrench;
  for (std::size_t i = 0; i < supports.size(); ++i) {
    Vec3 force;
    for (std::size_t k = 4 * i; k < 4 * i + 4; ++k)
      if (pressed_[k] > 0) force += edges_[k] * (pressed_[k] * stiffness);
    forces[i] = force;
    missing -= Vec6{cross(supports[i].p - origin, force), force};
  }
  return missing;
}

}  // namespace ugoki::control
