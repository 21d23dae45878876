#pragma once
// Physics correction: the motion near a given one that obeys the laws of mechanics. Offline, for captures and for the keys of an animator.
// docs/design/correction.md describes the method.

#include <functional>

#include "ugoki/motion/motion.h"
#include "ugoki/spatial/vec3.h"

namespace ugoki::correction {

struct CorrectOptions {
  double strength = 1;         ///< 0: the motion is not changed; 1: complete correction; in between: the poses are interpolated
  double gravity = 9.81;       ///< m/s^2, downwards
  double friction = 0.9;       ///< Coulomb coefficient of the ground
  bool level_floor = true;     ///< find the floor on which the feet stand, and move it to z = 0
  double smoothing = 9;        ///< Hz: cut-off of the low-pass filter of all joints; 0: no filter
  bool keep_duration = false;  ///< true: flights keep their duration, even if gravity is wrong in them
  /// Called with the fraction of the work that is done, 0 to 1. The correction is cancelled if it returns false. May be empty.
  std::function<bool(double)> progress = {};
};

/// Measures of a motion without a simulation.
struct CorrectionMeasures {
  double skate_cm = 0;        ///< mean net slip of a stance (motion/foot_slip.h)
  double penetration_mm = 0;  ///< maximum depth of a shape below the floor
  double residual_bw = 0;     ///< body weights: rms of the wrench that the ground cannot supply; moments are divided by 1 m
  double flight_g = 0;        ///< rms difference between the acceleration of the centre of mass in flights and gravity, in multiples of g
  double spin = 0;            ///< rms deviation of the angular momentum from its mean in a flight, divided by mass times 1 m^2/s
  double jerk = 0;            ///< rms angular jerk of the joints, 1000 rad/s^3
  double limit_deg = 0;       ///< maximum excess of a rotational joint limit, degrees
};

struct CorrectionReport {
  CorrectionMeasures before, after;
  int replaced_frames = 0;     ///< popping frames of joints, which were interpolated
  double floor_height = 0;     ///< m: height of the floor that was found, at its centre
  double floor_tilt = 0;       ///< degrees
  double travel = 0;           ///< m/s: speed that a walk in place was given, so that its standing feet rest; not part of root_move_cm
  int flights = 0;             ///< number of flights
  double duration_change = 0;  ///< s: time that wrong gravity in flights added or removed
  double change_deg = 0;       ///< rms rotation of the joints from the original motion at equal phase, degrees
  double root_move_cm = 0;     ///< rms displacement of the root, without the displacement of the floor, cm
};

/// Corrects a motion. Errors: the motion does not fit the mechanism; the root is not floating; no feet; fewer than 5 frames; options out of
/// range; cancelled.
[[nodiscard]] Result<Motion> correct_motion(const Mechanism& mechanism, const Motion& motion, const CorrectOptions& options = {},
                                            CorrectionReport* report = nullptr);

}  // namespace ugoki::correction
