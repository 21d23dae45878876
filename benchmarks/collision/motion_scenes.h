#pragma once
// Bodies in coherent motion: figures of convex links, and heaps of capsules.

#include <vector>

#include "bodies.h"
#include "ugoki/collision/collider.h"
#include "ugoki/spatial/spatial.h"

namespace ugoki::benchmarks {

/// The same for us and, as plain numbers, for the peers.
struct Motion {
  std::vector<collision::Collider> colliders;  ///< shape's frame = body's frame
  std::vector<int> groups;                     ///< [bodies] 0 or 1
  std::vector<Pose> poses;                     ///< [steps][bodies]
  PlainMotion plain;

  [[nodiscard]] std::span<const Pose> at(int step) const {
    return std::span(poses).subspan(static_cast<std::size_t>(step) * colliders.size(), colliders.size());
  }
};

/// Two groups of `figures` figures of 20 convex links (32 vertices each) that walk on circles and swing their joints by up to a few
/// degrees a step, hands by a few centimetres.
[[nodiscard]] Motion make_figures(int figures);

/// Capsules in a box that they fill to about a tenth, each drifting and turning.
[[nodiscard]] Motion make_swarm(int bodies);

}  // namespace ugoki::benchmarks
