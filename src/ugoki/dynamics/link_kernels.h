#pragma once
// Kinematics, and the recursive Newton-Euler algorithm, of the staged functions (dynamics.h). They are compiled for the baseline processor
// and, on x86, for AVX2; the width is chosen at run time (kernels.h). Each value is computed by the same operations in the same order for
// every width, so that the bits are equal. Internal to dynamics/.

#include <cstddef>

#include "ugoki/mechanism/mechanism.h"

namespace ugoki::dynamics {

/// Arguments of the recursions. All spatial quantities are about p0, in world axes.
struct LinkArguments {
  const LinkPlace* places;  ///< [links] parents before children
  std::size_t links;
  const Vec6* S;           ///< [nv] columns of the motion subspace
  const Vec6* V;           ///< [links] velocities; not used by `bias`
  const Vec6* C;           ///< [links] velocity-product accelerations; `bias`: only the part that is not V x vJ, of joints that have one
  const Inertia* I;        ///< [links] inertias
  const Vec6* external;    ///< [links] wrenches on the links about p0, or null
  const double* vdot;      ///< [nv] accelerations of the DOFs, or null: zero; `bias`: velocities of the DOFs
  const double* armature;  ///< [nv]
  double gravity[3];       ///< m/s^2, world
  double* scratch;         ///< [links][link_scratch], aligned to 32 bytes
  Vec6* F;                 ///< [links, out] force through the joint of each link
  double* tau;             ///< [nv, out]
};

/// Arguments of the kinematics; symbols: Kinematics.
struct KinematicsArguments {
  const Link* links;
  const LinkPlace* places;
  const double *q, *v;
  Vec3* p0;
  Pose* X_WB;
  Vec6 *S, *V, *C;
  Inertia* I;  ///< null: inertias are not computed
};

/// Number of `scratch` elements of a link.
constexpr std::size_t link_scratch = 24;

struct LinkKernels {
  /// Computes the kinematics of the links from `begin` on, parents before children. The poses have the bits of calc_poses().
  /// @return `end`, or the first link with a joint that is not fixed, revolute or spherical
  std::size_t (*kinematics)(const KinematicsArguments&, std::size_t begin, std::size_t end);
  /// tau = M vdot + b
  void (*inverse)(const LinkArguments&);
  /// tau = b at the velocities in LinkArguments::vdot
  void (*bias)(const LinkArguments&);
};

/// Returns whether the acceleration of a joint's frame has a part besides V x vJ (joint_bias()).
inline bool has_joint_bias(JointType type) {
  return type == JointType::planar || type == JointType::universal || type == JointType::floating;
}

/// The kernels of the instruction set that kernels() uses; for AVX-512 those of AVX2.
const LinkKernels& link_kernels();

}  // namespace ugoki::dynamics
