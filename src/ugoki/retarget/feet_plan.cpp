#include "ugoki/retarget/feet_plan.h"

#include <algorithm>
#include <cmath>

#include "ugoki/mechanism/state.h"

namespace ugoki::retarget {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }
constexpr double swing_tilt = 0.6;  // fraction of the source's tilt that a foot of another kind keeps in mid-swing
constexpr double tilt_time = 0.10;  // s, duration of the transition between level (stance) and tilted (swing)

/// Returns the contact labels of limb k: 1 in frames in which any link of the limb is labelled as in contact; empty if the motion has no
/// labels for the limb.
std::vector<std::uint8_t> labelled(const Rig& rig, const Motion& motion, int k) {
  std::vector<std::uint8_t> on;
  for (const ContactTrack& track : motion.contacts) {
    const int link = rig.mechanism->find_link(track.link);
    const std::vector<int>& own = rig.anatomy.limbs[at(k)].links;
    const std::vector<int>& parts = rig.limbs[at(k)].sole.parts;
    const bool ours = std::find(own.begin(), own.end(), link) != own.end() || std::find(parts.begin(), parts.end(), link) != parts.end();
    if (link < 0 || !ours || static_cast<int>(track.on.size()) != motion.frames) continue;
    on.resize(track.on.size());
    for (std::size_t f = 0; f < on.size(); ++f) on[f] = on[f] || track.on[f] ? 1 : 0;
  }
  return on;
}

}  // namespace

std::vector<std::vector<std::uint8_t>> source_contacts(const Rig& rig, const Motion& motion, double& ground) {
  std::vector<std::vector<std::uint8_t>> out(limb_count);
  std::vector<motion_edit::FootLimb> feet;
  std::vector<int> limbs;
  bool all = true;
  for (int k = 0; k < limb_count; ++k) {
    if (!rig.limbs[at(k)].found || (k >= 2 && !rig.anatomy.four_legs)) continue;
    out[at(k)] = labelled(rig, motion, k);
    all = all && !out[at(k)].empty();
    motion_edit::FootLimb sole = rig.limbs[at(k)].sole;
    if (rig.limbs[at(k)].point_foot) sole.points = {{rig.limbs[at(k)].end, {rig.limbs[at(k)].end_point, sole.points[0].location.radius}}};
    feet.push_back(std::move(sole));
    limbs.push_back(k);
  }
  ground = 0;
  if (all) return out;
  const double found = motion_edit::find_ground(*rig.mechanism, motion, feet);
  ground = std::fabs(found) < 0.04 * rig.hip_height ? 0 : found;
  motion_edit::FootContactOptions options;
  options.ground = ground;
  const motion_edit::FootContacts contacts = motion_edit::find_contacts(*rig.mechanism, motion, feet, options);
  for (std::size_t i = 0; i < limbs.size(); ++i)
    if (out[at(limbs[i])].empty()) out[at(limbs[i])] = contacts.bears[i];
  return out;
}

void flatten(FootPlan& plan, const Mat3& F, double rate) {
  const std::vector<std::uint8_t>& on = plan.raw.bears;
  const std::size_t n = on.size();
  // Time to the nearest stance, in frames.
  std::vector<double> away(n, 1e9);
  for (std::size_t f = 0; f < n; ++f) away[f] = on[f] ? 0 : f > 0 ? away[f - 1] + 1 : 1e9;
  for (std::size_t f = n; f-- > 0;)
    if (f + 1 < n) away[f] = std::min(away[f], away[f + 1] + 1);
  for (std::size_t f = 0; f < n; ++f) {
    const Quat turn = to_quat(plan.turn[f] * F);
    const Quat heading = normalized(std::fabs(turn.w) + std::fabs(turn.z) > 1e-12 ? Quat{turn.w, 0, 0, turn.z} : Quat{});
    const double s = std::min(1.0, away[f] / (tilt_time * rate));
    const Vec3 tilt = log_map(turn * heading.conjugate()) * (swing_tilt * s * s * (3 - 2 * s));
    plan.turn[f] = to_matrix(exp_map(tilt) * heading) * F.transposed();
  }
}

