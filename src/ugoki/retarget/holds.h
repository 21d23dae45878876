#pragma once
// Detects hands that hold a fixed object, or hold each other, from the wrists' paths. Internal to retarget.

#include <array>
#include <span>
#include <string>
#include <vector>

#include "ugoki/spatial/vec3.h"

namespace ugoki::retarget {

/// A range of frames in which a hand holds a fixed object or the other hand.
struct Hold {
  enum class Kind {
    fixed,    ///< the hand stays at one point of the world while the body moves
    together  ///< both hands move and keep the distance between them
  };
  Kind kind = Kind::fixed;
  int hand = 0;             ///< 0 left, 1 right; not used (0) for `together`
  int first = 0, last = 0;  ///< frames, both included
  Vec3 point;               ///< m, in the source's world: mean position of the wrist; not used for `together`
};

/// Finds all holds in the paths of the source's wrists. O(frames).
/// @param hands [left, right][frames] m, positions of the wrists in the world; empty if there is no hand
/// @param hips [frames] m, midpoint of the hips @param rate frames/s
/// @param size m, length of the source's legs
[[nodiscard]] std::vector<Hold> find_holds(const std::array<std::vector<Vec3>, 2>& hands, std::span<const Vec3> hips, double rate,
                                           double size);

/// Weight of a hold in a frame: 1 inside the hold, decreasing smoothly to 0 within 0.17 s before and after it.
[[nodiscard]] double weight_of(const Hold& hold, int frame, double rate);

/// Sentence for display: "The left hand holds still in frames 10 to 80."
[[nodiscard]] std::string text_of(const Hold& hold);

}  // namespace ugoki::retarget
