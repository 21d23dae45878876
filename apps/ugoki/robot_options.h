#pragma once
// Options of verbs that read descriptions of mechanisms (URDF, SDF, MJCF).

#include <memory>
#include <string>

#include "ugoki/base/result.h"
#include "ugoki/robot_formats/robot_model.h"
#include "verb.h"

namespace ugoki::cli {

/// Values of the options that add_robot_options() declares.
struct RobotChoice {
  std::string base, meshes, inertias;  ///< values given to the options; empty: the option was not given
  bool require_meshes = false;
  std::string loops;  ///< path of the YAML file; empty: NAME.yaml in the folder of NAME.urdf, if it lists loops
};

/// Declares --base, --meshes, --require-meshes, --inertias and --loops.
void add_robot_options(Verb verb, RobotChoice& choice);

/// Makes the reader's options for a file; meshes are read from disk. Errors: the loops file cannot be read.
[[nodiscard]] Result<robot_formats::RobotOptions> robot_options(const std::string& path, const RobotChoice& choice);

}  // namespace ugoki::cli
