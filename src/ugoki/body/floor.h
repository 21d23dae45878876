#pragma once
// Finds the floor under a measured motion: the plane through the positions at which the feet stand still.

#include <span>
#include <vector>

#include "ugoki/body/body.h"

namespace ugoki::body {

/// Frames in which one foot stands flat and still.
struct Stance {
  std::vector<int> frames;  ///< indices of these frames
  double ball_height = 0;   ///< m, median height of the ball along the floor's normal
  Vec3 foot_up, toes_up;    ///< unit, floor normal in the link frames of foot and toes, median over `frames`
};

/// Result of fit_floor.
struct FloorFit {
  bool found = false;               ///< at least one foot stands still in at least one frame
  Mat3 R_level = Mat3::identity();  ///< rotates measured directions so that the floor's normal becomes z
  double tilt = 0;                  ///< rad, angle between the measured floor and the horizontal plane
  std::vector<Stance> stances;      ///< [soles]
};

/// Finds the frames in which each foot stands, and the floor's tilt if the stance positions determine it.
/// A foot stands if ankle and ball are slower than 0.2 m/s (0.4 or 0.8 m/s if too few frames qualify; speeds scale with height / 1.7 m) and
/// the ball is low: at most 4 cm (for 1.7 m) above the 10th percentile of the slow balls' heights. If feet go below the floor found from
/// slow feet (walking on the spot), the frames with the lowest feet count instead. A character that walks in place
/// (motion/missing_travel.h) is looked at with the travel of its steps. Ball heights are measured after levelling.
/// @param height m, of the person
[[nodiscard]] FloorFit fit_floor(const MeasuredMotion& motion, std::span<const Sole> soles, double height);

}  // namespace ugoki::body
