#pragma once
// Which shapes of a scene are near each other, in crowds: the superior tree over their bounding spheres, instead of all pairs.
// What it gives depends on the present spheres alone, not on how they came there.

#include <cstdint>
#include <span>
#include <vector>

#include "ugoki/collision/pair_queries.h"
#include "ugoki/collision/scene.h"

namespace ugoki::collision {

class BroadPhase {
 public:
  /// Is this cheaper than looking at all pairs? O(systems)
  [[nodiscard]] static bool pays(const Scene& scene);
  /// The pairs inside this system are among those of find(); where not, Scene::self_pairs() is short enough to be gone through.
  [[nodiscard]] static bool covers(const Scene& scene, int system);

  /// All pairs of shapes whose spheres are closer than `margin` and which belong to different systems, one of them movable, or to one
  /// system that is covered; in the order of (a, b), a < b. Among them are some that are not that near.
  /// @param balls [shapes] world; those that are not finite are near nothing
  /// No allocation in coherent motion.
  [[nodiscard]] std::span<const BodyPair> find(const Scene& scene, std::span<const Workspace::Ball> balls, double margin);

 private:
  void begin(const Scene& scene);

  std::uint64_t content_ = 0;
  std::vector<std::uint8_t> covered_;  // [systems]
  std::vector<Pose> centres_;          // [shapes]
  SuperiorTree tree_;
  BoxesWithin within_{PairFilter{}};
  std::vector<BodyPair> found_;
};

}  // namespace ugoki::collision
