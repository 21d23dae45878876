#pragma once
// Contacts that things too fast for the margin of collision analysis will make within a step: a kicked ball, a sword.
//
// Conservative advancement (collision/advancement.h) finds when two bodies touch. The contact that is made of it stands at the present
// positions of the two points that will meet: its distance is what is left to close along the normal of the impact. The stepper lets
// them approach by that much and no more, and an impact with restitution takes place within the step. Only what is really hit
// gives a contact: nothing bounces off the continued plane of a plate that it flies past.

#include <span>
#include <vector>

#include "ugoki/collision/advancement.h"

namespace ugoki::contact {

class SweptContacts {
 public:
  /// The scene must outlive it.
  explicit SweptContacts(const collision::Scene& scene);

  /// Adds the first impact of every system within the step to what find_contacts() has found with the same margin.
  /// @param X_WB [systems][links] m, world: at the beginning
  /// @return contacts added
  int add(std::span<const collision::SystemMotion> systems, std::span<const std::span<const Pose>> X_WB, double dt, double margin,
          std::vector<collision::ContactPoint>& contacts);

 private:
  const collision::Scene* scene_;
  collision::ImpactSearch search_;
  std::vector<collision::SystemMotion> motions_;
  std::vector<double> still_;  // zeros
  std::vector<double> q_;      // of one system at the impact
  std::vector<Pose> X_;        // [links] of it
};

}  // namespace ugoki::contact
