#include "ugoki/control/foot_schedule.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "ugoki/mechanism/state.h"
#include "ugoki/spatial/elementary.h"

namespace ugoki::control {
namespace {
std::size_t idx(int i) { return static_cast<std::size_t>(i); }

/// True if the joint of the link and that of its parent turn the link about axes that are not parallel, in the neutral position.
bool can_turn(const Mechanism& m, int link) {
  constexpr double angle = 1e-4, parallel = 0.3;  // rad; sine of the angle between two axes
  const std::vector<double> q = m.neutral();
  std::vector<double> moved(q.size()), v(idx(m.nv()));
  std::vector<Pose> X(idx(m.link_count())), X_moved(X.size());
  calc_poses(m, q, X);
  std::vector<Vec3> axes;
  for (const int i : {link, m.link(link).parent}) {
    if (i <= 0) continue;
    for (int k = 0; k < m.link(i).joint.nv(); ++k) {
      std::ranges::fill(v, 0.0);
      v[idx(m.link(i).v_index + k)] = angle;
      integrate(m, q, v, 1, moved);
      calc_poses(m, moved, X_moved);
      axes.push_back(log_map(to_quat(X_moved[idx(link)].R * X[idx(link)].R.transposed())) / angle);
    }
  }
  for (const Vec3& a : axes)
    for (const Vec3& b : axes)
      if (norm(cross(a, b)) > parallel) return true;
  return false;
}

}  // namespace

std::vector<Foot> feet_of(const Mechanism& m) {
  std::vector<Foot> feet;
  for (const int link : find_feet(m)) {  // parents first
    const auto group = std::find_if(feet.begin(), feet.end(), [&](const Foot& f) {
      return std::find(f.parts.begin(), f.parts.end(), m.link(link).parent) != f.parts.end();
    });
    Foot& foot = group == feet.end() ? feet.emplace_back() : *group;
    if (foot.link < 0) foot.link = link;
    foot.parts.push_back(link);
    for (const SupportPoint& s : support_points(m.link(link))) foot.points.push_back({link, s});
  }
  std::vector<Pose> X(idx(m.link_count()));
  calc_poses(m, m.neutral(), X);
  for (Foot& foot : feet) {
    for (int i = foot.link; i > 0; i = m.link(i).parent)
      for (int k = 0; k < m.link(i).joint.nv(); ++k) foot.dofs.push_back(m.link(i).v_index + k);
    std::ranges::sort(foot.dofs);
    double low = std::numeric_limits<double>::infinity();
    const auto height = [&](const LinkPoint& p) { return (X[idx(p.link)] * p.location.p).z - p.location.radius; };
    for (const LinkPoint& p : foot.points)
      if (p.link == foot.link) low = std::min(low, height(p));
    Vec3 sum;
    double count = 0;
    for (const LinkPoint& p : foot.points) {
      if (p.link != foot.link || height(p) > low + 0.02) continue;
      sum += p.location.p + transpose_times(X[idx(p.link)].R, Vec3{0, 0, -p.location.radius});
      count += 1;
    }
    if (count > 0) foot.sole = sum / count;
    foot.turns = can_turn(m, foot.link);
    foot.normal = transpose_times(X[idx(foot.link)].R, Vec3{0, 0, 1});
  }
  std::vector<int> above(idx(m.link_count()));  // number of feet below each link
  for (const Foot& foot : feet)
    for (int i = foot.link; i >= 0; i = m.link(i).parent) ++above[idx(i)];
  for (Foot& foot : feet)
    for (int i = foot.link; i > 0 && (above[idx(i)] == 1 || foot.hip < 0); i = m.link(i).parent) foot.hip = i;
  return feet;
}

FootSchedule::FootSchedule(const Mechanism& m, std::span<const Foot> feet, const ReferenceMotion& motion, double floor, double rate)
    : leg_length_(feet.size()), stances_(feet.size()), turns_(feet.size()), rate_(rate) {
  const int frames = std::max(1, static_cast<int>(std::floor(motion.end() * rate))) + 1;
  const int margin = static_cast<int>(rate), part = 20 * margin;  // frames: the motion is labelled in parts of 20 s, with 1 s around each
  std::vector<double> q(idx(m.nq())), v(idx(m.nv())), a(v.size());
  std::vector<int> parts;  // links whose poses are kept: only the feet
  std::vector<std::vector<LinkPoint>> points;
  std::vector<std::size_t> first_part;  // [feet] index of the foot's link in `parts`
  for (const Foot& foot : feet) {
    first_part.push_back(parts.size());
    points.push_back(foot.points);
    for (LinkPoint& p : points.back()) {
      const auto found = std::find(foot.parts.begin(), foot.parts.end(), p.link);
      p.link = static_cast<int>(parts.size()) + static_cast<int>(found - foot.parts.begin());
    }
    parts.insert(parts.end(), foot.parts.begin(), foot.parts.end());
  }
  ContactLabelOptions options;
  options.ground = floor;
  options.height_on = 0.02;
  options.speed_on = 0.5;
  options.height_off = 0.03;
  options.speed_off = 0.6;
  std::vector<std::vector<std::uint8_t>> on(feet.size(), std::vector<std::uint8_t>(idx(frames)));
  std::vector<std::vector<double>> yaw_rate(feet.size(), std::vector<double>(idx(frames)));  // rad/s
  std::vector<double> height(idx(frames));                                                   // m, of the centre of mass
  std::vector<Pose> all(idx(m.link_count()));
  std::vector<std::vector<Pose>> poses;
  for (int first = 0; first < frames; first += part) {
    const int from = std::max(0, first - margin), to = std::min(frames, first + part + margin);
    poses.assign(idx(to - from), std::vector<Pose>(parts.size()));
    for (int f = from; f < to; ++f) {
      motion.sample(f / rate, q, v, a);
      calc_poses(m, q, all);
      height[idx(f)] = centre_of_mass(m, all).z - floor;
      for (std::size_t k = 0; k < feet.size(); ++k)
        if (feet[k].hip >= 0)
          leg_length_[k] = std::max(leg_length_[k], norm(all[idx(feet[k].hip)].p - all[idx(feet[k].link)] * feet[k].sole));
      for (std::size_t i = 0; i < parts.size(); ++i) poses[idx(f - from)][i] = all[idx(parts[i])];
    }
    for (std::size_t k = 0; k < feet.size(); ++k) {
      const std::vector<std::uint8_t> found = find_contact(poses, rate, points[k], options);
      const std::size_t sole = first_part[k];
      for (int f = first; f < std::min(frames, first + part); ++f) {
        on[k][idx(f)] = found[idx(f - from)];
        const Mat3 &now = poses[idx(f - from)][sole].R, &next = poses[idx(std::min(f + 1, to - 1) - from)][sole].R;
        yaw_rate[k][idx(f)] = log_map(to_quat(next * now.transposed())).z * rate;
      }
    }
  }
  use_known_contacts(m, feet, motion, on);
  const double infinity = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < feet.size(); ++k)
    for (int f = 0; f < frames;) {
      int to = f;
      while (to < frames && on[k][idx(to)] == on[k][idx(f)]) ++to;
      if (on[k][idx(f)]) {
        motion.sample(f / rate, q, v, a);
        calc_poses(m, q, all);
        stances_[k].push_back({f == 0 ? -infinity : f / rate, to == frames ? infinity : to / rate, all[idx(feet[k].link)],
                               all[idx(std::max(0, feet[k].hip))].p});
      }
      f = to;
    }
  find_flights(on, height, rate);
  for (std::size_t k = 0; k < feet.size(); ++k)
    for (const auto& [begin, end] : find_turns(on[k], yaw_rate[k], rate))
      turns_[k].push_back({static_cast<double>(begin) / rate, static_cast<double>(end) / rate, {}, {}});
}

