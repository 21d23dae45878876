#pragma once
// One step of several link systems with contact, friction, joint limits, springs, dampers and dry joint friction.
//
// 1. Impacts (collision_impulse.h): contacts hit with restitution receive their impulse, eqs. (12)-(19).
//    From here on, v is the velocity after the impacts.
// 2. The remaining impulses p [N s | N m s] act on the velocities. With the step dt [s], the inertia M [kg | kg m^2], implicit dampers D
//    and springs K, M' = M + dt D + dt^2 K, drive forces tau, bias forces b, and passive joint forces:
//      v' = v + M'^-1 (dt (tau - b - passive) + J^T p),   q' = q (+) v' dt   ((+): integration of the positions)
//    where p satisfies, for every contact (normal n, tangents t), with the velocity u = J v' [m/s | rad/s] (velocity_solver.h):
//      normal:        p_n >= 0,  u_n >= target,  p_n (u_n - target) = 0
//      friction:      |p_t| <= mu p_n, opposed to the sliding velocity u_t
//      joint limits:  p >= 0, opposed to the velocity into the limit
//      dry friction:  |p| <= dt * friction
//      loops:         u = -gap / dt, p unbounded (closed link systems)
//      grips:         gap after the step = 0, p unbounded (grip.h)
//
// `target` of a gap is -distance / dt: a contact is predicted one step ahead. `target` of a penetration is a bounded recovery speed.
// The solver needs whitened rows y = D^-1/2 L^-T J^T, where M' = L^T D L (this D is a diagonal matrix, not the dampers). A row has entries
// only on the chains of its two links. In these coordinates the inverse inertia seen by a row is y . y. Loops are eliminated exactly before
// contacts are solved: every other row is projected onto the velocities that the loops allow. Dependent loop rows are left out. After the
// step the positions of closed loops are corrected until their gap is at the level of rounding.
// Sources: Nagashima (1999) section 6.3; Hwangbo, Lee, Hutter (2018), Per-contact iteration; Featherstone (2008) ch. 8, 11.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "ugoki/collision/contact_point.h"
#include "ugoki/contact/collision_impulse.h"
#include "ugoki/contact/grip.h"
#include "ugoki/contact/inertial_motion.h"
#include "ugoki/contact/tree_island.h"
#include "ugoki/contact/velocity_solver.h"
#include "ugoki/contact/warm_start.h"
#include "ugoki/dynamics/articulated_factor.h"
#include "ugoki/dynamics/closed_links.h"
#include "ugoki/dynamics/dynamics.h"
#include "ugoki/dynamics/known_kinematics.h"

namespace ugoki::contact {

struct StepperOptions {
  /// m: an overlap deeper than this was present at the beginning of the simulation. A step does not create such an overlap, because
  /// GuardedStep splits the step at a fifth of this depth.
  static constexpr double deep_overlap = 5e-3;

  /// m | rad: a loop with a larger gap after a step is reported as open. This limit is far above the gaps of closed loops (1e-15) and far
  /// below the position errors of bodies in a large heap (1e-4 m). Test: step_report_test.cpp.
  static constexpr double open_gap = 1e-6;

