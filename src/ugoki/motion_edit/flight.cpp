#include "ugoki/motion_edit/flight.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "ugoki/mechanism/state.h"

namespace ugoki::motion_edit {
namespace {

constexpr int min_flight = 4;           // frames: the acceleration is not computed from shorter flights
constexpr double stance_weight = 0.02;  // weight of acceleration errors in frames with contact; in flight it is 1
constexpr double return_time = 0.15;    // s, time constant with which the vertical displacement returns to 0

struct Flight {
  int first = 0, last = 0;
  double acceleration = 0;  ///< m/s^2, mean vertical acceleration
};

std::vector<Flight> find_flights(std::span<const double> z, std::span<const std::uint8_t> bears, double rate) {
  std::vector<Flight> out;
  const int n = static_cast<int>(z.size());
  for (int from = 0; from < n;) {
    int to = from;
    while (to + 1 < n && bears[static_cast<std::size_t>(to) + 1] == bears[static_cast<std::size_t>(from)]) ++to;
    if (!bears[static_cast<std::size_t>(from)] && to - from + 1 >= min_flight && from > 0 && to + 1 < n) {
      // Least-squares parabola through the heights.
      double s2 = 0, s4 = 0, s0 = 0, z0 = 0, z2 = 0;
      const double middle = 0.5 * (from + to);
      for (int i = from; i <= to; ++i) {
        const double t = (i - middle) / rate;
        s0 += 1;
        s2 += t * t;
        s4 += t * t * t * t;
        z0 += z[static_cast<std::size_t>(i)];
        z2 += z[static_cast<std::size_t>(i)] * t * t;
      }
      out.push_back({from, to, 2 * (s0 * z2 - s2 * z0) / (s0 * s4 - s2 * s2)});
    }
    from = to + 1;
  }
  return out;
}

/// Solves A x = b in place for a symmetric positive definite band matrix of half-bandwidth 2.
/// @param a a[i][0..2] = A(i, i), A(i, i + 1), A(i, i + 2); overwritten  @param x b on entry, the solution on return
void solve_band(std::vector<std::array<double, 3>>& a, std::vector<double>& x) {
  const std::size_t n = x.size();
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t k = 1; k <= 2 && i + k < n; ++k) {
      const double factor = a[i][k] / a[i][0];
      for (std::size_t j = k; j <= 2; ++j) a[i + k][j - k] -= factor * a[i][j];
      x[i + k] -= factor * x[i];
    }
  for (std::size_t i = n; i-- > 0;) {
    for (std::size_t k = 1; k <= 2 && i + k < n; ++k) x[i] -= a[i][k] * x[i + k];
    x[i] /= a[i][0];
  }
}

}  // namespace

std::vector<double> centre_heights(const Mechanism& m, const Motion& motion) {
  std::vector<double> z;
  std::vector<Pose> X(static_cast<std::size_t>(m.link_count()));
  for (int f = 0; f < motion.frames; ++f) {
    calc_poses(m, {motion.frame(f), static_cast<std::size_t>(motion.nq)}, X);
    z.push_back(centre_of_mass(m, X).z);
  }
  return z;
}

double flight_acceleration(std::span<const double> heights, std::span<const std::uint8_t> bears, double rate, int& frames) {
  double sum = 0;
  frames = 0;
  for (const Flight& f : find_flights(heights, bears, rate)) {
    sum += f.acceleration * (f.last - f.first + 1);
    frames += f.last - f.first + 1;
  }
  return frames > 0 ? sum / frames : 0;
}

// Finds the displacements u that minimise the sum over all frames of weight (u'' - c)^2 + stance_weight u^2 / return_time^4. In flights c
// is the difference between wanted and actual acceleration; in other frames c is 0.
std::vector<double> raise_for_flight(std::span<const double> heights, std::span<const std::uint8_t> bears, double rate, double wanted) {
  const std::size_t n = heights.size();
  std::vector<double> c(n, 0.0), weight(n, stance_weight), u(n, 0.0);
  bool any = false;
  for (const Flight& f : find_flights(heights, bears, rate))
    for (int i = f.first; i <= f.last; ++i) {
      c[static_cast<std::size_t>(i)] = wanted - f.acceleration;
      weight[static_cast<std::size_t>(i)] = 1;
      any = true;
    }
  if (!any || n < 5) return u;
  const double r2 = rate * rate, back = 1 / (return_time * return_time * return_time * return_time);
  std::vector<std::array<double, 3>> a(n, {stance_weight * back, 0, 0});
  for (std::size_t i = 1; i + 1 < n; ++i) {  // one equation: (u[i - 1] - 2 u[i] + u[i + 1]) rate^2 = c[i]
    const double w = weight[i] * r2 * r2;
    a[i - 1][0] += w;
    a[i - 1][1] -= 2 * w;
    a[i - 1][2] += w;
    a[i][0] += 4 * w;
    a[i][1] -= 2 * w;
    a[i + 1][0] += w;
    u[i - 1] += weight[i] * r2 * c[i];
    u[i] -= 2 * weight[i] * r2 * c[i];
    u[i + 1] += weight[i] * r2 * c[i];
  }
  solve_band(a, u);
  return u;
}

}  // namespace ugoki::motion_edit
