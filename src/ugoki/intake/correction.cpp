#include "ugoki/intake/correction.h"

namespace ugoki::intake {
namespace {

Vec3 unit_of(const FileAxis& axis) {
  Vec3 e;
  e[axis.axis] = axis.negative ? -1 : 1;
  return e;
}

}  // namespace

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
    for (MeasuredFreedom& freedom : joint.freedoms) freedom.axis = R * freedom.axis;
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
