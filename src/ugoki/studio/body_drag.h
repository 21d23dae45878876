#pragma once
// Drags a point of a body by hand while the body follows as a body: its links have inertia, its joints resist like muscles that hold a
// posture, stop at their limits, and it touches the floor and itself.

#include <span>
#include <vector>

#include "ugoki/collision/scene.h"
#include "ugoki/contact/contact_search.h"
#include "ugoki/contact/stepper.h"
#include "ugoki/dynamics/dynamics.h"
#include "ugoki/lsi/pull.h"
#include "ugoki/mechanism/mechanism.h"

namespace ugoki::studio {

struct BodyDragOptions {
  int link = 0;                              ///< the dragged link
  Vec3 point;                                ///< m: the dragged point in its frame
  std::vector<int> pins = {};                ///< links that keep their pose in the world; the dragged link is never pinned
  double ground = 0;                         ///< m, height of the floor
  static constexpr double step = 1.0 / 240;  ///< s
  static constexpr double posture = 4;       ///< rad/s: natural frequency with which each joint returns to its posture
  static constexpr double root_damping = 1;  ///< 1/s: rate at which the free root comes to rest
  static constexpr lsi::PullOptions pull = {.frequency = 16, .damping = 1, .max_weights = 3};  ///< of the hand
};

/// The state of one drag. The equations are those of contact/stepper.h without gravity, so that the posture does not sag. For a joint with
/// the displacement e from its posture and the inertia I of everything that it moves: tau = -I (posture^2 e + 2 posture v), implicit. The
/// free root has the damping I root_damping only.
class BodyDrag {
 public:
  /// @param q [nq] the pose at the beginning, which is also the posture; at rest
  BodyDrag(MechanismPtr mechanism, std::span<const double> q, BodyDragOptions options);

  /// Draws the point towards `target` [m, world] for `seconds`. Whole steps are made; the remainder is made by the next call, so that the
  /// result does not depend on how the time is split.
  /// Error: the simulation failed; the state is then that before the failed step.
  [[nodiscard]] Result<void> advance(const Vec3& target, double seconds);
  [[nodiscard]] std::span<const double> q() const { return q_; }  ///< [nq]
  [[nodiscard]] std::span<const double> v() const { return v_; }  ///< [nv]

 private:
  void set_posture();
  [[nodiscard]] bool is_ignored(const collision::ContactPoint& c) const;

  MechanismPtr mechanism_;
  BodyDragOptions options_;
  collision::Scene scene_;
  contact::ContactSearch search_;
  contact::Stepper stepper_;
  dynamics::Workspace ws_;
  std::vector<double> q_, v_, posture_;           // [nq], [nv], [nq]
  std::vector<double> tau_, gain_, velocity_;     // [nv] drives of a step
  std::vector<Vec6> external_;                    // [links]
  std::vector<char> pinned_;                      // [links]
  std::vector<std::pair<int, int>> overlapping_;  // pairs of links that overlap at the beginning
  double remainder_ = 0;                          // s, not yet simulated
};

}  // namespace ugoki::studio
