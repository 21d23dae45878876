#pragma once
// Balance control: a character follows a reference motion on its own feet without an external force, and makes steps to keep its balance.
//
// Each tick:
//   1. Phase. The controller advances the time of the reference: at rate 1, and faster after a foot has landed early. A foot lifts when its
//      counterpart in the reference lifts, and stands when it touches the ground. A foot that lands late is pressed down.
//   2. Anchor. The reference is displaced in the horizontal plane so that its standing foot coincides with the real one. No force draws the
//      character back to the original path of the reference.
//   3. Centre of mass. With the error e of the centre of mass from the anchored reference, w0 = sqrt(g / height) and a gain k:
//        c'' = c''_ref - w0 k e - (w0 + k) e'     in the horizontal plane
//      This is the control law p = p_ref + (1 + k / w0) (xi - xi_ref) of the divergent component of motion (DCM) xi = c + c' / w0.
//   4. Swing feet. A foot begins its swing where it left the ground and lands at the reference plus a shift. The shift is the error of the
//      DCM that is predicted for the touch-down, so that the character steps in the direction of a push.
//   5. Reaction steps. If the DCM leaves the support while the reference stands, a foot steps to the position that the DCM will have at
//      the landing. The DCM of a pendulum on a point p moves by xi(T) = p + (xi - p) exp(w0 T). Several steps may follow each other. The
//      feet stay where they have landed until the reference makes its next steps.
//   6. A quadratic program (quadratic_program.h) finds accelerations, contact forces and torques. Only ground forces act on the root.
//      Standing soles are constraints, and the drives stay within their limits.
//
// Sources: Kajita et al. (2003), Englsberger et al. (2015), DCM; Khadiv et al. (2016), step adaptation; Lee, Kim, Lee (2010), correction of
// measured motions that grows with the phase; Abe, da Silva, Popovic (2007), de Lasa et al. (2010), whole-body quadratic programs.

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "ugoki/collision/contact_point.h"
#include "ugoki/control/foot_schedule.h"
#include "ugoki/control/quadratic_program.h"
#include "ugoki/dynamics/centroidal.h"
#include "ugoki/dynamics/dynamics.h"

namespace ugoki::control {

/// Parameters of the controller. Members named ..._weight are the cost of a squared acceleration error, in (m/s^2)^-2 or (rad/s^2)^-2.
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
  double swing_frequency = 45;  ///< rad/s: natural frequency of the errors of swing feet
  double swing_weight = 60, swing_turn_weight = 3;
  double flat = 0.15, steep = 0.4;  ///< rad: a sole tilted by less than `flat` is made level; a tilt above `steep` is kept
  double sole_damping = 40;         ///< 1/s: decay rate of the velocity of a sole point in stance
  double sole_weight = 1e5;         ///< weight of the constraints of standing feet
  double friction_margin = 0.7;     ///< fraction of the friction coefficient that forces may use
  double load_cost = 1e-6;          ///< cost of a squared edge force, N^-2
  double touch = 1e-3;              ///< m: only contact points closer to the ground than this bear load
  double lifting = 0.15;      ///< m/s: no load on a point that, in the reference, rises this much faster than the foot's slowest point
  double lifted = 0.01;       ///< m: no load on a rising point that, in the reference, is this much higher than the foot's lowest point
  double anchor_time = 0.04;  ///< s: time constant with which the anchor follows the foot
  double heading_time = 0.2;  ///< s: time constant of the anchor's heading; 0: the heading is not anchored
  double shift_growth = 2;    ///< 1/s: assumed growth rate of the DCM error until touch-down; without ankle torques the rate is w0
  double max_transfer = 0.3;  ///< s: maximum duration of the double support in the calculation of how far the next foothold is shifted
  double shift_time = 0.03;   ///< s: time constant with which the shift of the next foothold is updated
  double max_shift = 0.8;     ///< m: maximum shift of the next foothold from its place in the reference
  double hurry = 1, hurry_from = 0.15,
         max_hurry = 1.4;        ///< 1/m, m, factor: rate of time in a swing = 1 + hurry (shift - hurry_from), between 1 and max_hurry
  double clearance = 0.01;       ///< m: added to the height of a swing foot in the middle of the swing
  double aim_depth = 0.01;       ///< m: a swing foot aims this far below the floor at the end of the swing
  double press_speed = 0.8;      ///< m/s: downward speed of a foot that lands later than in the reference
  double step_time = 0.27;       ///< s: duration of a reaction step
  double step_delay = 0.04;      ///< s: time for which the DCM must be outside the support before a reaction step
  double step_margin = 0.3;      ///< s: a reaction step starts if the DCM leaves the support by over step_margin * reference speed
  double step_error = 0.06;      ///< m: minimum error of the DCM for a reaction step
  double step_clearance = 0.05;  ///< m: height of a reaction step
  double separation = 0.14;      ///< m: minimum lateral distance of the feet after a reaction step
  double early = 0.6;            ///< fraction of the swing after which a touching foot stands
  double early_rate = 1.6, late_rate = 1;  ///< rate of the reference's time after an early touch-down, and while a touch-down is late
  int limit_rounds = 2;  ///< maximum number of further solutions; each adds the limits that the previous solution exceeds as constraints
  Vec3 gravity{0, 0, -9.81};  ///< m/s^2, world
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
  };
  std::uint64_t started = 0;
  double time = 0;                   ///< s: time of the reference
  double rate = 1;                   ///< seconds of the reference per second
  double clock = 0;                  ///< s: time since the controller started
  double trouble = 0;                ///< s: time for which the DCM has been outside the support
  double x = 0, y = 0, heading = 0;  ///< m, rad: displacement of the reference by the anchor
  FootState feet[max_feet];
  double multipliers[6] = {0, 0, 0, 0, 0, 0};  ///< multipliers from which the quadratic program starts
};

