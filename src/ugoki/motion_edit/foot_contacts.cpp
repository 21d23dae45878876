#include "ugoki/motion_edit/foot_contacts.h"

#include <algorithm>
#include <cmath>

#include "ugoki/mechanism/state.h"
#include "ugoki/motion_edit/rounds.h"

namespace ugoki::motion_edit {
namespace {

constexpr double leg_of_options = 0.9;  // m, leg length for which FootContactOptions is specified

std::size_t at(int i) { return static_cast<std::size_t>(i); }

std::vector<std::vector<Pose>> poses_of(const Mechanism& m, const Motion& motion) {
  std::vector<std::vector<Pose>> poses(at(motion.frames), std::vector<Pose>(at(m.link_count())));
  for (int f = 0; f < motion.frames; ++f) calc_poses(m, std::span(motion.frame(f), at(motion.nq)), poses[at(f)]);
  return poses;
}

ContactLabelOptions scaled(const FootContactOptions& o, double ground, double leg) {
  const double size = leg > 0 ? leg / leg_of_options : 1, pace = std::sqrt(size);
  ContactLabelOptions out;
  out.ground = ground;
  out.height_on = o.height_on * size;
  out.height_off = o.height_off * size;
  out.speed_on = o.speed_on * pace;
  out.speed_off = o.speed_off * pace;
  out.span = o.span;
  out.min_contact = o.min_contact;
  out.min_gap = o.min_gap;
  return out;
}

std::vector<std::uint8_t> middle_of(const std::vector<std::uint8_t>& three) {
  const std::size_t n = (three.size() - 1) / 3;
  std::vector<std::uint8_t> out(three.begin() + static_cast<std::ptrdiff_t>(n), three.begin() + static_cast<std::ptrdiff_t>(2 * n + 1));
  out.back() = out.front();
  return out;
}

}  // namespace

std::vector<Stance> FootContacts::stances(std::size_t foot) const {
  std::vector<Stance> out;
  const std::vector<std::uint8_t>& on = bears[foot];
  for (std::size_t f = 0; f < on.size(); ++f) {
    if (!on[f]) continue;
    if (f == 0 || !on[f - 1]) out.push_back({static_cast<int>(f), 0});
    out.back().last = static_cast<int>(f);
  }
  return out;
}

double find_ground(const Mechanism& m, const Motion& motion, std::span<const FootLimb> feet) {
  struct Moment {
    double speed, low;
  };
  std::vector<Moment> moments;
  const std::vector<std::vector<Pose>> poses = poses_of(m, motion);
  const int reach = std::max(1, static_cast<int>(0.02 * motion.rate + 0.5));
  for (const FootLimb& foot : feet) {
    for (int f = 0; f < motion.frames; ++f) {
      const int before = std::max(0, f - reach), after = std::min(motion.frames - 1, f + reach);
      const LinkPoint* lowest = nullptr;
      double low = 1e300;
      for (const LinkPoint& p : foot.points) {
        const double z = (poses[at(f)][at(p.link)] * p.location.p).z - p.location.radius;
        if (z < low) {
          low = z;
          lowest = &p;
        }
      }
      if (!lowest) continue;
      const Vec3 p = lowest->location.p;
      const double dt = std::max(1, after - before) / motion.rate;
      moments.push_back({norm(poses[at(after)][at(lowest->link)] * p - poses[at(before)][at(lowest->link)] * p) / dt, low});
    }
  }
  if (moments.empty()) return 0;
  std::sort(moments.begin(), moments.end(), [](const Moment& a, const Moment& b) { return a.speed < b.speed; });
  moments.erase(moments.begin() + static_cast<std::ptrdiff_t>(std::max<std::size_t>(1, moments.size() / 4)), moments.end());
  const auto middle = moments.begin() + static_cast<std::ptrdiff_t>(moments.size() / 2);
  std::nth_element(moments.begin(), middle, moments.end(), [](const Moment& a, const Moment& b) { return a.low < b.low; });
  return middle->low;
}

FootContacts find_contacts(const Mechanism& m, const Motion& motion, std::vector<FootLimb> feet, const FootContactOptions& o) {
  FootContacts out;
  out.feet = std::move(feet);
  const bool around = motion.cyclic && motion.frames > 2;
  const Motion rounds = around ? three_rounds(motion, m) : motion;
  out.ground = o.find_ground ? find_ground(m, rounds, out.feet) : o.ground;
  const ContactLabelOptions options = scaled(o, out.ground, mean_leg_length(out.feet));
  const std::vector<std::vector<Pose>> poses = poses_of(m, rounds);
  const auto find = [&](std::span<const LinkPoint> places) {
    std::vector<std::uint8_t> on = find_contact(poses, rounds.rate, places, options);
    return around ? middle_of(on) : on;
  };
  for (const FootLimb& foot : out.feet) {
    out.bears.push_back(find(foot.points));
    for (const bool front : {false, true}) {
      std::vector<LinkPoint> places;
      for (const int i : front ? foot.toe : foot.heel) places.push_back(foot.points[at(i)]);
      std::vector<std::uint8_t> on = find(places);
      for (std::size_t f = 0; f < on.size(); ++f) on[f] = on[f] && out.bears.back()[f] ? 1 : 0;
      (front ? out.toe : out.heel).push_back(std::move(on));
    }
  }
  return out;
}

FootContacts find_contacts(const Mechanism& m, const Motion& motion, const FootContactOptions& options) {
  return find_contacts(m, motion, find_foot_limbs(m), options);
}

FootContacts labelled_contacts(const Mechanism& m, const Motion& motion, std::vector<FootLimb> feet, const FootContactOptions& options) {
  FootContacts out = find_contacts(m, motion, std::move(feet), options);
  for (std::size_t k = 0; k < out.feet.size(); ++k) {
    std::vector<std::uint8_t> on(at(motion.frames), 0);
    bool labelled = false;
    for (const int part : out.feet[k].parts)
      for (const ContactTrack& track : motion.contacts) {
        if (track.link != m.link(part).name || track.on.size() != on.size()) continue;
        labelled = true;
        for (std::size_t f = 0; f < on.size(); ++f) on[f] = on[f] || track.on[f] ? 1 : 0;
      }
    if (labelled) out.bears[k] = std::move(on);
  }
  return out;
}

void set_labels(const Mechanism& m, const FootContacts& contacts, Motion& motion) {
  motion.contacts.clear();
  for (std::size_t k = 0; k < contacts.feet.size(); ++k) motion.contacts.push_back({m.link(contacts.feet[k].link).name, contacts.bears[k]});
}

SkateReport measure_skate(const Mechanism& m, const Motion& motion, const FootContacts& contacts) {
  SkateReport out;
  std::vector<Pose> X(at(m.link_count())), before(X.size());
  std::vector<double> path(contacts.feet.size(), 0.0);
  double sum = 0;
  for (int f = 0; f < motion.frames; ++f) {
    std::swap(X, before);
    calc_poses(m, std::span(motion.frame(f), at(motion.nq)), X);
    for (std::size_t k = 0; k < path.size(); ++k) {
      if (!contacts.bears[k][at(f)]) continue;
      if (f == 0 || !contacts.bears[k][at(f - 1)]) {
        ++out.stances;
        path[k] = 0;
        continue;
      }
      const LinkPoint* lowest = nullptr;
      double low = 1e300;
      for (const LinkPoint& p : contacts.feet[k].points) {
        const double z = (X[at(p.link)] * p.location.p).z - p.location.radius;
        if (z >= low) continue;
        low = z;
        lowest = &p;
      }
      if (!lowest) continue;
      const Pose& now = X[at(lowest->link)];
      const Vec3 p = lowest->location.p + transpose_times(now.R, Vec3{0, 0, -lowest->location.radius});
      const Vec3 d = now * p - before[at(lowest->link)] * p;
      const double step = std::sqrt(d.x * d.x + d.y * d.y);
      path[k] += step;
      sum += step;
      out.worst_cm = std::max(out.worst_cm, 100 * path[k]);
    }
  }
  out.mean_cm = out.stances > 0 ? 100 * sum / out.stances : 0;
  return out;
}

}  // namespace ugoki::motion_edit
