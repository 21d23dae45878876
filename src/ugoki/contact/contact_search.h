#pragma once
// Contacts of a step: those of the present positions, and those that fast bodies reach within the step.

#include <memory>
#include <span>
#include <vector>

#include "ugoki/base/executor.h"
#include "ugoki/collision/scene.h"
#include "ugoki/contact/swept_contacts.h"
#include "ugoki/dynamics/shared_kinematics.h"

namespace ugoki::contact {

/// Finds the contacts of one step. The result depends on the given states alone, not on earlier calls.
class ContactSearch {
 public:
  /// Keeps a pointer to the scene, which must outlive this object. @param margin m: pairs of shapes up to this gap are contacts
  ContactSearch(const collision::Scene& scene, double margin);

  /// Computes poses on the threads of `executor`; null: on the calling thread. Scenes below min_parallel_dofs use the calling thread.
  void set_executor(Executor* executor);

  /// Uses the kinematics of `shared`, which must outlive this object, and leaves those of the states there. @param shared [systems]
  void set_shared_kinematics(dynamics::SceneKinematics& shared) {
    shared_ = &shared;
    own_.reset();
  }

  /// Returns the contacts of a step of length dt [s]. The list is valid until the next call; the caller may change it.
  /// @param systems [systems of the scene] positions and velocities
  /// Allocates nothing after warm-up, unless the number of contacts grows.
  std::vector<collision::ContactPoint>& find(std::span<const collision::SystemMotion> systems, double dt);

 private:
  [[nodiscard]] bool is_fast(std::size_t system, double dt) const;

  const collision::Scene* scene_;
  Executor* executor_ = nullptr;
  double margin_;
  collision::Workspace workspace_;
  SweptContacts swept_;
  std::vector<std::vector<Pose>> poses_;   // [systems][links]
  std::vector<std::vector<Vec6>> speeds_;  // [systems][links] rad/s, m/s: velocities about the first link's origin
  std::vector<std::span<const Pose>> views_;
  std::unique_ptr<dynamics::SceneKinematics> own_;  // null: kinematics are shared
  dynamics::SceneKinematics* shared_;
  std::vector<std::vector<double>> sizes_;  // [systems][links] m: radius about the link's origin that contains its shapes; -1: no shape
  std::vector<char> fast_;                  // [systems] result of is_fast()
  std::vector<collision::ContactPoint> contacts_;
};

}  // namespace ugoki::contact
