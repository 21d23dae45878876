#pragma once
// The nearest points of figures and things, added to a display frame for those who want to see them.

#include <memory>
#include <span>
#include <vector>

#include "ugoki/collision/scene.h"
#include "ugoki/collision/scene_tree.h"
#include "ugoki/mechanism/mechanism.h"

namespace ugoki::studio {

class NearestPairs {
 public:
  /// Farther than this nothing is shown, m.
  static constexpr double farthest = 3;
  /// Pairs in a frame, the nearest ones.
  static constexpr std::size_t most = 64;

  /// @param mechanisms of the characters, in the order of the frames
  explicit NearestPairs(std::vector<MechanismPtr> mechanisms);

  /// The frame, and behind it the nearest pair of each two characters (docs/studio-protocol.md). A frame of another form stays as it is.
  [[nodiscard]] std::span<const std::byte> added_to(std::span<const std::byte> frame);

 private:
  struct Found {
    int a, b;
    collision::PairDistance near;
  };
  [[nodiscard]] bool read_poses(std::span<const std::byte> frame);
  void find();

  collision::Scene scene_;
  collision::SceneTree tree_;
  std::vector<std::vector<Pose>> poses_;  // [characters][links]
  std::vector<std::span<const Pose>> views_;
  std::vector<Found> found_;
  std::vector<std::byte> bytes_;
};

}  // namespace ugoki::studio
