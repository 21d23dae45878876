#pragma once
// Acclaim skeletons (ASF) and motions (AMC). The dialect is described in docs/formats.md.

#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/formats/read_notes.h"
#include "ugoki/motion/skeleton.h"

namespace ugoki::formats {

/// One number that an AMC file gives a bone.
struct AsfFreedom {
  enum class Kind { rotation, translation, length } kind = Kind::rotation;
  int axis = 0;  ///< of the bone's own frame: 0 x, 1 y, 2 z
};

/// What an AMC file is read with: the skeleton, and for each joint of it the bone's frame and freedoms.
struct Asf {
  struct Bone {
    std::string name;                  ///< in the bytes of the file, as AMC files call it
    Quat axis;                         ///< turns the bone's own frame, in which it is measured, into ours at rest
    Vec3 direction;                    ///< unit, from start to end at rest
    std::vector<AsfFreedom> freedoms;  ///< in the order of the numbers of an AMC line; the first rotation is applied first
  };
  Skeleton skeleton;
  std::vector<Bone> bones;  ///< [joints]
  bool degrees = true;      ///< unit of angles of AMC files that do not tell
};

struct AsfOptions {
  double metres_per_unit = 0;  ///< m per unit of length of the file; 0: inches divided by the file's length scale
};

/// Reads a whole ASF file from memory. A joint of the skeleton is a bone, located where the bone starts (its parent's end),
/// with a frame parallel to the world at rest; joint 0 is the root. A bone with no children ends in an end site. The
/// freedoms of a joint carry the bone's axes and limits, the rotation that is applied last (outermost) first.
/// Errors: at most twenty problems, each with file:line and a remedy. O(text log bones).
[[nodiscard]] Result<Asf> read_asf(std::string_view text, std::string_view file_name, const AsfOptions& options = {},
                                   ReadNotes* notes = nullptr);

struct AmcOptions {
  double rate = 120;  ///< frames a second; the format does not tell
};

/// Reads a whole AMC file from memory. A bone's rotation is C M C^-1, M = R_last ... R_first of its numbers, C from the
/// bone's axis. Up to a second of missing frames in one place is interpolated and told in the notes.
/// Errors: at most twenty problems, each with file:line and a remedy. O(text log bones).
[[nodiscard]] Result<MeasuredMotion> read_amc(std::string_view text, std::string_view file_name, const Asf& asf,
                                              const AmcOptions& options = {}, ReadNotes* notes = nullptr);

struct AmcWriteOptions {
  double metres_per_unit = 0;  ///< 0: the unit of the file that the motion came from
  int decimals = 10;           ///< digits after the point of lengths and angles [deg] of the motion, 1 ... 15
};

/// A skeleton and the motion that is read with it.
struct AmcText {
  std::string asf, amc;
  std::vector<std::string> notes;  ///< sentences: what the formats cannot hold, or hold under another name
};

/// The motion as an ASF and an AMC file, Y up, degrees. Every joint that turns gets rx ry rz about the file's axes, every one whose
/// translation was measured tx ty tz. A bone ends where its child starts; where the children of a joint start elsewhere, bones without
/// freedoms lead to them
/// ("to Name"), and the joint's own bone has no length: read back, joints of the same name have the same positions and rotations.
/// O(frames * joints).
[[nodiscard]] AmcText write_amc(const MeasuredMotion& motion, const AmcWriteOptions& options = {});

}  // namespace ugoki::formats
