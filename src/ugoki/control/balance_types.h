#pragma once
// Parameters, state, input and output of balance control (balance_control.h).

#include <cstdint>
#include <limits>
#include <span>

#include "ugoki/collision/contact_point.h"
#include "ugoki/control/held_points.h"
#include "ugoki/spatial/vec3.h"

namespace ugoki::control {

/// Parameters of the controller for a person or a larger character; for smaller ones see sized_for(). Members named ..._weight are the cost
/// of a squared acceleration error, in (m/s^2)^-2 or (rad/s^2)^-2.
struct BalanceOptions {
  double com_gain = 3;  ///< 1/s: gain k of step 3 above
  double com_weight = 100;
  double height_frequency = 10;  ///< rad/s: natural frequency of the vertical error of the centre of mass (critically damped)
  double trunk_frequency = 15;   ///< rad/s: natural frequency of the errors of the orientation of pelvis and chest
  double pelvis_weight = 3, chest_weight = 1;
  double momentum_gain = 5;      ///< 1/s: decay rate of the error of angular momentum
  double momentum_weight = 0.3;  ///< weight of the angular momentum divided by the mean moment of inertia, about the centre of mass
  double joint_frequency = 20;   ///< rad/s: natural frequency of the errors of joints
  double joint_weight = 1, leg_weight = 0.3;
  double many_leg_weight =
             0.1,  ///< leg_weight of large characters on more than two feet, whose feet determine most of the posture of the legs
      many_momentum_weight = 0.9,  ///< momentum_weight of characters on more than two feet
      many_trunk_weight = 0.5,     ///< factor on pelvis_weight and chest_weight of characters on more than two feet
      many_landing = 0.7;          ///< `landing` of characters on more than two feet
  double swing_frequency = 45;     ///< rad/s: natural frequency of the errors of swing feet
  double swing_weight = 60, swing_turn_weight = 3;
  double turn_margin =
      0.1;  ///< rad: on slopes, the orientation of a swing foot counts less if a joint of the foot is closer than this to a limit
  double flat = 0.15, steep = 0.4;        ///< rad: a sole tilted by less than `flat` is made level; a tilt above `steep` is kept
  double sole_damping = 40;               ///< 1/s: decay rate of the velocity of a sole point in stance
  double sole_weight = 1e5;               ///< weight of the constraints of standing feet
  double friction_margin = 0.7;           ///< fraction of the friction coefficient that forces may use
  double load_cost = 1e-6;                ///< cost of a squared edge force, N^-2
  double touch = 1e-3;                    ///< m: only contact points closer to the ground than this bear load
  double hover = 2e-3, max_hover = 0.05;  ///< m: points of a standing sole that are this high above the ground are pressed down
  double exact =
      2e-3;  ///< m: on level ground, points of a sole that the reference has higher than this above its lowest point are not pressed down
  double exact_uneven = 0.01;  ///< m: the same for level ground below a sole of a character whose last steps were on uneven ground
  double max_gap = 0.012;      ///< m: points above ground that is lower than this below the plane of their foothold are not pressed down
  double hover_weight = 3000;  ///< weight of the tasks that press them down; the posture of the ankle holds a heel up with a smaller weight
  double press_margin = 0.02;  ///< m: on level ground, points of a measured sole are pressed down only if the wanted pressure is closer
                               ///< than this to the edge over which the foot tips, or behind it
  double hover_time = 0.04, hover_speed = 0.5;  ///< s, m/s: they move down at height / time, and not faster than this
  double lifting = 0.15;          ///< m/s: no load on a point that, in the reference, rises this much faster than the foot's slowest point
  double lifted = 0.01;           ///< m: no load on a rising point that, in the reference, is this much higher than the foot's lowest point
  double sole_share = 0.9;        ///< share of each sole in which the reference has its centre of pressure (feasible_centre.h)
  double pressure_reach = 0.15;   ///< heights of the centre of mass: maximum correction of the centre of pressure of the reference
  double anchor_time = 0.04;      ///< s: time constant with which the anchor follows the foot
  double ground_time = 0.1;       ///< s: time constant with which the height and the slope of the reference's ground follow the real ground
  double leg_share = 1;           ///< the body is lowered if a leg would be longer than this share of its maximum length in the reference
  double lower_time = 0.05;       ///< s: time constant of this lowering
  double max_step = 0.3;          ///< ground higher or lower than this share of the height of the centre of mass is no foothold
  double move_cost = 0.3;         ///< m: unevenness that a foothold may have, for each m by which it would move to even ground
  double foothold_margin = 0.04;  ///< m: ground this far ahead of a sole and behind it counts in the choice of its foothold
  double max_move = 0.65;         ///< lengths of the foot: maximum of this move
  double hold = 2,
         hold_from = 0.5;    ///< factor on the cost of a change of a foothold, which grows from the phase `hold_from` to the landing
  double homing = 0.1;       ///< share of its lateral displacement by which the reference is ahead of the foot, back towards its own place
  double max_homing = 0.02;  ///< maximum of this distance, in heights of the centre of mass
  double turn_homing = 0.2, max_turn_home = 0.06;  ///< the same for the heading: share; rad
  double homing_slope = 0.5;  ///< slope of the ground from which on the reference does not return sideways; below it, it returns less
  double heading_time = 0.2;  ///< s: time constant of the anchor's heading; 0: the heading is not anchored
  double turn_time = 0.1;     ///< s: time constant with which a foot that turns on the ground follows the heading of its reference
  double shift_growth = 1.5;  ///< 1/s: assumed growth rate of the DCM error until touch-down; without ankle torques the rate is w0
  double max_transfer = 0.3;  ///< s: maximum duration of the double support in the calculation of how far the next foothold is shifted
  double shift_time = 0.03;   ///< s: time constant with which the shift of the next foothold is updated
  double max_shift = 0.8;     ///< m: maximum shift of the next foothold from its place in the reference
  double hurry = 1, hurry_from = 0.15,
         max_hurry = 1.4;  ///< 1/m, m, factor: rate of time in a swing = 1 + hurry (shift - hurry_from), between 1 and max_hurry
  double pace_time =
      0.5;  ///< s: a character whose DCM is ahead of its reference by the way of a time t follows it faster by t / pace_time ...
  double max_pace = 0.1;          ///< ... but at most by this share ...
  double pace_slope = 0.05;       ///< ... and on ground with at least this slope (rise per length); on ground with less slope by less
  double clearance = 0.01;        ///< m: added to the height of a swing foot in the middle of the swing
  double rough_clearance = 0.05;  ///< m: maximum further height over ground that deviates from the line between both footholds
  double raise_speed = 0.6;       ///< m/s: a swing foot that touches something is raised at this speed ...
  double max_raise = 0.08;        ///< m: ... by at most this height
  double scuff = 0.01;            ///< m: ... if the foot is higher than this above the ground in the reference
  double max_tiptoe = 0.03;       ///< m: a foot that touches early stands only if its sole is at most this much higher than at its landing
  double aim_depth = 0.01;        ///< m: a swing foot aims this far below the floor at the end of the swing
  double press_speed = 0.8;       ///< m/s: downward speed of a foot that lands later than in the reference
  double step_time = 0.27;        ///< s: duration of a reaction step
  double step_delay = 0.04;       ///< s: time for which the DCM must be outside the support before a reaction step
  double step_margin = 0.3;       ///< s: a reaction step starts if the DCM leaves the support by over step_margin * reference speed
  double step_error = 0.06;       ///< m: minimum error of the DCM for a reaction step
  double step_clearance = 0.05;   ///< m: height of a reaction step
  double separation = 0.14;       ///< m: minimum lateral distance of the feet after a reaction step
  double push_off = 0.1;          ///< body weights: the feet lift to a flight only when the reference needs less ground force
  double landing = 0.4;           ///< factor on the DCM error in the shift of a landing after a flight, if another foot steps afterwards
  double jump_landing = 0.8;      ///< the same factor if all feet land together, so that no further step corrects the error
  double early = 0.6;             ///< fraction of the swing after which a touching foot stands
  double early_rate = 1.6, late_rate = 1;  ///< rate of the reference's time after an early touch-down, and while a touch-down is late
  double limit_time = 0.02;                ///< s: a joint keeps its limits for this time ahead, at constant acceleration
  int limit_rounds = 2;  ///< maximum number of further solutions; each adds the limits that the previous solution exceeds as constraints
  double swing = 0;      ///< rad: amplitude to which a hanging character swings by itself; 0: it only follows its reference
  double swing_range = 0.2;      ///< rad: the character swings with full effort if its amplitude is lower than `swing` by this
  double swing_flex = 1.2;       ///< rad: how far ahead of the reference the legs swing
  double swing_arch = 0.4;       ///< rad: how far behind the reference the legs swing
  double prepare_time = 0.35;    ///< s: a hanging character prepares its release for this time
  double prepare_weight = 10;    ///< weight of the angular momentum, divided by the mean moment of inertia, before a release
  double prepare_posture = 0.3;  ///< factor on the weights of the joints before a release
  double landing_reach = 0.45;  ///< share of the leg's length: maximum horizontal distance of the feet from the centre of mass at a landing
  double landing_leg = 0.93;    ///< share of the height of the centre of mass in the reference with which the feet meet the ground
  double landing_brake = 1.5;   ///< factor of gravity: maximum deceleration of the centre of mass after a landing
  double landing_spin = 1;      ///< share of the angular momentum that the place of the feet takes away
  double landing_upright = 10;  ///< factor on the weights of pelvis and chest before a landing: legs and arms turn the trunk upright
  double landing_weight = 60;   ///< weight of the feet before a landing
  double landing_frequency = 12;  ///< rad/s: natural frequency of the errors of the feet before a landing
  double landing_time = 0.6;      ///< s: time after a landing in which the deceleration is limited
  Vec3 gravity{0, 0, -9.81};      ///< m/s^2, world
};

/// Options for characters of any size. Let L be the height of the standing character's centre of mass divided by 0.8 m. If L is below 1,
/// frequencies and gains are divided by sqrt(L), as motions of similar bodies under gravity are faster (Froude scaling). The weights of the
/// orientations of pelvis and chest are multiplied by L^2, so that an angular acceleration costs as much as the linear acceleration of a
/// point of the trunk. Characters on more than two feet get their own weights.
/// @param height m: of the centre of mass of the standing character above its soles
[[nodiscard]] BalanceOptions sized_for(BalanceOptions options, double height, std::size_t feet);

/// How the character is supported, apart from walking and standing (HangPlan).
enum class HangMode : std::uint64_t {
  none,   ///< by its feet, or it flies as in its reference
  hangs,  ///< by grips at fixed places; no foot touches the ground
  drops,  ///< it has released its grips and falls towards the ground
  lands   ///< its feet have touched the ground after a drop
};

/// State of the controller between ticks. Plain data, so that it can be saved, restored and replayed.
struct BalanceState {
  static constexpr std::size_t max_feet = 8;
  struct FootState {
    std::uint64_t stands = 0;      ///< 1: the foot counts as standing
    std::uint64_t early = 0;       ///< 1: the foot stands, although it still swings in the reference
    std::uint64_t reacts = 0;      ///< 1: the foot makes a reaction step, which the reference does not contain
    double begin = 0, length = 0;  ///< s: begin (on BalanceState::clock) and duration of the reaction step
    double lost = 0;               ///< s: time for which the standing foot has had no ground contact
    double offset[3] = {0, 0, 0};  ///< m, world: position of the foot minus that in the reference, when the foot left the ground
    double shift[2] = {0, 0};      ///< m, world: shift of the next touch-down
    double place[2] = {0, 0};      ///< m, world: further shift, to even ground
    double from[3] = {0, 0, 0};    ///< m, world: where the foot left the ground; z: height of the ground there
    double to[3] = {0, 0, 0};      ///< m, world: foothold; z: height of the ground there
    double tilt[2] = {0, 0};       ///< slope of the ground at the foothold: rise per length along the x and y axes of the world
    double raise = 0;              ///< m: how much higher the foot swings because it has touched something
    double bump = 0;               ///< m: height of the path of the foot above the line between both places, in the middle of the way
    double sharp[2] = {1, 1};      ///< shape of this height in both halves of the way (swing_path.h)
  };
  std::uint64_t started = 0;
  double time = 0;                   ///< s: time of the reference
  double rate = 1;                   ///< seconds of the reference per second
  double pace = 1;                   ///< rate of the reference's time in an undisturbed step
  double clock = 0;                  ///< s: time since the controller started
  double trouble = 0;                ///< s: time for which the DCM has been outside the support
  double x = 0, y = 0, heading = 0;  ///< m, rad: displacement of the reference by the anchor
  double z = 0;                      ///< m: mean height of the ground around the centre of mass, minus that in the reference
  double tilt[2] = {0, 0};           ///< mean slope of this ground: rise per length along the x and y axes of the world
  double ground[2] = {0, 0};         ///< m, world: x and y of the point of the ground at which it has the height `z`
  double lower = 0;                  ///< m: how much lower the body is than in the reference, so that the legs reach the ground
  double loose = 0;                  ///< m: height of the objects under the standing feet that are not in the map of the ground
  FootState feet[max_feet];
  std::uint64_t hang = 0;                      ///< HangMode
  double hang_time = 0;                        ///< s: time in this mode
  double hang_effort = 0;                      ///< -1 to 1: how far the legs swing ahead (1) or behind (-1)
  double hang_rate = 0;                        ///< 1/s: rate of hang_effort
  double multipliers[6] = {0, 0, 0, 0, 0, 0};  ///< multipliers from which the quadratic program starts
};

/// Input of one tick. All spans refer to the caller's memory.
struct BalanceInput {
  std::span<const double> q, v;                       ///< present state [nq], [nv]
  std::span<const collision::ContactPoint> contacts;  ///< result of collision analysis at the present state
  int system = 0;                                     ///< index of this character in ContactPoint::system_a
  double dt = 0.002;                                  ///< s
  std::span<const HeldPoint> held = {};               ///< grips of this character, and grips of others that hold it; at most max_held
  static constexpr std::size_t max_held = 8;
  double release_in = std::numeric_limits<double>::infinity();  ///< s: time until the last fixed grip is released; infinite: unknown
};

/// Output of one tick.
struct BalanceOutput {
  Vec3 dcm_error;        ///< m, world: DCM minus its reference
  int iterations = 0;    ///< Newton steps of the quadratic program
  double residual = 0;   ///< N | N m: error of the equations of motion
  int limits = 0;        ///< number of torque limits that the planned torques reach
  int joint_limits = 0;  ///< number of joint limits that the planned accelerations reach
  bool solved = true;    ///< true: the quadratic program converged
  HangMode hang = HangMode::none;
};

}  // namespace ugoki::control
