#pragma once
// Broad phase of collision detection for crowds: finds the close pairs of shapes with a superior tree (superior_tree.h) over their bounding
// spheres, instead of testing all pairs. The result depends only on the current spheres, not on earlier calls.

#include <cstdint>
#include <span>
#include <vector>

#include "ugoki/collision/pair_queries.h"
#include "ugoki/collision/scene.h"

namespace ugoki::collision {

class BroadPhase {
 public:
  /// True if find() is faster for this scene than testing all pairs. O(systems)
  [[nodiscard]] static bool is_faster(const Scene& scene);
  /// True if find() includes the pairs of shapes inside this system. If false, testing all of Scene::self_pairs() is as fast.
  [[nodiscard]] static bool covers(const Scene& scene, int system);

  /// Returns pairs (a, b), a < b, of indices into Scene::shapes(), sorted by (a, b). The list contains all pairs whose spheres are closer
  /// than `margin` [m] and of which at least one shape is movable. Pairs of movable shapes of the same system are contained only if
  /// covers() is true for this system. The list may also contain pairs that are farther apart than `margin`. The span is valid until the
  /// next call. No allocation in coherent motion.
  /// @param balls [shapes] m, world: bounding spheres; spheres that are not finite are in no pair
  [[nodiscard]] std::span<const BodyPair> find(const Scene& scene, std::span<const Workspace::Ball> balls, double margin);

 private:
  void begin(const Scene& scene);

  std::uint64_t content_ = 0;          // Scene::content() of the scene that tree_ was built for
  std::vector<std::uint8_t> covered_;  // [systems] result of covers()
  std::vector<Pose> centres_;          // [shapes] world: unrotated poses at the centres of the bounding spheres
  SuperiorTree tree_;
  BoxesWithin within_{PairFilter{}};
  std::vector<BodyPair> found_;
};

}  // namespace ugoki::collision