  Vec3 gravity{0, 0, -9.81};     ///< m/s^2
  int iterations = 200;          ///< maximum number of sweeps over an island
  double tolerance = 1e-7;       ///< m/s: sweeps end when no velocity changes by more than this
  double recovery_time = 0.008;  ///< s: time in which a penetration is pushed out
  double recovery_speed = 0.6;   ///< m/s | rad/s: maximum speed of penetration recovery and of loop closing
  double impact_speed = 0.05;    ///< m/s: slower approaches do not bounce
  double softness =
      1e-4;  ///< contact compliance, as a fraction of the contact's normal inverse inertia; redundant contacts then share the load
  int min_tree_dofs = TreeIsland::min_dofs;     ///< systems with fewer DOFs are solved without TreeIsland
  double min_tree_work = TreeIsland::min_work;  ///< see TreeIsland::min_work
  double rolling = 0.02;                        ///< rolling resistance of free round bodies: moment / (radius * normal force)
};

/// State and inputs of one system for a step. All spans refer to the caller's memory.
struct StepSystem {
  std::span<double> q, v;                  ///< [nq], [nv] in: state before the step, out: after the step
  std::span<const double> tau;             ///< [nv] N | N m: drive forces
  std::span<const Vec6> external;          ///< [links] N m, N: wrenches about the world origin, world axes; empty: none
  std::span<const double> servo_gain;      ///< [nv] N m s/rad: the drive adds gain * (servo_velocity - v'); empty: none
  std::span<const double> servo_velocity;  ///< [nv] rad/s; v', the velocity after the step, is implicit, so that any gain is stable
  const dynamics::KnownKinematics* known = nullptr;  ///< may have the kinematics at q and v; null: the step computes them
};

enum class StepStatus {
  ok,
  singular,    ///< the inertia of DOF `dof` of system `system` is not positive
  not_finite,  ///< the velocity of DOF `dof` of system `system` became infinite, NaN or larger than 1e6
};

struct StepReport {
  StepStatus status = StepStatus::ok;
  int system = -1, dof = -1;
  int sweeps = 0;         ///< maximum number of sweeps over one island
  int newton_steps = 0;   ///< Newton steps, summed over all islands
  int handed_over = 0;    ///< small islands that the dense solver did not finish (velocity_solver.h)
  int islands = 0;        ///< groups of systems joined by contacts, and single systems with rows (limits, dry friction, ground contacts)
  double residual = 0;    ///< m/s: maximum change of velocity in the last sweep
  int contacts = 0;       ///< number of contacts that received rows
  int limits = 0;         ///< number of rows of joint limits and dry friction
  int impacts = 0;        ///< number of collisions in the impact phase
  double loop_gap = 0;    ///< m | rad: maximum gap of a closed loop after the step
  int substeps = 1;       ///< substeps into which GuardedStep split the step; 1: the step was not split
  int not_converged = 0;  ///< islands whose residual is above the tolerance and above 1e-5 m/s (SolverReport); summed over the substeps

  // Failures of stages of a step that has status ok, summed over the substeps.
  int failed_motions = 0;      ///< fast systems that InertialMotion could not move; they moved at constant velocity instead
  int unfinished_impacts = 0;  ///< sequences of impacts that reached their maximum number of collisions
  int open_loops = 0;          ///< closed systems with a gap above StepperOptions::open_gap after the step
  int stops = 0;               ///< substeps that were not halved further, and in which GuardedStep stopped all systems before a passage
  int left_overlaps = 0;       ///< substeps that ended with a new overlap deeper than 1 mm

  /// Returns the number of failed stages of the step.
  [[nodiscard]] int failures() const { return failed_motions + unfinished_impacts + open_loops + stops + left_overlaps; }
  /// Adds the report of the next substep or step. Sums and maxima are updated; islands, contacts and limits are replaced; substeps stays.
  void add(const StepReport& next);
};

/// Advances several link systems by one time step; see the equations at the top of this file.
class Stepper {
 public:
  Stepper(std::vector<MechanismPtr> systems, const StepperOptions& options);

  /// Computes systems and islands on the threads of `executor`; null: on the calling thread. The bits are equal in both cases. Scenes below
  /// min_parallel_dofs always use the calling thread.
  void set_executor(Executor* executor);
  /// Calls body(s) for each system s, on the threads of the executor.
  template <class Body>
  void for_each_system(const Body& body) {
    parallel_for(executor_, mechanisms_.size(), [&](std::size_t s, int worker) {
      scratch_[s].factor.use(factor_scratch_[static_cast<std::size_t>(worker)]);
      body(s);
    });
  }

