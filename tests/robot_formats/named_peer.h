#pragma once
// Compares a mechanism with MuJoCo's model of the same robot. Bodies and links are matched by name.

#ifdef UGOKI_HAVE_MUJOCO
#include <mujoco/mujoco.h>

#include <memory>
#include <random>
#include <string>
#include <vector>

#include "ugoki/dynamics/dynamics.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/robot_formats/robot_model.h"

namespace ugoki::robot_formats {

using MujocoModel = std::unique_ptr<mjModel, void (*)(mjModel*)>;

/// Opens the text (URDF or MJCF); everything except the rigid bodies is switched off. `why`: MuJoCo's error message if it refuses the text.
[[nodiscard]] MujocoModel open_in_mujoco(const std::string& text, std::string& why);

/// Maximum differences: poses in m and as entries of rotation matrices, the others relative to the largest value of their kind.
struct Disagreement {
  double pose = 0, inertia = 0, inverse = 0, forward = 0, methods = 0;
};

/// Our mechanism and MuJoCo's model, set to the same random states.
class NamedPeer {
 public:
  NamedPeer(const RobotModel& model, const mjModel& peer);

  /// Empty if both have the same DOFs; otherwise it names the links whose body is missing or has other DOFs.
  [[nodiscard]] const std::string& mismatch() const { return mismatch_; }
  /// Compares one random state, and updates `worst`.
  void compare(std::mt19937& random, Disagreement& worst);

 private:
  void set_state(std::mt19937& random);
  void compare_poses(Disagreement& worst);
  void compare_dynamics(std::mt19937& random, Disagreement& worst);
  /// Reorders velocities, accelerations or forces from our order to MuJoCo's.
  [[nodiscard]] std::vector<double> to_theirs(const std::vector<double>& ours) const;

  const RobotModel& model_;
  const Mechanism& m_;
  const mjModel& peer_;
  std::unique_ptr<mjData, void (*)(mjData*)> data_;
  dynamics::Workspace ws_;
  State state_;
  std::vector<int> body_;  ///< [links] MuJoCo's body; -1: none
  std::string mismatch_;
};

}  // namespace ugoki::robot_formats
#endif
