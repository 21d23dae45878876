#pragma once
// Joints of a scene file: their world transforms in the rest pose and in each frame become the frames of a measured motion. Internal to
// scene_formats.

#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "ugoki/formats/read_notes.h"
#include "ugoki/motion/skeleton.h"

namespace ugoki::scene_formats {

/// Affine map x -> M x + p. M may contain scaling.
struct Affine {
  Mat3 M = Mat3::identity();
  Vec3 p;
  friend Affine operator*(const Affine& a, const Affine& b) { return {a.M * b.M, a.M * b.p + a.p}; }
};
[[nodiscard]] bool is_finite(const Affine& X);

/// The rotation closest to M (polar decomposition by Newton's iteration); std::nullopt if M is singular or a reflection.
[[nodiscard]] std::optional<Mat3> nearest_rotation(Mat3 M);

/// Rotation from the axes of a file to ours. @param up index of the file's up axis: 0 x, 1 y, 2 z
[[nodiscard]] Mat3 axes_with_up(int up);

/// Returns `metres` [m per file unit], or a guess if a skeleton of the size `extent` [file units] would be larger than 20 m or smaller than
/// 1 cm. A guess is noted in `notes`.
[[nodiscard]] double plausible_unit(double extent, double metres, formats::ReadNotes& notes);

/// Frames per second of keys whose median distance is `gap` [s]; 30 if `gap` is infinite. Limited to 1 ... 1000; almost whole rates become
/// whole.
[[nodiscard]] double rate_of_gap(double gap);

/// The joints of a skeleton with their rest pose.
class SceneJoints {
 public:
  SceneJoints() = default;
  /// @param R, metres conversion from the file's world to Ugoki's
  SceneJoints(const Mat3& R, double metres) : R_(R), metres_(metres) {}
  /// Appends a joint. @param name made unique; empty: "joint"  @param parent index of an earlier joint; -1: a root
  /// @param rest world transform in the rest pose, in the file's axes and units
  void add(std::string name, int parent, const Affine& rest);
  [[nodiscard]] const Skeleton& skeleton() const { return skeleton_; }
  [[nodiscard]] Skeleton& skeleton() { return skeleton_; }
  /// Appends a frame to a motion of this skeleton, without changing its number of frames.
  /// @param world [joints] world transforms in the file's axes and units
  void append_frame(MeasuredMotion& motion, std::span<const Affine> world);
  /// Number of joint poses without a rotation (scaled to nothing or mirrored) since the last call.
  [[nodiscard]] long take_flat();

 private:
  Mat3 R_ = Mat3::identity();
  double metres_ = 1;
  Skeleton skeleton_;
  std::vector<Affine> rest_;
  std::vector<Mat3> turned_;
  std::set<std::string> used_;        ///< names of joints
  std::map<std::string, int> names_;  ///< number that was appended last to each name
  long flat_ = 0;
};

}  // namespace ugoki::scene_formats
