#pragma once
// Collision force: the impulse between two link systems, open or closed (paper, section 6.3, eqs. (6)-(19)).
//
// For one contact between the systems L and R: r is the unit normal from L towards R, u = r . (velocity of R - velocity of L) [m/s],
// f the force [N], p the impulse [N s]. For each system: v are its joint velocities, M is its inertia matrix, J the Jacobian of its contact
// point, MJ the change of v per unit impulse. Then
//   MJ_R = M_R^-1 J_R^T r,  MJ_L = -M_L^-1 J_L^T r                                        (15) (16)
//   p = f dt = -b / a,   a = MJ_R^T M_R MJ_R + MJ_L^T M_L MJ_L,   b = (1 + e) u           (12)-(14), e: coefficient of restitution
//   v' = v + MJ p                                                                          (18) (19)
// The paper uses e = 1, which conserves kinetic energy (then b = 2 u). In a closed system MJ is projected onto the velocities that the
// loops allow, in the metric of M: H (H^T M H)^-1 H^T J^T r. The columns of H span these velocities (the paper writes M_G and J H).
//
// Several contacts collide in sequence. The pair of links with the fastest approach collides first. All contacts of that pair (the corners
// of a box) and all pairs with the same approach speed collide simultaneously:
//   p >= 0,   u' + e u >= 0,   p (u' + e u) = 0     for every approaching contact of such a group, u' after the collision
// This repeats until no contact approaches. Every collision conserves momentum, and energy if e = 1; Newton's cradle behaves as observed.
// Contacts that still approach afterwards (e = 0, or too many bounces) are stopped by a plastic collision of all contacts.
// Sources: Nagashima (1999), section 6.3; Glocker (2001), Set-valued force laws; Lawson, Hanson (1974) for the active set.

#include <span>
#include <vector>

#include "ugoki/collision/contact_point.h"
#include "ugoki/dynamics/closed_impulse.h"
#include "ugoki/dynamics/closed_links.h"
#include "ugoki/dynamics/dynamics.h"

namespace ugoki::contact {

/// One link system that can collide. Spans refer to the caller's memory. `workspace` must contain the kinematics of (q, v).
struct LinkSystem {
  const Mechanism* mechanism = nullptr;
  dynamics::Workspace* workspace = nullptr;
  dynamics::ClosedLinks* loops = nullptr;  ///< null: the system is open
  std::span<const double> q;
  std::span<double> v;  ///< [nv] velocities; in: before, out: after the collisions. In a closed system they must satisfy the loops
};

struct ImpactOptions {
  double min_speed = 0;  ///< m/s: contacts that approach more slowly do not bounce
  double reach = 0;      ///< s: only contacts whose gap would close within this time collide; 0: all contacts
  bool plastic = true;   ///< stop remaining approaches by a plastic collision at the end
};

enum class ImpactStatus : unsigned char {
  ok,
  singular,    ///< the inertia of `system` is not positive
  unfinished,  ///< the limit of collisions was reached (1000 + 100 per contact); with `plastic` the remaining approaches were stopped
};

struct ImpactReport {
  ImpactStatus status = ImpactStatus::ok;
  int system = -1;      ///< the singular system; -1: none
  int collisions = 0;   ///< number of collisions in sequence; all contacts of a group count as one
  double approach = 0;  ///< m/s: maximum approach speed after the call; 0 if it does not exceed min_speed
};

/// Calculates simultaneous and sequential impacts; see the equations at the top of this file.
class CollisionImpulse {
 public:
  /// Computes all collisions and changes the velocities of the systems that are hit.
  /// @param contacts ContactPoint::system_a and system_b are indices into `systems`; -1: the ground
  /// Allocates nothing after a call with at least as many contacts and DOFs.
  ImpactReport collide(std::span<const LinkSystem> systems, std::span<const collision::ContactPoint> contacts,
                       const ImpactOptions& options);

  /// [contacts] N s: normal impulse of each contact in the last call of collide(). It acts along n on body a of the contact.
  [[nodiscard]] std::span<const double> impulses() const { return impulses_; }

 private:
  struct Side {
    int system = -1;
    int row = 0;  // index in rows_, plain_ and jumps_ of the first of the side's nv entries
  };
  struct Row {
    int contact = 0;
    Side sides[2];
    bool has_jump = false;
    double u = 0;     // m/s: present separation velocity along the normal; negative: approaching
    double open = 0;  // 1/kg: `a` of eq. (13), computed as if all loops were open
    double e = 0;     // coefficient of restitution
  };
  bool add_row(std::span<const LinkSystem> systems, const collision::ContactPoint& c, int index);
  bool make_jump(std::span<const LinkSystem> systems, Row& row, ImpactReport& report);
  void update_velocity(std::span<const LinkSystem> systems, Row& row, bool plain) const;
  double coupling(std::span<const LinkSystem> systems, const Row& a, const Row& b) const;
  bool collide_group(std::span<const LinkSystem> systems, std::span<const collision::ContactPoint> contacts, const ImpactOptions& options,
                     bool plastic, ImpactReport& report);
  void solve_nonnegative(std::size_t n);
  void apply(std::span<const LinkSystem> systems);

  dynamics::ClosedImpulse closed_;
  std::vector<Row> list_;
  std::vector<double> rows_;    // r^T J of each side; make_jump() replaces the row of a closed system by M MJ
  std::vector<double> plain_;   // r^T J of each side, never replaced
  std::vector<double> jumps_;   // MJ of each side, eqs. (15) (16)
  std::vector<char> factored_;  // [systems] 1: the inertia is factored
  std::vector<double> impulses_;
  double rounding_ = 0;                   // m/s: approaches at or below this are rounding
  std::vector<int> group_;                // rows of list_ that collide together
  std::vector<int> fastest_;              // contacts with the maximum approach speed
  std::vector<char> struck_;              // [systems] 1: hit by the last collision
  std::vector<std::size_t> struck_list_;  // the systems with struck_ == 1
  std::vector<std::size_t> first_dof_;    // [systems + 1] index in change_ of the first DOF of each system
  std::vector<double> change_;            // [DOFs of all systems] velocity changes of the systems in struck_list_
  std::vector<double> A_, b_, p_, L_, s_, g_;
  std::vector<int> passive_;
  std::vector<char> banned_;
};

}  // namespace ugoki::contact