void FootSchedule::use_known_contacts(const Mechanism& m, std::span<const Foot> feet, const ReferenceMotion& motion,
                                      std::span<std::vector<std::uint8_t>> on) {
  std::vector<std::uint8_t> links(idx(m.link_count()));
  known_.assign(on.empty() ? 0 : on[0].size(), 0);
  for (std::size_t f = 0; f < known_.size(); ++f) {
    if (!motion.contacts(static_cast<double>(f) / rate_, links)) continue;
    known_[f] = 1;
    for (std::size_t k = 0; k < feet.size(); ++k)
      on[k][f] = std::ranges::any_of(feet[k].parts, [&](int link) { return links[idx(link)] != 0; }) ? 1 : 0;
  }
}

void FootSchedule::find_flights(std::span<const std::vector<std::uint8_t>> on, std::span<const double> height, double rate) {
  const auto in_air = [&](std::size_t f) { return std::ranges::none_of(on, [&](const auto& foot) { return foot[f] != 0; }); };
  for (std::size_t f = 0; f < height.size();) {
    std::size_t to = f;
    while (to < height.size() && in_air(to)) ++to;
    if (to > f && f > 0 && to < height.size())
      flights_.push_back({static_cast<double>(f) / rate, static_cast<double>(to) / rate, height[to]});
    f = std::max(to, f + 1);
  }
}

const Flight* FootSchedule::flight(double t) const {
  const auto next = std::upper_bound(flights_.begin(), flights_.end(), t, [](double time, const Flight& f) { return time < f.begin; });
  return next != flights_.begin() && t < (next - 1)->end ? &*(next - 1) : nullptr;
}

bool FootSchedule::turns(std::size_t foot, double t) const {
  const std::vector<Stance>& list = turns_[foot];
  const auto next = std::upper_bound(list.begin(), list.end(), t, [](double time, const Stance& s) { return time < s.begin; });
  return next != list.begin() && t < (next - 1)->end;
}

bool FootSchedule::knows_contacts(double t) const {
  const double frame = std::floor(t * rate_ + 0.5);
  return frame >= 0 && frame < static_cast<double>(known_.size()) && known_[static_cast<std::size_t>(frame)] != 0;
}

ScheduledFoot FootSchedule::at(std::size_t foot, double t) const {
  const std::vector<Stance>& list = stances_[foot];
  const auto next = std::upper_bound(list.begin(), list.end(), t, [](double time, const Stance& s) { return time < s.begin; });
  const double infinity = std::numeric_limits<double>::infinity();
  const double after = next == list.end() ? infinity : next->begin;
  const Stance* landing = next == list.end() ? nullptr : &*next;
  if (next == list.begin()) return {false, -infinity, after, landing};
  const Stance& last = *(next - 1);
  if (t < last.end) return {true, last.begin, last.end, nullptr};
  return {false, last.end, after, landing};
}

}  // namespace ugoki::control
