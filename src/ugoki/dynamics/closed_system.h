#pragma once
// A closed link system as a MotionSystem for the integrators. Its loops are closed to rounding, and can be closed and opened at run time.

#include "ugoki/dynamics/closed_links.h"
#include "ugoki/dynamics/open_system.h"

namespace ugoki::dynamics {

/// Result of closing a loop.
struct ClosingReport {
  ClosedStatus status = ClosedStatus::ok;
  double gap = 0;          ///< maximum gap before closing, m | rad
  double energy_lost = 0;  ///< J: kinetic energy lost in the closing impulse
};

class ClosedSystem : public OpenSystem {
 public:
  /// Uses the mechanism's own loops; those with Loop::closed set are closed.
  explicit ClosedSystem(MechanismPtr mechanism, const OpenSystemOptions& options = {});

  /// Adds an open loop, for example a hand on a rail. Allocates. @return its index in links().loops()
  int add_loop(Loop loop);
  /// Closes a loop at the state (q, v). First q is corrected to remove the gap, by the correction of minimum kinetic energy.
  /// Then v jumps to the closest velocity, in the kinetic-energy norm, that opens no loop. links().multipliers() returns the impulses
  /// [N s | N m s] of that jump. Momentum changes only by the impulses on the world; kinetic energy never increases. Allocates.
  ClosingReport close(int loop, std::span<double> q, std::span<double> v);
  /// Finds the rows that depend on others at every position (three in every planar loop), and leaves them out from now on. The computation
  /// becomes faster, and stays correct even if the frames of redundant rows are not exactly consistent, as in most model files. Allocates.
  /// @param q [nq] closed position; q and five positions near q are tested @return number of rows left out
  int leave_out_redundant_rows(std::span<const double> q);
  /// Opens a loop. Positions and velocities do not change. Allocates.
  void open(int loop);

  /// Accelerations. At an angle d from a singular position (dead point or change point) the error of the accelerations grows as eps / d^3,
  /// where eps is the rounding error of the gap. If the position is nearly singular, the acceleration is therefore interpolated from states
  /// before and after that position along the motion.
  [[nodiscard]] int calc_acceleration(double t, std::span<const double> q, std::span<const double> v, std::span<double> vdot) override;

  /// @return false: exact derivatives exist for open systems only
  [[nodiscard]] bool calc_acceleration_jacobian(double, std::span<const double>, std::span<const double>, std::span<double>,
                                                std::span<double>) override {
    return false;
  }
  [[nodiscard]] Projection project(double t, std::span<double> q, std::span<double> v) override;

  /// The loops. Their multipliers() are forces after calc_acceleration(), and impulses after close().
  [[nodiscard]] const ClosedLinks& links() const { return links_; }
  void set_memory(const ClosedLinks::Memory& memory) { links_.set_memory(memory); }

 private:
  void rebuild(std::vector<Loop> loops, std::span<const char> closed, std::span<const char> rows = {});

  /// calc_acceleration() without the treatment of singular positions. @return -1 or the singular DOF
  [[nodiscard]] int accelerate(double t, std::span<const double> q, std::span<const double> v, std::span<double> vdot);
  /// Acceleration near a singular position, interpolated from four states before and after it. @return false if the system is at rest
  bool interpolate_acceleration(double t, std::span<const double> q, std::span<const double> v, std::span<double> vdot);
  /// sum += weight * acceleration at time t + dt. dt may be negative. The state at t + dt is predicted from (q, v) and closed.
  bool add_acceleration_near(double t, double dt, std::span<const double> q, std::span<const double> v, double weight,
                             std::span<double> sum);

  ClosedLinks links_;
  std::vector<double> q_, v_, a_, guess_, mean_;
};

}  // namespace ugoki::dynamics
