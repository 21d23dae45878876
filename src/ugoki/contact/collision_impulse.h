#pragma once
// Collision force: the impulse between two link systems, open or closed (paper, section 6.3, eqs. (6)-(19)).
//
// At one contact, r the normal from L towards R, u = r . (velocity of R - velocity of L), for every system that takes part
//   MJ_R = M_R^-1 J_R^T r,  MJ_L = -M_L^-1 J_L^T r                                        (15) (16)
//   p = f dt = -b / a,   a = MJ_R^T M_R MJ_R + MJ_L^T M_L MJ_L,   b = (1 + e) u           (12)-(14), with restitution e
//   v' = v + MJ p                                                                          (18) (19)
// e = 1 is the paper's (its b = 2 u conserves kinetic energy). In a closed system MJ is projected onto the velocities that the
// loops allow, in the metric of M: H (H^T M H)^-1 H^T J^T r, which is the paper's M_G and J H.
//
// Several contacts: the law is sequential. The pair of links that approach fastest collides; a pair's contacts (the corners of a
// box) and pairs that tie with it collide at once:
//   p >= 0,   u' + e u >= 0,   p (u' + e u) = 0     over the approaching contacts of the group,
// and so on until nothing approaches. Every collision conserves momentum, and energy where e = 1; Newton's cradle comes out as
// observed. What still approaches at last (e = 0, or bounces without end) is stopped by one plastic collision of all contacts.
// Sources: Nagashima (1999), section 6.3; Glocker (2001), Set-valued force laws; Lawson, Hanson (1974) for the active set.

#include <span>
#include <vector>

#include "ugoki/collision/contact_point.h"
#include "ugoki/dynamics/closed_impulse.h"
#include "ugoki/dynamics/closed_links.h"
#include "ugoki/dynamics/dynamics.h"

namespace ugoki::contact {

/// One link system as the impulse sees it. `workspace` holds the kinematics of (q, v).
struct LinkSystem {
  const Mechanism* mechanism = nullptr;
  dynamics::Workspace* workspace = nullptr;
  dynamics::ClosedLinks* loops = nullptr;  ///< null: an open system
  std::span<const double> q;
  std::span<double> v;  ///< [nv] in: before, out: after. Of a closed system: velocities that its loops allow
};

struct ImpactOptions {
  double least_speed = 0;  ///< m/s: slower approaches do not bounce
  double reach = 0;        ///< s: contacts take part whose gap would close within it; 0: all
  bool plastic = true;     ///< what approaches at last is stopped
};

enum class ImpactStatus : unsigned char {
  ok,
  singular,    ///< the inertia of `system` is not positive
  unfinished,  ///< too many collisions in one instant; with `plastic` what was left is stopped
};

struct ImpactReport {
  ImpactStatus status = ImpactStatus::ok;
  int system = -1;
  int collisions = 0;
  double approach = 0;  ///< m/s: greatest approach left of a contact that takes part and is not slower than least_speed
};

class CollisionImpulse {
 public:
  /// Contacts' system_a and system_b index `systems`; -1: the ground. Systems that nothing hits are not touched.
  /// Allocates nothing once it has seen as many contacts and freedoms.
  ImpactReport collide(std::span<const LinkSystem> systems, std::span<const collision::ContactPoint> contacts,
                       const ImpactOptions& options);

  /// N s: normal impulse of each contact in the last call, on its body a along n.
  [[nodiscard]] std::span<const double> impulses() const { return impulses_; }

 private:
  struct Side {
    int system = -1;
    int row = 0;  // of rows_ and jumps_, [nv]
  };
  struct Row {
    int contact = 0;
    Side sides[2];
    bool has_jump = false;
    double u = 0;     // m/s, now
    double open = 0;  // 1/kg: a of the same systems without their loops
    double e = 0;
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
  std::vector<double> rows_;    // r^T J of each side; M MJ, which is the same along the loops, once its jump is known
  std::vector<double> plain_;   // r^T J as it is
  std::vector<double> jumps_;   // MJ of each side
  std::vector<char> factored_;  // [systems]
  std::vector<double> impulses_;
  double rounding_ = 0;                     // m/s: slower approaches are none
  std::vector<int> group_;                  // into list_
  std::vector<int> fastest_;                // contacts that approach fastest
  std::vector<char> struck_;                // [systems] by the last collision
  std::vector<std::size_t> struck_list_;    // the same
  std::vector<std::size_t> first_freedom_;  // [systems + 1]
  std::vector<double> change_;              // [freedoms of all systems] of the velocities of those struck
  std::vector<double> A_, b_, p_, L_, s_, g_;
  std::vector<int> passive_;
  std::vector<char> banned_;
};

}  // namespace ugoki::contact
