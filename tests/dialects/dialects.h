#pragma once
// Rewrites a measured motion into dialects: files that differ in rest pose, names, axes, unit, channels and additional joints, but contain
// the same motion in the world. The import must make the same body from each of them.

#include <cstdint>
#include <string>
#include <vector>

#include "ugoki/motion/skeleton.h"

namespace ugoki::dialects {

enum class RestPose { as_is, random, along_x, along_y, along_z };
enum class Carrier { none, still, moving };

/// One dialect. The defaults change nothing.
struct Dialect {
  std::string name;
  RestPose rest = RestPose::as_is;
  int convention = -1;              ///< index of a naming convention (convention_names); -1: the file's own names
  std::string prefix;               ///< text before every name
  bool z_up = false;                ///< true: the up axis of the BVH file is Z
  double unit = 0.0254;             ///< m per unit of the file
  std::string order = "ZXY";        ///< order of the rotation channels
  double rate_factor = 1;           ///< the motion is sampled at this multiple of the file's frame rate
  Vec3 place;                       ///< m, displacement of the whole motion
  double heading = 0;               ///< rad, rotation of the whole motion about the vertical
  Vec3 root_offset;                 ///< m, OFFSET of the root, which has no effect on the motion
  Carrier carrier = Carrier::none;  ///< additional joint that carries the root
  bool camera = false;              ///< true: adds a moving camera, a sibling of the root and a child of the carrier
  bool footsteps = false;           ///< true: adds a moving joint without a bone as a child of the root
  bool calibration_frame = false;   ///< true: adds a T pose as the first frame
  bool twists = false;              ///< true: adds bones in thighs, upper arms and forearms that take half of the twist
  bool helpers = false;             ///< true: adds end bones that do not move at head, hands and feet
  bool six_channels = false;        ///< true: writes positions of all joints
  std::string format = "bvh";       ///< "bvh", "amc", "glb"
  std::uint64_t seed = 1;
};

/// A file of a dialect.
struct DialectFile {
  std::string name;  ///< file name with extension
  std::string bytes;
  std::string asf;  ///< text of the ASF file that contains the skeleton of an AMC file
};

/// Names of the naming conventions; Dialect::convention is an index into this list.
[[nodiscard]] const std::vector<std::string>& convention_names();
/// The forty dialects of the acceptance test.
[[nodiscard]] std::vector<Dialect> all_dialects();
/// Rewrites a motion on one of the CMU skeletons of 31 joints (other skeletons keep their names).
[[nodiscard]] MeasuredMotion rewrite(const MeasuredMotion& motion, const Dialect& dialect);
/// The rewritten motion as a file.
[[nodiscard]] DialectFile write(const MeasuredMotion& motion, const Dialect& dialect, const std::string& stem);

}  // namespace ugoki::dialects
