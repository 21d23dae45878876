#pragma once
// Computes the closest points of every pair of characters and appends them to a display frame, when a page requests them.

#include <memory>
#include <span>
#include <vector>

#include "ugoki/collision/scene.h"
#include "ugoki/collision/scene_tree.h"
#include "ugoki/mechanism/mechanism.h"

namespace ugoki::studio {

class ClosestPairs {
 public:
  /// Maximum distance between the characters of a pair that is shown, m.
  static constexpr double max_distance = 3;
  /// Maximum number of pairs in a frame; the closest pairs are kept.
  static constexpr std::size_t max_pairs = 64;

  /// @param mechanisms mechanism of each character, in the order of the characters in display frames
  explicit ClosestPairs(std::vector<MechanismPtr> mechanisms);

  /// Returns a copy of `frame` followed by the closest points of every pair of characters (docs/studio-protocol.md). Returns `frame`
  /// itself if its characters or links do not match the mechanisms. The result is valid until the next call.
  [[nodiscard]] std::span<const std::byte> append_to(std::span<const std::byte> frame);

 private:
  struct Found {
    int a, b;  ///< indices of the characters, a < b
    collision::PairDistance near;
  };
  [[nodiscard]] bool read_poses(std::span<const std::byte> frame);
  void find();

  collision::Scene scene_;
  collision::SceneTree tree_;
  std::vector<std::vector<Pose>> poses_;  // poses of the links: [characters][links]
  std::vector<std::span<const Pose>> views_;
  std::vector<Found> found_;
  std::vector<std::byte> bytes_;
};

}  // namespace ugoki::studio
