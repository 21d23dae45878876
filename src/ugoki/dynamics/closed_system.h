#pragma once
// A closed link system as the integrators see it: loops that hold to rounding, and that can be closed and opened while it runs.

#include "ugoki/dynamics/closed_links.h"
#include "ugoki/dynamics/open_system.h"

namespace ugoki::dynamics {

/// What happened when a loop was closed.
struct ClosingReport {
  ClosedStatus status = ClosedStatus::ok;
  double gap = 0;          ///< greatest gap before, m | rad
  double energy_lost = 0;  ///< J, kinetic: what the impulse took
};

class ClosedSystem : public OpenSystem {
 public:
  /// With the mechanism's own loops, those closed that are closed at the start.
  explicit ClosedSystem(MechanismPtr mechanism, const OpenSystemOptions& options = {});

  /// Adds an open loop, for example a hand on a rail. Allocates. @return its index in links().loops()
  int add_loop(Loop loop);
  /// Closes a loop at (q, v): positions are brought together (what is left of the gap, moving as little mass as little as
  /// possible), and v jumps to the nearest velocity that opens no loop: links().multipliers() are the impulses [N s | N m s].
  /// Momentum is that before plus the impulses on the world; energy is lost, never won. Allocates.
  ClosingReport close(int loop, std::span<double> q, std::span<double> v);
  /// Finds the rows that follow from others wherever the system is (three in every planar loop), and leaves them out from then on: faster,
  /// and right also where the frames of redundant rows do not quite agree, as in most files. Allocates.
  /// @param q [nq] closed; looked at with a few positions around it @return how many rows were left out
  int leave_out_redundant_rows(std::span<const double> q);
  /// Opens a loop: nothing jumps. Allocates.
  void open(int loop);

  [[nodiscard]] int calc_acceleration(double t, std::span<const double> q, std::span<const double> v, std::span<double> vdot) override;
  // Within an angle d of a singular position (a dead point, a change point) the loops determine accelerations only up to eps / d^3; there
  // those a little before and after, extrapolated to the position, are taken, so that the system passes as it would exactly.

  /// The exact derivatives are those of open systems.
  [[nodiscard]] bool calc_acceleration_jacobian(double, std::span<const double>, std::span<const double>, std::span<double>,
                                                std::span<double>) override {
    return false;
  }
  [[nodiscard]] Projection project(double t, std::span<double> q, std::span<double> v) override;

  /// After calc_acceleration() its multipliers are the forces in the loops, after close() the impulses.
  [[nodiscard]] const ClosedLinks& links() const { return links_; }
  void set_memory(const ClosedLinks::Memory& memory) { links_.set_memory(memory); }

 private:
  void rebuild(std::vector<Loop> loops, std::span<const char> closed, std::span<const char> rows = {});

  /// calc_acceleration() at a position that is not singular. @return -1 or the singular freedom
  [[nodiscard]] int accelerate(double t, std::span<const double> q, std::span<const double> v, std::span<double> vdot);
  /// The acceleration in passing a singular position, from those before and after it. @return false where the system rests
  bool accelerate_across(double t, std::span<const double> q, std::span<const double> v, std::span<double> vdot);
  bool accelerate_beside(double t, double dt, std::span<const double> q, std::span<const double> v, double weight, std::span<double> sum);

  ClosedLinks links_;
  std::vector<double> q_, v_, a_, guess_, mean_;
};

}  // namespace ugoki::dynamics
