#pragma once
// Getting up: a body that lies on the ground rolls to its front and gets up to a squat, by the torques of its joints alone.
//
//   flatten   the body stretches: every roll begins from the same posture
//   roll      arms and legs swing the body from its back or its side to its front
//   climb     the body follows the way of get_up_plan.h up to a squat on both soles
//   rest      the tries have failed; dampers hold the joints
//
// In each tick, three parts make the torques:
//   1. the contact forces, inside their friction cones, that bear the weight and move the centre of mass and the pelvis to their places on
//      the way (contact_forces.h), times the Jacobians of the contact points
//   2. gravity on the links
//   3. a posture servo for the joints, implicit as in posture_servo.h
// The way waits while the centre of mass is not over its place. No force acts on the root.

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "ugoki/collision/contact_point.h"
#include "ugoki/control/contact_forces.h"
#include "ugoki/control/get_up_plan.h"
#include "ugoki/control/ground_map.h"
#include "ugoki/dynamics/workspace.h"

namespace ugoki::control {

struct GetUpOptions {
  double strength = 0.6;                             ///< share of the torque limits that the controller uses
  double bend = 0.123;                               ///< rad: error of a joint at which its servo uses this share
  double damping = 0.0573;                           ///< s: damping of a joint divided by its stiffness
  double centre_gain = 83.3, centre_damping = 8.67;  ///< 1/s^2, 1/s: of the error of the centre of mass
  double turn_gain = 25.5, turn_damping = 6.61;      ///< 1/s^2, 1/s: of the error of the pelvis's orientation, and of the angular momentum
  /// Shares of the height of the hips: errors of the centre of mass at which the way slows down, and nearly stops.
  double slow_from = 0.0852, slow_to = 0.311;
  double roll_speed = -0.33, roll_gain = 12.05;  ///< rad/s, 1/s: wanted speed of a roll, and gain of its error
  double on_front = 0.20;                        ///< a body whose front points downwards by more than this cosine lies on its front
  double roll_time = 1.5;                        ///< s: a longer roll has failed
  double climb_time = 6.5;                       ///< s: a longer climb has failed
  std::uint64_t tries = 6;                       ///< failed tries after which the body rests
  Vec3 gravity{0, 0, -9.81};                     ///< m/s^2, world
};

enum class GetUpPhase : std::uint64_t { begin, flatten, roll, climb, rest };

/// State between ticks. Plain data, so that it can be saved, restored and replayed.
struct GetUpState {
  static constexpr std::size_t max_coordinates = 512;
  std::uint64_t phase = 0;            ///< GetUpPhase
  std::uint64_t side = 0;             ///< 0: rolls to its left, 1: to its right
  std::uint64_t tries = 0;            ///< number of failed tries
  double time = 0;                    ///< s: time in this phase
  double low = 0;                     ///< s: time for which the body has been too low for its place on the way
  double miss = 0;                    ///< m: how far the centre of mass is behind its place on the way
  double way = 0;                     ///< place on the way up, index of a posture; -1: at `from`
  double from[max_coordinates] = {};  ///< [nq] posture at the begin of the phase
};

class GetUp {
 public:
  /// Plans the way up; see plan_get_up().
  /// @param ground kept: the ground under the body
  GetUp(MechanismPtr mechanism, const GetUpOptions& options, std::shared_ptr<const GroundMap> ground = std::make_shared<const GroundMap>());
  /// False: the body has no two arms and two legs, or more than GetUpState::max_coordinates coordinates.
  [[nodiscard]] bool can_get_up() const { return plan_.has_value(); }
  [[nodiscard]] const GetUpPlan& plan() const { return *plan_; }
  /// Computes the drives of one tick. @param contacts of all systems, at the present state @param system index of the body in `contacts`
  /// @param tau, gain, velocity [nv, out] as in contact::StepSystem
  void step(std::span<const double> q, std::span<const double> v, std::span<const collision::ContactPoint> contacts, int system, double dt,
            GetUpState& state, std::span<double> tau, std::span<double> gain, std::span<double> velocity);
  /// True if the body squats on both soles with its divergent component of motion (balance_control.h) over them.
  [[nodiscard]] bool is_ready(std::span<const double> q, std::span<const double> v, const GetUpState& state);

 private:
  void start(GetUpPhase phase, std::span<const double> q, GetUpState& state) const;
  void change_phase(std::span<const double> q, double dt, GetUpState& state) const;
  /// Sets goal_ and next_: the wanted postures of this tick and the next. @return the posture of the way; null in other phases
  const GetUpPosture* find_goal(double dt, GetUpState& state);
  void add_support(std::span<const collision::ContactPoint> contacts, int system, const GetUpPosture* goal, GetUpState& state,
                   std::span<double> tau);
  void add_servo(std::span<const double> q, std::span<const double> v, double dt, std::span<double> tau, std::span<double> gain,
                 std::span<double> velocity);
  /// Horizontal direction ahead of the pelvis, and the middle of the balls of the feet.
  [[nodiscard]] Vec3 ahead() const;
  [[nodiscard]] Vec3 balls() const;
  /// m: height of the ground below a point of the body, which may be a little below the ground.
  [[nodiscard]] double ground_at(const Vec3& p) const { return ground_->below(p + Vec3{0, 0, 0.1 * body_->hip_height}).height; }

  MechanismPtr mechanism_;
  GetUpOptions options_;
  std::shared_ptr<const GroundMap> ground_;
  std::optional<BodyPlan> body_;
  std::optional<GetUpPlan> plan_;
  dynamics::Workspace ws_;
  ContactForceProblem problem_;
  std::vector<Support> supports_;
  std::vector<int> support_links_;
  std::vector<Vec3> forces_;
  std::vector<double> gradient_, goal_, next_, error_, rate_;
  Vec3 chest_front_;  // unit, in the frame of the chest
};

}  // namespace ugoki::control
