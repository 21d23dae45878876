#pragma once
// Anchor of balance control: the displacement of the reference.

#include <array>

#include "ugoki/control/balance_model.h"

namespace ugoki::control {

/// Keeps the standing foot of the reference at the standing foot of the character.
class ReferenceAnchor {
 public:
  /// Updates the displacement in `state`. During double support it moves from the rear to the front foot.
  /// @param dt s
  void update(const BalanceModel& model, double dt, BalanceState& state);
  /// m, horizontal: distance by which the DCM of the reference is ahead of its displacement D, which moves from foot to foot:
  /// the integral of D' exp(-w0 s) over the future s. @param w0 1/s
  [[nodiscard]] Vec3 ahead(double w0) const;

 private:
  static void home(const BalanceModel& model, const BalanceState& state, const Vec3& centre, Vec3& shift, double& turn);

  /// What decides the future share of a standing foot.
  struct Move {
    double since, until;  // s of the reference: since it landed, until it lifts
    Vec3 offset;          // m, world, horizontal: from the foot of the reference
  };
  struct Moves {
    std::array<Move, BalanceState::max_feet> feet;
    std::size_t count = 0;
    double landing = 0;              // s of the reference: until the next foot lands
    double rate = 1, max_share = 0;  // of the reference's time; s
  };
  Moves moves_;
};

}  // namespace ugoki::control
