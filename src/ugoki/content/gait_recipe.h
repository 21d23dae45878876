#pragma once
// The recipe of a gait: the settings from which the motion of a clip was made without measured data. docs/scenario.md describes its JSON
// form. The recipe is data only; the module gait makes the motion.

#include <array>
#include <string>
#include <vector>

#include "ugoki/base/result.h"

namespace ugoki::content {

/// A further part of a gait, from `time` on.
struct GaitRecipeStage {
  double time = 0;            ///< s from the beginning of the motion
  std::string kind = "walk";  ///< name of a kind of gait
  double speed = 0;           ///< m/s, forward; 0: stand
  double turn = 0;            ///< degrees per second, positive to the left
  friend bool operator==(const GaitRecipeStage&, const GaitRecipeStage&) = default;
};

struct GaitRecipe {
  std::string kind = "walk";    ///< name of a kind of gait
  std::string style = "usual";  ///< name of a style
  double speed = -1;            ///< m/s, forward; -1: a usual speed of the kind for the body
  double turn = 0;              ///< degrees per second, positive to the left; not used if there is a path
  double seconds = 10;          ///< duration, s
  bool from_stand = true;       ///< the motion begins with standing
  bool to_stand = true;         ///< the motion ends with standing
  double step_height = 0;       ///< m: height of the swing feet; 0: usual
  std::vector<GaitRecipeStage> stages = {};
  /// Points of a path over the ground, m, in the frame of the clip's start: x ahead, y to the left. The path begins at the clip's start
  /// (0, 0), which is not in the list. Empty: `turn` decides.
  std::vector<std::array<double, 2>> path = {};
  friend bool operator==(const GaitRecipe&, const GaitRecipe&) = default;
};

/// Reports values that are out of range. Names of kinds and styles are checked when the motion is made.
void check_gait_recipe(const GaitRecipe& recipe, const std::string& location, Error& problems);

}  // namespace ugoki::content
