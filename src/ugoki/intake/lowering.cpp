#include "ugoki/intake/lowering.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "ugoki/motion/band.h"

namespace ugoki::intake {
namespace {

constexpr double time_unit = 0.1;            // s: an acceleration a counts as the distance a time_unit^2
constexpr double smooth_weight = 0.05;       // of the acceleration of the lowering: it follows changes of the height within 0.1 s
constexpr double bound_weight = 30;          // of accelerations beyond the bounds
constexpr double flight_weight = 0.01;       // of the lowering in a flight of the motion
constexpr double floor_weight = 20;          // of a lowering that puts the lowest point below the floor
constexpr double off_ground = 0.01;          // m: lower points carry load; a body that its legs pull down in the data is left alone
constexpr double gravity = 9.81;             // m/s^2
constexpr double max_push = 1.75 * gravity;  // m/s^2 upwards: a ground force of 2.75 body weights, as captured runs and jumps have
constexpr double window = 0.04;              // s, of the second difference of the centre of mass, which is noisy in captures
constexpr int rounds = 40;

/// The heights outside of flights, and linear between them in flights: a flight is shifted as a whole.
std::vector<double> across_flights(const std::vector<double>& lift, const std::vector<std::uint8_t>& flies) {
  const std::size_t n = lift.size();
  std::vector<double> out(n);
  for (std::size_t f = 0; f < n; ++f) {
    out[f] = std::max(0.0, lift[f]);
    if (flies[f] == 0) continue;
    std::size_t end = f;
    while (end < n && flies[end] != 0) ++end;
    const double after = end < n ? std::max(0.0, lift[end]) : f > 0 ? out[f - 1] : 0, before = f > 0 ? out[f - 1] : after;
    const double steps = static_cast<double>(end - f + 1);
    for (std::size_t k = f; k < end; ++k) out[k] = before + (after - before) * static_cast<double>(k - f + 1) / steps;
    f = end - 1;
  }
  return out;
}

}  // namespace

std::vector<double> physical_lowering(const std::vector<double>& lift, const std::vector<std::uint8_t>& flies,
                                      const std::vector<double>& centre, double rate) {
  const std::size_t n = lift.size(), half = std::max<std::size_t>(1, static_cast<std::size_t>(std::lround(window * rate)));
  const double unit = time_unit * time_unit, r2 = rate * rate, h = static_cast<double>(half) / rate;
  const std::array<double, 3> second{unit * r2, -2 * unit * r2, unit * r2};
  const std::vector<double> wanted = across_flights(lift, flies);
  std::vector<double> down(n, 0.0);
  for (int round = 0; round < rounds; ++round) {
    BandLeastSquares terms(n);
    for (std::size_t f = 0; f < n; ++f) {
      const double room = std::max(0.0, lift[f]);
      if (down[f] > room)
        terms.add(f, room, floor_weight);
      else
        terms.add(f, wanted[f], flies[f] ? flight_weight : 1.0);
      if (f == 0 || f + 1 == n) continue;
      terms.add(f - 1, second, 0, smooth_weight);
      const std::size_t m = std::clamp(f, half, std::max(half, n - 1 - half));
      if (m + half >= n) continue;
      const double own = (centre[m + half] - 2 * centre[m] + centre[m - half]) / (h * h);
      const double now = own - (down[f - 1] - 2 * down[f] + down[f + 1]) * r2;
      if (now < -gravity && (own > -gravity || flies[f] != 0 || lift[f] > off_ground))
        terms.add(f - 1, second, unit * (own + gravity), bound_weight);
      if (now > max_push && own < max_push) terms.add(f - 1, second, unit * (own - max_push), bound_weight);
    }
    down = terms.solve();
  }
  return down;
}

}  // namespace ugoki::intake
