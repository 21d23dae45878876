#pragma once
// Motion control: joint torques that make a character follow a reference motion on its own feet.
//
// Each tick:
//   1. Wanted acceleration = reference acceleration + stable PD on the error (Tan, Liu, Turk 2011), for joints and root. The reference
//      trajectory of the root is shifted if feet have landed elsewhere than in the reference.
//   2. Inverse dynamics calculates the joint torques and the wrench that the root would need.
//   3. Contact forces inside the friction pyramids provide as much of that wrench as possible (contact_forces.h; Abe 2007, da Silva 2008),
//      and the joint torques transmit them.
//   4. The part of the weight that the ground cannot carry is left to gravity: a character in the air flies and falls, and the shift of
//      the root trajectory follows it.
//   5. The remaining wrench is the root assist, which is capped, applied and reported. If the wanted assist, averaged over `patience`,
//      exceeds the cap, control is released: from then on there is no drive torque and no assist, and the character is a ragdoll.

#include <span>
#include <vector>

#include "ugoki/collision/contact_point.h"
#include "ugoki/control/contact_forces.h"
#include "ugoki/dynamics/dynamics.h"

namespace ugoki::control {

/// Parameters of the controller. A body weight is the character's mass times gravity [N].
struct ControlOptions {
  double tracking = 1;          ///< factor on the joints' gains, 0 ... 2
  double balance = 1;           ///< factor on the root's gains, 0 ... 2
  double joint_frequency = 20;  ///< rad/s: natural frequency of the errors of joints that bear no load (critically damped)
  double root_frequency = 20;   ///< rad/s: natural frequency of the errors of the root and of joints between root and loaded feet
  double joint_hold =
      0.3;  ///< s/rad: the servo gain of a joint that bears load is joint_hold * strength^2 / (weight * lever), strength in N m
  double assist_limit = 0.5;      ///< body weights: cap of the root assist; moments are divided by MotionControl::lever()
  double patience = 0.25;         ///< s: time constant of the averaged wanted assist, which decides the release of control
  double contact_margin = 0.005;  ///< m: only contacts closer than this, or closing in the step, can bear load
  double planted_height = 0.04;   ///< m: a point whose reference is more than this above the contact is not planted (bears no load)
  double planted_speed = 0.5;     ///< m/s upwards: a reference point faster than this is not planted
  double lifting_speed = 0.05;    ///< m/s upwards: load on a point costs (1 + (reference speed / lifting_speed)^2)^2
  double sliding_speed = 0.8;     ///< m/s along the floor: a reference point faster than this is not planted
  double shift_time = 0.12;       ///< s: time constant with which the root trajectory shifts towards the actual position of the feet
  double return_time = 2;         ///< s: time constant with which the shift decays
  double fall_depth = 0.5;    ///< fraction of lever(): free fall without support fades out until the root is this far below its reference
  Vec3 gravity{0, 0, -9.81};  ///< m/s^2, world
};

/// Memory from tick to tick. Plain data, so that it can be saved and restored.
struct ControlState {
  double overload = 0;          ///< average of wanted assist / cap; control is released above 1
  double shift[3] = {0, 0, 0};  ///< m, world: shift of the root trajectory relative to the reference, caused by feet positions or a fall
  std::uint64_t released = 0;   ///< 1: control is released; 0: active
};

/// Input of one tick. All spans refer to the caller's memory.
struct ControlInput {
  std::span<const double> q, v;                       ///< present state [nq], [nv]
  std::span<const double> q_ref, v_ref, a_ref;        ///< reference at the present time [nq], [nv], [nv]
  std::span<const collision::ContactPoint> contacts;  ///< result of collision analysis at the present state
  int system = 0;                                     ///< index of this character in ContactPoint::system_a
  double dt = 0.002;                                  ///< s: duration of the tick
};

/// Output of one tick.
struct ControlOutput {
  Vec6 assist;         ///< applied root assist: moment about the root link's origin [N m], force [N], world axes
  Vec6 wanted;         ///< root assist before the cap, same units
  double ratio = 0;    ///< norm of the wanted assist / cap
  double size_bw = 0;  ///< body weights: norm of the applied assist, moments divided by lever()
  bool released = false;
};

/// Controller of one character; see the steps at the top of this file.
class MotionControl {
 public:
  MotionControl(MechanismPtr mechanism, const ControlOptions& options);

  /// Calculates the drive torques of one tick.
  /// @param tau [nv, out] N | N m: drive forces; zero for the root's DOFs and after the release of control
  /// @param servo_gain, servo_velocity [nv, out] N m s/rad, rad/s: gain and target of a velocity servo (contact::StepSystem). The target is
  ///   the planned velocity at the end of the step, so that a joint that bears load resists unplanned motion; zero gain for other joints
  ControlOutput step(const ControlInput& input, ControlState& state, std::span<double> tau, std::span<double> servo_gain,
                     std::span<double> servo_velocity);

  [[nodiscard]] const ControlOptions& options() const { return options_; }
  [[nodiscard]] const Mechanism& mechanism() const { return *mechanism_; }
  /// m: lever that converts moments to forces in the norm of the assist. It is the maximum of the height of the root above the character's
  /// lowest point in the neutral position, half the character's height, the root mean square horizontal distance of the character's mass
  /// from the root, and 0.1 m.
  [[nodiscard]] double lever() const { return lever_; }
  /// The assist as an external wrench on the root link about the world origin.
  /// @param root m, world: origin of the root link
  [[nodiscard]] static Vec6 about_world_origin(const Vec6& assist, const Vec3& root) {
    return {assist.w + cross(root, assist.v), assist.v};
  }

 private:
  MechanismPtr mechanism_;
  ControlOptions options_;
  /// Sets supports_ to the contacts that can bear load: planted in the reference and closed in the present state.
  void find_supports(const ControlInput& input, const Vec3& shift);
  /// Free fall: lets gravity accelerate the body with the part of the weight that the ground does not carry. Recalculates the torques and
  /// reduces the missing wrench.
  /// @param ahead m, world: actual minus reference position of the root
  /// @return fraction of the weight that is left to gravity, 0 ... 1
  double apply_free_fall(const Vec3& ahead, Vec6& missing, std::span<double> tau);
  /// Updates the shift of the root's reference trajectory. The shift follows the mean offset of the loaded feet from their reference; in
  /// free fall it follows the root itself.
  /// @param ahead m, world: actual minus reference position of the root
  /// @param falling fraction of the weight that is left to gravity
  void update_shift(const ControlInput& input, std::span<const Vec3> forces, const Vec3& ahead, double falling, double (&shift)[3]) const;

  dynamics::Workspace workspace_, reference_;
  ContactForceProblem problem_;
  double lever_ = 1;
  double weight_ = 0;  // N
  bool floating_ = false;
  std::vector<double> wanted_;  // [nv] accelerations, m/s^2 | rad/s^2
  std::vector<double> displacement_;
  std::vector<unsigned char> bears_load_;  // [nv] 1: DOF on the chain between a support and the root
  std::vector<Support> supports_;
  std::vector<int> support_links_;
  std::vector<Vec3> offsets_;  // [supports] m, world: offset of the contact point from its reference position
  std::vector<Vec3> forces_;
};

}  // namespace ugoki::control
