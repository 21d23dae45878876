#pragma once
// Getting up: a body that lies on the ground rolls to its front and stands up, by the torques of its joints alone.

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "ugoki/collision/contact_point.h"
#include "ugoki/control/contact_forces.h"
#include "ugoki/control/get_up_plan.h"
#include "ugoki/dynamics/workspace.h"

namespace ugoki::control {

struct GetUpOptions {
  double strength = 0.6;      ///< share of the torque limits that the joints use
  double bend = 0.2;          ///< rad: error of a joint at which it uses this share
  double damping = 0.15;      ///< s: damping of a joint, divided by its stiffness
  double ground = 0;          ///< m: height of the ground
  double centre_gain = 40, centre_damping = 12;  ///< 1/s^2, 1/s
  double turn_gain = 25, turn_damping = 8;
  double slow_from = 0.06, slow_to = 0.2;  ///< m
  double centre_memory = 0;  ///< 1/s^3
  double pace = 1;            ///< speed of the way up
  Vec3 gravity{0, 0, -9.81};  ///< m/s^2, world
};

enum class GetUpPhase : std::uint64_t { begin, roll, flatten, climb, done };

/// State between ticks. Plain data, so that it can be saved, restored and replayed.
struct GetUpState {
  static constexpr std::size_t max_coordinates = 512;
  std::uint64_t phase = 0;            ///< GetUpPhase
  std::uint64_t side = 0;             ///< 0: rolls to its left, 1: to its right
  std::uint64_t tries = 0;            ///< number of failed tries
  double time = 0;                    ///< s: time in this phase
  double sum[2] = {0, 0};             ///< m s: integral of the error of the centre of mass, ahead and left
  double way = 0;                     ///< place on the way up, index of a posture
  double from[max_coordinates] = {};  ///< [nq] posture at the begin of the phase
};

class GetUp {
 public:
  GetUp(MechanismPtr mechanism, const GetUpOptions& options);
  /// False: the body has no two arms and two legs.
  [[nodiscard]] bool can_get_up() const { return plan_.has_value(); }
  /// Computes the drives of one tick. @param tau, gain, velocity [nv, out] as in contact::StepSystem
  void step(std::span<const double> q, std::span<const double> v, std::span<const collision::ContactPoint> contacts, int system, double dt,
            GetUpState& state, std::span<double> tau, std::span<double> gain, std::span<double> velocity);
  [[nodiscard]] const GetUpPlan& plan() const { return *plan_; }

 [[nodiscard]] bool ready(std::span<const double> q, std::span<const double> v);
 [[nodiscard]] const Vec3& miss() const { return miss_; }

 private:
  void start(GetUpPhase phase, std::span<const double> q, GetUpState& state) const;
  void follow(std::span<const double> v, double dt, std::span<const double> q, std::span<double> tau, std::span<double> gain, std::span<double> velocity);

  MechanismPtr mechanism_;
  GetUpOptions options_;
  std::optional<BodyPlan> body_;
  std::optional<GetUpPlan> plan_;
  dynamics::Workspace ws_;
  void support(std::span<const collision::ContactPoint> contacts, int system, const GetUpPosture* goal, double dt,
               GetUpState& state, std::span<double> tau);
  ContactForceProblem problem_;
  std::vector<Support> supports_;
  std::vector<int> support_links_;
  std::vector<Vec3> forces_;
  std::vector<double> gradient_, goal_, next_, error_, rate_;
  Vec3 miss_;  // m: wanted minus present centre of mass, in the heading frame
  Vec3 forward_chest_, forward_root_;
};

}  // namespace ugoki::control
