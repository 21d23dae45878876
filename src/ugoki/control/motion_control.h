#pragma once
// Motion control: joint torques that make a character follow a reference motion on its own feet.
//
// Each tick:
//   1. Wanted acceleration = reference acceleration + stable PD on the error (Tan, Liu, Turk 2011), for joints and root. The reference
//      trajectory of the root is shifted if feet have landed at other positions than in the reference.
//   2. Inverse dynamics calculates the joint torques and the wrench that the root would need.
//   3. Contact forces inside the friction pyramids provide as much of this wrench as possible (contact_forces.h; Abe 2007, da Silva 2008),
//      and the joint torques transmit these forces.
//   4. The part of the weight that the ground cannot carry accelerates the body: a character in the air flies and falls, and the root
//      trajectory is shifted with it.
//   5. The remaining wrench is the root assist, which is capped, applied and reported. The part above the cap changes the acceleration of
//      the root: all joints keep their wanted accelerations, and the root lags behind its reference.
//   In closed loops, the torques of joints without a drive are transmitted to the drives (loop_drives.h).
//   6. If the character has fallen or lost its reference on the average over `patience`, control is released: from then on there is no
//      drive torque and no assist, and the character is a ragdoll.

#include <span>
#include <vector>

#include "ugoki/collision/contact_point.h"
#include "ugoki/control/contact_forces.h"
#include "ugoki/control/loop_drives.h"
#include "ugoki/dynamics/dynamics.h"
#include "ugoki/dynamics/known_kinematics.h"

namespace ugoki::control {

/// Parameters of the controller. One body weight is the character's mass times gravity [N]. Frequencies, times, speeds and the planted
/// height are those of a person. For a character whose lever is below 0.8 m (at least 0.02 m) they are scaled: lengths by lever / 0.8 m,
/// times and speeds by the square root, frequencies by its inverse.
struct ControlOptions {
  double tracking = 1;            ///< factor (0 ... 2) on the joints' gains
  double balance = 1;             ///< factor (0 ... 2) on the root's gains
  double joint_frequency = 20;    ///< rad/s: natural frequency of the errors of joints that bear no load (critically damped)
  double root_frequency = 20;     ///< rad/s: natural frequency of the errors of the root and of joints between root and loaded feet
  double joint_hold = 0.3;        ///< s/rad: servo gain of a load-bearing joint = joint_hold * strength^2 / (weight * lever); strength: N m
  double assist_limit = 0.5;      ///< body weights: cap of the root assist; moments are divided by MotionControl::lever()
  double patience = 0.25;         ///< s: time constant of the averaged departure from the reference, which decides the release of control
  double contact_margin = 0.005;  ///< m: only contacts that are closer than this, or that close within the step, can bear load
  double planted_height = 0.04;   ///< m: a point higher than this in the reference, relative to the contact, is not planted (bears no load)
  double planted_speed = 0.5;     ///< m/s: a point that rises faster than this in the reference is not planted
  /// Cost of load on a point whose speed in the reference is `rise` upwards and `slide` along the floor:
  /// (1 + (rise / lifting_speed)^2 + ((slide - sliding_speed) / slip_speed)^2)^2; negative terms in the inner brackets count as zero.
  double lifting_speed = 0.05;  ///< m/s
  double sliding_speed = 0.8;   ///< m/s: stance feet of walks move slower than this
  double slip_speed = 0.1;      ///< m/s: a point that slides at 1.6 m/s bears load if no other point can
  double sliding_limit =
      3;  ///< m/s: a point that moves faster along the floor is not planted: a swinging foot, not one in stance or landing
  double shift_time = 0.12;  ///< s: time constant with which the root trajectory is shifted towards the actual feet
  double return_time = 2;    ///< s: time constant with which the shift decays
  /// Fraction of lever(): a root that is deeper below the reference, or farther away from its shifted reference horizontally, has lost it.
  double fall_depth = 0.5;
  double flight_depth =
      0.25;  ///< fraction of lever(): depth of the root below the reference at which free fall without support has faded out
  /// Departure from the reference (calc_departure) from which contacts bear load although the reference lifts or slides them, and the range
  /// over which the conditions of planted_height, planted_speed and sliding_limit fade out.
  double lost_from = 0.1, lost_range = 0.3;
  double release_tilt = 1;    ///< rad: a root that is tilted by more relative to its reference has lost it
  Vec3 gravity{0, 0, -9.81};  ///< m/s^2, world
};

/// State of the controller between ticks. Plain data, so that it can be saved and restored.
struct ControlState {
  double departure = 0;         ///< moving average of the departure from the reference (calc_departure); above 1 control is released
  double shift[3] = {0, 0, 0};  ///< m, world: shift of the root trajectory relative to the reference, caused by foot positions or a fall
  std::uint64_t released = 0;   ///< 1: control is released; 0: active
};

/// Input of one tick. All spans refer to the caller's memory.
struct ControlInput {
  std::span<const double> q, v;                       ///< present state [nq], [nv]
  std::span<const double> q_ref, v_ref, a_ref;        ///< reference at the present time [nq], [nv], [nv]
  std::span<const collision::ContactPoint> contacts;  ///< result of collision analysis at the present state
  int system = 0;                                     ///< index of this character in ContactPoint::system_a
  double dt = 0.002;                                  ///< s: duration of the tick
  const dynamics::KnownKinematics* known = nullptr;   ///< may have the kinematics at q and v; null: MotionControl computes them
};

/// Output of one tick.
struct ControlOutput {
  Vec6 assist;         ///< applied root assist: moment about the root link's origin [N m], force [N], world axes
  Vec6 wanted;         ///< root assist before the cap, same units
  double ratio = 0;    ///< norm of the wanted assist / cap
  double size_bw = 0;  ///< body weights: norm of the applied assist, in which moments are divided by lever()
  bool released = false;
};

/// Controller of one character; see the steps at the top of this file.
class MotionControl {
 public:
  MotionControl(MechanismPtr mechanism, const ControlOptions& options);

