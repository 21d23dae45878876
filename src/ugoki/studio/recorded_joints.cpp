#include "ugoki/studio/recorded_joints.h"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <numbers>

#include "ugoki/spatial/rotation.h"

namespace ugoki::studio {
namespace {

constexpr std::size_t header_size = 64, character_size = 56, link_size = 28;  // bytes

template <class T>
T read(std::span<const std::byte> bytes, std::size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

/// Angle [rad] about `axis` (unit) of a rotation about this axis.
double angle_about(const Vec3& axis, const Mat3& R) { return dot(axis, log_map(to_quat(R))); }

}  // namespace

std::array<double, 6> displacement_of(const Joint& joint, const Pose& X_PB) {
  const Pose X = joint.X_PJ.inverse() * X_PB;
  switch (joint.type) {
    case JointType::fixed:
    case JointType::floating: return {};
    case JointType::revolute:
    case JointType::helical: return {angle_about(joint.axis, X.R)};
    case JointType::prismatic: return {dot(joint.axis, X.p)};
    case JointType::cylindrical: return {angle_about(joint.axis, X.R), dot(joint.axis, X.p)};
    case JointType::planar: return {X.p.x, X.p.y, angle_about({0, 0, 1}, X.R)};
    case JointType::universal: {
      // The first rotation turns the second axis; the second one leaves it where it is.
      const Vec3 turned = X.R * joint.axis2;
      const Vec3 from = joint.axis2 - dot(joint.axis2, joint.axis) * joint.axis, to = turned - dot(turned, joint.axis) * joint.axis;
      const double first = std::atan2(dot(joint.axis, cross(from, to)), dot(from, to));
      const Mat3 R1 = rotation_about(joint.axis, first);
      return {first, angle_about(joint.axis2, R1.transposed() * X.R)};
    }
    case JointType::spherical: {
      const Vec3 r = log_map(to_quat(X.R));
      return {r.x, r.y, r.z};
    }
  }
  return {};
}

void unwrap(std::span<double> angles) {
  constexpr double turn = 2 * std::numbers::pi;
  for (std::size_t i = 1; i < angles.size(); ++i) angles[i] -= turn * std::round((angles[i] - angles[i - 1]) / turn);
}

Pose link_pose(std::span<const std::byte> frame, std::size_t character, int link) {
  std::size_t at = header_size;
  for (std::size_t i = 0; i < character; ++i) at += character_size + link_size * read<std::uint32_t>(frame, at);
  at += character_size + link_size * static_cast<std::size_t>(link);
  const auto value = [&](std::size_t i) { return static_cast<double>(read<float>(frame, at + 4 * i)); };
  return {to_matrix(Quat{value(3), value(4), value(5), value(6)}), {value(0), value(1), value(2)}};
}

}  // namespace ugoki::studio
