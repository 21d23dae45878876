#pragma once
// Positions of the dog's joints in the standing position, shared by its mechanism and its motions. Metres; x forward, y left, z up,
// paws on z = 0.

#include "ugoki/spatial/spatial.h"

namespace ugoki::samples {

/// Joint positions of a left leg: hip, stifle, hock, knuckle (hind leg) or shoulder, elbow, carpus, knuckle (fore leg). y is half the
/// lateral distance between left and right paw.
struct DogLimb {
  Vec3 root, middle, end, knuckle;
};

inline constexpr Vec3 dog_root{0, 0, 0.510};
inline constexpr Vec3 dog_chest{0.235, 0, 0.508};
inline constexpr Vec3 dog_neck{0.510, 0, 0.535};
inline constexpr Vec3 dog_scapula{0.455, 0.062, 0.590};
inline constexpr DogLimb dog_fore{{0.560, 0.078, 0.432}, {0.462, 0.078, 0.318}, {0.470, 0.078, 0.118}, {0.488, 0.078, 0.034}};
inline constexpr DogLimb dog_hind{{-0.020, 0.074, 0.470}, {0.072, 0.074, 0.300}, {-0.100, 0.074, 0.152}, {-0.072, 0.074, 0.034}};

}  // namespace ugoki::samples
