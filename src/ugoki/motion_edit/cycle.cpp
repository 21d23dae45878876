#include "ugoki/motion_edit/cycle.h"

#include <algorithm>
#include <cmath>

#include "ugoki/base/number.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/motion_edit/rounds.h"

namespace ugoki::motion_edit {
namespace {

constexpr double speed_time = 0.1;  // s: in the comparison of frames, a velocity difference counts as the distance covered in this time

std::size_t at(int i) { return static_cast<std::size_t>(i); }

std::string place_of(const Motion& motion) { return "motion " + motion.name; }

/// Velocity [nv] (rad/s or m/s) at frame f, by central differences; one-sided at the first and last frame.
std::vector<double> velocity(const Mechanism& m, const Motion& motion, int f) {
  const int before = std::max(0, f - 1), after = std::min(motion.frames - 1, f + 1);
  std::vector<double> v(at(m.nv()), 0.0);
  if (after == before) return v;
  difference(m, {motion.frame(before), at(m.nq())}, {motion.frame(after), at(m.nq())}, v);
  for (double& x : v) x *= motion.rate / (after - before);
  return v;
}

/// Difference between frames: joint coordinates, height and tilt of the root, velocities. Position and heading on the floor are ignored.
class FrameDifference {
 public:
  FrameDifference(const Mechanism& m, const Motion& motion) : m_(m) {
    const auto nq = at(m.nq());
    for (int f = 0; f < motion.frames; ++f) {
      std::vector<double> q(motion.frame(f), motion.frame(f) + nq), v = velocity(m, motion, f);
      Placement root = root_placement(m, q);
      root.z = 0;
      displace_root(m, inverse(root), q);
      if (m.link(0).joint.type == JointType::floating) {  // linear velocity of the root relative to its heading
        const Mat3 R = m.link(0).joint.X_PJ.R.transposed() * (rotation_about({0, 0, 1}, -root.heading) * m.link(0).joint.X_PJ.R);
        const Vec3 p = R * Vec3{v[3], v[4], v[5]};
        for (int k = 0; k < 3; ++k) v[at(3 + k)] = p[k];
      }
      q_.push_back(std::move(q));
      v_.push_back(std::move(v));
    }
  }

  /// Mean over the DOFs of the squared difference [rad^2] between frames i and j; 1 m counts as 1 rad.
  [[nodiscard]] double operator()(int i, int j) const {
    std::vector<double> d(at(m_.nv()));
    difference(m_, q_[at(i)], q_[at(j)], d);
    double sum = 0;
    for (std::size_t k = 0; k < d.size(); ++k) {
      const double dv = (v_[at(j)][k] - v_[at(i)][k]) * speed_time;
      sum += d[k] * d[k] + dv * dv;
    }
    return sum / std::max<double>(1, static_cast<double>(d.size()));
  }

