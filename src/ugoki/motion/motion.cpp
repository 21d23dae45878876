#include "ugoki/motion/motion.h"

#include <algorithm>
#include <cmath>

#include "ugoki/mechanism/state.h"
#include "ugoki/motion/torques.h"

namespace ugoki {

Error check_motion(const Motion& motion, const Mechanism& mechanism) {
  Error errors;
  const std::string location = "motion " + motion.name;
  if (motion.nq != mechanism.nq()) {
    errors.add(ErrorCode::structure, location,
               "The motion has " + std::to_string(motion.nq) + " coordinates, but mechanism " + mechanism.name() + " has " +
                   std::to_string(mechanism.nq()) + ".",
               "Use the motion with the mechanism for which it was made (" + motion.mechanism + ").");
    return errors;
  }
  if (motion.frames < 1 || motion.q.size() != static_cast<std::size_t>(motion.frames) * static_cast<std::size_t>(motion.nq))
    errors.add(ErrorCode::structure, location, "The motion has no frames, or its number of values is not frames times coordinates.",
               "Import the motion again.");
  if (!(motion.rate > 0) || !std::isfinite(motion.rate))
    errors.add(ErrorCode::range, location, "The motion's frame rate is not above 0.", "Import the motion again.");
  if (!errors.empty()) return errors;
  for (int f = 0; f < motion.frames; ++f) {
    const double* q = motion.frame(f);
    if (!is_finite(std::span(q, static_cast<std::size_t>(motion.nq)))) {
      errors.add(ErrorCode::range, location + ", frame " + std::to_string(f), "A value is not finite.", "Import the motion again.");
      return errors;
    }
    for (const Link& link : mechanism.links()) {
      const int at = link.joint.type == JointType::spherical ? 0 : link.joint.type == JointType::floating ? 3 : -1;
      if (at < 0) continue;
      const double* r = q + link.q_index + at;
      if (std::fabs(r[0] * r[0] + r[1] * r[1] + r[2] * r[2] + r[3] * r[3] - 1) > 1e-6) {
        errors.add(ErrorCode::range, location + ", frame " + std::to_string(f),
                   "The quaternion of link " + link.name + " is not of unit length.", "Import the motion again.");
        return errors;
      }
    }
  }
  for (const ContactTrack& c : motion.contacts) {
    if (mechanism.find_link(c.link) < 0)
      errors.add(ErrorCode::unknown, location, "The motion has contact labels of link '" + c.link + "', which does not exist.",
                 "Label the contacts again.");
    if (c.on.size() != static_cast<std::size_t>(motion.frames))
      errors.add(ErrorCode::structure, location, "The number of contact labels of link '" + c.link + "' differs from the number of frames.",
                 "Label the contacts again.");
  }
  for (Problem& p : check_torques(motion, mechanism).problems) errors.problems.push_back(std::move(p));
  return errors;
}

void sample(const Motion& motion, const Mechanism& mechanism, double t, std::span<double> q) {
  const double x = std::clamp(t * motion.rate, 0.0, static_cast<double>(motion.frames - 1));
  const int i = std::min(static_cast<int>(x), std::max(0, motion.frames - 2));
  const int j = std::min(i + 1, motion.frames - 1);
  const auto n = static_cast<std::size_t>(motion.nq);
  interpolate(mechanism, std::span(motion.frame(i), n), std::span(motion.frame(j), n), x - i, q);
}

}  // namespace ugoki
