#include "ugoki/scene_formats/scene_joints.h"

#include <algorithm>
#include <cmath>

#include "ugoki/base/number.h"
#include "ugoki/formats/file_axes.h"

namespace ugoki::scene_formats {

bool is_finite(const Affine& X) {
  return ugoki::is_finite(X.p) && ugoki::is_finite(X.M.row(0)) && ugoki::is_finite(X.M.row(1)) && ugoki::is_finite(X.M.row(2));
}

std::optional<Mat3> nearest_rotation(Mat3 M) {
  for (int i = 0; i < 60; ++i) {
    const double det = M.determinant();
    if (!(std::fabs(det) > 1e-18) || !std::isfinite(det)) return std::nullopt;
    const Mat3 next = (M + inverse(M).transposed()) * 0.5;
    const Mat3 change = next - M;
    M = next;
    if (norm(change.row(0)) + norm(change.row(1)) + norm(change.row(2)) < 1e-15) break;
  }
  if (M.determinant() < 0) return std::nullopt;
  return M;
}

Mat3 axes_with_up(int up) {
  if (up == 2) return Mat3::identity();
  return up == 0 ? Mat3{0, 1, 0, 0, 0, 1, 1, 0, 0} : Mat3{0, 0, 1, 1, 0, 0, 0, 1, 0};
}

double plausible_unit(double extent, double metres, formats::ReadNotes& notes) {
  if (!(extent > 0) || (extent * metres <= 20 && extent * metres >= 0.01)) return metres;
  const formats::UnitGuess guess = formats::guess_unit(extent);
  notes.remarks.push_back("With the unit of the file the skeleton would be " + to_fixed(extent * metres, 3) +
                          " m large; the unit is assumed to be " + to_text(guess.metres) + " m.");
  notes.unit_guessed = true;
  return guess.metres;
}

double rate_of_gap(double gap) {
  double rate = std::isfinite(gap) ? std::min(1 / gap, 1000.0) : 30;
  if (const double whole = std::round(rate); whole >= 1 && std::fabs(rate / whole - 1) < 2e-3) rate = whole;
  return std::max(rate, 1.0);
}

void SceneJoints::add(std::string name, int parent, const Affine& rest) {
  SkeletonJoint joint;
  joint.name = name.empty() ? "joint" : std::move(name);
  const std::string stem = joint.name;
  // The numbers after the first are tried from the one that was given last, so that many equal names take no longer.
  for (int& last = names_.try_emplace(stem, 1).first->second; !used_.insert(joint.name).second;)
    joint.name = stem + "_" + std::to_string(++last);
  joint.parent = parent;
  joint.offset = R_ * rest.p * metres_;
  if (parent >= 0) joint.offset = joint.offset - R_ * rest_[static_cast<std::size_t>(parent)].p * metres_;
  joint.dofs = {{{1, 0, 0}}, {{0, 1, 0}}, {{0, 0, 1}}};
  skeleton_.unit = metres_;
  skeleton_.joints.push_back(std::move(joint));
  rest_.push_back(rest);
}

void SceneJoints::append_frame(MeasuredMotion& motion, std::span<const Affine> world) {
  turned_.resize(rest_.size());
  for (std::size_t j = 0; j < rest_.size(); ++j) {
    const int parent = skeleton_.joints[j].parent;
    // G: rotation of the joint from the rest pose, in which joint frames are parallel to the world's axes.
    std::optional<Mat3> G;
    if (std::fabs(rest_[j].M.determinant()) > 1e-18) G = nearest_rotation(R_ * (world[j].M * inverse(rest_[j].M)) * R_.transposed());
    if (!G) {
      ++flat_;
      G = parent < 0 ? Mat3::identity() : turned_[static_cast<std::size_t>(parent)];
    }
    turned_[j] = *G;
    const Vec3 p = R_ * world[j].p * metres_;
    if (parent < 0) {
      motion.translations.push_back(p);
      motion.rotations.push_back(to_quat(*G));
    } else {
      const Mat3& up = turned_[static_cast<std::size_t>(parent)];
      motion.translations.push_back(transpose_times(up, p - R_ * world[static_cast<std::size_t>(parent)].p * metres_));
      motion.rotations.push_back(to_quat(up.transposed() * *G));
    }
  }
}

long SceneJoints::take_flat() {
  const long out = flat_;
  flat_ = 0;
  return out;
}

}  // namespace ugoki::scene_formats
