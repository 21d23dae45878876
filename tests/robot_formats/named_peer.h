#pragma once
// A mechanism against MuJoCo's model of the same robot, whose bodies have the names of its links.

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

/// Opens the text (URDF or MJCF); all but the rigid bodies is switched off. `why`: MuJoCo's words where it refuses.
[[nodiscard]] MujocoModel open_in_mujoco(const std::string& text, std::string& why);

/// Greatest disagreements: poses in m and as entries of rotations, the others relative to the greatest number of their kind.
struct Disagreement {
  double pose = 0, inertia = 0, inverse = 0, forward = 0, methods = 0;
};

class NamedPeer {
 public:
  NamedPeer(const RobotModel& model, const mjModel& peer);

  /// Empty where both have the same freedoms, with links without a body of that name named.
  [[nodiscard]] const std::string& mismatch() const { return mismatch_; }
  /// One random state.
  void compare(std::mt19937& random, Disagreement& worst);

 private:
  void set_state(std::mt19937& random);
  void compare_poses(Disagreement& worst);
  void compare_dynamics(std::mt19937& random, Disagreement& worst);
  /// Velocities, accelerations or forces, ours to theirs.
  [[nodiscard]] std::vector<double> to_theirs(const std::vector<double>& ours) const;

  const RobotModel& model_;
  const Mechanism& m_;
  const mjModel& peer_;
  std::unique_ptr<mjData, void (*)(mjData*)> data_;
  dynamics::Workspace ws_;
  State state_;
  std::vector<int> body_;  ///< for each link; -1: none
  std::string mismatch_;
};

}  // namespace ugoki::robot_formats
#endif
