#pragma once
// Tasks of balance control: the equations of the quadratic program that describe the wanted motion.

#include <span>
#include <vector>

#include "ugoki/control/balance_model.h"
#include "ugoki/control/ground_support.h"
#include "ugoki/control/hang_plan.h"
#include "ugoki/control/leg_posture.h"
#include "ugoki/control/quadratic_program.h"

namespace ugoki::control {

/// Adds the tasks of one tick to a quadratic program.
class BalanceTasks {
 public:
  explicit BalanceTasks(const BalanceModel& model);
  /// Maximum number of equations that the tasks of a character add.
  [[nodiscard]] static int max_equations(const BalanceModel& model);

  /// Posture: weights and centre of the program. Joints follow the reference with adapted legs by stable PD.
  void add_posture(const BalanceModel& model, const LegPosture& legs, const BalanceInput& input, const BalanceState& state,
                   QuadraticProgram& program);
  /// Acceleration of the centre of mass and rate of the angular momentum. @param acceleration m/s^2, world: wanted, of the centre of mass
  void add_momentum(BalanceModel& model, const Vec3& acceleration, QuadraticProgram& program);
  /// Before a release: the angular momentum with which the body comes to its landing posture. Call after add_posture().
  void add_release(BalanceModel& model, const ReleasePlan& release, QuadraticProgram& program);
  /// Orientation of the trunk, constraints of standing feet and of grips, motion of swing feet.
  void add_links(const BalanceModel& model, const GroundSupport& support, const BalanceInput& input, const BalanceState& state,
                 QuadraticProgram& program);

 private:
  std::vector<double> error_;  // [nv]
  std::vector<Vec6> A_G_;      // [nv]
};

}  // namespace ugoki::control
