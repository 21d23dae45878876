#include "ugoki/motion_edit/progression.h"

#include <cmath>

namespace ugoki::motion_edit {
namespace {

/// Returns sin(x)/x and (1 - cos(x))/x, computed from their series for small x.
std::pair<double, double> arc(double x) {
  if (std::fabs(x) < 1e-4) return {1 - x * x / 6, x / 2};
  const SinCos s = sin_cos(x);
  return {s.sin / x, (1 - s.cos) / x};
}

}  // namespace

Placement Progression::at(double phase) const {
  const auto [a, b] = arc(turn * phase);
  return start * Placement{phase * (a * vx - b * vy), phase * (b * vx + a * vy), 0, turn * phase};
}

Progression find_progression(const Motion& motion, const Mechanism& m) {
  Progression out;
  const auto nq = static_cast<std::size_t>(motion.nq);
  const int n = motion.frames - 1;
  const auto root = [&](int f) { return root_placement(m, {motion.frame(f), nq}); };
  const Placement cycle = cycle_of(motion, m), first = root(0);
  out.turn = cycle.heading - 2 * pi * std::floor(cycle.heading / (2 * pi) + 0.5);
  double sine = 0, cosine = 0;
  for (int f = 0; f < n; ++f) {
    const SinCos h = sin_cos(root(f).heading - out.turn * f / n);
    sine += h.sin;
    cosine += h.cos;
  }
  out.start = {first.x, first.y, 0, atan2(sine, cosine)};
  const auto make_way = [&] {  // sets vx, vy so that the displacement at phase 1 is `cycle`
    const Placement way = inverse(out.start) * cycle * out.start;
    const auto [a, b] = arc(out.turn);
    const double d = a * a + b * b;
    out.vx = (a * way.x + b * way.y) / d;
    out.vy = (a * way.y - b * way.x) / d;
  };
  make_way();
  for (int pass = 0; pass < 3; ++pass) {
    double x = 0, y = 0;
    for (int f = 0; f < n; ++f) {
      const Placement off = inverse(out.at(static_cast<double>(f) / n)) * root(f);
      x += off.x / n;
      y += off.y / n;
    }
    out.start = out.start * Placement{x, y, 0, 0};
    make_way();
  }
  return out;
}

}  // namespace ugoki::motion_edit
