#include "ugoki/correction/flight_spin.h"

namespace ugoki::correction {

void keep_spin(const Mechanism& m, const Observation& o, Motion& motion) {
  constexpr double shortest = 0.1;  // s: in shorter flights the momentum of a capture is less accurate than its change
  for (const Flight& flight : o.flights) {
    if (flight.frames() < shortest * o.rate) continue;
    // A turn r with the rate r' changes the momentum by I r'. The integral of I^-1 (H0 - H) must be zero.
    Mat3 sum = Mat3::identity() * 0.0;
    Vec3 right;
    std::vector<Mat3> mobility;
    for (int f = flight.first; f <= flight.last; ++f) {
      const auto i = static_cast<std::size_t>(f);
      mobility.push_back(inverse(o.inertia[i].matrix()));
      sum = sum + mobility.back();
      right += mobility.back() * o.spin[i];
    }
    const Vec3 kept = inverse(sum) * right;
    Vec3 turn;
    for (int f = flight.first; f <= flight.last; ++f) {
      const auto i = static_cast<std::size_t>(f);
      const Vec3 rate = mobility[i - static_cast<std::size_t>(flight.first)] * (kept - o.spin[i]);
      turn += rate * (0.5 / o.rate);
      const Mat3 R = to_matrix(exp_map(turn));
      displace(m, {R, o.centre[i] - R * o.centre[i]}, motion.frame(f));
      turn += rate * (0.5 / o.rate);
    }
  }
}

}  // namespace ugoki::correction
