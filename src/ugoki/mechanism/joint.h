#pragma once
// Joint types, their coordinates and their kinematics.
//
// A joint defines the pose of its link's frame B in the parent link's frame P: X_PB = X_PJ * X_JB(q), where J is the joint frame,
// fixed in P. Coordinates of each type (angles in rad, distances in m; ' is the time derivative):
//
//   type         nq nv  q                        v                                   X_JB(q)
//   fixed         0  0                                                               1
//   revolute      1  1  angle                    angle'                              rotation about axis
//   prismatic     1  1  distance                 distance'                           translation along axis
//   helical       1  1  angle                    angle'                              rotation about axis, shift pitch * angle along it
//   cylindrical   2  2  angle, distance          derivatives                         rotation about axis, translation along it
//   planar        3  3  x, y, angle              derivatives                         translation in J's x-y plane, rotation about z
//   universal     2  2  angle, angle             derivatives                         rotation about axis, then about axis2
//   spherical     4  3  unit quaternion wxyz     angular velocity in B               rotation
//   floating      7  6  position, quaternion     angular velocity in B, position' in J   translation, rotation

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>

#include "ugoki/spatial/spatial.h"

namespace ugoki {

enum class JointType : std::uint8_t { fixed, revolute, prismatic, helical, cylindrical, planar, universal, spherical, floating };

inline constexpr std::array<std::uint8_t, 9> position_counts = {0, 1, 1, 1, 2, 3, 2, 4, 7}, velocity_counts = {0, 1, 1, 1, 2, 3, 2, 3, 6};
/// nq, number of position coordinates
[[nodiscard]] constexpr int position_count(JointType type) { return position_counts[static_cast<std::size_t>(type)]; }
/// nv, number of DOFs
[[nodiscard]] constexpr int velocity_count(JointType type) { return velocity_counts[static_cast<std::size_t>(type)]; }
[[nodiscard]] std::string_view name_of(JointType type);
[[nodiscard]] std::optional<JointType> joint_type_named(std::string_view name);

/// Limits, spring, friction and drive of one DOF of a joint. Units: rad and N m for rotations, m and N for translations.
struct Dof {
  double lower = -std::numeric_limits<double>::infinity();  ///< lower limit of the coordinate (spherical: of a rotation vector component)
  double upper = std::numeric_limits<double>::infinity();   ///< upper limit of the coordinate; the limits of floating joints are not used
  double damping = 0;                                       ///< viscous damping: torque or force per velocity
  double stiffness = 0;                                     ///< spring: torque or force per displacement from `rest`
  double rest = 0;                                          ///< displacement at which the spring exerts no force
  double armature = 0;  ///< rotor inertia seen through the gear, added to the diagonal of M; kg m^2 or kg
  double friction = 0;  ///< maximum dry-friction torque or force
  double effort = std::numeric_limits<double>::infinity();  ///< maximum torque or force of the drive
  friend bool operator==(const Dof&, const Dof&) = default;
};

struct Joint {
  JointType type = JointType::fixed;
  Pose X_PJ;                  ///< joint frame in the parent link's frame
  Vec3 axis = {0, 0, 1};      ///< unit, in J
  Vec3 axis2 = {0, 1, 0};     ///< unit, second axis of a universal joint, in J rotated by the first angle
  double pitch = 0;           ///< m/rad; only for the type helical
  std::array<Dof, 6> dofs{};  ///< only the first nv elements are used

  [[nodiscard]] int nq() const { return position_count(type); }
  [[nodiscard]] int nv() const { return velocity_count(type); }
};

/// Pose X_JB(q) of the link's frame B in the joint frame J. @param q [nq]
[[nodiscard]] Pose joint_pose(const Joint& joint, const double* q);

/// Computes the motion subspace: columns S[0] to S[nv - 1] in B's frame; the velocity of B relative to J is sum S[i] v[i].
/// @param q [nq] @param S [nv, out]  @return nv
int joint_subspace(const Joint& joint, const double* q, Vec6* S);

/// Velocity-product acceleration of the joint: (dS/dt) v in B's frame; zero for most types. @param q [nq] @param v [nv]
[[nodiscard]] Vec6 joint_bias(const Joint& joint, const double* q, const double* v);

/// Sets q to the neutral position: zeros and identity quaternions. @param q [nq, out]
void joint_neutral(const Joint& joint, double* q);

/// q_out = q (+) v dt: the exact result of moving for dt [s] at the constant velocity v. q_out may alias q.
void joint_integrate(JointType type, const double* q, const double* v, double dt, double* q_out);
inline void joint_integrate(const Joint& joint, const double* q, const double* v, double dt, double* q_out) {
  joint_integrate(joint.type, q, v, dt, q_out);
}

/// Computes the constant velocity v that leads from q0 to q1 in 1 s: joint_integrate(q0, v, 1) = q1. @param v [nv, out]
void joint_difference(JointType type, const double* q0, const double* q1, double* v);
inline void joint_difference(const Joint& joint, const double* q0, const double* q1, double* v) { joint_difference(joint.type, q0, q1, v); }

/// Computes the displacement of each DOF from the neutral position; limits and springs act on it. Angles [rad], distances [m], or
/// the components of the rotation vector [rad] of a spherical joint; six zeros for a floating joint. @param x [nv, out]
void joint_displacement(const Joint& joint, const double* q, double* x);

}  // namespace ugoki
