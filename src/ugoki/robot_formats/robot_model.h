#pragma once
// What every reader of this module gives, and the choices that their callers have.

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/mechanism/mechanism.h"

namespace ugoki::robot_formats {

/// A joint or a loop of the file, by the name that it has there.
struct JointName {
  std::string joint;
  std::string link;  ///< the link that it carries; for a loop the loop's name
};

struct RobotModel {
  MechanismPtr mechanism;
  std::vector<JointName> joints;    ///< tree joints in the order of the mechanism's links, without invented ones
  std::vector<std::string> driven;  ///< links whose joints the file calls driven; empty if it does not tell
  std::vector<std::string> notes;   ///< sentences for people: what was approximated, repaired, left out
};

/// How the base of the tree is joined to the world where the file leaves it open.
enum class Base { by_file, fixed, floating };
/// Meshes that collide: taken as the box around them, demanded (a missing one is an error), or left out.
enum class Meshes { box, require, none };
/// Inertia that no body can have: moved to the nearest possible one with a note, or refused.
enum class Inertias { repair, strict };

/// The bytes of a file that a description names, or an Error (code io: not there).
using AssetReader = std::function<Result<std::string>(const std::string& path)>;

struct RobotOptions {
  Base base = Base::by_file;
  Meshes meshes = Meshes::box;
  Inertias inertias = Inertias::repair;
  AssetReader read_asset;  ///< absent: no file beside the description is read
};

}  // namespace ugoki::robot_formats