  /// Computes the drive torques of one tick.
  /// @param tau [nv, out] N | N m: drive forces; zero for the root's DOFs and after the release of control
  /// @param servo_gain, servo_velocity [nv, out] N m s/rad, rad/s: gain and target of a velocity servo (contact::StepSystem). The target is
  ///   the planned velocity at the end of the step, so that a load-bearing joint resists unplanned motion. For other joints the gain is 0
  ControlOutput step(const ControlInput& input, ControlState& state, std::span<double> tau, std::span<double> servo_gain,
                     std::span<double> servo_velocity);

  [[nodiscard]] const ControlOptions& options() const { return options_; }
  [[nodiscard]] const Mechanism& mechanism() const { return *mechanism_; }
  /// Lever [m] that converts moments to forces in the norm of the assist. It is the maximum of four lengths: height of the root above the
  /// character's lowest point in the neutral position, half the character's height, root mean square horizontal distance of the character's
  /// mass from the root, and 0.1 m.
  [[nodiscard]] double lever() const { return lever_; }
  /// Converts the assist to an external wrench on the root link about the world origin.
  /// @param root m, world: origin of the root link
  [[nodiscard]] static Vec6 about_world_origin(const Vec6& assist, const Vec3& root) {
    return {assist.w + cross(root, assist.v), assist.v};
  }

 private:
  /// Memory of one tick.
  struct Scratch {
    explicit Scratch(const Mechanism& m);
    dynamics::Workspace workspace;      // at the present state
    dynamics::Workspace reference;      // at the reference, the links that support the character and their parents
    std::vector<char> reference_known;  // [links] not 0: `reference` contains the link
    ContactForceProblem problem;
  };

  MechanismPtr mechanism_;
  ControlOptions options_;
  /// Scales the options from a person to a smaller character: lengths by the ratio of the levers, times and speeds by its square root,
  /// because characters of different size move alike if their times are in this ratio (Alexander and Jayes 1983).
  void scale_to_size(double size);
  /// Sets supports_ to the contacts that can bear load: planted in the reference and closed in the present state.
  void find_supports(const ControlInput& input, const Vec3& shift);
  /// Replaces the wanted accelerations of the joints without a drive (effort 0) and outside of loops by those that their springs and
  /// dampers will cause, and recomputes the torques. The other joints keep their wanted accelerations.
  void predict_undriven(const ControlInput& input, std::span<double> tau, dynamics::Workspace& ws);
  /// Free fall: the part of the weight that the ground does not carry accelerates the body. Recomputes torques, reduces the missing wrench.
  /// @param ahead m, world: actual minus reference position of the root
  /// @param gravity m/s^2, in and out: gravity minus the acceleration of the free fall, for inverse dynamics
  /// @return fraction of the weight that is left to gravity, 0 ... 1
  double apply_free_fall(const Vec3& ahead, Vec6& missing, Vec3& gravity, std::span<double> tau, dynamics::Workspace& ws);
  /// Changes the wanted acceleration of the root so that the character does without the wrench `lack`, and recomputes the torques. The
  /// wanted accelerations of the joints stay the same, so the wrench accelerates the character as one rigid body.
  void give_up(const Vec6& lack, const Vec3& gravity, std::span<double> tau, dynamics::Workspace& ws);
  /// Updates the shift of the root's reference trajectory. The shift follows the mean offset of the loaded feet from their reference; in
  /// free fall it follows the root itself.
  /// @param ahead m, world: actual minus reference position of the root
  /// @param falling fraction of the weight that is left to gravity
  void update_shift(const ControlInput& input, std::span<const Vec3> forces, const Vec3& ahead, double falling, double (&shift)[3]) const;

  /// Departure of the root from its reference: the maximum of depth, horizontal distance and tilt, each divided by its limit
  /// (ControlOptions::fall_depth and release_tilt). The depth is relative to the reference itself, the distance to the shifted reference.
  /// @param ahead m, world: actual minus reference position of the root
  [[nodiscard]] double calc_departure(const ControlInput& in, const Vec3& ahead, const double (&shift)[3]) const;

  Scratch scratch_;
  Mat3 rest_root_ = Mat3::identity();  // orientation of the root link in the neutral position
  double lever_ = 1;
  double weight_ = 0;  // N
  bool floating_ = false;
  double lost_ = 0;                // 0: follows the reference; 1: has lost it, so that all contacts bear load
  std::vector<double> wanted_;     // [nv] accelerations, m/s^2 | rad/s^2
  std::vector<int> sprung_links_;  // links whose joint has a spring
  std::vector<double> displacement_;
  LoopDrives loop_drives_;
  std::vector<int> undriven_;              // velocity indices of the joint DOFs without a drive that no loop moves
  std::vector<double> extra_, response_;   // [nv] scratch memory of predict_undriven(); empty if all joints have drives
  std::vector<unsigned char> bears_load_;  // [nv] 1: DOF on the chain between a support and the root
  // [nv] 1: DOF on the chain between the root and a link that touches the ground although it is not planted in the reference
  std::vector<unsigned char> touches_;
  std::vector<Support> supports_;
  std::vector<int> support_links_;
  std::vector<Vec3> offsets_;  // [supports] m, world: contact point minus its position in the reference
  std::vector<Vec3> forces_;
};

}  // namespace ugoki::control
