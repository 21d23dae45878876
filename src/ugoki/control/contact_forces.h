#pragma once
// Which ground forces can give a figure the wrench that its wanted motion needs? A small quadratic program:
//   minimize  |W (G beta - w)|^2 + eps sum price_k beta_k^2   over   beta >= 0,
// where column k of G is the wrench of a unit force along edge k of a contact's friction pyramid. It is solved exactly through
// its dual, which has 6 unknowns whatever the number of contacts: W^-2 y + G max(0, G^T y) / eps = w, by Newton's
// method on a piecewise linear, strongly convex problem.
// Sources: Abe, da Silva, Popovic (2007); Qi, Sun (1993) for the semismooth method.

#include <array>
#include <span>
#include <vector>

#include "ugoki/spatial/spatial.h"

namespace ugoki::control {

/// A contact that can bear load: where, its normal (pointing at the figure) and its friction.
struct Support {
  Vec3 p;  ///< m, world
  Vec3 n;  ///< unit, world
  double friction = 0;
  double price = 1;  ///< factor on the price of squared force here
};

class ContactForceProblem {
 public:
  /// Room for this many supports without allocation.
  explicit ContactForceProblem(std::size_t capacity = 64);

  /// @param wrench the wrench to be given: moment about `origin` [N m], force [N], world axes
  /// @param lever m: moments count as forces at this distance
  /// @param softness eps: price of squared contact force against squared missing force
  /// @param forces [supports, out] N, world axes, inside the friction pyramids
  /// @return what is missing: wrench minus the forces' wrench
  Vec6 solve(std::span<const Support> supports, const Vec3& origin, const Vec6& wrench, double lever, double softness,
             std::span<Vec3> forces);

  /// Newton steps of the last call.
  [[nodiscard]] int iterations() const { return iterations_; }

 private:
  std::vector<Vec6> columns_;  // 4 for each support, moments divided by the lever
  std::vector<Vec3> edges_;
  int iterations_ = 0;
};

}  // namespace ugoki::control
