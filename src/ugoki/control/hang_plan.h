#pragma once
// Hanging, swinging and landing: what balance control does while grips at fixed places carry the character, and after it has released them.
//
//   hangs  The posture follows the reference, and the body turns freely about its grips. With BalanceOptions::swing, the legs swing ahead
//          while the body swings ahead and behind while it swings back, until the amplitude is reached. With the angle theta of the centre
//          of mass from the vertical below the grips, its natural frequency w and the angle phi of the legs ahead of the reference,
//            theta'' + w^2 theta = -k phi'',   so that phi ~ theta' adds energy (k > 0 for legs, which are far below the grips)
//          In the last BalanceOptions::prepare_time before the release, the body gets the angular momentum H with which it comes to
//          its landing posture by itself: H T = A_G d, with T the duration of the flight, A_G the centroidal momentum matrix, and d the
//          displacement of the root's orientation and of all joints from the posture at the release to that at the landing.
//   drops  The feet move to the place of the landing: the point at which a pendulum with the velocity of the body comes to rest,
//          c + c' / w0, as far as the legs reach. The trunk turns upright. Angular momentum cannot change.
//   lands  The feet stand. The centre of mass brakes with a limited deceleration: knees and hips bend.

#include <vector>

#include "ugoki/control/balance_model.h"
#include "ugoki/control/ground_support.h"

namespace ugoki::control {

/// Wanted motion of a sole: m, m/s, m/s^2, world.
struct LandingGoal {
  Vec3 place, velocity, acceleration;
};
/// Wanted motion of the sole of a foot in the mode HangMode::drops.
[[nodiscard]] LandingGoal landing_goal(const BalanceModel& model, const BalanceState& state, std::size_t foot);

/// Swing of a hanging body.
struct Swing {
  double angle = 0, rate = 0;  ///< rad, rad/s: of the centre of mass about the grips; 0: below them, positive: ahead
  double amplitude = 0;        ///< rad: of the swing of a pendulum with this angle and rate
  double frequency = 0;        ///< rad/s: natural frequency of small swings of a point mass
};
[[nodiscard]] Swing swing_of(const BalanceModel& model, const BalanceInput& input);

/// The flight that follows the next release of a hanging body.
struct ReleasePlan {
  double rest = 0;    ///< s: time until the release; 0: no release is prepared
  double flight = 0;  ///< s: duration of the flight
  Vec3 turn;          ///< rad, world: rotation of the root from the release to the landing
};

class HangPlan {
 public:
  explicit HangPlan(const BalanceModel& model);
  /// Changes between the modes, and advances the effort of the legs. Call after GroundSupport::collect().
  void update(const BalanceModel& model, const GroundSupport& support, const BalanceInput& input, BalanceState& state);
  /// True if the feet carry no load in this mode, so that neither phase nor anchor follow them.
  [[nodiscard]] static bool is_airborne(const BalanceState& state) {
    return state.hang == static_cast<std::uint64_t>(HangMode::hangs) || state.hang == static_cast<std::uint64_t>(HangMode::drops);
  }
  /// Places the reference at the body that hangs or drops: x, y and heading of the state.
  void place_reference(const BalanceModel& model, BalanceState& state) const;
  /// Replaces the sampled reference. A hanging body: its own root, legs moved by the effort. A body that drops or lands: on the ground.
  void edit_reference(BalanceModel& model, const BalanceInput& input, const BalanceState& state);
  /// True if the body hangs and prepares its release.
  [[nodiscard]] static bool prepares(const BalanceModel& model, const BalanceInput& in, const BalanceState& state) {
    return state.hang == static_cast<std::uint64_t>(HangMode::hangs) && in.release_in < model.options.prepare_time;
  }
  /// The release that the body prepares. Call after edit_reference().
  [[nodiscard]] const ReleasePlan& release() const { return release_; }

 private:
  void update_effort(const BalanceModel& model, const BalanceInput& input, BalanceState& state);

  void plan_release(const BalanceModel& model, const BalanceInput& in, const BalanceState& state);

  ReleasePlan release_;
  std::vector<double> step_;         // [nv]
  std::vector<double> no_velocity_;  // [nv] zeros
};

}  // namespace ugoki::control
