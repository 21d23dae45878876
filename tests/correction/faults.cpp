#include "faults.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "ugoki/mechanism/state.h"
#include "ugoki/motion/clip.h"
#include "ugoki/motion_edit/edit.h"
#include "ugoki/motion_edit/foot_contacts.h"

namespace ugoki::correction {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

void raise(const Mechanism& m, Motion& motion, int f, const Vec3& by) {
  displace_root(m, {by.x, by.y, by.z, 0}, {motion.frame(f), at(motion.nq)});
}

/// 1 in the middle of the motion, 0 at its ends, with smooth flanks of 0.2 s.
double middle(const Motion& m, int f) {
  const double t = f / m.rate, from = 0.3 * m.duration(), to = 0.7 * m.duration();
  const double s = std::clamp(std::min(t - from, to - t) / 0.2 + 0.5, 0.0, 1.0);
  return s * s * (3 - 2 * s);
}

Motion floating(const Mechanism& m, const Motion& clean) {
  Motion out = clean;
  for (int f = 0; f < out.frames; ++f) raise(m, out, f, {0, 0, 0.05 * middle(out, f)});
  return out;
}

Motion penetrating(const Mechanism& m, const Motion& clean) {
  Motion out = clean;
  for (int f = 0; f < out.frames; ++f) raise(m, out, f, {0, 0, -0.06 * middle(out, f)});
  return out;
}

Motion sliding(const Mechanism& m, const Motion& clean) {
  Motion out = clean;
  for (int f = 0; f < out.frames; ++f)
    raise(m, out, f, {0.15 * (clean.frame(f)[0] - clean.frame(0)[0]), 0.15 * (clean.frame(f)[1] - clean.frame(0)[1]), 0});
  return out;
}

/// Compresses the time of flights so that the body falls with 1.5 g.
Motion heavy(const Mechanism& m, const Motion& clean) {
  const motion_edit::FootContacts contacts = motion_edit::find_contacts(m, clean);
  std::vector<motion_edit::TimePoint> points;
  double time = 0;
  for (int f = 0; f < clean.frames; ++f) {
    points.push_back({time, f / clean.rate});
    const bool flies = std::ranges::none_of(contacts.bears, [&](const auto& on) { return on[at(f)] != 0; });
    time += (flies ? 1 / std::sqrt(1.5) : 1.0) / clean.rate;
  }
  points.back().source = clean.duration();
  return motion_edit::time_warp(m, clean, points).value();
}

/// Keys every 0.1 s with random errors of 1.5 degrees, joined by straight lines.
Motion jerky(const Mechanism& m, const Motion& clean) {
  Motion keys = clean;
  std::mt19937 random(1);
  std::vector<double> error(at(m.nv()));
  for (int f = 0; f < keys.frames; ++f) {
    for (std::size_t i = 0; i < error.size(); ++i) error[i] = i < 6 ? 0 : (static_cast<double>(random() % 2001) / 1000 - 1) * 0.026;
    integrate(m, {clean.frame(f), at(keys.nq)}, error, 1, {keys.frame(f), at(keys.nq)});
  }
  Motion out = keys;
  const int every = std::max(1, static_cast<int>(0.1 * out.rate + 0.5));
  for (int f = 0; f < out.frames; ++f) {
    const int a = f / every * every, b = std::min(a + every, out.frames - 1);
    interpolate(m, {keys.frame(a), at(out.nq)}, {keys.frame(b), at(out.nq)}, b > a ? static_cast<double>(f - a) / (b - a) : 0,
                {out.frame(f), at(out.nq)});
  }
  return out;
}

/// The floor is 12 cm too high and rises by 3 degrees in the direction of the motion.
Motion tilted(const Mechanism& m, const Motion& clean) {
  Motion out = clean;
  const double* last = out.frame(out.frames - 1);
  Vec3 way{last[0] - out.q[0], last[1] - out.q[1], 0};
  const Vec3 axis = norm(way) > 0.1 ? normalized(cross(normalized(way), {0, 0, 1})) : Vec3{0, 1, 0};
  const Mat3 R = rotation_about(axis, norm(way) > 1.5 ? 3 * pi / 180 : 0.0);
  for (int f = 0; f < out.frames; ++f) {
    double* q = out.frame(f);
    const Pose X = Pose{R, {0, 0, 0.12}} * joint_pose(m.link(0).joint, q);
    const Quat r = to_quat(X.R);
    const double values[7] = {X.p.x, X.p.y, X.p.z, r.w, r.x, r.y, r.z};
    std::copy(values, values + 7, q);
  }
  return out;
}

/// Made for a body of 0.93 times the size: the root is too low and moves too little.
Motion scaled(const Mechanism& m, const Motion& clean) {
  Motion out = clean;
  for (int f = 0; f < out.frames; ++f) {
    const double* q = clean.frame(f);
    raise(m, out, f, {-0.07 * (q[0] - clean.q[0]), -0.07 * (q[1] - clean.q[1]), -0.07 * q[2]});
  }
  return out;
}

Motion popping(const Mechanism& m, const Motion& clean) {
  Motion out = clean;
  int which = 0;
  for (int f = 20; f + 3 < out.frames; f += out.frames / 7) {
    std::vector<double> jump(at(m.nv()), 0.0);
    if (which % 3 == 0) jump[5] = 0.06;  // m: the root
    for (int i = 0; i < m.link_count(); ++i)
      if (i % 3 == which % 3 && i > 0 && m.link(i).joint.nv() > 0) jump[at(m.link(i).v_index)] = 0.4;
    for (int k = 0; k <= which % 2; ++k) integrate(m, {clean.frame(f + k), at(out.nq)}, jump, 1, {out.frame(f + k), at(out.nq)});
    ++which;
  }
  return out;
}

Motion drifting(const Mechanism& m, const Motion& clean) {
  Motion out = clean;
  for (int f = 0; f < out.frames; ++f) raise(m, out, f, Vec3{0.05, 0.06, 0} * (f / out.rate));
  return out;
}

/// One leg is 0.05 s late.
Motion mistimed(const Mechanism& m, const Motion& clean) {
  Motion out = clean;
  const std::vector<motion_edit::FootLimb> feet = motion_edit::find_foot_limbs(m);
  if (feet.empty()) return out;
  std::vector<int> links = feet.front().chain;
  links.insert(links.end(), feet.front().parts.begin(), feet.front().parts.end());
  const int late = static_cast<int>(0.05 * out.rate);
  for (int f = late; f < out.frames; ++f)
    for (const int i : links) {
      const Link& link = m.link(i);
      std::copy(clean.frame(f - late) + link.q_index, clean.frame(f - late) + link.q_index + link.joint.nq(), out.frame(f) + link.q_index);
    }
  return out;
}

}  // namespace

const std::vector<Fault>& faults() {
  static const std::vector<Fault> all = {{"floating", floating}, {"sliding", sliding},  {"gravity", heavy},           {"jerky", jerky},
                                         {"floor", tilted},      {"limbs", scaled},     {"penetrating", penetrating}, {"popping", popping},
                                         {"drifting", drifting}, {"mistimed", mistimed}};
  return all;
}

}  // namespace ugoki::correction
