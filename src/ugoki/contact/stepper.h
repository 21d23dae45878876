#pragma once
// One step of several link systems with contact, friction, joint limits, springs, dampers and dry joint friction.
//
// First the impacts (collision_impulse.h): contacts that are hit with restitution give their impulse (12)-(19), v <- v+. Then, at the
// level of velocities, with M' = M + dt D + dt^2 K (implicit dampers D and springs K),
//   v' = v + M'^-1 (dt (tau - b - passive) + J^T p),   q' = q (+) v' dt,
// the impulses p solve, for every contact (normal n, tangents t) and limit (velocity_solver.h):
//   normal:    p_n >= 0,  u_n >= target,  p_n (u_n - target) = 0
//   friction:  |p_t| <= mu p_n, against the sliding velocity u_t
//   limits:    p >= 0 against the velocity into the limit;   dry friction: |p| <= dt * friction
//   loops:     u = -gap / dt, p free (closed link systems)
// Rows come from the sparse factor of M' (they live on the chains of the touching links only). target is -distance/dt for gaps
// (contact is predicted one step ahead) and a bounded recovery velocity for penetrations. Loops are eliminated beforehand,
// exactly: the rows of everything else are projected onto what the loops allow (rows of loops that follow from others are left
// out), and positions are closed to rounding after the step.
// Sources: Nagashima (1999) section 6.3; Hwangbo, Lee, Hutter (2018), Per-contact iteration; Featherstone (2008) ch. 8, 11.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "ugoki/collision/contact_point.h"
#include "ugoki/contact/collision_impulse.h"
#include "ugoki/contact/velocity_solver.h"
#include "ugoki/contact/warm_start.h"
#include "ugoki/dynamics/closed_links.h"
#include "ugoki/dynamics/dynamics.h"

namespace ugoki::contact {

struct StepperOptions {
  Vec3 gravity{0, 0, -9.81};     ///< m/s^2
  int iterations = 200;          ///< greatest number of sweeps over an island
  double tolerance = 1e-7;       ///< m/s: sweeps end when no velocity changes more
  double recovery_time = 0.008;  ///< s in which penetration is pushed out
  double recovery_speed = 0.6;   ///< m/s, greatest speed of that; of loops that are open, with which they close, m/s | rad/s
  double impact_speed = 0.05;    ///< m/s: slower approaches do not bounce
  double softness = 1e-4;        ///< share of a contact's own inverse inertia added to it, so that redundant contacts share the load
  double rolling = 0.02;         ///< rolling resistance of free round bodies: moment / (radius times normal force)
};

/// One system's part in a step. Spans of the caller's memory.
struct StepSystem {
  std::span<double> q, v;                  ///< in, out
  std::span<const double> tau;             ///< [nv] drive forces
  std::span<const Vec6> external;          ///< [links] wrenches about the world origin, or empty
  std::span<const double> servo_gain;      ///< [nv] N m s/rad: the drive adds gain (servo_velocity - v'), taken implicitly, so
  std::span<const double> servo_velocity;  ///< [nv] that any gain is stable; both empty for none
};

enum class StepStatus {
  ok,
  singular,    ///< an inertia is not positive: `system`, `freedom`
  not_finite,  ///< a velocity came out infinite or NaN: `system`, `freedom`
};

struct StepReport {
  StepStatus status = StepStatus::ok;
  int system = -1, freedom = -1;
  int sweeps = 0;        ///< of the island that took most
  int newton_steps = 0;  ///< of all islands
  int islands = 0;       ///< groups of systems that touch, and systems alone that have limits or ground contacts
  double residual = 0;   ///< m/s: greatest change of velocity in the last sweep
  int contacts = 0;      ///< contacts that took part
  int limits = 0;        ///< joint limits and dry frictions that took part
  int impacts = 0;       ///< collisions of the impact phase
  double loop_gap = 0;   ///< m | rad: greatest gap that the closed loops are left with
};

class Stepper {
 public:
  Stepper(std::vector<MechanismPtr> systems, const StepperOptions& options);

  /// Advances all systems by dt. On failure every q and v is left as it was: the last good state.
  /// @param contacts from collision analysis at the present positions; systems and links as given to the constructor
  /// @param certain contacts from this index on take part however far apart they are; of the others, those that can be reached
  /// No allocation after warm-up, unless the number of contacts grows; the first time that a linked system turns by more than a tenth of
  /// a radian in a step it gets what it needs for that.
  StepReport step(std::span<StepSystem> systems, std::span<const collision::ContactPoint> contacts, double dt,
                  std::size_t certain = SIZE_MAX);

  /// The same step once more, from the same positions and velocities, after contacts were added to those of the last call of step() or
  /// again(): only islands that the new ones touch are solved, three times as closely.
  /// @param contacts those of the last call, then the new ones, which take part however far apart they are
  StepReport again(std::span<StepSystem> systems, std::span<const collision::ContactPoint> contacts, double dt);
  /// Whether the last call of again() may have changed what became of a system; after step() everything may have changed.
  [[nodiscard]] bool has_changed(int system) const { return solver_.is_solved(system); }

