#pragma once
// What a verb's argument names: a measured file, a project, executable data, or an entry of the library.

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "robot_options.h"
#include "ugoki/base/result.h"
#include "ugoki/content/generate.h"
#include "ugoki/content/scenario.h"
#include "ugoki/intake/intake.h"
#include "ugoki/store/library.h"

namespace ugoki::cli {

enum class TargetKind { measured_file, mechanism_file, project, library, executable, entry };

struct SourceOptions {
  std::string library;  ///< path; empty: the default
  std::string asf;      ///< skeleton for AMC files; empty: beside the file
  intake::IntakeOptions intake;
  RobotChoice robot;  ///< for URDF, SDF and MJCF
};

/// Path of the library that the options mean.
[[nodiscard]] std::string library_path(const std::string& option);

/// The library in which `target`, which is no file, may be an entry. Errors: there is none yet.
[[nodiscard]] Result<store::Library> library_of(const std::string& target, const SourceOptions& options);

/// A file by its first bytes or the ending of its name; what is no file is taken for an entry's name or id.
[[nodiscard]] Result<TargetKind> kind_of(const std::string& target);

/// Reads a measured file (with its skeleton) or a description of a mechanism (with its meshes and loops) from disk.
[[nodiscard]] Result<intake::Intake> take_in_file(const std::string& path, const SourceOptions& options);

/// A motion with the mechanism that it moves.
struct ClipSource {
  std::string name;
  MechanismPtr mechanism;
  MotionPtr motion;
  double height = 0;  ///< m; 0: not known
};
/// From a measured file, or from an entry of the library (motion or measured).
[[nodiscard]] Result<ClipSource> load_clip(const std::string& target, const SourceOptions& options);

/// A document in which one figure performs the clip from beginning to end.
/// @param step s
[[nodiscard]] content::Scenario clip_scenario(const ClipSource& clip, double step);
[[nodiscard]] content::Resources clip_resources(const ClipSource& clip);

}  // namespace ugoki::cli
