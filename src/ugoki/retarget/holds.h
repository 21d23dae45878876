#pragma once
// Hands that hold something: what stays at rest while the body moves, or the other hand. Internal to retarget.

#include <array>
#include <span>
#include <string>
#include <vector>

#include "ugoki/spatial/vec3.h"

namespace ugoki::retarget {

struct Hold {
  enum class Kind {
    place,    ///< a hand stays where it is while the body moves
    together  ///< both hands move, at the same distance
  };
  Kind kind = Kind::place;
  int hand = 0;             ///< 0 left, 1 right; together: 0
  int first = 0, last = 0;  ///< frames
  Vec3 place;               ///< m, in the source's world
};

/// Finds them in the paths of the source's wrists.
/// @param hands [2][frames] m, in the world; empty where there is no hand @param hips [frames] m
/// @param size m, length of the source's legs
[[nodiscard]] std::vector<Hold> find_holds(const std::array<std::vector<Vec3>, 2>& hands, std::span<const Vec3> hips, double rate,
                                           double size);

/// Share of a hold that counts in a frame: 1 inside, falling to 0 within a sixth of a second beside it.
[[nodiscard]] double weight_of(const Hold& hold, int frame, double rate);

/// "left hand holds still in frames 10 to 80"
[[nodiscard]] std::string text_of(const Hold& hold);

}  // namespace ugoki::retarget
