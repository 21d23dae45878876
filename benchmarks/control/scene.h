#pragma once
// A character under balance control on a level floor, for measurements of balance control.

#include <memory>
#include <string>
#include <vector>

#include "terrain.h"
#include "ugoki/base/result.h"
#include "ugoki/contact/guarded_step.h"
#include "ugoki/control/balance_control.h"
#include "ugoki/motion/smooth_motion.h"

namespace ugoki::bench {

/// A motion with its mechanism.
struct ClipFile {
  std::string name;
  MechanismPtr mechanism;
  MotionPtr motion;
};
/// Reads a BVH or AMC file, or makes a sample motion: `sample-stand`, `sample-walk`, `sample-dog-trot`, `sample-dog-stand`,
/// or `gait-SPEED`: a computed walk of the sample human for 60 s at this speed in m/s, with start and stop.
Result<ClipFile> read_clip(const std::string& path);

/// Reference motion: a motion played once, or a cyclic motion repeated.
class MotionReference final : public control::ReferenceMotion {
 public:
  MotionReference(MechanismPtr mechanism, const Motion& motion, double length);
  void sample(double t, std::span<double> q, std::span<double> v, std::span<double> a) const override;
  [[nodiscard]] double end() const override { return clip_.length; }
  [[nodiscard]] bool contacts(double t, std::span<std::uint8_t> on) const override;

 private:
  MechanismPtr mechanism_;
  SmoothMotion motion_;
  std::vector<std::pair<int, std::vector<std::uint8_t>>> contacts_;  // links with their labels in each frame; empty: not known
  Clip clip_;
};

/// A force on the chest's centre of mass.
struct Push {
  double time = 1e9, duration = 0.2;  ///< s
  Vec3 force;                         ///< N, world axes
};

/// Result of a run.
struct Outcome {
  double time = 0;  ///< s: duration of the run, or time of the fall
  bool fell = false;
  double tracking_deg = 0;                     ///< degrees, rms tracking error of the joints
  double control_us = 0, total_us = 0;         ///< us, mean processor time per tick
  double slip_worst_cm = 0, slip_mean_cm = 0;  ///< cm, net slip of a stance: maximum and mean
  double penetration_mm = 0;                   ///< mm: maximum depth of a foot below the ground
  double travel = 0;                           ///< m: horizontal distance of the root from its start
  int max_iterations = 0, unsolved = 0;        ///< maximum Newton steps of the quadratic program; ticks in which it did not converge
  std::uint64_t hash = 0;                      ///< hash of the final positions
};

struct RunSettings {
  double dt = 0.002, duration = 1e9;
  double friction = 0.9;
  bool self_collision = false;
  Terrain terrain;
  Push push;
  control::BalanceOptions control;
  bool trace = false;     ///< print the state every 0.05 s
  bool landings = false;  ///< print a line for each landing of a foot
};

/// Runs the reference from its beginning on a level floor.
Outcome run(const MechanismPtr& mechanism, const std::shared_ptr<const control::ReferenceMotion>& reference, const RunSettings& settings);

}  // namespace ugoki::bench
