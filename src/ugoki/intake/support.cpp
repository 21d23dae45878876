#include "ugoki/intake/support.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "ugoki/base/number.h"
#include "ugoki/intake/lowering.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/motion/contact_labels.h"
#include "ugoki/spatial/elementary.h"

namespace ugoki::intake {
namespace {

/// Height [m] of the lowest support point. @param points [links], in the frames of the links  @param X [links] poses in the world
double lowest_height(const std::vector<std::vector<SupportPoint>>& points, const std::vector<Pose>& X) {
  double lowest = 1e300;
  for (std::size_t i = 0; i < X.size(); ++i)
    for (const SupportPoint& s : points[i]) lowest = std::min(lowest, (X[i] * s.p).z - s.radius);
  return lowest;
}

/// Link of the lowest support point.
int lowest_link(const std::vector<std::vector<SupportPoint>>& points, const std::vector<Pose>& X) {
  double low = 1e300;
  int link = 0;
  for (std::size_t i = 0; i < X.size(); ++i)
    for (const SupportPoint& s : points[i])
      if (const double z = (X[i] * s.p).z - s.radius; z < low) {
        low = z;
        link = static_cast<int>(i);
      }
  return link;
}

/// Minimum horizontal displacement [m] from `before` to `now` of the support points that are lower than `highest` [m]; -1e9 without one.
double slowest_slide(const std::vector<std::vector<SupportPoint>>& points, const std::vector<Pose>& before, const std::vector<Pose>& now,
                     double highest) {
  double slowest = 1e300;
  for (std::size_t i = 0; i < now.size(); ++i)
    for (const SupportPoint& s : points[i]) {
      const Vec3 p = now[i] * s.p, d = p - before[i] * s.p;
      if (p.z - s.radius < highest) slowest = std::min(slowest, std::sqrt(d.x * d.x + d.y * d.y));
    }
  return slowest < 1e299 ? slowest : -1e9;
}

/// Horizontal distance [m] by which `p` is outside the convex hull of the points; negative inside. 16 directions approximate the hull.
double distance_outside(const Vec3& p, const std::vector<Vec3>& points) {
  constexpr int directions = 16;
  double out = -1e300;
  for (int k = 0; k < directions; ++k) {
    const SinCos d = sin_cos(2 * pi * k / directions);
    double reach = -1e300;
    for (const Vec3& q : points) reach = std::max(reach, d.cos * q.x + d.sin * q.y);
    out = std::max(out, d.cos * p.x + d.sin * p.y - reach);
  }
  return out;
}

/// Sentence about the time in which the character hardly accelerates although the points near the floor cannot balance it: the zero-moment
/// point of its centre of mass is far outside them (Vukobratovic and Borovac 2004). Empty if there is no such time.
/// @param centre [frames] m, centre of mass @param dt s between frames
std::string describe_unbalanced_rest(const std::string& name, const std::vector<Vec3>& centre,
                                     const std::vector<std::vector<Vec3>>& near_floor, double dt, double height) {
  // 8 % of the height is 14 cm for a person: more than errors of mass distribution and soles. Runners lean for less than 0.4 s.
  constexpr double margin = 0.08, shortest = 0.6, window = 0.1;
  const int n = static_cast<int>(centre.size()), half = std::max(1, static_cast<int>(std::lround(window / dt)));
  int unbalanced = 0, run = 0;
  double first = -1, farthest = 0, farthest_in_run = 0;
  for (int k = half; k <= n - half; ++k) {
    const auto at = [&](int i) { return centre[static_cast<std::size_t>(i)]; };
    double outside = -1;
    if (k < n - half && !near_floor[static_cast<std::size_t>(k)].empty()) {
      const Vec3 a = (at(k + half) - at(k) * 2.0 + at(k - half)) / (half * dt * half * dt);
      const double lever = at(k).z / std::max(1.0, 9.81 + a.z);  // s^2, of the horizontal acceleration
      // 3 m/s^2: beyond that the character runs or jumps, or its data jump.
      if (norm(a) < 3) outside = distance_outside(at(k) - a * lever, near_floor[static_cast<std::size_t>(k)]);
    }
    if (outside > margin * height) {
      ++run;
      farthest_in_run = std::max(farthest_in_run, outside);
      continue;
    }
    if (run * dt >= shortest) {
      unbalanced += run;
      farthest = std::max(farthest, farthest_in_run);
      if (first < 0) first = (k - run) * dt;
    }
    run = 0;
    farthest_in_run = 0;
  }
  if (unbalanced == 0) return {};
  return name + ": in " + to_fixed(100.0 * unbalanced / n, 0) + " % of the frames (first at " + to_fixed(first, 2) +
         " s) the points near the floor cannot balance the character, which is up to " + to_fixed(100 * farthest, 0) +
         " cm beside them. It sits on, leans on or holds something that the file does not contain (a chair, a wall, a bar). Under dynamics "
         "it falls there.";
}

/// Frames in which the centre of mass accelerates downwards much faster than gravity.
struct Pull {
  std::size_t count = 0, first = 0;
  double fastest = 0;  ///< m/s^2
  [[nodiscard]] double share(std::size_t frames) const {
    return static_cast<double>(count) / static_cast<double>(std::max<std::size_t>(1, frames));
  }
};

constexpr double gravity = 9.81, few_pulled = 0.05;  // m/s^2, share of the frames

/// @param height [frames] m, of the centre of mass  @param dt s, between the frames
Pull find_pull(const std::vector<double>& height, double dt) {
  constexpr double window = 0.08, pulled = 1.5 * gravity;  // s, m/s^2
  const std::size_t half = std::max<std::size_t>(1, static_cast<std::size_t>(std::lround(window / dt)));
  const double h = static_cast<double>(half) * dt;
  Pull out;
  for (std::size_t k = half; k + half < height.size(); ++k) {
    const double down = -(height[k + half] - 2 * height[k] + height[k - half]) / (h * h);
    if (down < pulled) continue;
    if (out.count++ == 0) out.first = k;
    out.fastest = std::max(out.fastest, down);
  }
  return out;
}

/// A sentence about such frames; empty if they are few.
std::string describe_pull(const std::string& name, const std::vector<Vec3>& centre, double dt) {
  std::vector<double> height;
  for (const Vec3& c : centre) height.push_back(c.z);
  const Pull pull = find_pull(height, dt);
  if (pull.share(height.size()) < few_pulled) return {};
  return name + ": in " + to_fixed(100 * pull.share(height.size()), 0) + " % of the frames (first at " +
         to_fixed(static_cast<double>(pull.first) * dt, 2) + " s) the centre of mass accelerates downwards with up to " +
         to_fixed(pull.fastest / gravity, 1) +
         " times gravity. Nothing but gravity pulls a character down: under dynamics its feet leave the floor there, and it cannot follow "
         "the motion exactly.";
}

/// A sentence about parts of the body far below the floor; empty if they are there in few frames.
/// @param low [frames] m, height of the lowest support point  @param lowest [frames] link of this point
std::string describe_sunken(const Mechanism& mechanism, const std::string& name, const std::vector<double>& low,
                            const std::vector<int>& lowest, double height) {
  constexpr double depth = 0.03, few = 0.05;  // share of the height: soles and paws of captures sink by up to 2 %; share of the frames
  std::size_t count = 0, deepest = 0;
  for (std::size_t k = 0; k < low.size(); ++k) {
    count += low[k] < -depth * height ? 1 : 0;
    if (low[k] < low[deepest]) deepest = k;
  }
  const double share = static_cast<double>(count) / static_cast<double>(std::max<std::size_t>(1, low.size()));
  if (share < few) return {};
  return name + ": in " + to_fixed(100 * share, 0) + " % of the frames parts of the body are below the floor, " +
         mechanism.link(lowest[deepest]).name + " by up to " + to_fixed(-100 * low[deepest], 0) +
         " cm. Under dynamics the floor holds them up, and their joints cannot follow the motion exactly.";
}

/// A sentence about feet that slide over the floor all the time; empty if they seldom do.
/// @param slide [frames] m/s, minimum horizontal speed of the points near the floor; negative: no point is near it
std::string describe_sliding(const std::string& name, const std::vector<double>& slide, double height) {
  // Feet of captures roll or slip with less than 0.3 m/s for a person of 1.7 m; speeds scale with the root of the height (Froude).
  const double fast = 0.3 * std::sqrt(height / 1.7);
  constexpr double often = 0.5;  // share of the frames with a point near the floor: landing feet of runners slide in a third of them
  std::vector<double> sliding;
  std::size_t standing = 0;
  for (const double s : slide) {
    standing += s >= 0 ? 1 : 0;
    if (s > fast) sliding.push_back(s);
  }
  if (standing == 0 || static_cast<double>(sliding.size()) < often * static_cast<double>(standing)) return {};
  const auto middle = sliding.begin() + static_cast<std::ptrdiff_t>(sliding.size() / 2);
  std::nth_element(sliding.begin(), middle, sliding.end());
  return name + ": in " + to_fixed(100.0 * static_cast<double>(sliding.size()) / static_cast<double>(slide.size()), 0) +
         " % of the frames all that is near the floor slides over it, usually at " + to_fixed(*middle, 2) +
         " m/s. Under dynamics friction holds the feet, and the legs cannot follow the motion exactly.";
}

}  // namespace

std::string describe_missing_support(const Mechanism& mechanism, const Motion& motion, double height, bool on_belt) {
  // Measured feet are up to 4 % of the height away from the floor in stance (soft soles, noise). A body that accelerates downwards with
  // more than a third of gravity is in a flight phase.
  constexpr double gap = 0.05, falling = -0.35 * 9.81, shortest = 0.25, window = 0.08;
  const int count = mechanism.link_count();
  std::vector<std::vector<SupportPoint>> points;
  for (const Link& link : mechanism.links()) points.push_back(support_points(link));
  const int step = std::max(1, static_cast<int>(std::lround(motion.rate / 30)));
  std::vector<Pose> X(static_cast<std::size_t>(count));
  std::vector<double> low, root;
  std::vector<Vec3> centre;
  std::vector<std::vector<Vec3>> near_floor;  // [frames] points at most `gap` above the floor
  constexpr double touching = 0.01;           // share of the height
  std::vector<int> lowest;
  std::vector<double> slide;
  std::vector<Pose> before;
  for (int f = 0; f < motion.frames; f += step) {
    calc_poses(mechanism, {motion.frame(f), static_cast<std::size_t>(motion.nq)}, X);
    low.push_back(lowest_height(points, X));
    lowest.push_back(lowest_link(points, X));
    slide.push_back(before.empty() ? -1 : slowest_slide(points, before, X, touching * height) * motion.rate / step);
    before = X;
    root.push_back(X[0].p.z);
    centre.push_back(centre_of_mass(mechanism, X));
    std::vector<Vec3>& standing = near_floor.emplace_back();
    for (std::size_t i = 0; i < X.size(); ++i)
      for (const SupportPoint& s : points[i])
        if (const Vec3 p = X[i] * s.p; p.z - s.radius < gap * height) standing.push_back(p);
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
  if (missing == 0) {
    std::string reason = describe_unbalanced_rest(motion.name, centre, near_floor, dt, height);
    if (reason.empty()) reason = describe_pull(motion.name, centre, dt);
    if (reason.empty()) reason = describe_sunken(mechanism, motion.name, low, lowest, height);
    if (reason.empty() && !on_belt) reason = describe_sliding(motion.name, slide, height);
    return reason;
  }
  return motion.name + ": in " + to_fixed(100.0 * missing / n, 0) + " % of the frames (first at " + to_fixed(first, 2) +
         " s) nothing of the character is near the floor although it does not fall. It stands on, sits on or hangs from something that the "
         "file does not contain (stairs, a box, a chair, a bar), or its height drifts. Under dynamics it loses its support there.";
}

std::vector<double> hovering_heights(const Mechanism& mechanism, const Motion& motion, double height) {
  // As in describe_missing_support(): a gap that soft paws do not explain, and a third of gravity.
  constexpr double gap = 0.03, falling = -0.35 * 9.81, window = 0.08, highest = 0.5, longest = 1.0;
  const int n = motion.frames, half = std::max(1, static_cast<int>(std::lround(window * motion.rate)));
  if (n < 2 * half + 2) return {};
  std::vector<std::vector<SupportPoint>> points;
  for (const Link& link : mechanism.links()) points.push_back(support_points(link));
  std::vector<Pose> X(static_cast<std::size_t>(mechanism.link_count()));
  std::vector<double> low, root, centre;
  for (int f = 0; f < n; ++f) {
    calc_poses(mechanism, {motion.frame(f), static_cast<std::size_t>(motion.nq)}, X);
    low.push_back(lowest_height(points, X));
    root.push_back(X[0].p.z);
    centre.push_back(centre_of_mass(mechanism, X).z);
  }
  const auto at = [](const std::vector<double>& v, int i) { return v[static_cast<std::size_t>(i)]; };
  // The second difference over `half` frames does not see the first and last frames of a flight phase.
  std::vector<std::uint8_t> flight(static_cast<std::size_t>(n), 0);
  for (int m = half; m < n - half; ++m) {
    const double h = half / motion.rate;
    if ((at(root, m + half) - 2 * at(root, m) + at(root, m - half)) / (h * h) > falling) continue;
    for (int f = m - half; f <= m + half; ++f) flight[static_cast<std::size_t>(f)] = 1;
  }
  int run = 0;
  bool hovers = false;
  for (int f = 0; f < n; ++f) {
    const bool high = at(low, f) > gap * height;
    if (high && flight[static_cast<std::size_t>(f)] != 0) continue;
    flight[static_cast<std::size_t>(f)] = 0;
    run = high ? run + 1 : 0;
    hovers = hovers || high;
    if (high && (at(low, f) > highest * height || run > longest * motion.rate)) return {};
  }
  if (!hovers && find_pull(centre, 1 / motion.rate).share(centre.size()) < few_pulled) return {};
  return physical_lowering(low, flight, centre, motion.rate);
}

}  // namespace ugoki::intake