  /// Advances all systems by dt [s]. On failure every q and v keeps its value from before the step.
  /// @param contacts  result of collision analysis at the present positions; their system and link indices refer to the constructor's list
  /// @param forced    index into `contacts`: from there on, contacts always get rows; earlier ones only if they can close within the step
  /// Allocates nothing after warm-up, unless the number of contacts grows.
  StepReport step(std::span<StepSystem> systems, std::span<const collision::ContactPoint> contacts, double dt,
                  std::size_t forced = SIZE_MAX);

  /// Repeats the last step from the same positions and velocities with additional contacts. Only islands that contain a new contact are
  /// solved again, with 0.3 times the coarse tolerance of step() (SolverOptions::coarse) and 4 times the sweeps.
  /// @param contacts contacts of the last call of step() or repeat(), followed by the new ones; the new ones are forced contacts
  StepReport repeat(std::span<StepSystem> systems, std::span<const collision::ContactPoint> contacts, double dt);
  /// Whether the last call of repeat() may have changed the result of a system. Meaningful only after repeat().
  [[nodiscard]] bool has_changed(int system) const {
    const SystemScratch& x = scratch_[static_cast<std::size_t>(system)];
    return x.by_tree ? x.tree_solved : solver_.is_solved(system);
  }
  /// Whether repeat() can add this contact; if not, the step must be computed again by step().
  [[nodiscard]] bool can_add(const collision::ContactPoint& contact) const;

  /// Sets the grips of all following steps. Contacts between the two links of a grip get no rows.
  void set_grips(std::span<const Grip> grips);
  /// [grips] N m, N, world axes: moment and force of the last step on link a of each grip, at the gripping point.
  [[nodiscard]] std::span<const Vec6> grip_forces() const { return grip_forces_; }
  /// True if the contact is between the two links of a grip.
  [[nodiscard]] bool is_gripped(const collision::ContactPoint& contact) const;

  /// Limits the work of Newton's method in the velocity solver; see VelocitySolver::limit_newton().
  void limit_newton(double operations) { solver_.limit_newton(operations); }

  /// [contacts] N, world axes: force on body a of each contact of the last step. The impulse of an impact is given as a force that is
  /// constant over the step, eq. (17).
  [[nodiscard]] std::span<const Vec3> contact_forces() const { return forces_; }
  /// m/s, world: velocity of the link's point at p [m, world], from the positions before and the velocities after the last step.
  /// For a system that moved in inertial substeps: the velocities before these substeps.
  [[nodiscard]] Vec3 velocity_after(int system, int link, const Vec3& p) const;
  /// Kinematics of one system at the beginning of the last step.
  [[nodiscard]] const dynamics::Workspace& workspace(int system) const { return workspaces_[static_cast<std::size_t>(system)]; }
  [[nodiscard]] const Mechanism& mechanism(int system) const { return *mechanisms_[static_cast<std::size_t>(system)]; }
  [[nodiscard]] int system_count() const { return static_cast<int>(mechanisms_.size()); }
  [[nodiscard]] const StepperOptions& options() const { return options_; }

  /// Impulses of the last step, from which the next step's solver starts. These impulses and loop_memory() are the only memory between
  /// steps: save and restore both with a simulation.
  using Warm = contact::Warm;
  [[nodiscard]] std::span<const Warm> warm() const { return warm_.records(); }
  void set_warm(std::span<const Warm> warm) { warm_.set(warm); }
  /// Reference values of a closed system's loops (ClosedLinks::memory()); empty for an open system.
  using LoopMemory = dynamics::ClosedLinks::Memory;
  [[nodiscard]] LoopMemory loop_memory(int system) const;
  void set_loop_memory(int system, const LoopMemory& memory);

