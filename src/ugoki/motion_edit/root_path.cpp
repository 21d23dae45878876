#include "ugoki/motion_edit/root_path.h"

#include <algorithm>
#include <cmath>

#include "ugoki/base/number.h"
#include "ugoki/motion/clip.h"

namespace ugoki::motion_edit {
namespace {

constexpr int pieces = 64;       // line segments that approximate the curve between two points
constexpr double min_way = 0.2;  // m: a shorter path has no definite direction

std::size_t at(int i) { return static_cast<std::size_t>(i); }
double distance(const PathPoint& a, const PathPoint& b) { return std::sqrt((a.x - b.x) * (a.x - b.x) + (a.y - b.y) * (a.y - b.y)); }
PathPoint between(const PathPoint& a, const PathPoint& b, double s) { return {a.x + s * (b.x - a.x), a.y + s * (b.y - a.y)}; }

/// A polyline with the arc length at each of its points.
struct Way {
  std::vector<PathPoint> p;
  std::vector<double> length;  ///< m, arc length from the first point

  explicit Way(std::vector<PathPoint> places) : p(std::move(places)) {
    for (std::size_t i = 0; i < p.size(); ++i) length.push_back(i ? length.back() + distance(p[i - 1], p[i]) : 0);
  }
  [[nodiscard]] double total_length() const { return length.back(); }
  /// Point at arc length s [m]; extrapolated along the first and last segment.
  [[nodiscard]] PathPoint point(double s) const {
    std::size_t i = static_cast<std::size_t>(std::upper_bound(length.begin(), length.end(), s) - length.begin());
    i = std::clamp<std::size_t>(i, 1, p.size() - 1);
    while (i > 1 && length[i] - length[i - 1] < 1e-12) --i;
    while (i + 1 < p.size() && length[i] - length[i - 1] < 1e-12) ++i;
    const double h = length[i] - length[i - 1];
    return h < 1e-12 ? p[i] : between(p[i - 1], p[i], (s - length[i - 1]) / h);
  }
  /// Point at arc length s [m], and direction of the chord from s - reach to s + reach [m].
  [[nodiscard]] Placement frame(double s, double reach) const {
    const PathPoint here = point(s), a = point(s - reach), b = point(s + reach);
    return {here.x, here.y, 0, atan2(b.y - a.y, b.x - a.x)};
  }
};

/// Centripetal Catmull-Rom spline through the points as a polyline, by the recursion of Barry and Goldman.
std::vector<PathPoint> catmull_rom(std::span<const PathPoint> points) {
  std::vector<PathPoint> p;
  for (const PathPoint& q : points)
    if (p.empty() || distance(p.back(), q) > 1e-6) p.push_back(q);
  if (p.size() < 2) return p;
  p.insert(p.begin(), between(p[0], p[1], -1));
  p.push_back(between(p[p.size() - 2], p.back(), 2));
  std::vector<PathPoint> out;
  for (std::size_t i = 1; i + 2 < p.size(); ++i) {
    double t[4] = {0, 0, 0, 0};
    for (std::size_t k = 1; k < 4; ++k) t[k] = t[k - 1] + std::sqrt(distance(p[i + k - 2], p[i + k - 1]));
    for (int piece = 0; piece < pieces + (i + 3 == p.size() ? 1 : 0); ++piece) {
      const double u = t[1] + (t[2] - t[1]) * piece / pieces;
      PathPoint a[3];
      for (std::size_t k = 0; k < 3; ++k) a[k] = between(p[i + k - 1], p[i + k], (u - t[k]) / (t[k + 1] - t[k]));
      const PathPoint b0 = between(a[0], a[1], (u - t[0]) / (t[2] - t[0])), b1 = between(a[1], a[2], (u - t[1]) / (t[3] - t[1]));
      out.push_back(between(b0, b1, (u - t[1]) / (t[2] - t[1])));
    }
  }
  return out;
}

}  // namespace

std::vector<PathPoint> root_path(const Mechanism& m, const Motion& motion, double smoothing) {
  std::vector<PathPoint> raw, out;
  for (int f = 0; f < motion.frames; ++f) {
    const Placement root = root_placement(m, {motion.frame(f), at(motion.nq)});
    raw.push_back({root.x, root.y});
  }
  const int half = std::max(1, static_cast<int>(0.5 * smoothing * motion.rate + 0.5));
  for (int pass = 0; pass < 2; ++pass) {
    out.clear();
    for (int f = 0; f < motion.frames; ++f) {
      const int reach = std::min({half, f, motion.frames - 1 - f});  // the window shrinks to 0 at the ends, so that the end points are kept
      PathPoint sum;
      for (int k = -reach; k <= reach; ++k) {
        sum.x += raw[at(f + k)].x / (2 * reach + 1);
        sum.y += raw[at(f + k)].y / (2 * reach + 1);
      }
      out.push_back(sum);
    }
    raw = out;
  }
  return out;
}

Result<Motion> bend_path(const Mechanism& m, const Motion& motion, std::span<const PathPoint> points, const RootPathOptions& o,
                         FootLockReport* report) {
  if (Error wrong = check_motion(motion, m); !wrong.empty()) return fail(std::move(wrong));
  const JointType root = m.link_count() > 0 ? m.link(0).joint.type : JointType::fixed;
  if (root != JointType::floating && root != JointType::planar)
    return fail(ErrorCode::structure, "mechanism " + m.name(), "The mechanism's root cannot move over the ground.",
                "Use a mechanism with a floating or planar root.");
  for (std::size_t i = 0; i < points.size(); ++i)
    if (!(std::fabs(points[i].x) <= 1e6 && std::fabs(points[i].y) <= 1e6))
      return fail(ErrorCode::range, "path, point " + std::to_string(i), "The point is not finite or is beyond 1e6 m.",
                  "Enter coordinates in metres.");
  std::vector<PathPoint> curve = catmull_rom(points);
  if (curve.size() < 2)
    return fail(ErrorCode::structure, "path", "The path has fewer than two different points.", "Specify at least two points.");
  const Way to(std::move(curve)), from(root_path(m, motion, o.smoothing));
  if (from.total_length() < min_way)
    return fail(ErrorCode::structure, "motion " + motion.name,
                "The path of the motion is " + to_fixed(from.total_length(), 3) + " m long; bending needs at least 0.2 m.",
                "Move or turn the whole motion instead.");
  const double ratio = o.keep_speed ? 1 : to.total_length() / from.total_length(), reach = 0.25 * std::min(1.0, from.total_length());
  Motion out = motion;
  for (int f = 0; f < motion.frames; ++f) {
    const double s = from.length[at(f)];
    const Placement by = to.frame(ratio * s, ratio * reach) * inverse(from.frame(s, reach));
    displace_root(m, by, {out.frame(f), at(out.nq)});
  }
  out.cyclic = false;
  FootContacts contacts = labelled_contacts(m, motion, find_foot_limbs(m), o.contacts);
  if (!o.lock_feet || contacts.feet.empty()) return out;
  return lock_feet(m, out, contacts, o.lock, report);
}

}  // namespace ugoki::motion_edit
