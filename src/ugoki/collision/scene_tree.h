#pragma once
// The superior tree over a scene: its systems are the groups, their shapes the bodies.

#include <memory>
#include <span>
#include <vector>

#include "ugoki/collision/pair_queries.h"
#include "ugoki/collision/scene.h"

namespace ugoki::collision {

/// Questions about the distances of a scene's shapes. Body i is Scene::shapes()[i]. One for each thread.
class SceneTree {
 public:
  /// The scene must outlive it; its switches of self-collision are taken as they are now.
  explicit SceneTree(const Scene& scene);
  ~SceneTree();

  /// @param X_WB [systems][links] m, world
  void update(std::span<const std::span<const Pose>> X_WB);

  /// Nearest pair of shapes of two systems, which may be the same one: then of the pairs that can collide. Bodies -1: there is none.
  /// Keeps what it found for the next step; the first question about two systems allocates.
  [[nodiscard]] const NearPair& nearest(int system_a, int system_b);

  /// All pairs closer than `margin`, of those that find_contacts looks at, without the ground; in the order of (a, b).
  void pairs_within(double margin, std::vector<NearPair>& out);

 private:
  class Distances;
  struct Question {
    int a, b;
    NearestPair query;
  };

  const Scene& scene_;
  std::vector<Pose> poses_;  // [shapes] X_WS
  SuperiorTree tree_;
  std::unique_ptr<Distances> distances_;
  std::vector<std::unique_ptr<Question>> questions_;
  PairsWithin within_;
};

}  // namespace ugoki::collision
