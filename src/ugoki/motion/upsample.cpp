#include "ugoki/motion/upsample.h"

#include <cmath>
#include <span>

namespace ugoki {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Solves for the second derivatives (per frame^2) of the cubic spline through y at the frames 0, 1, ...: M[i - 1] + 4 M[i] + M[i + 1]
/// = 6 (y[i - 1] - 2 y[i] + y[i + 1]), constant in the first and the last interval.
std::vector<double> bends(std::span<const double> y) {
  const std::size_t n = y.size();
  std::vector<double> M(n, 0.0), share(n, 0.0);
  if (n < 3) return M;
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double pivot = 4 + (i == 1 ? 1 : 0) + (i + 2 == n ? 1 : 0) - share[i - 1];
    share[i] = i + 2 == n ? 0 : 1 / pivot;
    M[i] = (6 * (y[i - 1] - 2 * y[i] + y[i + 1]) - M[i - 1]) / pivot;
  }
  for (std::size_t i = n - 2; i-- > 1;) M[i] -= share[i] * M[i + 1];
  M[0] = M[1];
  M[n - 1] = M[n - 2];
  return M;
}

/// Index of the first component of the quaternion among the coordinates of the joint; -1: none.
int quat_of(const Joint& joint) { return joint.type == JointType::spherical ? 0 : joint.type == JointType::floating ? 3 : -1; }

}  // namespace

Motion upsampled(const Motion& motion, const Mechanism& mechanism, double rate) {
  const int parts = motion.rate > 0 ? static_cast<int>(std::ceil(rate / motion.rate - 1e-9)) : 1;
  if (parts <= 1 || motion.frames < 2) return motion;
  const int around = motion.cyclic ? std::min(motion.frames - 1, 12) : 0;  // frames of the next and the previous round, whose effect decays
  const std::size_t n = at(motion.frames), nq = at(motion.nq), pad = at(around);
  std::vector<double> q = motion.q;
  for (const Link& link : mechanism.links())
    if (const int k = quat_of(link.joint); k >= 0)
      for (std::size_t f = 1; f < n; ++f) {  // of a quaternion and its negative, the one closer to the frame before
        double* r = q.data() + f * nq + at(link.q_index + k);
        const double* before = r - nq;
        if (r[0] * before[0] + r[1] * before[1] + r[2] * before[2] + r[3] * before[3] < 0)
          for (int c = 0; c < 4; ++c) r[c] = -r[c];
      }
  Motion out = motion;
  out.rate = motion.rate * parts;
  out.frames = (motion.frames - 1) * parts + 1;
  out.q.assign(at(out.frames) * nq, 0.0);
  std::vector<double> y(n + 2 * pad);
  for (std::size_t c = 0; c < nq; ++c) {
    const double turn = q[(n - 1) * nq + c] - q[c];  // of a round
    for (std::size_t i = 0; i < y.size(); ++i)
      y[i] = i < pad ? q[(n - 1 - (pad - i)) * nq + c] - turn : i < pad + n ? q[(i - pad) * nq + c] : q[(i - pad - n + 1) * nq + c] + turn;
    const std::vector<double> M = bends(y);
    for (int f = 0; f < out.frames; ++f) {
      const std::size_t i = pad + std::min(at(f / parts), n - 2);
      const double s = static_cast<double>(f) / parts - static_cast<double>(i - pad), r = 1 - s;
      out.q[at(f) * nq + c] = r * y[i] + s * y[i + 1] + (r * (r * r - 1) * M[i] + s * (s * s - 1) * M[i + 1]) / 6;
    }
  }
  for (const Link& link : mechanism.links())
    if (const int k = quat_of(link.joint); k >= 0)
      for (int f = 0; f < out.frames; ++f) {
        double* r = out.frame(f) + link.q_index + k;
        const double length = std::sqrt(r[0] * r[0] + r[1] * r[1] + r[2] * r[2] + r[3] * r[3]);
        for (int x = 0; x < 4; ++x) r[x] = f % parts == 0 ? motion.frame(f / parts)[link.q_index + k + x] : r[x] / length;
      }
  for (std::size_t t = 0; t < out.contacts.size(); ++t) {
    out.contacts[t].on.clear();
    for (int f = 0; f < out.frames; ++f) out.contacts[t].on.push_back(motion.contacts[t].on[at((f + parts / 2) / parts)]);
  }
  return out;
}

}  // namespace ugoki
