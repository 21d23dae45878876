#pragma once
// Kinematics of one mechanism that several users need at the same state: collision analysis, motion control and the step of one tick.

#include <array>
#include <deque>
#include <span>
#include <vector>

#include "ugoki/dynamics/dynamics.h"

namespace ugoki::dynamics {

/// Kinematics of a mechanism with the state to which they belong.
struct KinematicsAt {
  explicit KinematicsAt(const Mechanism& m);
  std::vector<double> q, v;  ///< [nq], [nv]
  Kinematics kinematics;     ///< results of update_kinematics(q, v)
};

/// Kinematics of the last two states that one user has computed and others copy: those at the beginning and at the end of a step.
/// Kinematics depend on q and v alone: a user who asks for another state, or while another user is at work, computes them itself and gets
/// the same bits. Users may therefore run at the same time. Allocates nothing, except in update() while another user is at work.
class SharedKinematics {
 public:
  explicit SharedKinematics(const Mechanism& m);
  SharedKinematics(const SharedKinematics&) = delete;
  SharedKinematics& operator=(const SharedKinematics&) = delete;

  /// Copies the kinematics at q and v to `to`. @return false: they are not known; `to` does not change
  [[nodiscard]] bool find(std::span<const double> q, std::span<const double> v, Kinematics& to);
  /// Copies the poses and velocities of the links at q and v. Computes the kinematics and keeps them, if they are not known.
  /// @param X_WB [links, out] m, world @param V [links, out] rad/s, m/s: velocities about the first link's origin, world
  void update(const Mechanism& m, std::span<const double> q, std::span<const double> v, std::span<Pose> X_WB, std::span<Vec6> V);
  /// Keeps `next`, and gives the older kinematics in exchange.
  void exchange(KinematicsAt& next);

 private:
  [[nodiscard]] const KinematicsAt* known_at(std::span<const double> q, std::span<const double> v) const;
  KinematicsAt& older() { return values_[1 - newer_]; }

  bool busy_ = false;  // atomic: a user is at work
  std::array<KinematicsAt, 2> values_;
  std::array<bool, 2> known_{};
  std::size_t newer_ = 0;  // index of the kinematics that were kept last
};

/// Shared kinematics of the mechanisms of a scene, one for each system.
using SceneKinematics = std::deque<SharedKinematics>;
[[nodiscard]] SceneKinematics make_scene_kinematics(std::span<const MechanismPtr> systems);

/// update_kinematics(); copies the results from `shared` if it has them. @param shared null: nothing is shared
void update_kinematics(const Mechanism& m, std::span<const double> q, std::span<const double> v, SharedKinematics* shared, Kinematics& k);

}  // namespace ugoki::dynamics
