#include "ugoki/motion/smooth_motion.h"

#include <algorithm>
#include <cmath>

#include "ugoki/mechanism/state.h"
#include "ugoki/motion/butterworth.h"

namespace ugoki {
namespace {

void normalize_quat(double* r) {
  const double n = std::sqrt(r[0] * r[0] + r[1] * r[1] + r[2] * r[2] + r[3] * r[3]);
  for (int k = 0; k < 4; ++k) r[k] /= n;
}

/// Index of the quaternion's first component in the coordinates of the joint; -1: no quaternion.
int quat_of(const Joint& joint) { return joint.type == JointType::spherical ? 0 : joint.type == JointType::floating ? 3 : -1; }

}  // namespace

SmoothMotion::SmoothMotion(const Motion& motion, const Mechanism& m, double cutoff)
    : SmoothMotion(motion, m, std::vector<double>(static_cast<std::size_t>(m.link_count()), cutoff)) {}

SmoothMotion::SmoothMotion(const Motion& motion, const Mechanism& m, std::span<const double> cutoffs)
    : rate_(motion.rate),
      frames_(motion.frames),
      nq_(static_cast<std::size_t>(m.nq())),
      nv_(static_cast<std::size_t>(m.nv())),
      q_(motion.q) {
  const auto n = static_cast<std::size_t>(frames_);
  // A quaternion and its negative are the same rotation; the filter needs the sign for which it is closer to the previous one.
  for (const Link& link : m.links()) {
    const int at = quat_of(link.joint);
    if (at < 0) continue;
    for (std::size_t f = 1; f < n; ++f) {
      const double* before = q_.data() + (f - 1) * nq_ + static_cast<std::size_t>(link.q_index + at);
      double* r = q_.data() + f * nq_ + static_cast<std::size_t>(link.q_index + at);
      if (r[0] * before[0] + r[1] * before[1] + r[2] * before[2] + r[3] * before[3] < 0)
        for (int k = 0; k < 4; ++k) r[k] = -r[k];
    }
  }
  for (std::size_t l = 0; l < cutoffs.size(); ++l) {
    const double cutoff = cutoffs[l];
    if (!(cutoff > 0 && cutoff < rate_ / 3) || frames_ < 4) continue;
    const Link& link = m.links()[l];
    const std::size_t pad = std::min(n - 1, static_cast<std::size_t>(2 * rate_ / cutoff) + 1);
    std::vector<double> row(n + 2 * pad);
    for (int k = 0; k < link.joint.nq(); ++k) {
      const auto c = static_cast<std::size_t>(link.q_index + k);
      const double first = q_[c], last = q_[(n - 1) * nq_ + c];
      for (std::size_t i = 0; i < row.size(); ++i) {
        if (i < pad)
          row[i] = motion.cyclic ? q_[(n - 1 - (pad - i)) * nq_ + c] - (last - first) : 2 * first - q_[(pad - i) * nq_ + c];
        else if (i < pad + n)
          row[i] = q_[(i - pad) * nq_ + c];
        else
          row[i] = motion.cyclic ? q_[(i - pad - n + 1) * nq_ + c] + (last - first) : 2 * last - q_[(2 * n - 2 - (i - pad)) * nq_ + c];
      }
      filter_both_ways(row, rate_, cutoff);
      for (std::size_t f = 0; f < n; ++f) q_[f * nq_ + c] = row[f + pad];
    }
    if (const int at = quat_of(link.joint); at >= 0)
      for (std::size_t f = 0; f < n; ++f) normalize_quat(q_.data() + f * nq_ + static_cast<std::size_t>(link.q_index + at));
  }

  v_.assign(n * nv_, 0.0);
  a_.assign(n * nv_, 0.0);
  step_.assign(n * nv_, 0.0);
  if (frames_ < 2) return;
  const auto frame = [&](std::size_t f) { return std::span<const double>(q_.data() + f * nq_, nq_); };
  std::vector<double> step((n - 1) * nv_);  // [frames - 1][nv] mean velocity between the frames f and f + 1
  for (std::size_t f = 0; f + 1 < n; ++f) {
    const std::span<double> d(step.data() + f * nv_, nv_);
    difference(m, frame(f), frame(f + 1), d);
    std::ranges::copy(d, step_.begin() + static_cast<std::ptrdiff_t>(f * nv_));
    for (double& x : d) x *= rate_;
  }
  for (std::size_t f = 0; f < n; ++f) {
    const bool has_before = f > 0 || motion.cyclic, has_after = f + 1 < n || motion.cyclic;
    const double* before = step.data() + (f > 0 ? f - 1 : n - 2) * nv_;
    const double* after = step.data() + (f + 1 < n ? f : 0) * nv_;
    for (std::size_t k = 0; k < nv_; ++k) {
      v_[f * nv_ + k] = has_before && has_after ? 0.5 * (before[k] + after[k]) : has_after ? after[k] : before[k];
      a_[f * nv_ + k] = has_before && has_after ? (after[k] - before[k]) * rate_ : 0.0;
    }
  }
}

void SmoothMotion::sample(const Mechanism& m, double t, std::span<double> q, std::span<double> v, std::span<double> a) const {
  const double x = std::clamp(t * rate_, 0.0, static_cast<double>(frames_ - 1));
  const auto i = static_cast<std::size_t>(std::min(static_cast<int>(x), std::max(0, frames_ - 2)));
  const std::size_t j = std::min(i + 1, static_cast<std::size_t>(frames_ - 1));
  const double* const step = step_.data() + i * nv_;  // displacement from frame i to frame j
  const double s = x - static_cast<double>(i), dt = 1 / rate_;
  const bool inside = t >= 0 && t <= duration();
  const double* q0 = q_.data() + i * nq_;
  const double* v0 = v_.data() + i * nv_;
  const double* v1 = v_.data() + j * nv_;
  const double* a0 = a_.data() + i * nv_;
  const double* a1 = a_.data() + j * nv_;
  // Cubic Hermite interpolation of the displacement from frame i.
  const double h01 = s * s * (3 - 2 * s), h10 = s * (1 - s) * (1 - s), h11 = s * s * (s - 1);
  const double d01 = 6 * s * (1 - s), d10 = (1 - s) * (1 - 3 * s), d11 = s * (3 * s - 2);
  // v holds the displacement from frame i to time t until the joints are moved by it.
  for (std::size_t f = 0; f < nv_; ++f) v[f] = h01 * step[f] + dt * (h10 * v0[f] + h11 * v1[f]);
  for (const LinkPlace& link : m.places())
    if (link.nv > 0) joint_integrate(link.type, q0 + link.q_index, v.data() + link.v_index, 1.0, q.data() + link.q_index);
  for (std::size_t f = 0; f < nv_; ++f) {
    v[f] = inside ? d01 * step[f] * rate_ + d10 * v0[f] + d11 * v1[f] : 0.0;
    a[f] = inside ? (1 - s) * a0[f] + s * a1[f] : 0.0;
  }
}

void sample(const Clip& clip, const SmoothMotion& motion, const Mechanism& m, double t, std::span<double> q, std::span<double> v,
            std::span<double> a) {
  const ClipPhase phase = phase_of(clip, motion.duration(), t);
  motion.sample(m, phase.time, q, v, a);
  const Placement location = placement_in(clip, phase.rounds);
  displace_root(m, location, q);
  const bool playing = t >= clip.start && t <= clip.end();
  const double speed = playing ? clip.speed : 0;
  for (double& x : v) x *= speed;
  for (double& x : a) x *= speed * speed;
  const Joint& root = m.link(0).joint;
  const int linear = root.type == JointType::floating ? 3 : root.type == JointType::planar ? 0 : -1;
  if (linear < 0) return;
  // The root's linear velocity and acceleration are in the axes of its joint frame; the clip's heading is about the world's Z.
  const Mat3 R = root.X_PJ.R.transposed() * (rotation_about({0, 0, 1}, location.heading) * root.X_PJ.R);
  for (const std::span<double> x : {v, a}) {
    double* p = x.data() + m.link(0).v_index + linear;
    const Vec3 turned = R * Vec3{p[0], p[1], root.type == JointType::floating ? p[2] : 0.0};
    p[0] = turned.x;
    p[1] = turned.y;
    if (root.type == JointType::floating) p[2] = turned.z;
  }
}

}  // namespace ugoki
