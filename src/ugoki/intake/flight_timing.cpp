#include "ugoki/intake/flight_timing.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "ugoki/motion/band.h"

namespace ugoki::intake {
namespace {

constexpr double gravity = 9.81;               // m/s^2
constexpr double max_push = 1.75;              // g upwards: a ground force of 2.75 body weights, as captured runs and jumps have
constexpr double max_fall = 1.5;               // g downwards: the reports name faster falls
constexpr double friction = 0.9;               // of the ground
constexpr double slowest = 0.16, fastest = 9;  // squared speeds
constexpr double near_weight = 0.003;   // of w - 1 within near_time of an impossible acceleration; accelerations in g have the weight 1
constexpr double far_weight = 0.1;      // of w - 1 elsewhere
constexpr double near_time = 0.25;      // s
constexpr double flight_weight = 0.03;  // of the difference of w in a flight from the value of its height
constexpr double smooth_time = 0.04;    // s: the speed changes within about this time
constexpr double smooth_weight = 0.05;
constexpr double bound_weight = 3;
constexpr double air_course = 0.3, ground_course = 0.03;  // weights of horizontal accelerations that a change of the speed causes
constexpr double time_unit = 0.1;                         // s: an acceleration a counts as the distance a time_unit^2
constexpr double fall_weight = 30;                        // of accelerations in the air, and of those beyond the bounds
constexpr double air_height = 0.3;                        // of the change of the height in flights
constexpr double bend_weight = 0.05;                      // of the acceleration of the change of the height on the ground
constexpr double floor_weight = 20;                       // of heights that put the lowest point below the floor
constexpr int rounds = 40;

/// For each frame the squared speed with which a flight takes as long as a fall from its apex, and a rise to it; 1 on the ground.
std::vector<double> speeds_of_heights(std::span<const Vec3> centre, std::span<const Support> support, double rate) {
  std::vector<double> out(centre.size(), 1.0);
  for (std::size_t f = 0; f < centre.size(); ++f) {
    if (support[f] != Support::flight) continue;
    std::size_t end = f;
    double top = centre[f].z;
    while (end < centre.size() && support[end] == Support::flight) top = std::max(top, centre[end++].z);
    const double time = std::sqrt(2 * (top - centre[f].z) / gravity) + std::sqrt(2 * (top - centre[end - 1].z) / gravity);
    const double speed = static_cast<double>(end - f) / rate / std::max(time, 0.02);
    std::fill(out.begin() + static_cast<std::ptrdiff_t>(f), out.begin() + static_cast<std::ptrdiff_t>(end),
              std::clamp(speed * speed, slowest, fastest));
    f = end - 1;
  }
  return out;
}

}  // namespace

std::size_t slope_margin(double rate) { return std::max<std::size_t>(1, static_cast<std::size_t>(std::lround(0.025 * rate))); }

Slope slope_at(std::span<const Vec3> x, std::size_t f, double rate) {
  const std::size_t d = slope_margin(rate);
  const double h = static_cast<double>(d) / rate;
  return {(x[f + d] - x[f - d]) / (2 * h), (x[f + d] - x[f] * 2 + x[f - d]) / (h * h)};
}

std::vector<double> squared_speeds(std::span<const Vec3> centre, std::span<const Support> support, double rate) {
  const std::size_t n = centre.size(), d = slope_margin(rate), around = static_cast<std::size_t>(std::lround(near_time * rate));
  std::vector<double> w(n, 1.0), keep(n, far_weight);
  if (n < 2 * d + 3) return w;
  const std::vector<double> goal = speeds_of_heights(centre, support, rate);
  for (std::size_t f = d; f + d < n; ++f)
    if (support[f] == Support::flight || (support[f] == Support::ground && slope_at(centre, f, rate).second.z < -max_fall * gravity))
      for (std::size_t k = f > around ? f - around : 0; k <= std::min(n - 1, f + around); ++k) keep[k] = near_weight;
  const double bend = smooth_time * rate * smooth_time * rate;
  for (int round = 0; round < rounds; ++round) {
    BandLeastSquares terms(n);
    for (std::size_t f = 0; f < n; ++f) {
      terms.add(f, goal[f], support[f] == Support::flight ? flight_weight : keep[f]);
      if (w[f] < slowest) terms.add(f, slowest, bound_weight);
      if (w[f] > fastest) terms.add(f, fastest, bound_weight);
      if (f == 0 || f + 1 == n) continue;
      terms.add(f - 1, {bend, -2 * bend, bend}, 0, smooth_weight);
      if (f < d || f + d >= n) continue;
      const Slope s = slope_at(centre, f, rate);
      const Vec3 side = s.first * (rate / 4 / gravity);
      for (const double v : {side.x, side.y}) terms.add(f - 1, {-v, 0, v}, 0, support[f] == Support::ground ? ground_course : air_course);
      const std::array<double, 3> up{-side.z, s.second.z / gravity, side.z};
      const double now = up[0] * w[f - 1] + up[1] * w[f] + up[2] * w[f + 1];
      if (support[f] == Support::flight) terms.add(f - 1, up, -1, 1);
      if (support[f] != Support::ground) continue;
      if (now < -1) terms.add(f - 1, up, -1, bound_weight);
      if (now > max_push) terms.add(f - 1, up, max_push, bound_weight);
    }
    w = terms.solve();
  }
  for (double& x : w) x = std::clamp(x, slowest, fastest);
  return w;
}

std::vector<double> flight_heights(std::span<const Vec3> centre, std::span<const double> lowest, std::span<const Support> support,
                                   double rate) {
  const std::size_t n = centre.size(), d = slope_margin(rate);
  std::vector<double> up(n, 0.0);
  if (n < 2 * d + 3) return up;
  const double unit = time_unit * time_unit, r2 = rate * rate;
  const std::array<double, 3> second{unit * r2, -2 * unit * r2, unit * r2};
  for (int round = 0; round < rounds; ++round) {
    BandLeastSquares terms(n);
    for (std::size_t f = 0; f < n; ++f) {
      const double room = std::max(0.0, lowest[f]);
      terms.add(f, 0, support[f] == Support::ground ? 1.0 : air_height);
      if (up[f] < -room) terms.add(f, -room, floor_weight);
      if (f == 0 || f + 1 == n) continue;
      const double own = slope_at(centre, std::clamp(f, d, n - 1 - d), rate).second.z;
      if (support[f] == Support::flight) {
        terms.add(f - 1, second, unit * (-gravity - own), fall_weight);
        continue;
      }
      terms.add(f - 1, second, 0, bend_weight);
      const double now = own + (up[f - 1] - 2 * up[f] + up[f + 1]) * r2;
      if (now < -gravity) terms.add(f - 1, second, unit * (-gravity - own), fall_weight);
      if (now > max_push * gravity && own < max_push * gravity) terms.add(f - 1, second, unit * (max_push * gravity - own), fall_weight);
    }
    up = terms.solve();
  }
  return up;
}

double impossible_acceleration(std::span<const Vec3> centre, std::span<const Support> support, std::span<const double> w, double rate) {
  const std::size_t n = centre.size(), d = slope_margin(rate);
  double sum = 0, time = 0;
  for (std::size_t f = d; f + d < n; ++f) {
    const Slope s = slope_at(centre, f, rate);
    const Vec3 a = (s.second * w[f] + s.first * ((w[f + 1] - w[f - 1]) * rate / 4)) / gravity;
    const double dt = 1 / std::sqrt(w[f]), side = std::hypot(a.x, a.y);
    const bool stands = support[f] == Support::ground;
    const double fall = stands ? std::min(0.0, a.z + 1) : a.z + 1, push = stands ? std::max(0.0, a.z - max_push) : 0;
    const double slip = stands ? std::max(0.0, side - friction * std::max(0.0, a.z + 1)) : side;
    sum += dt * (fall * fall + push * push + slip * slip);
    time += dt;
  }
  return time > 0 ? sum / time : 0;
}

}  // namespace ugoki::intake
