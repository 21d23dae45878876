#include "ugoki/correction/travel.h"

#include <algorithm>

#include "ugoki/mechanism/state.h"

namespace ugoki::correction {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

}  // namespace

MissingTravel find_missing_travel(const Mechanism& m, const Motion& motion, std::span<const motion_edit::FootLimb> feet) {
  std::vector<std::vector<Pose>> X(at(motion.frames), std::vector<Pose>(at(m.link_count())));
  std::vector<Vec3> body;
  for (int f = 0; f < motion.frames; ++f) {
    calc_poses(m, {motion.frame(f), at(motion.nq)}, X[at(f)]);
    body.push_back(X[at(f)][0].p);
  }
  std::vector<FootTrack> tracks;
  for (const motion_edit::FootLimb& foot : feet) {
    if (foot.points.empty()) continue;
    FootTrack& track = tracks.emplace_back();
    for (int f = 0; f < motion.frames; ++f) {
      const auto height = [&](const LinkPoint& p) { return (X[at(f)][at(p.link)] * p.location.p).z - p.location.radius; };
      const LinkPoint& lowest = *std::ranges::min_element(foot.points, {}, height);
      const std::size_t link = at(lowest.link), before = at(std::max(0, f - 1)), after = at(std::min(motion.frames - 1, f + 1));
      const Vec3 p = lowest.location.p + transpose_times(X[at(f)][link].R, Vec3{0, 0, -lowest.location.radius});
      const double seconds = static_cast<double>(std::max<std::size_t>(1, after - before)) / motion.rate;
      track.height.push_back(height(lowest));
      track.velocity.push_back((X[after][link] * p - X[before][link] * p) / seconds);
    }
  }
  return ugoki::find_missing_travel(tracks, body, motion.rate, motion_edit::mean_leg_length(feet));
}

}  // namespace ugoki::correction