  /// Force [N] on body a of each contact of the last step, world axes, in the order of its contacts. An impact's impulse
  /// counts as a force that is constant over the step, eq. (17).
  [[nodiscard]] std::span<const Vec3> contact_forces() const { return forces_; }
  /// Velocity [m/s, world] of a link's point at p [m, world], with the positions before and the velocities after the last step;
  /// of what then turned on by its inertia alone, those with which it set out.
  [[nodiscard]] Vec3 velocity_after(int system, int link, const Vec3& p) const;
  /// Kinematics at the beginning of the last step.
  [[nodiscard]] const dynamics::Workspace& workspace(int system) const { return workspaces_[static_cast<std::size_t>(system)]; }
  [[nodiscard]] const Mechanism& mechanism(int system) const { return *mechanisms_[static_cast<std::size_t>(system)]; }
  [[nodiscard]] int system_count() const { return static_cast<int>(mechanisms_.size()); }
  [[nodiscard]] const StepperOptions& options() const { return options_; }

  /// The impulses kept for the next step's warm start: the only memory from step to step, for saving and restoring a simulation.
  using Warm = contact::Warm;
  [[nodiscard]] std::span<const Warm> warm() const { return warm_.records(); }
  void set_warm(std::span<const Warm> warm) { warm_.set(warm); }

 private:
  [[nodiscard]] SolverOptions solver_options(double dt, bool careful) const;
  StepReport finish(std::span<StepSystem> systems, std::span<const collision::ContactPoint> contacts, double dt, const SolverReport& solved,
                    StepReport report);
  void find_impacts(std::span<StepSystem> systems, std::span<const collision::ContactPoint> contacts, double dt, StepReport& report);
  void prepare(std::size_t s, const StepSystem& system, double dt, StepReport& report);
  void move_freely(std::size_t s, const StepSystem& system, double dt);
  bool coast(std::size_t s, StepSystem& system, double dt, StepReport& report);
  double turn(std::size_t s, std::span<const double> v, double dt) const;
  void add_contact(int index, const collision::ContactPoint& c, double dt, bool certain);
  void add_rolling(const collision::ContactPoint& c);
  void add_joint_rows(std::size_t s, double dt);
  void spread_over_loops(std::size_t s, int last, int rows, const double* row);
  double* add_side(std::size_t s, int last);
  void finish_side(std::size_t s, int last, int rows, double* row);
  void whiten(std::size_t s, int last, std::span<double> y) const;
  void add_impulses(std::size_t s);
  void solve_loops(std::size_t s, const StepSystem& system, double dt);
  double make_loop_row(std::size_t s, const Loop& loop, int index, int row, std::span<double> y, double& terms);
  void close_loops(std::size_t s, StepSystem& system, StepReport& report);

  struct SystemScratch {
    std::vector<double> v;               // [nv] at the start of the step, after impacts
    std::vector<double> extra;           // [nv] implicit damping and stiffness
    std::vector<double> free_v;          // [nv] velocity without impulses; at the end of a step with them
    std::vector<double> unforced;        // [nv] without them, until the next step
    std::vector<double> mean;            // [nv] of old and new velocities
    std::vector<double> none;            // [nv] zeros
    std::vector<double> start_q;         // [nq] before it coasts
    std::vector<double> root_D_inverse;  // [nv]
    std::vector<double> impulse;         // [nv]
    std::vector<double> displacement;    // [nv]
    std::vector<int> limited;            // links with a limited freedom
    std::vector<int> rubbed;             // freedoms with dry friction
    std::vector<char> straight;          // [nv] whose chain is 0, 1, 2 ...
    double round = 0;                    // m: radius of a free round body
    bool free_body = false;              // one floating link
    bool springs = false;
    bool coasts = false;                // moves by its inertia after the forces have acted
    std::vector<std::size_t> turning;   // freedoms that are angles
    std::unique_ptr<Stepper> inertial;  // of the mechanism alone, for that
    struct Loops {
      explicit Loops(const Mechanism& m);
      dynamics::ClosedLinks links;
      dynamics::LoopRows rows;
      dynamics::Workspace ws;      // of closing positions
      std::vector<double> basis;   // [rank * nv] orthonormal: what the loops forbid, whitened; [rows * nv] while it is made
      std::vector<double> target;  // [rows]
      std::vector<double> least;   // [rows] what their squares must exceed
      std::vector<double> sparse;  // [3 * nv] rows on a chain before they are spread
      int rank = 0;
    };
    std::unique_ptr<Loops> loops;  // of a mechanism with closed loops
  };

  std::vector<MechanismPtr> mechanisms_;
  StepperOptions options_;
  bool coasting_ = false;  // inertial forces and loops only
  std::vector<dynamics::Workspace> workspaces_;
  std::vector<SystemScratch> scratch_;
  VelocitySolver solver_;
  CollisionImpulse impact_;
  std::vector<LinkSystem> struck_systems_;
  std::vector<double> struck_;  // [contacts] N s: normal impulse of the impact phase
  WarmStart warm_;
  StepReport begun_;  // of the last step(): what again() does not do anew
  std::vector<Vec3> forces_;
  std::vector<Vec3> frames_;  // [contacts * 3] n, t1, t2
};

}  // namespace ugoki::contact
