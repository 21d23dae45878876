#pragma once
// FBX and COLLADA files of the tests' own making, through assimp's exporters and as text.

#include <string>

#include "ugoki/motion/skeleton.h"

namespace ugoki::scene_formats {

/// A skeleton of a dozen joints that turns and moves at random. Rest poses are as the readers make them.
[[nodiscard]] MeasuredMotion random_motion(unsigned seed, int frames = 20);

struct MadeOptions {
  std::string format = "fbxa";  ///< of assimp's exporters: "fbxa" (ASCII FBX), "collada"; its binary FBX it cannot read itself
  double units_per_metre = 1;
  bool skin = true;  ///< a mesh with bones
};
/// The motion as such a file, Y up. Nodes have rest rotations of their own.
[[nodiscard]] std::string make_scene_file(const MeasuredMotion& motion, const MadeOptions& options);

/// A COLLADA text written by hand: two joints, `up` ("Y_UP", "Z_UP", "X_UP"), metres in a unit; the second joint turns by 90 degrees about
/// the file's x in one second.
[[nodiscard]] std::string collada_text(const std::string& up, double metre);

}  // namespace ugoki::scene_formats