 private:
  const Mechanism& m_;
  std::vector<std::vector<double>> q_, v_;
};

/// Finds the strides: frame ranges from one touch-down of a foot to its next in which each other foot lands exactly once. Feet that never
/// land are ignored.
std::vector<Stance> find_strides(const FootContacts& contacts) {
  std::vector<std::vector<int>> landings;
  for (std::size_t k = 0; k < contacts.feet.size(); ++k) {
    landings.emplace_back();
    for (const Stance& s : contacts.stances(k))
      if (s.first > 0) landings.back().push_back(s.first);
  }
  for (const std::vector<int>& own : landings) {
    std::vector<Stance> strides;
    for (std::size_t i = 1; i < own.size(); ++i) {
      const bool whole = std::all_of(landings.begin(), landings.end(), [&](const std::vector<int>& other) {
        const auto count = std::count_if(other.begin(), other.end(), [&](int f) { return f >= own[i - 1] && f < own[i]; });
        return other.empty() || count == 1;
      });
      if (whole) strides.push_back({own[i - 1], own[i]});
    }
    if (!strides.empty()) return strides;  // always the first foot with a stride, so that similar motions are cut at the same foot
  }
  return {};
}

}  // namespace

Result<Stance> find_cycle(const Mechanism& m, const Motion& motion, const FootContacts& contacts, const CycleOptions& o,
                          CycleReport* report) {
  const int minimum = std::max(2, static_cast<int>(o.shortest * motion.rate)), maximum = static_cast<int>(o.longest * motion.rate);
  if (motion.frames <= minimum)
    return fail(
        ErrorCode::structure, place_of(motion),
        "The motion has " + std::to_string(motion.frames) + " frames; the shortest cycle needs " + std::to_string(minimum + 1) + ".",
        "Use a motion with at least two steps of each foot.");
  const FrameDifference frame_difference(m, motion);
  Stance best{-1, -1};
  double min_cost = 1e300;
  const auto consider = [&](const Stance& s) {
    if (s.last - s.first < minimum || s.last - s.first > maximum) return;
    if (const double cost = frame_difference(s.first, s.last); cost < min_cost) {
      min_cost = cost;
      best = s;
    }
  };
  for (const Stance& s : find_strides(contacts)) consider(s);
  const bool by_contacts = best.first >= 0;
  if (!by_contacts) {
    // Compare every frame with every later frame, first in steps of a tenth of the shortest cycle, then frame by frame around the best
    // pair.
    const int step = std::max(1, minimum / 10);
    for (int i = 0; i < motion.frames; i += step)
      for (int j = i + minimum; j < motion.frames && j - i <= maximum; j += step) consider({i, j});
    if (best.first >= 0) {
      const Stance coarse = best;
      for (int i = std::max(0, coarse.first - step); i <= coarse.first + step; ++i)
        for (int j = coarse.last - step; j <= std::min(motion.frames - 1, coarse.last + step); ++j) consider({i, j});
    }
  }
  if (best.first < 0)
    return fail(ErrorCode::structure, place_of(motion),
                "No cycle between " + to_text(o.shortest) + " s and " + to_text(o.longest) + " s long was found.",
                "Specify the first and last frame of the cycle.");
  if (report) {
    report->seam = std::sqrt(min_cost);
    report->by_contacts = by_contacts;
  }
  return best;
}

namespace {

/// Moves the motion vertically so that its feet stand on the ground, unless the displacement would exceed CycleOptions::level.
/// @param raised [out] upward displacement, m
Motion levelled(const Mechanism& m, const Motion& motion, std::span<const FootLimb> feet, const CycleOptions& o, double& raised) {
  Motion out = motion;
  if (feet.empty() || o.contacts.find_ground) return out;
  const double off = o.contacts.ground - find_ground(m, motion, feet);
  if (std::fabs(off) > o.level * mean_leg_length(feet) / 0.9) return out;
  raised = off;
  for (int f = 0; f < out.frames; ++f) displace_root(m, {0, 0, off, 0}, {out.frame(f), at(out.nq)});
  return out;
}

}  // namespace

Result<Motion> make_cyclic(const Mechanism& m, const Motion& source, const CycleOptions& o, CycleReport* report) {
  if (Error wrong = check_motion(source, m); !wrong.empty()) return fail(std::move(wrong));
  if (m.nv() == 0)
    return fail(ErrorCode::structure, "mechanism " + m.name(), "The mechanism has no movable joint.", "Use a mechanism with joints.");
  CycleReport reported;
  std::vector<FootLimb> feet = find_foot_limbs(m);
  const Motion motion = levelled(m, source, feet, o, reported.raised);
  Motion out = motion;
  if (!motion.cyclic) {
    Stance cycle{o.first, o.last};
    if (o.first < 0 || o.last < 0) {
      Result<Stance> found = find_cycle(m, motion, find_contacts(m, motion, feet, o.contacts), o, &reported);
      if (!found) return fail(std::move(found.error()));
      cycle = *found;
    }
    if (cycle.last >= motion.frames || cycle.last - cycle.first < 2)
      return fail(ErrorCode::range, place_of(motion),
                  "Frames " + std::to_string(cycle.first) + " to " + std::to_string(cycle.last) + " are not a cycle of the motion of " +
                      std::to_string(motion.frames) + " frames.",
                  "Specify two frames of the motion, at least two apart.");
    reported.first = cycle.first;
    reported.last = cycle.last;
    const int n = cycle.last - cycle.first;
    const auto nq = at(m.nq()), nv = at(m.nv());
    out.frames = n + 1;
    out.q.assign(motion.frame(cycle.first), motion.frame(cycle.last) + nq);
    out.contacts.clear();
    out.cyclic = true;
    const Placement way = cycle_of(out, m);
    std::vector<double> end(out.frame(n), out.frame(n) + nq), gap(nv), jump(nv), part(nv);
    displace_root(m, inverse(way), end);
    difference(m, end, {out.frame(0), nq}, gap);  // gap = displacement from the last to the first frame
    const std::vector<double> v0 = velocity(m, motion, cycle.first);
    std::vector<double> v1 = velocity(m, motion, cycle.last);
    if (m.link(0).joint.type == JointType::floating) {
      const Mat3& J = m.link(0).joint.X_PJ.R;
      const Vec3 p = transpose_times(J, rotation_about({0, 0, 1}, -way.heading) * (J * Vec3{v1[3], v1[4], v1[5]}));
      for (int k = 0; k < 3; ++k) v1[at(3 + k)] = p[k];
    }
    for (std::size_t k = 0; k < nv; ++k) jump[k] = v1[k] - v0[k];
    const double near = std::min(o.ease * motion.rate, 0.5 * n);
    for (int f = 0; f <= n; ++f) {
      const double s = static_cast<double>(f) / n - 0.5, left = n - f;
      const double in = f < near ? f * (1 - f / near) * (1 - f / near) : 0,
                   away = left < near ? left * (1 - left / near) * (1 - left / near) : 0;
      for (std::size_t k = 0; k < nv; ++k) part[k] = s * gap[k] + 0.5 * jump[k] / motion.rate * (in + away);
      if (m.link(0).joint.type ==
          JointType::floating) {  // express the linear part in the world: the character's heading changes during the cycle
        const Mat3& J = m.link(0).joint.X_PJ.R;
        const Mat3 turn = rotation_about({0, 0, 1}, way.heading * (static_cast<double>(f) / n));
        const Vec3 p = transpose_times(J, turn * (J * Vec3{part[3], part[4], part[5]}));
        for (int k = 0; k < 3; ++k) part[at(3 + k)] = p[k];
      }
      integrate(m, {out.frame(f), nq}, part, 1.0, {out.frame(f), nq});
    }
    std::copy(out.frame(0), out.frame(0) + nq, out.frame(n));
    displace_root(m, way, {out.frame(n), nq});
  }
  FootContacts contacts = find_contacts(m, out, std::move(feet), o.contacts);
  set_labels(m, contacts, out);
  if (o.lock_feet && !contacts.feet.empty()) {
    Result<Motion> locked = lock_feet(m, out, contacts, o.lock, &reported.feet);
    if (!locked) return fail(std::move(locked.error()));
    out = std::move(*locked);
  }
  if (report) *report = reported;
  return out;
}

}  // namespace ugoki::motion_edit
