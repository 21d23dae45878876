#pragma once
// Posture of the legs: the reference with legs that reach the places of their feet.

#include <vector>

#include "ugoki/control/balance_model.h"

namespace ugoki::control {

/// Inverse kinematics of the standing legs below the pelvis of the reference. Where the ground is higher, lower or steeper than in the
/// reference, the joints of the leg have other angles than in the reference. Two feet: horizontal displacements are not adapted, because
/// the reference is displaced to the standing foot. Several standing feet have different displacements: the legs of characters on more than
/// two feet, also those in swing, are adapted to them.
class LegPosture {
 public:
  explicit LegPosture(const BalanceModel& model);
  /// Computes positions(): O(legs * DOFs of a leg^3). Damped least squares (Levenberg 1944), from the reference. Call after
  /// BalanceModel::sample_reference() and GroundPlan::update().
  void update(const BalanceModel& model, const BalanceState& state);
  /// [nq] the reference with adapted legs
  [[nodiscard]] std::span<const double> positions() const { return q_; }

 private:
  static constexpr std::size_t max_dofs = 12;  // of a leg; further DOFs keep the posture of the reference
  [[nodiscard]] bool move_leg(const BalanceModel& model, std::size_t foot);

  dynamics::Workspace ws_;
  std::vector<double> q_, zero_, step_;
  std::vector<Pose> goal_;              // [feet] m, world: position of the sole, orientation of the foot's link
  std::vector<unsigned char> reaches_;  // [feet] 1: the foot stands
  std::vector<std::vector<int>> dofs_;  // [feet] velocity indices of the leg
};

}  // namespace ugoki::control
