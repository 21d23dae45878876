#pragma once
// The superior tree over a scene: the groups of the tree are the systems of the scene, the bodies are their shapes.

#include <memory>
#include <span>
#include <vector>

#include "ugoki/collision/pair_queries.h"
#include "ugoki/collision/scene.h"

namespace ugoki::collision {

/// Distance queries over the shapes of a scene. Body i is Scene::shapes()[i]. One instance for each thread.
class SceneTree {
 public:
  /// The scene must outlive this object. The self-collision switches are read here; later changes have no effect.
  explicit SceneTree(const Scene& scene);
  ~SceneTree();

  /// Moves the shapes to the given poses of the links; call it before the queries of a step.
  /// @param X_WB [systems][links] m, world
  void update(std::span<const std::span<const Pose>> X_WB);

  /// Closest pair of shapes of two systems. If system_a == system_b, only pairs that can collide are considered. Bodies -1: no pair.
  /// Each pair of systems has its own query, warm-started from step to step; the first call for a pair allocates it.
  [[nodiscard]] const NearPair& nearest(int system_a, int system_b);

  /// Finds all pairs with a distance <= `margin` [m], among the pairs that find_contacts() tests, without the ground.
  /// @param out cleared, then filled in the order of (a, b), with a < b
  void pairs_within(double margin, std::vector<NearPair>& out);

 private:
  class Distances;
  struct Query {
    int a, b;
    ClosestPair query;
  };

  const Scene& scene_;
  std::vector<Pose> poses_;  // [shapes] X_WS
  SuperiorTree tree_;
  std::unique_ptr<Distances> distances_;
  std::vector<std::unique_ptr<Query>> queries_;
  PairsWithin within_;
};

}  // namespace ugoki::collision
