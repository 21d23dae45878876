#pragma once
// Kinematics of one mechanism that are known already at some state, so that several users need not compute them: collision analysis, motion
// control and the next step use those at the end of a step.

#include <span>
#include <vector>

#include "ugoki/dynamics/dynamics.h"

namespace ugoki::dynamics {

/// Kinematics of a mechanism with the state to which they belong. Kinematics depend on q and v alone: a user with another state computes
/// them itself and gets the same bits. Allocates in its constructor only.
class KnownKinematics {
 public:
  explicit KnownKinematics(const Mechanism& m);

  /// Computes the kinematics at q and v.
  void update(const Mechanism& m, std::span<const double> q, std::span<const double> v);
  /// Returns the kinematics if they belong to q and v (equal bits), otherwise null.
  [[nodiscard]] const Kinematics* find(std::span<const double> q, std::span<const double> v) const;
  /// Kinematics of the last update(); zeros before the first one.
  [[nodiscard]] const Kinematics& values() const { return kinematics_; }

 private:
  bool is_known_ = false;      // update() was called
  std::vector<double> q_, v_;  // [nq], [nv]
  Kinematics kinematics_;
};

/// update_kinematics(); copies the results from `known` if it has them. @param known null: nothing is known
void update_kinematics(const Mechanism& m, std::span<const double> q, std::span<const double> v, const KnownKinematics* known,
                       Kinematics& k);

}  // namespace ugoki::dynamics
