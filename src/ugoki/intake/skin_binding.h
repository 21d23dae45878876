#pragma once
// Attaches the skin of a file to the links of the body that is made from the file's skeleton. Internal to intake.

#include <span>
#include <string>
#include <vector>

#include "ugoki/body/body.h"
#include "ugoki/formats/file_skin.h"
#include "ugoki/intake/intake.h"
#include "ugoki/intake/rigid_joints.h"
#include "ugoki/motion/skeleton.h"

namespace ugoki::intake {

/// Follows the bones of a skin through the changes that an import makes to the skeleton. Call reduce() after the joints were reduced,
/// turn() and scale() whenever the motions are turned and scaled, and attach() at the end.
class SkinBinding {
 public:
  SkinBinding() = default;
  /// @param motions as read from the file, all on the same skeleton
  SkinBinding(formats::FileSkin skin, std::span<const MeasuredMotion> motions);

  /// False if the file has no skin.
  [[nodiscard]] bool exists() const { return !file_.bones.empty(); }
  void turn(const Mat3& R);
  void scale(double factor);
  /// Gives bones of joints that were removed to the joint with which they move: the nearest remaining ancestor, or else the joint to which
  /// they are closest to rigid. Bones of other characters are dropped with their triangles.
  /// @param motions the same motions with fewer or other joints, which have kept their world poses
  void reduce(std::span<const MeasuredMotion> motions);
  /// Attaches the skin to the body's links. @param mechanism receives skin and skin_bones; unchanged if nothing of the skin remains
  void attach(const body::Body& body, MechanismSpec& mechanism);

 private:
  void drop_lost_triangles();

  formats::FileSkin file_;
  SampledJoints joints_;    ///< to which the bones belong: those of the file, after reduce() those that remain
  std::vector<char> lost_;  ///< [bones] 1: of no joint of the body
};

/// Reads the skin of a glTF file; empty, with a remark, if it cannot be read.
[[nodiscard]] formats::FileSkin skin_of_gltf(std::span<const std::byte> bytes, std::string_view file_name, const IntakeOptions& options,
                                             formats::ReadNotes& notes);

/// The same of an FBX or COLLADA file.
[[nodiscard]] formats::FileSkin skin_of_scene(std::span<const std::byte> bytes, std::string_view file_name, const IntakeOptions& options,
                                              formats::ReadNotes& notes);

/// Sentence about the skin for the user.
[[nodiscard]] std::string describe(const Skin& skin);

}  // namespace ugoki::intake
