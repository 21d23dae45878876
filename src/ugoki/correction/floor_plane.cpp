#include "ugoki/correction/floor_plane.h"

#include <algorithm>
#include <cmath>

#include "ugoki/mechanism/state.h"

namespace ugoki::correction {
namespace {

constexpr double slow = 0.2;         // m/s: slower points of a foot stand, except for two or three frames at the top of a jump
constexpr double outlier = 0.03;     // m: samples this far from the plane count a quarter; soles of captures vary by 1 cm
constexpr double min_extent = 1;     // m: shorter distances between steps do not show a slope; 1 cm of noise would be more than 0.6 degrees
constexpr double max_slope = 0.25;   // steeper planes are stairs or errors
constexpr double min_slope = 0.004;  // 0.23 degrees: the accuracy of captures
constexpr double clearly_better = 0.75;  // factor of the rms error that a slope must reach

std::size_t at(int i) { return static_cast<std::size_t>(i); }

std::vector<Vec3> standing_points(const Mechanism& m, const Motion& motion, std::span<const motion_edit::FootLimb> feet) {
  std::vector<std::vector<Pose>> X(at(motion.frames), std::vector<Pose>(at(m.link_count())));
  for (int f = 0; f < motion.frames; ++f) calc_poses(m, {motion.frame(f), at(motion.nq)}, X[at(f)]);
  std::vector<Vec3> out;
  const auto height = [&](int f, const LinkPoint& p) { return (X[at(f)][at(p.link)] * p.location.p).z - p.location.radius; };
  std::vector<LinkPoint> others;
  for (int i = 0; i < m.link_count(); ++i)
    for (const SupportPoint& p : support_points(m.link(i))) others.push_back({i, p});
  std::vector<double> lowest(at(motion.frames), 1e300);  // m, of all links: feet that are higher than a hand or the back do not stand
  for (int f = 0; f < motion.frames; ++f)
    for (const LinkPoint& p : others) lowest[at(f)] = std::min(lowest[at(f)], height(f, p));
  for (const motion_edit::FootLimb& foot : feet)
    for (int f = 1; f + 1 < motion.frames; ++f) {
      const LinkPoint* sole = nullptr;
      double low = 0;
      for (const LinkPoint& p : foot.points) {
        const double z = height(f, p);
        if (sole && z >= low) continue;
        sole = &p;
        low = z;
      }
      if (!sole || low > lowest[at(f)] + 2 * outlier) continue;
      const std::size_t link = at(sole->link);
      const Vec3 p = sole->location.p + transpose_times(X[at(f)][link].R, Vec3{0, 0, -sole->location.radius});
      if (norm(X[at(f + 1)][link] * p - X[at(f - 1)][link] * p) * 0.5 * motion.rate < slow) out.push_back(X[at(f)][link] * p);
    }
  return out;
}

/// Straight line height + slope * x through samples, by iteratively reweighted least squares. @param with_slope false: level
struct Line {
  double height = 0, slope = 0, error = 0;
};
Line fit(const std::vector<double>& x, const std::vector<double>& z, bool with_slope) {
  Line line;
  std::vector<double> w(x.size(), 1.0);
  for (int round = 0; round < 20; ++round) {
    double n = 0, sx = 0, sz = 0, sxx = 0, sxz = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      n += w[i];
      sx += w[i] * x[i];
      sz += w[i] * z[i];
      sxx += w[i] * x[i] * x[i];
      sxz += w[i] * x[i] * z[i];
    }
    const double det = n * sxx - sx * sx;
    line.slope = with_slope && det > 1e-9 ? (n * sxz - sx * sz) / det : 0;
    line.height = (sz - line.slope * sx) / n;
    line.error = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      const double e = z[i] - line.height - line.slope * x[i], share = 1 / (1 + e * e / (outlier * outlier));
      line.error += w[i] * e * e / n;
      w[i] = share * share;
    }
    line.error = std::sqrt(line.error);
  }
  return line;
}

}  // namespace

Pose FloorPlane::to_level() const {
  const Vec3 normal = normalized(Vec3{-slope.x, -slope.y, 1});
  const Mat3 R = to_matrix(rotation_between(normal, {0, 0, 1}));
  const Vec3 origin{centre.x, centre.y, height};
  return {R, Vec3{centre.x, centre.y, 0} - R * origin};
}

FloorPlane find_floor(const Mechanism& m, const Motion& motion, std::span<const motion_edit::FootLimb> feet) {
  FloorPlane plane;
  const std::vector<Vec3> points = standing_points(m, motion, feet);
  if (points.empty()) return plane;
  for (const Vec3& p : points) plane.centre += p / static_cast<double>(points.size());
  plane.centre.z = 0;
  double xx = 0, xy = 0, yy = 0;
  for (const Vec3& p : points) {
    const Vec3 d = p - plane.centre;
    xx += d.x * d.x;
    xy += d.x * d.y;
    yy += d.y * d.y;
  }
  const SinCos main = sin_cos(0.5 * atan2(2 * xy, xx - yy));
  std::vector<double> along(points.size()), height(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) height[i] = points[i].z;
  for (const Vec3& u : {Vec3{main.cos, main.sin, 0}, Vec3{-main.sin, main.cos, 0}}) {
    for (std::size_t i = 0; i < points.size(); ++i) along[i] = dot(u, points[i] - plane.centre);
    const auto [low, high] = std::ranges::minmax_element(along);
    if (*high - *low < min_extent) continue;
    const Line level = fit(along, height, false), sloped = fit(along, height, true);
    if (std::fabs(sloped.slope) > max_slope || std::fabs(sloped.slope) < min_slope || sloped.error > clearly_better * level.error) continue;
    plane.slope += u * sloped.slope;
    for (std::size_t i = 0; i < points.size(); ++i) height[i] -= sloped.slope * along[i];
  }
  plane.height = fit(along, height, false).height;
  return plane;
}

}  // namespace ugoki::correction
