#include "ugoki/motion/torques.h"

#include <memory>
#include <span>
#include <utility>

#include "ugoki/base/hash.h"
#include "ugoki/mechanism/state.h"

namespace ugoki {

std::uint64_t path_hash(const Motion& motion) {
  Hash64 hash;
  hash.add(std::span<const double>(&motion.rate, 1));
  hash.add(std::span<const double>(motion.q));
  return hash.value();
}

void mark_computed(Motion& motion) {
  auto record = std::make_shared<MotionTorques>();
  record->path = path_hash(motion);
  motion.torques = std::move(record);
}

bool is_computed(const Motion& motion) {
  return motion.torques && motion.torques->tau.empty() && motion.torques->path == path_hash(motion);
}

const MotionTorques* torques_of(const Motion& motion) {
  return motion.torques && !motion.torques->tau.empty() && motion.torques->path == path_hash(motion) ? motion.torques.get() : nullptr;
}

Error check_torques(const Motion& motion, const Mechanism& mechanism) {
  Error errors;
  if (!motion.torques || motion.torques->tau.empty()) return errors;
  const MotionTorques& t = *motion.torques;
  const std::string location = "motion " + motion.name;
  const auto nv = static_cast<std::size_t>(mechanism.nv());
  if (t.q0.size() != static_cast<std::size_t>(mechanism.nq()) || t.v0.size() != nv || t.tau.empty() || t.tau.size() % nv != 0)
    errors.add(
        ErrorCode::structure, location,
        "The torques or the first state of the motion do not have the number of degrees of freedom of mechanism " + mechanism.name() + ".",
        "Convert the motion to torques again.");
  if (!(t.step >= 1e-4 && t.step <= 0.1))
    errors.add(ErrorCode::range, location, "The step of the motion's torques is not between 0.0001 and 0.1 s.",
               "Convert the motion to torques again.");
  if (!is_finite(t.q0) || !is_finite(t.v0) || !is_finite(t.tau))
    errors.add(ErrorCode::range, location, "A torque, or a value of the first state, is not finite.",
               "Convert the motion to torques again.");
  return errors;
}

}  // namespace ugoki
