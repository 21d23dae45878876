#pragma once
// Contacts of a step: those of the present positions, and those that fast bodies reach within the step.

#include <span>
#include <vector>

#include "ugoki/base/executor.h"
#include "ugoki/collision/scene.h"
#include "ugoki/contact/shared_poses.h"
#include "ugoki/contact/swept_contacts.h"

namespace ugoki::contact {

/// Finds the contacts of one step. The result depends on the given states alone, not on earlier calls.
class ContactSearch {
 public:
  /// Keeps a pointer to the scene, which must outlive this object. @param margin m: pairs of shapes up to this gap are contacts
  ContactSearch(const collision::Scene& scene, double margin);

  /// Computes poses on the threads of `executor`; null: on the calling thread. Scenes below min_parallel_dofs use the calling thread.
  void set_executor(Executor* executor);

  /// Uses poses from `poses` where it has those of the same positions; null: computes all poses.
  void set_shared_poses(SharedPoses* poses) { shared_ = poses; }

  /// Returns the contacts of a step of length dt [s]. The list is valid until the next call; the caller may change it.
  /// @param systems [systems of the scene] positions and velocities
  /// Allocates nothing after warm-up, unless the number of contacts grows.
  std::vector<collision::ContactPoint>& find(std::span<const collision::SystemMotion> systems, double dt);

 private:
  [[nodiscard]] bool is_fast(std::span<const collision::SystemMotion> systems, double dt) const;

  const collision::Scene* scene_;
  Executor* executor_ = nullptr;
  double margin_;
  collision::Workspace workspace_;
  SweptContacts swept_;
  std::vector<std::vector<Pose>> poses_;  // [systems][links]
  std::vector<std::span<const Pose>> views_;
  SharedPoses* shared_ = nullptr;
  std::vector<double> reach_;  // [systems] free body: maximum distance of its shapes from its origin, m; otherwise 0
  std::vector<collision::ContactPoint> contacts_;
};

}  // namespace ugoki::contact
