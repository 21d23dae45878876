#pragma once
// Bodies in coherent motion: characters of convex links, and heaps of capsules.

#include <vector>

#include "bodies.h"
#include "ugoki/collision/collider.h"
#include "ugoki/spatial/spatial.h"

namespace ugoki::benchmarks {

/// A motion in Ugoki's types, and as plain arrays for the peers (other libraries).
struct Motion {
  std::vector<collision::Collider> colliders;  ///< shapes, each in the frame of its body
  std::vector<int> groups;                     ///< [bodies] 0 or 1
  std::vector<Pose> poses;                     ///< [steps][bodies]
  PlainMotion plain;

  [[nodiscard]] std::span<const Pose> at(int step) const {
    return std::span(poses).subspan(static_cast<std::size_t>(step) * colliders.size(), colliders.size());
  }
};

/// Two groups of `characters` characters of 20 convex links (32 vertices each). They walk on circular paths. Joints turn by up to a few
/// degrees per step, and hands move by a few centimetres.
[[nodiscard]] Motion make_characters(int characters);

/// Drifting and turning capsules that fill about a tenth of a box.
[[nodiscard]] Motion make_swarm(int bodies);

}  // namespace ugoki::benchmarks