 private:
  [[nodiscard]] SolverOptions solver_options(double dt, bool careful) const;
  StepReport finish(std::span<StepSystem> systems, std::span<const collision::ContactPoint> contacts, double dt, const SolverReport& solved,
                    StepReport report);
  void move_links(std::size_t s, std::span<const double> v);
  [[nodiscard]] double max_speed(std::size_t s, std::span<const double> v);
  bool reduce_recovery();
  StepReport step(std::span<StepSystem> systems, std::span<const collision::ContactPoint> contacts, double dt, std::size_t forced,
                  double recovery);
  [[nodiscard]] int steps_before_hand_over(std::size_t s) const;
  bool hand_over();
  [[nodiscard]] bool is_movable(int system, int link) const;
  void choose_methods(std::span<const collision::ContactPoint> contacts);
  void find_separations(std::span<const collision::ContactPoint> contacts);
  [[nodiscard]] Vec3 recovery_direction(const collision::ContactPoint& c) const;
  SolverReport solve_rows(const SolverOptions& options, std::size_t first_new, bool again);
  void find_impacts(std::span<StepSystem> systems, std::span<const collision::ContactPoint> contacts, double dt, StepReport& report);
  void prepare(std::size_t s, const StepSystem& system, double dt);
  void move_freely(std::size_t s, const StepSystem& system, double dt);
  void integrate_system(std::size_t s, StepSystem& system, double dt);
  void add_contact(int index, const collision::ContactPoint& c, double dt, bool forced);
  void add_rolling(const collision::ContactPoint& c);
  int add_joint_rows(std::size_t s, double dt);
  double spread_over_loops(std::size_t s, int last);
  double* add_side(std::size_t s, int last);
  const Vec6& free_velocity(std::size_t s, int last);
  void predict_grips(std::span<const StepSystem> systems, double dt);
  void add_grip(const Grip& grip, double dt);
  void take_grip_forces(double dt);
  void solve_loops(std::size_t s, const StepSystem& system, double dt);
  void make_loop_basis(std::size_t s, const StepSystem& system, double dt);
  void make_loop_rows(std::size_t s, int loop, std::span<double> y, std::span<double> terms);
  void close_loops(std::size_t s, StepSystem& system);

  struct SystemScratch {
    explicit SystemScratch(const Mechanism& m) : factor(m) {}
    dynamics::ArticulatedFactor factor;        // of the inertia M'
    std::vector<double> v;                     // [nv] velocity after the impacts
    std::vector<double> extra;                 // [nv] dt D + dt^2 K: implicit damping and stiffness added to the inertia
    std::vector<double> free_v;                // [nv] velocity without impulses; finish() adds their effect
    std::vector<double> unforced;              // [nv] velocity without impulses, kept for repeat()
    std::vector<double> mean;                  // [nv] mean of the old and new velocities
    std::vector<double> zeros;                 // [nv]
    std::vector<Vec6> free_motion;             // [nv] velocity without impulses of the link that each DOF moves, about p0
    bool has_free_motion = false;              // free_motion is computed
    std::vector<double> displacement;          // [nv] m | rad: displacements of the joints of displaced_links from the neutral position
    std::vector<int> limited_links;            // links whose joint has a limited DOF
    std::vector<int> displaced_links;          // links whose joint has a limited DOF or a spring
    std::vector<int> dry_friction_dofs;        // DOFs with dry friction
    std::vector<char> contiguous_chain;        // [nv] 1: the chain of this DOF is 0, 1, 2 ...
    int singular_dof = -1;                     // result of prepare(): DOF whose pivot is not positive; -1: none
    double loop_gap = 0;                       // m | rad: maximum gap of the system's loops, result of integrate_system()
    bool motion_failed = false;                // result of integrate_system(): see StepReport::failed_motions
    bool deep = false;                         // true: a contact of this step overlaps by more than StepperOptions::deep_overlap
    double rolling_radius = 0;                 // m: radius of a free round body; 0 for all other systems
    bool free_body = false;                    // true: the system is one floating link
    bool is_inertial = false;                  // true: this step ends with `inertial`, which adds the velocity-dependent forces
    std::unique_ptr<InertialMotion> inertial;  // null: a single link or DOF
    bool gripped = false;                      // true: a grip acts on the system; it then moves without `inertial`
    std::vector<double> next_q;                // [nq] gripped: position after motion at the velocities before the step
    std::vector<Pose> next_X;                  // [links] gripped: poses at next_q
    struct Loops {
      explicit Loops(const Mechanism& m);
      /// Allocates `basis`. Its size grows with the square of the number of loops: 200 MB for 1000 linkages. TreeIsland does not need it.
      void make_room_for_basis(std::size_t dofs);
      dynamics::ClosedLinks links;
      dynamics::LoopRows rows;
      dynamics::Workspace ws;       // working memory for closing the positions
      std::vector<double> basis;    // [rank * nv] orthonormal basis of the whitened loop rows; [rows * nv] during orthogonalisation
      std::vector<double> target;   // [rows] component of w along each basis vector that closes the loops
      std::vector<double> minimum;  // [rows] squared row length below which the row is numerically zero
      std::vector<double> sparse;   // [4 * nv] scratch for up to three rows with entries on one chain only
      std::vector<double> impulse;  // [nv] whitened impulse of the loops
      std::vector<double> w;        // [nv] whitened velocity
      std::vector<double> parts;    // [4 * rows] components of up to three rows along the basis
      int rank = 0;
      bool has_basis = false;  // basis, rank and target are those of the present position
    };
    std::unique_ptr<Loops> loops;      // null: the mechanism has no closed loop
    std::unique_ptr<TreeIsland> tree;  // null: the system is small, or TreeIsland cannot treat its joints
    bool can_hand_over = false;        // true: a system that `tree` does not finish is solved again by whitened rows
    bool by_tree = false;              // true: `tree` solves the rows of this step
    bool tree_solved = false;          // the last solution may have changed the impulses of `tree`
    std::size_t tree_blocks = 0;       // blocks of `tree` at its last solution
    SolverReport tree_report;
  };

