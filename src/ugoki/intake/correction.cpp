#include "ugoki/intake/correction.h"

#include <algorithm>

namespace ugoki::intake {
namespace {

Vec3 unit_of(const FileAxis& axis) {
  Vec3 e;
  e[axis.axis] = axis.negative ? -1 : 1;
  return e;
}

constexpr double shift_tolerance = 1e-4;  // m; smaller changes of a translation are rounding errors of the file

/// True if the only root begins a chain without branches in which some joint translates relative to its parent.
bool root_is_carrier(std::span<const MeasuredMotion> motions) {
  const std::vector<SkeletonJoint>& joints = motions[0].skeleton.joints;
  const auto children_of = [&](int i) { return std::count_if(joints.begin(), joints.end(), [i](const auto& j) { return j.parent == i; }); };
  if (joints.empty() || children_of(-1) != 1) return false;
  const auto shifts = [&](std::size_t i) {
    return std::any_of(motions.begin(), motions.end(), [&](const MeasuredMotion& m) {
      for (int f = 1; f < m.frames; ++f)
        if (norm(m.translations[static_cast<std::size_t>(f) * joints.size() + i] - m.translations[i]) > shift_tolerance) return true;
      return false;
    });
  };
  for (std::size_t i = 1; i < joints.size(); ++i) {
    const int before = static_cast<int>(i) - 1;
    if (joints[i].parent != before || children_of(before) != 1 || !joints[i - 1].end_sites.empty()) return false;
    if (shifts(i)) return true;
  }
  return false;
}

/// Removes the root; its pose is merged into its only child.
void remove_root(MeasuredMotion& m) {
  std::vector<SkeletonJoint>& joints = m.skeleton.joints;
  const std::size_t n = joints.size();
  joints[1].offset += joints[0].offset;  // at rest all frames are parallel
  joints.erase(joints.begin());
  for (SkeletonJoint& j : joints) j.parent -= 1;
  std::vector<Vec3> translations;
  std::vector<Quat> rotations;
  translations.reserve(m.translations.size());
  rotations.reserve(m.rotations.size());
  for (std::size_t first = 0; first < m.rotations.size(); first += n) {
    const Quat& q = m.rotations[first];
    translations.push_back(m.translations[first] + rotate(q, m.translations[first + 1]));
    rotations.push_back(normalized(q * m.rotations[first + 1]));
    for (std::size_t i = first + 2; i < first + n; ++i) {
      translations.push_back(m.translations[i]);
      rotations.push_back(m.rotations[i]);
    }
  }
  m.translations = std::move(translations);
  m.rotations = std::move(rotations);
}

}  // namespace

std::vector<std::string> remove_carrier_roots(std::span<MeasuredMotion> motions) {
  std::vector<std::string> names;
  while (root_is_carrier(motions)) {
    names.push_back(motions[0].skeleton.joints[0].name);
    for (MeasuredMotion& m : motions) remove_root(m);
  }
  return names;
}

std::optional<FileAxis> file_axis_named(std::string_view name) {
  const bool negative = name.starts_with('-');
  if (negative) name.remove_prefix(1);
  if (name.size() != 1 || name[0] < 'x' || name[0] > 'z') return std::nullopt;
  return FileAxis{name[0] - 'x', negative};
}

std::string name_of(const FileAxis& axis) { return std::string(axis.negative ? "-" : "") + static_cast<char>('x' + axis.axis); }

Orientation usual_orientation(bool z_up) { return z_up ? Orientation{{2, false}, {0, false}} : Orientation{}; }

Mat3 rotation_to_ours(const Orientation& file) {
  const Vec3 forward = unit_of(file.forward), up = unit_of(file.up), left = cross(up, forward);
  return {forward.x, forward.y, forward.z, left.x, left.y, left.z, up.x, up.y, up.z};
}

void turn(MeasuredMotion& motion, const Mat3& R) {
  for (SkeletonJoint& joint : motion.skeleton.joints) {
    joint.offset = R * joint.offset;
    for (Vec3& end : joint.end_sites) end = R * end;
    for (MeasuredDof& dof : joint.dofs) dof.axis = R * dof.axis;
  }
  for (Vec3& t : motion.translations) t = R * t;
  for (Quat& q : motion.rotations) {
    const Vec3 v = R * q.vec();
    q = {q.w, v.x, v.y, v.z};
  }
}

void turn(MarkerMotion& motion, const Mat3& R) {
  for (Vec3& p : motion.positions) p = R * p;
  for (ForcePlate& plate : motion.plates)
    for (Vec3& corner : plate.corners) corner = R * corner;
}

void scale(MeasuredMotion& motion, double factor) {
  for (SkeletonJoint& joint : motion.skeleton.joints) {
    joint.offset *= factor;
    for (Vec3& end : joint.end_sites) end *= factor;
  }
  for (Vec3& t : motion.translations) t *= factor;
  motion.skeleton.unit *= factor;
}

void set_rate(MarkerMotion& motion, double rate) {
  const double factor = rate / motion.rate;
  motion.analog_rate *= factor;
  for (MarkedEvent& event : motion.events) event.time /= factor;
  motion.rate = rate;
}

}  // namespace ugoki::intake
