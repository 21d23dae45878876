#pragma once
// Contact forces that provide the wrench w of a character's wanted motion. They are the solution of a small quadratic program:
//   minimize  |W (G beta - w)|^2 + eps sum cost_k beta_k^2   over   beta >= 0
// Column k of G is the wrench of a unit force along edge k of a contact's friction pyramid; beta_k [N] is the force along this edge, with
// the cost eps cost_k beta_k^2. W weights forces by 1 and moments by 1 / lever. The program is solved exactly through its dual problem,
// which is strongly convex and has 6 unknowns y for any number of contacts: W^-2 y + G max(0, G^T y) / eps = w (for cost_k = 1). This
// equation is piecewise linear and is solved by Newton's method.
// Sources: Abe, da Silva, Popovic (2007); Qi, Sun (1993) for the semismooth method.

#include <array>
#include <span>
#include <vector>

#include "ugoki/spatial/spatial.h"

namespace ugoki::control {

/// A contact that can bear load.
struct Support {
  Vec3 p;               ///< m, world: contact point
  Vec3 n;               ///< unit, world: normal, towards the character
  double friction = 0;  ///< Coulomb coefficient
  double cost = 1;      ///< factor on the cost of the squared force at this contact
  Vec3 along{1, 0, 0};  ///< world, not parallel to n: direction of the first edge of the friction pyramid, for example the heading
};

/// Solves the quadratic program at the top of this file.
class ContactForceProblem {
 public:
  /// Reserves memory for `capacity` supports; solve() allocates memory only for more supports.
  explicit ContactForceProblem(std::size_t capacity = 64);

  /// @param origin   m, world: reference point of `wrench` and of the result
  /// @param wrench   wanted: moment about `origin` [N m], force [N], world axes
  /// @param lever    m: a moment M has the same weight as a force M / lever
  /// @param softness eps: cost of squared contact force relative to squared missing force
  /// @param forces [supports, out] N, world axes, inside the friction pyramids
  /// @return missing wrench: `wrench` minus the wrench of the forces
  Vec6 solve(std::span<const Support> supports, const Vec3& origin, const Vec6& wrench, double lever, double softness,
             std::span<Vec3> forces);

  /// Newton steps of the last solve(), at most 50.
  [[nodiscard]] int iterations() const { return iterations_; }

 private:
  // The four edges of a support are in SIMD lanes.
  std::vector<double> edges_;    // [supports][3][4] edges of the friction pyramids, divided by sqrt(cost)
  std::vector<double> columns_;  // [supports][6][4] columns of the map G from edge forces to root moment and force; moments are divided by
                                 // a length, so that all are in N
  std::vector<double> scaled_;   // [supports][6][4] columns / eps of the edges that bear load; zeros for the other edges
  std::vector<double> pressed_;  // [supports][4] G^T y, N: an edge bears load where it is positive
  std::vector<double> loaded_;   // [supports][4] 1: the edge bears load in the equation of the present Newton step; else 0
  int iterations_ = 0;
};

}  // namespace ugoki::control
