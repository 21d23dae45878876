#pragma once
// One step of several link systems with contact, friction, joint limits, springs, dampers and dry joint friction.
//
// Velocity level: with M' = M + dt D + dt^2 K (implicit dampers D and springs K),
//   v' = v + M'^-1 (dt (tau - b - passive) + J^T p),   q' = q (+) v' dt,
// the impulses p solve, for every contact (normal n, tangents t) and limit:
//   normal:    p_n >= 0,  u_n >= target,  p_n (u_n - target) = 0        (the paper's impulse (12)-(19) with restitution)
//   friction:  |p_t| <= mu p_n, against the sliding velocity u_t
//   limits:    p >= 0 against the velocity into the limit;   dry friction: |p| <= dt * friction
//   loops:     u = -gap / dt, p free (closed link systems)
// by block Gauss-Seidel on the Delassus matrix J M'^-1 J^T, which comes from the sparse factor of M' (rows live on the chains
// of the touching links only). target is -distance/dt for gaps (contact is predicted one step ahead), a bounded
// recovery velocity for penetrations, and -e u_n for impacts. Loops are eliminated from that matrix beforehand, exactly (Cholesky
// with the greatest pivot first; rows that follow from others are left out), and positions are closed to rounding after the step.
// Sources: Nagashima (1999) section 6.3; Hwangbo, Lee, Hutter (2018), Per-contact iteration; Featherstone (2008) ch. 8, 11.

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "ugoki/collision/contact_point.h"
#include "ugoki/dynamics/closed_links.h"
#include "ugoki/dynamics/dynamics.h"

namespace ugoki::contact {

struct StepperOptions {
  Vec3 gravity{0, 0, -9.81};    ///< m/s^2
  int iterations = 60;          ///< greatest number of Gauss-Seidel sweeps
  double tolerance = 1e-7;      ///< m/s: sweeps end when no velocity changes more
  double slop = 5e-4;           ///< m of penetration that is left alone, so that resting contacts stay
  double recovery_time = 0.02;  ///< s in which deeper penetration is pushed out
  double recovery_speed = 0.6;  ///< m/s, greatest speed of that
  double impact_speed = 0.25;   ///< m/s: slower approaches do not bounce
  double softness = 1e-3;       ///< share of a row's own inverse inertia added to it, so that redundant contacts share the load
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
  int sweeps = 0;
  double residual = 0;  ///< m/s: change of velocity in the last sweep
  int contacts = 0;     ///< contacts that took part
  int limits = 0;       ///< joint limits that took part
  double loop_gap = 0;  ///< m | rad: greatest gap that the closed loops are left with
};

class Stepper {
 public:
  Stepper(std::vector<MechanismPtr> systems, const StepperOptions& options);

  /// Advances all systems by dt. On failure every q and v is left as it was: the last good state.
  /// @param contacts from collision analysis at the present positions; systems and links as given to the constructor
  /// No allocation after warm-up, unless the number of contacts grows.
  StepReport step(std::span<StepSystem> systems, std::span<const collision::ContactPoint> contacts, double dt);

  /// Force [N] on body a of each contact of the last step, world axes, in the order of its contacts.
  [[nodiscard]] std::span<const Vec3> contact_forces() const { return forces_; }
  /// Kinematics at the beginning of the last step.
  [[nodiscard]] const dynamics::Workspace& workspace(int system) const { return workspaces_[static_cast<std::size_t>(system)]; }
  [[nodiscard]] const Mechanism& mechanism(int system) const { return *mechanisms_[static_cast<std::size_t>(system)]; }
  [[nodiscard]] int system_count() const { return static_cast<int>(mechanisms_.size()); }
  [[nodiscard]] const StepperOptions& options() const { return options_; }

  /// The impulses kept for the next step's warm start: the only memory from step to step. Fixed layout of
  /// warm_capacity() records; for saving and restoring a simulation.
  struct Warm {
    std::uint64_t key = 0;
    double p[3] = {0, 0, 0};
  };
  [[nodiscard]] std::span<const Warm> warm() const { return warm_; }
  void set_warm(std::span<const Warm> warm) { warm_.assign(warm.begin(), warm.end()); }

 private:
  /// Part of a row that lives on one chain: J on the chain of freedom `last` of a system, times D^-1/2 L^-T.
  struct Segment {
    int system, last, offset, length;
  };
  enum class RowKind : unsigned char { contact, limit, friction, loop };
  /// A block of rows solved together: a contact (3), a limit (1), a dry friction (1), a row of a loop (1). Loops come first.
  struct Block {
    RowKind kind;
    int row, rows;
    int first_segment, segments;  // each segment holds `rows` vectors of its length
    int contact;                  // index into the step's contacts
    double mu, bound;
    std::uint64_t key;
  };

  void prepare(std::size_t s, const StepSystem& system, double dt, StepReport& report);
  void add_loop_rows(std::size_t s, const StepSystem& system, double dt);
  void add_loop_row(std::size_t s, const Loop& loop, int index, int row, double dt);
  void eliminate_loops();
  void recover_loops();
  void close_loops(std::size_t s, StepSystem& system, StepReport& report);
  void add_contact(int index, const collision::ContactPoint& c, double dt);
  void add_joint_rows(std::size_t s, double dt);
  int add_segment(std::size_t s, int last, int rows);
  void finish_rows(Block& block);
  void build_delassus();
  void warm_start();
  void sweep_all(StepReport& report);
  void apply_impulses();

  std::vector<MechanismPtr> mechanisms_;
  StepperOptions options_;
  std::vector<dynamics::Workspace> workspaces_;
  struct SystemScratch {
    std::vector<double> extra;           // [nv] implicit damping and stiffness
    std::vector<double> free_v;          // [nv] velocity without impulses
    std::vector<double> root_D_inverse;  // [nv]
    std::vector<double> impulse;         // [nv]
    std::vector<double> displacement;    // [nv]
    std::vector<int> limited;            // links with a limited freedom
    std::vector<int> rubbed;             // freedoms with dry friction
    bool springs = false;
    struct Loops {
      explicit Loops(const Mechanism& m) : links(m), rows(m.loops()), ws(m) {}
      dynamics::ClosedLinks links;
      dynamics::LoopRows rows;
      dynamics::Workspace ws;  // of closing positions
    };
    std::unique_ptr<Loops> loops;  // of a mechanism with closed loops
  };
  std::vector<SystemScratch> scratch_;
  std::vector<Segment> segments_;
  std::vector<double> data_;  // rows of the segments
  std::vector<Block> blocks_;
  std::vector<double> target_;    // [rows] u of the free motion minus target
  std::vector<double> diagonal_;  // [rows] softness
  std::vector<double> A_;         // [rows * rows] Delassus matrix
  std::vector<double> p_;         // [rows] impulses
  int loop_rows_ = 0;             // the first rows
  std::vector<int> pivots_;       // loop rows in the order of their elimination
  std::vector<double> loop_L_;    // [pivots * rows] what each of them took with it
  std::vector<double> loop_t_;    // [pivots]
  std::vector<char> eliminated_;  // [rows]
  std::vector<Vec3> point_rows_;
  std::vector<Vec3> forces_;
  std::vector<Vec3> frames_;  // [contacts * 3] n, t1, t2
  std::vector<Warm> warm_;
};

}  // namespace ugoki::contact
