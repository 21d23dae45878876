#pragma once
// Acclaim skeletons (ASF) and motions (AMC). docs/formats.md describes the supported variants.

#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/formats/read_notes.h"
#include "ugoki/motion/skeleton.h"

namespace ugoki::formats {

/// One degree of freedom of a bone: one value on the bone's line in each frame of an AMC file.
struct AsfDof {
  enum class Kind { rotation, translation, length } kind = Kind::rotation;
  int axis = 0;  ///< axis of the bone's own frame: 0 x, 1 y, 2 z
};

/// A skeleton read from an ASF file, with the data of each bone that the reader of AMC files needs.
struct Asf {
  struct Bone {
    std::string name;          ///< the bytes of the file (not converted to UTF-8), because they are compared with the names in AMC files
    Quat axis;                 ///< rotation at rest from the bone's own frame (the frame of its AMC values) to Ugoki's axes
    Vec3 direction;            ///< unit vector from the bone's start to its end at rest, Ugoki's axes (X forward, Y left, Z up)
    std::vector<AsfDof> dofs;  ///< in the order of the bone's values in an AMC file; the first rotation is applied first
  };
  Skeleton skeleton;
  std::vector<Bone> bones;  ///< [joints] one bone for each joint of the skeleton
  bool degrees = true;      ///< unit of angles in AMC files that do not specify one: true deg, false rad
};

struct AsfOptions {
  double metres_per_unit = 0;  ///< m per file unit; 0: one inch (0.0254 m) divided by the file's length scale
};

/// Reads a whole ASF file from memory. Each bone becomes a joint at the start of the bone, which is the end of its parent. At rest all
/// joint frames are parallel to the world. Joint 0 is the root. A bone without children has an end site. The DOFs of a joint are the bone's
/// rotations with their axes and limits, from the outermost (applied last) to the innermost.
/// Errors: at most twenty problems, each with file:line and a remedy. O(text log bones).
[[nodiscard]] Result<Asf> read_asf(std::string_view text, std::string_view file_name, const AsfOptions& options = {},
                                   ReadNotes* notes = nullptr);

struct AmcOptions {
  double rate = 120;  ///< frames per second; the format does not specify it
};

/// Reads a whole AMC file from memory. The rotation of a bone is C M C^-1 with M = R_last ... R_first (the rotations of its
/// DOFs) and C the rotation of Asf::Bone::axis. A gap of at most one second in the frame numbers is interpolated; the notes
/// report the number of missing frames.
/// Errors: at most twenty problems, each with file:line and a remedy. O(text log bones).
[[nodiscard]] Result<MeasuredMotion> read_amc(std::string_view text, std::string_view file_name, const Asf& asf,
                                              const AmcOptions& options = {}, ReadNotes* notes = nullptr);

struct AmcWriteOptions {
  double metres_per_unit = 0;  ///< m per file unit; 0: unit of the file that was read
  int decimals = 10;           ///< digits after the decimal point of lengths and angles [deg] in the AMC file, 1 ... 15
};

/// The text of an ASF file and of the AMC file that belongs to it.
struct AmcText {
  std::string asf, amc;
  std::vector<std::string> notes;  ///< one sentence for each change that the formats require (names, added bones, limits left out)
};

/// Returns the motion as an ASF and an AMC file, Y up, degrees. A joint that rotates has the DOFs rx ry rz about the file's axes; a joint
/// whose translation was measured has tx ty tz. A joint with a single child has a bone that ends at the start of this child. The root, and
/// every joint with several children or end sites, has a bone of length zero; connecting bones without DOFs ("to_NAME") lead from it to the
/// children and end sites. When the files are read again, joints of the same name have the same positions and rotations. O(frames *
/// joints).
[[nodiscard]] AmcText write_amc(const MeasuredMotion& motion, const AmcWriteOptions& options = {});

}  // namespace ugoki::formats
