#pragma once
// The floor under measured motion: where the feet stand still, and the plane through those places.

#include <span>
#include <vector>

#include "ugoki/body/body.h"

namespace ugoki::body {

/// Where one foot stands flat and still.
struct Stance {
  std::vector<int> frames;  ///< frames in which it does
  double ball_height = 0;   ///< m, median height of the ball along the floor's normal
  Vec3 foot_up, toes_up;    ///< the floor's normal in the foot's and in the toes' frame, median over these frames
};

struct FloorFit {
  bool found = false;
  Mat3 R_level = Mat3::identity();  ///< turns measured directions so that the floor's normal becomes z
  double tilt = 0;                  ///< rad, angle of the floor against the level in the measured data
  std::vector<Stance> stances;      ///< [soles]
};

/// Finds frames in which each foot stands (both ankle and ball slower than 0.2 m/s, near the lowest height at which it
/// does so; slower feet first if there are too few; where feet would go through that floor, as they do when somebody walks on the
/// spot, all frames in which they are lowest) and, if the stance places tell it clearly, the floor's tilt.
/// Heights of the balls are measured after levelling. @param height m, of the person
[[nodiscard]] FloorFit fit_floor(const MeasuredMotion& motion, std::span<const Sole> soles, double height);

}  // namespace ugoki::body
