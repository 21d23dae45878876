#pragma once
// Contacts that things too fast for the margin of collision analysis will make within a step: a kicked ball, a sword.
//
// Conservative advancement (collision/advancement.h) finds when two bodies touch, at time t, and the contact points of that moment are
// carried back to where they are now. With u the velocity at which such a point opens now, its distance is
//   d = d(t) - t u,
// so that velocities v' = (t / dt) v, which lead exactly to the impact however far the bodies turn, are those that the stepper, which asks
// for d + dt u' >= 0, just lets through. An impact with restitution takes place within the step. Only what is really hit gives a
// contact: nothing bounces off the continued plane of a plate that it flies past.

#include <memory>
#include <span>
#include <vector>

#include "ugoki/collision/advancement.h"
#include "ugoki/collision/contact_manifold.h"
#include "ugoki/dynamics/dynamics.h"

namespace ugoki::contact {

class SweptContacts {
 public:
  /// The scene must outlive it.
  explicit SweptContacts(const collision::Scene& scene);

  /// Adds the first impact of every system within the step to what find_contacts() has found with the same margin.
  /// @param X_WB [systems][links] m, world: at the beginning
  /// No allocation but at a system's first impact.
  /// @return impacts found
  int add(std::span<const collision::SystemMotion> systems, std::span<const std::span<const Pose>> X_WB, double dt, double margin,
          std::vector<collision::ContactPoint>& contacts);

 private:
  /// A system at the present and at the impact.
  struct Side {
    int system = -1;
    int link = 0;
    Pose now, then;
    [[nodiscard]] Vec3 back(const Vec3& p) const { return system < 0 ? p : now * (then.inverse() * p); }
    [[nodiscard]] Vec3 back_with(const Vec3& n) const { return system < 0 ? n : now.R * transpose_times(then.R, n); }
  };
  Side side_at(int system, int link, std::span<const std::span<const Pose>> X_WB, double time);
  void find_points(const collision::SceneImpact& impact, const Side& a, const Side& b, double margin);

  const collision::Scene* scene_;
  collision::ImpactSearch search_;
  std::vector<collision::SystemMotion> motions_;
  std::vector<double> still_;                                     // zeros
  std::vector<double> q_;                                         // of one system at the impact
  std::vector<Pose> X_;                                           // [links] of it
  std::vector<std::unique_ptr<dynamics::Workspace>> kinematics_;  // [systems] those that ever met something
  collision::ManifoldWorkspace work_;
  collision::Manifold points_;
};

}  // namespace ugoki::contact
