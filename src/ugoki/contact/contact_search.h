#pragma once
// Contacts of a step: those of the present positions, and those that fast bodies reach within the step.

#include <span>
#include <vector>

#include "ugoki/base/executor.h"
#include "ugoki/collision/scene.h"
#include "ugoki/contact/swept_contacts.h"
#include "ugoki/dynamics/known_kinematics.h"

namespace ugoki::contact {

/// Finds the contacts of one step. The result depends on the given states alone, not on earlier calls.
class ContactSearch {
 public:
  /// Keeps a pointer to the scene, which must outlive this object. @param margin m: pairs of shapes up to this gap are contacts
  ContactSearch(const collision::Scene& scene, double margin);

  /// Computes poses on the threads of `executor`; null: on the calling thread. Scenes below min_parallel_dofs use the calling thread.
  void set_executor(Executor* executor);

  /// Returns the contacts of a step of length dt [s]. The list is valid until the next call; the caller may change it.
  /// @param systems [systems of the scene] positions and velocities
  /// @param known [systems of the scene] may have the kinematics of the states; empty: nothing is known
  /// Allocates nothing after warm-up, unless the number of contacts grows.
  std::vector<collision::ContactPoint>& find(std::span<const collision::SystemMotion> systems, double dt,
                                             std::span<const dynamics::KnownKinematics> known = {});

 private:
  [[nodiscard]] bool is_fast(std::size_t system, const dynamics::Kinematics& k, double dt) const;

  const collision::Scene* scene_;
  Executor* executor_ = nullptr;
  double margin_;
  collision::Workspace workspace_;
  SweptContacts swept_;
  std::vector<dynamics::KnownKinematics> own_;  // [systems] kinematics that were not known
  std::vector<std::span<const Pose>> views_;    // [systems] poses of the links
  std::vector<std::vector<double>> sizes_;      // [systems][links] m: radius about the link's origin that contains its shapes; -1: no shape
  std::vector<char> fast_;                      // [systems] result of is_fast()
  std::vector<collision::ContactPoint> contacts_;
};

}  // namespace ugoki::contact
