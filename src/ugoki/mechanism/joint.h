#pragma once
// Joint types, their coordinates and their kinematics.
//
// A joint places its link's frame B in the parent link's frame P: X_PB = X_PJ * X_JB(q). Coordinates of each type:
//
//   type         nq nv  q                        v                                   X_JB(q)
//   fixed         0  0                                                               1
//   revolute      1  1  angle                    angle'                              rotation about axis
//   prismatic     1  1  distance                 distance'                           translation along axis
//   helical       1  1  angle                    angle'                              rotation about, pitch * angle along axis
//   cylindrical   2  2  angle, distance          derivatives                         rotation about, translation along axis
//   planar        3  3  x, y, angle              derivatives                         translation in J's x-y plane, rotation about z
//   universal     2  2  angle, angle             derivatives                         rotation about axis, then about axis2
//   spherical     4  3  unit quaternion wxyz     angular velocity in B               rotation
//   floating      7  6  position, quaternion     angular velocity in B, position' in J   translation, rotation

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>

#include "ugoki/spatial/spatial.h"

namespace ugoki {

enum class JointType : std::uint8_t { fixed, revolute, prismatic, helical, cylindrical, planar, universal, spherical, floating };

[[nodiscard]] int position_count(JointType type);  ///< nq
[[nodiscard]] int velocity_count(JointType type);  ///< nv
[[nodiscard]] std::string_view name_of(JointType type);
[[nodiscard]] std::optional<JointType> joint_type_named(std::string_view name);

/// What belongs to one freedom of a joint. Units are those of the freedom: rad or m, N m or N.
struct Freedom {
  double lower = -std::numeric_limits<double>::infinity();  ///< limit of the coordinate (of the rotation vector's component
  double upper = std::numeric_limits<double>::infinity();   ///< for a spherical joint; floating joints have none)
  double damping = 0;                                       ///< torque per velocity
  double stiffness = 0;                                     ///< torque per displacement from `rest`
  double rest = 0;                                          ///< where the spring is relaxed
  double armature = 0;                                      ///< inertia of a geared rotor, added to the diagonal of M
  double friction = 0;                                      ///< greatest dry-friction torque
  double effort = std::numeric_limits<double>::infinity();  ///< greatest torque that a drive may give
  friend bool operator==(const Freedom&, const Freedom&) = default;
};

struct Joint {
  JointType type = JointType::fixed;
  Pose X_PJ;                          ///< joint frame in the parent link's frame
  Vec3 axis = {0, 0, 1};              ///< unit, in J
  Vec3 axis2 = {0, 1, 0};             ///< unit, in J turned by the first angle (universal)
  double pitch = 0;                   ///< m/rad (helical)
  std::array<Freedom, 6> freedoms{};  ///< the first nv count

  [[nodiscard]] int nq() const { return position_count(type); }
  [[nodiscard]] int nv() const { return velocity_count(type); }
};

/// X_JB(q). @param q [nq]
[[nodiscard]] Pose joint_pose(const Joint& joint, const double* q);

/// Motion subspace: columns S[0 ... nv), in B's frame, so that the velocity of B relative to J is sum S[i] v[i].
/// @return nv
int joint_subspace(const Joint& joint, const double* q, Vec6* S);

/// Velocity-product term of the joint: (dS/dt) v as seen in B, zero for most types.
[[nodiscard]] Vec6 joint_bias(const Joint& joint, const double* q, const double* v);

/// q <- the neutral position (zeros; unit quaternions).
void joint_neutral(const Joint& joint, double* q);

/// q_out = q (+) v dt, exactly along a constant v. May alias.
void joint_integrate(const Joint& joint, const double* q, const double* v, double dt, double* q_out);

/// v = the constant velocity that leads from q0 to q1 in unit time: joint_integrate(q0, v, 1) = q1. @param v [nv, out]
void joint_difference(const Joint& joint, const double* q0, const double* q1, double* v);

/// Displacement of each freedom from neutral, on which limits and springs act: angles, distances, rotation-vector
/// components; for floating joints six zeros. @param x [nv, out]
void joint_displacement(const Joint& joint, const double* q, double* x);

}  // namespace ugoki
