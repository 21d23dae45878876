#pragma once
// What a verb's options say about descriptions of mechanisms (URDF, SDF, MJCF).

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "ugoki/base/result.h"
#include "ugoki/robot_formats/robot_model.h"

namespace ugoki::cli {

struct RobotChoice {
  std::string base, meshes, inertias;  ///< words of the options; empty: not given
  bool require_meshes = false;
  std::string loops;  ///< path of the YAML file; empty: the one of the same name beside the file, if it names loops
};

/// --base, --meshes, --require-meshes, --inertias, --loops.
void add_robot_options(CLI::App& verb, RobotChoice& choice);

/// The reader's options for the file; meshes are read from disk. Errors: the loops file cannot be read.
[[nodiscard]] Result<robot_formats::RobotOptions> robot_options(const std::string& path, const RobotChoice& choice);

}  // namespace ugoki::cli
