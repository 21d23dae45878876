#include "ugoki/correction/travel.h"

#include <algorithm>
#include <cmath>

#include "ugoki/mechanism/state.h"

namespace ugoki::correction {
namespace {

constexpr double leg_of_constants = 0.9;  // m: lengths scale with the leg, speeds with its square root (Froude)
constexpr double low = 0.03;              // m above the lowest fifth of the frames: lower feet stand
constexpr double min_speed = 0.3;         // m/s: slower slides are drift, which contact detection tolerates
constexpr double common_range = 0.5;      // of the common velocity: feet of hand-made walks slide by this much more and less
constexpr double common_share = 0.6;      // of the frames that must have the common velocity

std::size_t at(int i) { return static_cast<std::size_t>(i); }

double median(std::vector<double> x, double share = 0.5) {
  const auto place = x.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(x.size() - 1));
  std::nth_element(x.begin(), place, x.end());
  return *place;
}

}  // namespace

Vec3 find_missing_travel(const Mechanism& m, const Motion& motion, std::span<const motion_edit::FootLimb> feet) {
  const double size = motion_edit::mean_leg_length(feet) / leg_of_constants;
  std::vector<std::vector<Pose>> X(at(motion.frames), std::vector<Pose>(at(m.link_count())));
  for (int f = 0; f < motion.frames; ++f) calc_poses(m, {motion.frame(f), at(motion.nq)}, X[at(f)]);
  std::vector<double> heights, vx, vy;
  std::vector<Vec3> slides;
  for (int f = 1; f + 1 < motion.frames; ++f) {
    const LinkPoint* lowest = nullptr;
    double height = 0;
    for (const motion_edit::FootLimb& foot : feet)
      for (const LinkPoint& p : foot.points)
        if (const double z = (X[at(f)][at(p.link)] * p.location.p).z - p.location.radius; !lowest || z < height) {
          lowest = &p;
          height = z;
        }
    if (!lowest) return {};
    const std::size_t link = at(lowest->link);
    const Vec3 p = lowest->location.p + transpose_times(X[at(f)][link].R, Vec3{0, 0, -lowest->location.radius});
    heights.push_back(height);
    slides.push_back((X[at(f + 1)][link] * p - X[at(f - 1)][link] * p) * (0.5 * motion.rate));
  }
  if (heights.empty() || !(size > 0)) return {};
  const double bound = median(heights, 0.2) + low * size;
  for (std::size_t i = 0; i < slides.size(); ++i) {
    if (heights[i] > bound) continue;
    vx.push_back(slides[i].x);
    vy.push_back(slides[i].y);
  }
  const Vec3 common{median(vx), median(vy), 0};
  const double speed = norm(common);
  if (speed < min_speed * std::sqrt(size)) return {};
  Vec3 sum;
  double count = 0;
  for (std::size_t i = 0; i < vx.size(); ++i) {
    const Vec3 v{vx[i], vy[i], 0};
    if (norm(v - common) > common_range * speed) continue;
    sum += v;
    count += 1;
  }
  if (count < common_share * static_cast<double>(vx.size())) return {};
  return sum * (-1 / count);
}

}  // namespace ugoki::correction
