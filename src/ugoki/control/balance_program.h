#pragma once
// The quadratic program of balance control with the equations of motion and the limits, and the torques of its solution.

#include <span>
#include <vector>

#include "ugoki/control/balance_model.h"
#include "ugoki/control/balance_tasks.h"
#include "ugoki/control/ground_support.h"
#include "ugoki/control/quadratic_program.h"

namespace ugoki::control {

/// Finds accelerations, contact forces and drive torques of one tick.
class BalanceProgram {
 public:
  explicit BalanceProgram(const BalanceModel& model);
  /// Solves the program of one tick. @param acceleration m/s^2, world: wanted acceleration of the centre of mass
  /// @param release release that a hanging body prepares @param tau [nv, out] N | N m, zero for the root @param out receives iterations,
  /// residual, limits, solved
  void solve(BalanceModel& model, const GroundSupport& support, const BalanceInput& input, const Vec3& acceleration,
             const ReleasePlan& release, BalanceState& state, std::span<double> tau, BalanceOutput& out);
  /// [nv] accelerations of the last solution.
  [[nodiscard]] std::span<const double> accelerations() const { return accelerations_; }

 private:
  /// Unknown force on a link: an edge of a friction pyramid, or one direction of the force or moment of a grip.
  struct Load {
    int link;
    int point;             // loads of one point have the same number
    Vec3 p;                // m, world
    Vec3 force, moment{};  // N, N m, world: for a unit load
  };
  void collect_loads(const BalanceModel& model, const GroundSupport& support, const BalanceInput& input);
  /// Force per unit load k on DOF i.
  [[nodiscard]] double load_on(const BalanceModel& model, std::size_t i, std::size_t k) const;
  void add_root_equations(BalanceModel& model);
  /// Adds the torque limits that the solution exceeds. @return number of limits added
  std::size_t add_torque_limits(const BalanceModel& model, const BalanceInput& input, std::span<const double> tau);
  /// Adds the position limits of joints that the solution would exceed. @return number of limits added
  std::size_t add_joint_limits(const BalanceModel& model, const BalanceInput& input);
  /// Adds the carried masses to the inertia matrix and to the bias forces.
  void add_carried(BalanceModel& model);
  void find_torques(BalanceModel& model, const BalanceInput& input, std::span<double> tau);

  QuadraticProgram program_;
  LegPosture legs_;
  BalanceTasks tasks_;
  std::vector<Load> loads_;
  std::vector<double> accelerations_, bias_, displacement_;
  std::vector<int> limited_;  // DOFs whose torque limit is a balance (inequality) of the program
  std::vector<int> stopped_;  // DOFs whose position limit is a balance of the program
};

}  // namespace ugoki::control
