#pragma once
// Finds the joint of a reduced skeleton with which a joint of the whole skeleton moves. Internal to intake.

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "ugoki/spatial/spatial.h"

namespace ugoki::intake {

/// Joints of a skeleton in sampled frames.
struct SampledJoints {
  std::vector<std::string> names;          ///< [joints]
  std::vector<int> parents;                ///< [joints] -1: a root
  std::vector<std::vector<Pose>> samples;  ///< [sampled frames][joints] world poses
  std::vector<Vec3> rest;                  ///< [joints] m, in the rest pose
};

/// A joint that moves another one.
struct RigidJoint {
  std::size_t joint = 0;  ///< index in the reduced skeleton
  Pose X;                 ///< pose of the other joint in its frame
};

class RigidJoints {
 public:
  /// @param reduced fewer joints than `whole`, at the same world poses in the same frames
  RigidJoints(SampledJoints whole, SampledJoints reduced);
  /// The remaining joint with which a joint of the whole skeleton moves: the nearest remaining ancestor if both move rigidly, or else the
  /// joint to which it is closest to rigid, with their constant relative pose. Without a rigid joint, the relative pose is that at rest.
  /// Nothing for joints that neither hang below the reduced skeleton nor carry it.
  [[nodiscard]] std::optional<RigidJoint> find(const std::string& name) const;

 private:
  [[nodiscard]] std::optional<std::size_t> remaining(std::size_t joint) const;
  [[nodiscard]] bool carries_remaining(std::size_t joint) const;
  [[nodiscard]] double relative_motion(std::size_t reduced, std::size_t whole) const;

  SampledJoints whole_, reduced_;
  std::map<std::string, std::size_t, std::less<>> in_whole_, in_reduced_;  ///< indices by name
};

}  // namespace ugoki::intake