/// Input of one tick. All spans refer to the caller's memory.
struct BalanceInput {
  std::span<const double> q, v;                       ///< present state [nq], [nv]
  std::span<const collision::ContactPoint> contacts;  ///< result of collision analysis at the present state
  int system = 0;                                     ///< index of this character in ContactPoint::system_a
  double dt = 0.002;                                  ///< s
};

/// Output of one tick.
struct BalanceOutput {
  Vec3 dcm_error;       ///< m, world: DCM minus its reference
  int iterations = 0;   ///< Newton steps of the quadratic program
  double residual = 0;  ///< N | N m: error of the equations of motion
  int limits = 0;       ///< number of torque limits that the planned torques reach
  bool solved = true;   ///< true: the quadratic program converged
};

/// Controller of one character; see the steps at the top of this file.
class BalanceControl {
 public:
  /// @param reference motion of this mechanism; the controller keeps the pointer
  BalanceControl(MechanismPtr mechanism, std::shared_ptr<const ReferenceMotion> reference, const BalanceOptions& options, double floor = 0);
  /// Computes the drive torques of one tick. @param tau [nv, out] N | N m, zero for the root
  BalanceOutput step(const BalanceInput& input, BalanceState& state, std::span<double> tau);

  /// [nq] reference of the last tick, displaced by the anchor.
  [[nodiscard]] std::span<const double> reference() const { return q_ref_; }
  /// [nv] accelerations that the quadratic program found in the last tick.
  [[nodiscard]] std::span<const double> wanted() const { return wanted_; }
  [[nodiscard]] const FootSchedule& schedule() const { return schedule_; }
  [[nodiscard]] std::span<const Foot> feet() const { return feet_; }
  [[nodiscard]] const BalanceOptions& options() const { return options_; }

 private:
  /// A contact point that bears load.
  struct Bearing {
    int foot, link;
    Vec3 p, n;  // m, world: position; unit, world: normal
    double friction;
    double height, rise;  // m, m/s: height and upward speed of this material point in the reference
  };
  void sample_reference(const BalanceState& state);
  void find_bearing(const BalanceInput& in, const BalanceState& state);
  void update_phase(const BalanceInput& in, BalanceState& state);
  void update_anchor(const BalanceInput& in, BalanceState& state);
  void add_turn_task(int link, const Mat3& R_ref, double frequency, double weight);
  [[nodiscard]] Mat3 levelled(std::size_t foot) const;
  void add_swing_task(std::size_t foot, const BalanceState& state);
  void add_standing_foot(std::size_t foot);
  void update_reactions(const BalanceInput& in, BalanceState& state, double w0);
  /// Computes the distance of p from the edge of the support: the convex hull, in the horizontal plane, of the contact points of a foot
  /// (-1: of all standing feet). @param closest [out] closest point of the hull @return m: signed distance, positive inside
  double distance_to_support(int foot, const BalanceInput& in, const BalanceState& state, const Vec3& p, Vec3& closest);
  void lift(std::size_t foot, BalanceState& state);
  /// Sets wanted_, and tau to the torques of the program's solution. @param edge function (load) -> direction of its force
  template <class Edge>
  void find_torques(const BalanceInput& in, const Edge& edge, std::span<double> tau);
  void add_point_rows(int link, const Vec3& p, const Vec3& target, double weight, std::span<const Vec3> directions);

  MechanismPtr mechanism_;
  std::shared_ptr<const ReferenceMotion> motion_;
  BalanceOptions options_;
  std::vector<Foot> feet_;
  FootSchedule schedule_;
  double floor_ = 0, weight_ = 0;
  int chest_ = -1;
  dynamics::Workspace ws_, ref_;
  QuadraticProgram program_;
  std::vector<double> q_ref_, v_ref_, a_ref_, wanted_, bias_, displacement_, error_;
  std::vector<unsigned char> is_leg_;  // [nv]
  std::vector<Vec6> A_G_, columns_;
  std::vector<Bearing> bearing_;
  std::vector<int> touching_;  // [feet] number of contacts
  std::vector<int> limited_;   // DOFs whose torque limit is a balance (inequality) of the program
  std::vector<Vec3> hull_;     // scratch
  std::vector<int> part_of_;   // [links] index of the foot that contains the link; -1: none
  std::size_t left_foot_ = 0;
  Mat3 rest_pelvis_;  // orientation of the root link in the neutral position
  dynamics::Centroidal now_, want_;
  Vec3 anchor_rate_;        // m/s: velocity of the anchor in double support
  double anchor_rest_ = 0;  // s: remaining time of the double support
  Vec6 want_rate_;          // rate of change of the reference's centroidal momentum
};

}  // namespace ugoki::control
