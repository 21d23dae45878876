#pragma once
// Balance control: a character follows a reference motion on its own feet without an external force, and makes steps to keep its balance.
//
// Each tick:
//   1. Phase (foot_phase.h). The controller advances the time of the reference: at rate 1, and faster after a foot has landed early. A foot
//      lifts when its counterpart in the reference lifts, and stands when it touches the ground. A foot that lands late is pressed down.
//      In a flight, the time of the reference runs so that reference and character land together.
//   2. Anchor (reference_anchor.h) and ground (ground_plan.h). The reference is displaced so that its standing feet coincide with the real
//      ones. No force draws the character back to the original path of the reference. The heights of the body and of the footholds
//      follow a map of the ground.
//   3. Centre of mass. With the error e of the centre of mass from the anchored reference, w0 = sqrt(g / height) and a gain k:
//        c'' = c''_ref - w0 k e - (w0 + k) e'     in the horizontal plane
//      This is the control law p = p_ref + (1 + k / w0) (xi - xi_ref) of the divergent component of motion (DCM) xi = c + c' / w0.
//   4. Swing feet. A foot begins its swing where it left the ground and lands at the reference plus a shift. The shift is the error of the
//      DCM that is predicted for the touch-down, so that the character steps in the direction of a push.
//   5. Reaction steps. If the DCM leaves the support while the reference stands, a foot steps to the position that the DCM will have at
//      the landing. The DCM of a pendulum on a point p moves by xi(T) = p + (xi - p) exp(w0 T). Several steps may follow each other. The
//      feet stay where they have landed until the reference makes its next steps.
//      On uneven ground, the wanted posture of the standing legs is adapted to the ground (leg_posture.h).
//      While grips carry the character, and when it has released them, other goals apply (hang_plan.h).
//   6. A quadratic program (balance_program.h) finds accelerations, contact forces and torques. Only the ground and grips act on the root.
//      Standing soles are constraints, and drives and joints stay within their limits. A foot turns on the ground if its counterpart in
//      the reference turns.
//
// Sources: Kajita et al. (2003), Englsberger et al. (2015), DCM; Khadiv et al. (2016), step adaptation; Lee, Kim, Lee (2010), correction of
// measured motions that grows with the phase; Abe, da Silva, Popovic (2007), de Lasa et al. (2010), whole-body quadratic programs.

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "ugoki/control/balance_model.h"
#include "ugoki/control/balance_program.h"
#include "ugoki/control/balance_types.h"
#include "ugoki/control/foot_schedule.h"
#include "ugoki/control/ground_plan.h"
#include "ugoki/control/ground_support.h"
#include "ugoki/control/hang_plan.h"
#include "ugoki/control/reference_anchor.h"
#include "ugoki/control/step_planner.h"

namespace ugoki::control {

/// Controller of one character; see the steps at the top of this file.
class BalanceControl {
 public:
  /// @param reference motion of this mechanism; the controller keeps the pointer
  /// @param floor m: height of the floor on which the reference was recorded
  /// @param ground the ground on which the character walks; nothing: the level floor
  BalanceControl(MechanismPtr mechanism, std::shared_ptr<const ReferenceMotion> reference, const BalanceOptions& options, double floor = 0,
                 std::optional<GroundMap> ground = std::nullopt);
  /// Computes the drive torques of one tick. @param tau [nv, out] N | N m, zero for the root
  BalanceOutput step(const BalanceInput& input, BalanceState& state, std::span<double> tau);

  /// Replaces the ground on which the character walks. The schedule of the feet stays.
  void set_ground(GroundMap ground) { model_.map = std::move(ground); }

  /// [nq] reference of the last tick, displaced by the anchor.
  [[nodiscard]] std::span<const double> reference() const { return model_.q_ref; }
  /// [nv] accelerations that the quadratic program found in the last tick.
  [[nodiscard]] std::span<const double> wanted() const { return program_.accelerations(); }
  [[nodiscard]] const FootSchedule& schedule() const { return model_.schedule; }
  [[nodiscard]] std::span<const Foot> feet() const { return model_.feet; }
  [[nodiscard]] const BalanceOptions& options() const { return model_.options; }
  /// Kinematics of the character and of its reference in the last tick.
  [[nodiscard]] const BalanceModel& model() const { return model_; }
  /// Contacts and bearing points of the last tick.
  [[nodiscard]] const GroundSupport& support() const { return support_; }

 private:
  BalanceModel model_;
  GroundSupport support_;
  ReferenceAnchor anchor_;
  GroundPlan ground_;
  HangPlan hang_;
  StepPlanner planner_;
  BalanceProgram program_;
};

}  // namespace ugoki::control
