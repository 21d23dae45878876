#pragma once
// The character and its reference motion, as all stages of balance control see them.

#include <memory>
#include <vector>

#include "ugoki/control/balance_types.h"
#include "ugoki/control/feasible_centre.h"
#include "ugoki/control/foot_schedule.h"
#include "ugoki/control/ground_map.h"
#include "ugoki/dynamics/centroidal.h"
#include "ugoki/dynamics/dynamics.h"
#include "ugoki/spatial/heading.h"

namespace ugoki::control {

/// Smooth step from 0 to 1 and its first two derivatives.
struct SmoothStep {
  double value = 0, rate = 0, acceleration = 0;
};
/// Quintic smooth step at x; constant below 0 and above 1.
[[nodiscard]] SmoothStep smooth_step(double x);

/// Horizontal part of a vector.
[[nodiscard]] inline Vec3 horizontal(const Vec3& x) { return {x.x, x.y, 0}; }

/// Data of a character that do not change, and the kinematics of the character and of its reference in the present tick.
struct BalanceModel {
  BalanceModel(MechanismPtr mechanism, std::shared_ptr<const ReferenceMotion> motion, const BalanceOptions& options, double floor,
               GroundMap ground = GroundMap());

  /// Samples the reference at state.time, displaced by the anchor of `state`, and computes its kinematics.
  void sample_reference(const BalanceState& state);
  /// Sets the masses that the character carries, and adds them to `centroid`, which must be that of `now`.
  void carry(std::span<const HeldPoint> held);
  /// kg: mass of the character and of what it carries.
  [[nodiscard]] double mass() const { return mass_; }
  /// m, world: centre of the sole of a foot.
  [[nodiscard]] Vec3 sole(std::size_t foot) const { return now.X_WB[link_of(foot)] * feet[foot].sole; }
  /// m, world: centre of the sole of a foot of the reference.
  [[nodiscard]] Vec3 reference_sole(std::size_t foot) const { return ref.X_WB[link_of(foot)] * feet[foot].sole; }
  /// m: height of the ground at p above the ground at the standing feet, if the ground continues with the same slope.
  [[nodiscard]] double ground_rise(const BalanceState& state, const Vec3& p) const {
    return state.tilt[0] * (p.x - state.ground[0]) + state.tilt[1] * (p.y - state.ground[1]);
  }
  /// m: ground that is higher or lower than this above the ground at the standing feet is no foothold.
  [[nodiscard]] double max_step(const BalanceState& state) const { return options.max_step * (want.centre.z - floor - state.z); }
  /// m, world: height of the ground at p in the map; at most max_step() below the ground at the character.
  [[nodiscard]] double map_height(const BalanceState& state, const Vec3& p) const;
  /// Unit, horizontal: heading of the pelvis.
  [[nodiscard]] Vec3 heading() const { return heading_of(now.X_WB[0].R * rest_pelvis.transposed()); }
  /// Unit, horizontal: direction to the left of the pelvis. In the neutral position, the pelvis faces x and its left is y.
  [[nodiscard]] Vec3 left() const;
  /// Flight of the reference, if no foot of the character stands either; otherwise null.
  [[nodiscard]] const Flight* flight(const BalanceState& state) const;
  /// Removes a foot from the ground: it begins a swing at its present position.
  void lift(std::size_t foot, BalanceState& state) const;

  MechanismPtr mechanism;
  std::shared_ptr<const ReferenceMotion> motion;
  BalanceOptions options;
  std::vector<Foot> feet;
  FootSchedule schedule;
  FeasibleCentre feasible;
  double floor = 0;  // m: of the reference
  GroundMap map;
  int chest = -1;                     // link; -1: none
  std::vector<unsigned char> is_leg;  // [nv]
  std::vector<int> part_of;           // [links] index of the foot that contains the link; -1: none
  std::size_t left_foot = 0;
  Mat3 rest_pelvis;  // orientation of the root link in the neutral position

  dynamics::Workspace now, ref;             // kinematics of the character and of the reference
  std::vector<double> q_ref, v_ref, a_ref;  // [nq], [nv], [nv] reference
  dynamics::Centroidal centroid, want;      // of the character and of the reference
  Vec6 want_rate;                           // rate of change of the reference's centroidal momentum
  double w0 = 0;                            // 1/s: sqrt(g / height of the centre of mass)

  /// A mass at a point of a link.
  struct Carried {
    int link;
    Vec3 point;  // m, in the frame of the link
    double mass;
  };
  std::vector<Carried> carried;

 private:
  /// Adds carried masses to the linear part of centroidal quantities. @param rate [in, out] rate of the momentum; null: not needed
  void add_carried(const dynamics::Workspace& ws, std::span<const double> acceleration, dynamics::Centroidal& c, Vec6* rate) const;
  double mass_ = 0;
  [[nodiscard]] std::size_t link_of(std::size_t foot) const { return static_cast<std::size_t>(feet[foot].link); }
};

}  // namespace ugoki::control