void step_where_dragged(FootPlan& plan, double rate, double length) {
  constexpr double max_drag = 0.2, step_height = 0.12;   // fractions of the leg's length
  constexpr double step_time = 0.12, min_stance = 0.06;  // s: half the duration of a step, shortest stance
  std::vector<std::uint8_t>& on = plan.raw.bears;
  const int n = static_cast<int>(on.size()), half = std::max(1, static_cast<int>(step_time * rate));
  const auto position = [&](int f) { return plan.raw.X_WF[at(f)].p; };
  const auto off = [&](int f, const Vec3& from) {
    const Vec3 d = position(f) - from;
    return std::sqrt(d.x * d.x + d.y * d.y);
  };
  const std::vector<std::uint8_t> stood = on;
  for (int first = 0; first < n; ++first) {
    if (!stood[at(first)] || (first > 0 && stood[at(first - 1)])) continue;
    int last = first;
    while (last + 1 < n && stood[at(last + 1)]) ++last;
    // A stance lasts until its planned position has moved by max_drag; then a step of 2 * step_time follows.
    Vec3 from = position(first);
    int began = first;
    for (int f = first; f <= last; ++f) {
      if (off(f, from) < max_drag * length) continue;
      const int lift = std::max(began, f - half), land = std::min(last, f + half);
      for (int i = lift; i <= land; ++i) on[at(i)] = 0;
      began = land + 1;
      f = land;
      if (began <= last) from = position(began);
    }
  }
  const int minimum = static_cast<int>(min_stance * rate + 0.5);
  for (int first = 0; first < n; ++first) {
    if (!on[at(first)] || (first > 0 && on[at(first - 1)])) continue;
    int last = first;
    while (last + 1 < n && on[at(last + 1)]) ++last;
    if (last - first + 1 < minimum && (first > 0 && last + 1 < n))
      for (int i = first; i <= last; ++i) on[at(i)] = 0;
    first = last;
  }
  // Lift the foot in the added steps.
  for (int first = 0; first < n; ++first) {
    if (!stood[at(first)] || on[at(first)]) continue;
    int last = first;
    while (last + 1 < n && stood[at(last + 1)] && !on[at(last + 1)]) ++last;
    for (int i = first; i <= last; ++i) {
      const double s = (i - first + 1.0) / (last - first + 2.0);
      plan.raw.X_WF[at(i)].p.z += step_height * length * 16 * s * s * (1 - s) * (1 - s);
    }
    first = last;
  }
}

void delay(FootPlan& plan, std::vector<std::uint8_t>& bears, int frames) {
  if (frames == 0) return;
  const int n = static_cast<int>(bears.size());
  const auto from = plan.from_hip;
  const auto turn = plan.turn;
  const auto on = bears;
  for (int f = 0; f < n; ++f) {
    const std::size_t g = at(std::clamp(f - frames, 0, n - 1));
    plan.from_hip[at(f)] = from[g];
    plan.turn[at(f)] = turn[g];
    bears[at(f)] = on[g];
  }
}

int stride_of(std::span<const std::uint8_t> bears) {
  std::vector<int> between;
  int last = -1;
  for (int f = 1; f < static_cast<int>(bears.size()); ++f) {
    if (!bears[at(f)] || bears[at(f - 1)]) continue;
    if (last >= 0) between.push_back(f - last);
    last = f;
  }
  if (between.empty()) return 0;
  std::sort(between.begin(), between.end());
  return between[between.size() / 2];
}

double path_skate(const motion_edit::FootPath& path, int& stances) {
  const std::size_t n = path.X_WF.size(), count = n > 0 ? path.points.size() / n : 0;
  double worst = 0, travelled = 0;
  for (std::size_t f = 0; f < n; ++f) {
    if (!path.bears[f]) continue;
    if (f == 0 || !path.bears[f - 1]) {
      travelled = 0;
      ++stances;
      continue;
    }
    const Pose& X = path.X_WF[f];
    Vec3 lowest;
    double low = 1e300;
    std::size_t index = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const SupportPoint& s = path.points[f * count + i];
      const Vec3 p = s.p + transpose_times(X.R, Vec3{0, 0, -s.radius});
      if (const double z = (X * p).z; z < low) {
        low = z;
        lowest = p;
        index = i;
      }
    }
    const Vec3 same = lowest - path.points[f * count + index].p + path.points[(f - 1) * count + index].p;
    const Vec3 d = X * lowest - path.X_WF[f - 1] * same;
    travelled += std::sqrt(d.x * d.x + d.y * d.y);
    worst = std::max(worst, travelled);
  }
  return worst;
}

}  // namespace ugoki::retarget
