#include "ugoki/intake/support.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "ugoki/base/number.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/motion/contact_labels.h"

namespace ugoki::intake {

std::string describe_missing_support(const Mechanism& mechanism, const Motion& motion, double height) {
  // Measured feet are up to 4 % of the height away from the floor in stance (soft soles, noise). A body that accelerates downwards with
  // more than a third of gravity is in a flight phase.
  constexpr double gap = 0.05, falling = -0.35 * 9.81, shortest = 0.25, window = 0.08;
  const int count = mechanism.link_count();
  std::vector<std::vector<SupportPoint>> points;
  for (const Link& link : mechanism.links()) points.push_back(support_points(link));
  const int step = std::max(1, static_cast<int>(std::lround(motion.rate / 30)));
  std::vector<Pose> X(static_cast<std::size_t>(count));
  std::vector<double> low, root;
  for (int f = 0; f < motion.frames; f += step) {
    calc_poses(mechanism, {motion.frame(f), static_cast<std::size_t>(motion.nq)}, X);
    double lowest = 1e300;
    for (std::size_t i = 0; i < X.size(); ++i)
      for (const SupportPoint& s : points[i]) lowest = std::min(lowest, (X[i] * s.p).z - s.radius);
    low.push_back(lowest);
    root.push_back(X[0].p.z);
  }
  const double dt = step / motion.rate;
  const int half = std::max(1, static_cast<int>(std::lround(window / dt)));
  int missing = 0, run = 0;
  double first = -1;
  const int n = static_cast<int>(low.size());
  const auto at = [](const std::vector<double>& v, int i) { return v[static_cast<std::size_t>(i)]; };
  for (int k = 0; k <= n; ++k) {
    bool unsupported = false;
    if (k < n && at(low, k) > gap * height && at(low, k) < 1e200) {
      const int m = std::clamp(k, half, std::max(half, n - 1 - half));
      const double h = half * dt;
      const double a = m + half < n ? (at(root, m + half) - 2 * at(root, m) + at(root, m - half)) / (h * h) : 0;
      unsupported = a > falling;
    }
    if (unsupported) {
      ++run;
      continue;
    }
    if (run * dt >= shortest) {
      missing += run;
      if (first < 0) first = (k - run) * dt;
    }
    run = 0;
  }
  if (missing == 0) return {};
  return motion.name + ": in " + to_fixed(100.0 * missing / n, 0) + " % of the frames (first at " + to_fixed(first, 2) +
         " s) nothing of the character is near the floor although it does not fall. It stands on, sits on or hangs from something that the "
         "file does not contain (stairs, a box, a chair, a bar), or its height drifts. Under dynamics it loses its support there.";
}

}  // namespace ugoki::intake
