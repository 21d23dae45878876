#pragma once
// Motion control: joint torques that make a figure follow a reference motion on its own feet.
//
// Each tick:
//   1. wanted acceleration = reference + stable PD on the error (Tan, Liu, Turk 2011), for the joints and for the root, whose
//      path is carried along where feet have landed elsewhere than the reference's;
//   2. inverse dynamics gives the joint torques and the wrench that the root would need;
//   3. contact forces at the points where the figure stands, inside their friction pyramids, give as much of that wrench as they
//      can (contact_forces.h; Abe 2007, da Silva 2008); joint torques carry them;
//   4. what the ground cannot give of the weight is left to gravity: a figure in the air flies and falls, and its path goes along;
//   5. what is still missing is the root assist: capped, applied, and reported. While more is wanted than the cap for longer
//      than a moment, the figure lets go: from then on there is no drive torque and no assist. It is a ragdoll.

#include <span>
#include <vector>

#include "ugoki/collision/contact_point.h"
#include "ugoki/control/contact_forces.h"
#include "ugoki/dynamics/dynamics.h"

namespace ugoki::control {

struct ControlOptions {
  double tracking = 1;            ///< factor on the joints' gains, 0 ... 2
  double balance = 1;             ///< factor on the root's gains, 0 ... 2
  double joint_frequency = 20;    ///< rad/s: how fast a free joint's error decays (critically damped)
  double root_frequency = 20;     ///< rad/s: the same for the root and the joints between it and a foot that stands
  double joint_hold = 0.3;        ///< s/rad: servo gain of a joint that bears load, times its strength^2 / (weight * lever)
  double assist_limit = 0.5;      ///< body weights: cap of the root assist (moments count at the lever of the root's height)
  double patience = 0.25;         ///< s: time constant with which the wanted assist is averaged before the figure lets go
  double contact_margin = 0.005;  ///< m: contacts nearer than this can bear load
  double planted_height = 0.04;   ///< m above the present contact: a point that the path has higher than this is not planted
  double planted_speed = 0.5;     ///< m/s upwards: a reference point faster than this is not planted
  double lifting_speed = 0.05;    ///< m/s upwards: a reference point that is faster bears load only where others cannot
  double sliding_speed = 0.8;     ///< m/s along the floor: a reference point faster than this is not planted
  double shift_time = 0.12;       ///< s: how fast the path follows feet that have landed elsewhere than the reference's
  double return_time = 2;         ///< s: how fast it comes back to the reference's path
  double fall_depth = 0.5;        ///< of the root's height, below the reference: so far a figure that nothing carries falls freely
  Vec3 gravity{0, 0, -9.81};
};

/// Memory from tick to tick: plain data, for saving and restoring.
struct ControlState {
  double overload = 0;          ///< averaged wanted assist / cap
  double shift[3] = {0, 0, 0};  ///< m: by how much the figure's path has left the reference's, as its feet or its fall have it
  std::uint64_t let_go = 0;     ///< 1 once the figure has let go
};

/// Input of one tick; spans of the caller's memory.
struct ControlInput {
  std::span<const double> q, v;                       ///< present state [nq], [nv]
  std::span<const double> q_ref, v_ref, a_ref;        ///< reference at the present time [nq], [nv], [nv]
  std::span<const collision::ContactPoint> contacts;  ///< of collision analysis at the present state
  int system = 0;                                     ///< this figure's index in the contacts
  double dt = 0.002;                                  ///< s
};

/// Output of one tick.
struct ControlOutput {
  Vec6 assist;         ///< applied root assist: moment about the root link's origin [N m], force [N], world axes
  Vec6 wanted;         ///< before the cap
  double ratio = 0;    ///< size of the wanted assist / cap
  double size_bw = 0;  ///< size of the applied assist in body weights, moments included at the lever
  bool let_go = false;
};

class MotionControl {
 public:
  MotionControl(MechanismPtr mechanism, const ControlOptions& options);

  /// @param tau [nv, out] drive forces; zero for the root's freedoms and after letting go
  /// @param servo_gain, servo_velocity [nv, out] N m s/rad, rad/s: the drives also hold the velocity that was planned for the end of
  ///   the step, with this gain; a joint that bears load resists what was not planned (see contact::StepSystem)
  ControlOutput step(const ControlInput& input, ControlState& state, std::span<double> tau, std::span<double> servo_gain,
                     std::span<double> servo_velocity);

  [[nodiscard]] const ControlOptions& options() const { return options_; }
  [[nodiscard]] const Mechanism& mechanism() const { return *mechanism_; }
  /// m: distance at which a moment counts as a force in the size of the assist; the root's height above the lowest point
  /// in the neutral position.
  [[nodiscard]] double lever() const { return lever_; }
  /// The assist as an external wrench on the root link about the world origin. @param X_WB pose of the root link
  [[nodiscard]] static Vec6 about_world_origin(const Vec6& assist, const Vec3& root) {
    return {assist.w + cross(root, assist.v), assist.v};
  }

 private:
  MechanismPtr mechanism_;
  ControlOptions options_;
  void find_supports(const ControlInput& input, const Vec3& shift);
  /// Lets the figure fall as far as the ground does not carry it: lowers the acceleration wanted, the torques and what is missing.
  /// @param ahead m, the root's place against its reference
  /// @return how much of the figure's weight is left to gravity, 0 ... 1
  double fall(const Vec3& ahead, Vec6& missing, std::span<double> tau);
  /// Feet that have landed elsewhere than the reference's carry the path along, and so does a fall.
  void carry_path(const ControlInput& input, std::span<const Vec3> forces, const Vec3& ahead, double falling, double (&shift)[3]) const;

  dynamics::Workspace workspace_, reference_;
  ContactForceProblem problem_;
  double lever_ = 1;
  double weight_ = 0;  // N
  bool floating_ = false;
  std::vector<double> wanted_;  // [nv] accelerations
  std::vector<double> displacement_;
  std::vector<unsigned char> bears_;  // [nv] lies between the ground and the root
  std::vector<Support> supports_;
  std::vector<int> support_links_;
  std::vector<Vec3> apart_;  // [supports] from where the reference has the point to where it is
  std::vector<Vec3> forces_;
};

}  // namespace ugoki::control
