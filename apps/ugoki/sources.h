#pragma once
// Resolves the argument of a verb: a measured file, a mechanism file, a project, executable data, or an entry of the library.

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

/// Kind of the file or entry that the argument of a verb names.
enum class TargetKind { measured_file, mechanism_file, project, library, executable, entry };

/// Options for reading the file or entry that a verb's argument names.
struct SourceOptions {
  std::string library;  ///< path of the library; empty: the default path
  std::string mapping;  ///< JSON file that corrects the recognised anatomy; empty: none
  std::string asf;      ///< skeleton for AMC files (empty: NN.asf in the folder of NN_MM.amc), or body model of SMPL files
  intake::IntakeOptions intake;
  RobotChoice robot;  ///< options for URDF, SDF and MJCF files
};

/// Adds --library. @param path set to the library's file; empty: the default
void add_library_option(Verb verb, std::string& path);
/// Adds --skeleton: the skeleton of AMC files, or the body model of SMPL and OpenSim files.
void add_skeleton_option(Verb verb, SourceOptions& options);
/// Adds --rate: the frames per second of AMC files.
void add_rate_option(Verb verb, SourceOptions& options);
/// Adds --height and --mass of the person.
void add_person_options(Verb verb, SourceOptions& options);
/// Adds the options --unit, --up, --forward, --travel, --correct-labels, --mapping, --character and --take, which correct a motion file or
/// choose from it.
void add_correction_options(Verb verb, SourceOptions& options);

/// Path of the library: `option`, or the default path if it is empty.
[[nodiscard]] std::string library_path(const std::string& option);

/// Opens the library in which `target` is to be looked up; for a `target` that is not a file. Error: no library exists.
[[nodiscard]] Result<store::Library> library_of(const std::string& target, const SourceOptions& options);

/// Kind of a file, from its first bytes or extension. If no such file exists, `target` is the name or id of an entry.
[[nodiscard]] Result<TargetKind> kind_of(const std::string& target);

/// Reads a measured file (with its skeleton) or a description of a mechanism (with its meshes and loops) from disk.
[[nodiscard]] Result<intake::Intake> take_in_file(const std::string& path, const SourceOptions& options);

/// A motion with the mechanism that it moves.
struct ClipSource {
  std::string name;
  MechanismPtr mechanism;
  MotionPtr motion;
  double height = 0;                     ///< height of the recorded person, m; 0: not known
  std::vector<std::string> checks = {};  ///< sentences: what dynamics cannot follow in a measured motion
};
/// Loads a clip from a measured file, or from an entry of the library (motion or measured data).
[[nodiscard]] Result<ClipSource> load_clip(const std::string& target, const SourceOptions& options);

/// Makes a scenario in which one character performs the clip from beginning to end.
/// @param step step size of the dynamics, s
[[nodiscard]] content::Scenario clip_scenario(const ClipSource& clip, double step);
[[nodiscard]] content::Resources clip_resources(const ClipSource& clip);

/// A scenario with its resources, from which executable data are generated.
struct SceneSource {
  std::string name;
  content::Scenario scenario;
  content::Resources resources;
  int frames = 0;                   ///< recorded frames of a clip; 0: a project
  double height = 0;                ///< height of the recorded person of a clip, m; 0: not known
  std::vector<std::string> checks;  ///< of a clip
};
/// Loads a project, or a clip as a scenario with one character. @param step s: step size of a clip's scenario
[[nodiscard]] Result<SceneSource> load_scene(const std::string& target, const SourceOptions& options, double step);

/// The executable data of a target: the bytes of a *.ugx file, or the data generated from a project or a clip.
struct ExecutableSource {
  std::string name;
  std::vector<std::byte> ugx;
};
[[nodiscard]] Result<ExecutableSource> load_executable(const std::string& target, const SourceOptions& options, double step = 0.002);

}  // namespace ugoki::cli
