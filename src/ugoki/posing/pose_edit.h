#pragma once
// Edits of one pose by hand, as an animator makes them with gizmos and handles.

#include <span>
#include <variant>
#include <vector>

#include "ugoki/mechanism/mechanism.h"

namespace ugoki::posing {

/// Rotates a link about an axis through its joint.
struct TurnEdit {
  int link = 0;
  Vec3 axis;         ///< unit, in the link's frame
  double angle = 0;  ///< rad
};
/// Sets one DOF of a joint to a displacement from the neutral position.
struct SetEdit {
  int link = 0, dof = 0;
  double value = 0;  ///< rad | m
};
/// Which joints may move while a link is dragged.
enum class Reach {
  limb,  ///< the joints from the dragged link up to the trunk, that is up to the first link with several children
  body   ///< all joints; pinned links keep their pose
};
/// Drags a point of a link to a position.
struct ReachEdit {
  int link = 0;
  Vec3 point;   ///< m, in the link's frame
  Vec3 target;  ///< m, world
  Reach moves = Reach::limb;
};
/// Exchanges left and right of the pose. Position and heading of the root stay.
struct MirrorEdit {};
/// Moves joints towards those of another pose of the same mechanism.
struct BlendEdit {
  std::vector<double> q;   ///< [nq] the other pose
  std::vector<int> links;  ///< links whose joints move
  double share = 1;        ///< 0 to 1
};
using PoseEdit = std::variant<TurnEdit, SetEdit, ReachEdit, MirrorEdit, BlendEdit>;

struct PoseEditOptions {
  std::vector<int> pins = {};  ///< links that keep their pose in the world, if the moving joints can do this
  bool limits = true;          ///< false: joints may pass their limits
};

/// Links of the limb that ends with `link`: from the link next to the trunk down to `link`. A limb ends at the first ancestor that has
/// several children, or at the root.
[[nodiscard]] std::vector<int> limb_of(const Mechanism& mechanism, int link);

/// Applies one edit. Pinned links that the edit would move are led back by inverse kinematics; closed loops stay closed.
/// @param q [nq, in and out] in the world
/// @return error with its remedy, for example for a mechanism that cannot be mirrored; then q is unchanged
[[nodiscard]] Result<void> edit_pose(const Mechanism& mechanism, const PoseEdit& edit, const PoseEditOptions& options, std::span<double> q);

}  // namespace ugoki::posing
