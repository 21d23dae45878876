#pragma once
// Displacement of the centre of mass of a reference motion, with which its centre of pressure stays on the standing feet.

#include <span>
#include <vector>

#include "ugoki/control/balance_types.h"
#include "ugoki/control/foot_schedule.h"

namespace ugoki::control {

/// The centre of pressure p of a measured motion is partly outside its standing feet: accelerations are filtered, masses are estimates, and
/// contacts are detected. A character that follows it cannot move its pressure there, and the error of its divergent component of motion
/// grows with exp(w0 t) until the next foot lands. This class moves the centre of mass by d(t), so that the pressure that it needs is the
/// point s(t) of the support that is closest to p:
///   d'' = w^2 (d - (s - p)),  w^2 = (g + c''_z) / c_z
/// Of all solutions, the one that does not diverge begins before the pressure leaves the support: the character leans in advance. The
/// equation is a tridiagonal system over all frames. Source: Kajita et al. (2003), preview of the centre of pressure.
class FeasibleCentre {
 public:
  /// @param floor m: height of the floor of the reference @param rate Hz, of the frames. O(duration)
  FeasibleCentre(const Mechanism& mechanism, std::span<const Foot> feet, const FootSchedule& schedule, const ReferenceMotion& motion,
                 const BalanceOptions& options, double floor, double rate = 120);

  /// m, m/s, m/s^2: horizontal displacement in the axes of the reference, and its derivatives.
  struct Shift {
    Vec3 position, velocity, acceleration;
  };
  [[nodiscard]] Shift at(double t) const;

 private:
  std::vector<Vec3> position_, acceleration_;  // [frames]
  double rate_;
};

}  // namespace ugoki::control
