#pragma once
// Falling: detects that a character can no longer keep its balance, and protects it while it falls.
//
//   track   the character follows its track
//   brace   a fall is possible: balance control goes on with the legs and the trunk, and the arms already reach for the ground
//   fall    the hands move towards the place where the body will hit the ground, knees and hips bend, and the head leans away from this
//           place. The joints are soft springs with dampers (posture_servo.h), so that arms and legs absorb the impact
//   lie     the body has come to rest; dampers hold its joints
//   rise    the body gets up (get_up.h)
//   ready   the body squats on both feet: balance control can stand it up (return_motion.h)
//
// A character braces if the trunk is tilted too far from its reference, if the centre of mass is too low, or if the divergent component of
// motion (DCM, balance_control.h) is too far from its reference, for longer than `delay`. It falls if wider limits are exceeded: within the
// narrow limits, steps often keep a character up.
//
// Bodies without two arms and two legs keep the posture in which the fall begins, and stay on the ground.

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "ugoki/control/body_plan.h"
#include "ugoki/control/get_up.h"
#include "ugoki/control/ground_map.h"
#include "ugoki/control/pose_finder.h"
#include "ugoki/control/posture_servo.h"

namespace ugoki::control {

/// Limits beyond which a character braces or falls.
struct FallLimits {
  double tilt;    ///< rad: tilt of the trunk from its reference
  double height;  ///< share of the reference's height: the centre of mass is lower than this
  double reach;   ///< share of the height of the centre of mass: error of the DCM
};

struct FallOptions {
  FallLimits brace{0.6, 0.8, 0.6};
  FallLimits fall{1, 0.65, 1.4};
  double delay = 0.03;        ///< s: a limit must be exceeded for longer than this
  double calm = 0.3;          ///< s: bracing ends when no limit has been exceeded for this time
  double frequency = 9;       ///< rad/s: natural frequency of the joints' errors during a fall
  double strength = 0.5;      ///< share of the torque limits that the joints use during a fall
  double rest_speed = 0.3;    ///< m/s: the body lies if its centre of mass is slower than this ...
  double rest_time = 0.3;     ///< s: ... for this time
  double lie_damping = 3;     ///< rad/s: natural frequency whose critical damping acts on the joints of a lying body
  double lie_time = 0.2;      ///< s: the body lies for this time before it gets up
  bool get_up = false;        ///< the body gets up after it has come to rest
  Vec3 gravity{0, 0, -9.81};  ///< m/s^2, world
};

enum class FallMode : std::uint64_t { track, brace, fall, lie, rise, ready };

/// State between ticks. Plain data, so that it can be saved, restored and replayed.
struct FallState {
  static constexpr std::size_t max_coordinates = 512;
  std::uint64_t mode = 0;                ///< FallMode
  double time = 0;                       ///< s: time in this mode
  double trouble = 0;                    ///< s: time for which a limit of the next mode (brace, then fall) has been exceeded
  double calm = 0;                       ///< s: time for which no limit of bracing has been exceeded
  double rest = 0;                       ///< s: time for which the body has been at rest
  double posture[max_coordinates] = {};  ///< wanted posture [nq] during a fall
  GetUpState get_up;                     ///< in the mode rise
};

class FallControl {
 public:
  /// @param ground the ground on which the body falls and lies: a level floor, slopes, platforms
  FallControl(MechanismPtr mechanism, const FallOptions& options, GroundMap ground = GroundMap());

  /// Changes between the modes track, brace and fall. Call it in each tick of the modes track and brace.
  /// @param q, v present state [nq], [nv] @param q_ref [nq] reference at the place of the body @param dcm_error m: DCM minus its reference
  /// @return distance from the limits of a fall: 1 if the body is at its reference, 0 at a limit, negative beyond it
  double check(std::span<const double> q, std::span<const double> v, std::span<const double> q_ref, const Vec3& dcm_error, double dt,
               FallState& state);
  /// Replaces the drives of the arms in the mode brace. @param tau, gain, velocity [nv, in and out] as in contact::StepSystem
  void brace(std::span<const double> q, std::span<const double> v, double dt, FallState& state, std::span<double> tau,
             std::span<double> gain, std::span<double> velocity);
  /// Computes the drives of one tick in the modes fall, lie, rise and ready. The first tick of a rise plans the way up: it allocates, and
  /// takes about 0.2 s of processor time. @param contacts contact points of all systems @param system index of this body in `contacts`
  /// @param tau, gain, velocity [nv, out] as in contact::StepSystem
  void step(std::span<const double> q, std::span<const double> v, std::span<const collision::ContactPoint> contacts, int system, double dt,
            FallState& state, std::span<double> tau, std::span<double> gain, std::span<double> velocity);
  /// The way up; null before the first rise, and for bodies that cannot get up.
  [[nodiscard]] const GetUpPlan* plan() const { return get_up_ && get_up_->can_get_up() ? &get_up_->plan() : nullptr; }
  /// Plans the way up now, for a state that was restored.
  const GetUpPlan* make_plan();

 private:
  void update(std::span<const double> q, std::span<const double> v);  // kinematics, inertia and weight
  void reach_for_the_ground(std::span<const double> q, double dt, FallState& state);

  MechanismPtr mechanism_;
  FallOptions options_;
  std::shared_ptr<const GroundMap> ground_;
  std::optional<BodyPlan> plan_;
  dynamics::Workspace ws_;
  PoseFinder finder_;
  std::unique_ptr<GetUp> get_up_;  // null before the first rise
  std::vector<double> crouch_;     // [nq] posture with bent knees and hips
  std::vector<double> zero_, error_, gradient_, tau_, gain_, velocity_;
  std::vector<int> arms_;  // DOFs of the arms
};

}  // namespace ugoki::control