  std::vector<MechanismPtr> mechanisms_;
  StepperOptions options_;
  Executor* executor_ = nullptr;
  std::vector<dynamics::Workspace> workspaces_;
  std::vector<SystemScratch> scratch_;
  std::vector<dynamics::FactorScratch> factor_scratch_;  // [workers] used by the factors of the systems that a worker computes
  VelocitySolver solver_;
  double recovery_ = 1;                         // fraction of the recovery speeds of overlaps and joint limits; 0 in a repeated solution
  std::size_t forced_ = 0;                      // index of the first contact of the step that always gets rows
  int handed_over_ = 0;                         // systems that TreeIsland handed over in this step
  std::vector<double> tree_work_;               // [systems] scratch of choose_methods()
  int max_dense_rows_ = DenseIsland::max_rows;  // maximum number of rows of an island for the dense solver
  CollisionImpulse impact_;
  std::vector<LinkSystem> impact_systems_;
  std::vector<double> impact_impulses_;  // [contacts] N s: normal impulse of the impact phase
  std::vector<Grip> grips_;
  std::vector<Vec6> grip_forces_;  // [grips] see grip_forces()
  WarmStart warm_;
  StepReport first_report_;  // report of the last step() before its solver ran; repeat() continues from it
  std::vector<Vec3> forces_;
  /// Direction in which two systems with deep overlaps come apart.
  struct Separation {
    std::uint64_t pair;   // index of the lower system + 1, then that of the higher one
    std::size_t index;    // order of the contacts, so that the sums have the same bits everywhere
    Vec3 sum, deepest;    // of the contacts' normals, towards the higher system: weighted by depth; of the deepest contact
    double depth, total;  // m: of the deepest contact; of all contacts
  };
  std::vector<Separation> separations_;  // of the pairs with deep overlaps in this step, by pair
  std::vector<Vec3> frames_;             // [contacts * 3] normal n, tangents t1 and t2 of each contact
};

}  // namespace ugoki::contact
