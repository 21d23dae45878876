#include "ugoki/control/balance_model.h"

#include <algorithm>
#include <cmath>

#include "ugoki/base/check.h"
#include "ugoki/dynamics/jacobian.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/motion/clip.h"
#include "ugoki/spatial/elementary.h"

namespace ugoki::control {
namespace {
std::size_t at(int i) { return static_cast<std::size_t>(i); }
}  // namespace

SmoothStep smooth_step(double x) {
  if (x <= 0) return {0, 0, 0};
  if (x >= 1) return {1, 0, 0};
  return {x * x * x * (10 + x * (6 * x - 15)), 30 * x * x * (1 - x) * (1 - x), 60 * x * (1 - x) * (1 - 2 * x)};
}

BalanceOptions sized_for(BalanceOptions options, double height, std::size_t feet) {
  constexpr double person = 0.8, smallest = 0.02;  // m
  const double length = std::clamp(height, smallest, person) / person, time = std::sqrt(length);
  BalanceOptions& o = options;
  for (double* rate : {&o.com_gain, &o.height_frequency, &o.trunk_frequency, &o.momentum_gain, &o.joint_frequency, &o.swing_frequency,
                       &o.sole_damping, &o.shift_growth})
    *rate /= time;
  o.pelvis_weight *= length * length;
  o.chest_weight *= length * length;
  if (feet > 2) {
    constexpr double min_share = 0.25;  // smaller machines keep to the posture of their legs as dogs do
    o.leg_weight = o.many_leg_weight * std::max(length * length, min_share);
    o.momentum_weight = o.many_momentum_weight;
    o.pelvis_weight *= o.many_trunk_weight;
    o.chest_weight *= o.many_trunk_weight;
    o.landing = o.many_landing;
    // A gallop that turns back faster follows its reference less exactly.
    o.turn_homing *= 0.5;
    o.max_turn_home *= 0.5;
  }
  return options;
}

BalanceModel::BalanceModel(MechanismPtr m, std::shared_ptr<const ReferenceMotion> reference, const BalanceOptions& settings, double level,
                           GroundMap ground)
    : mechanism(std::move(m)),
      motion(std::move(reference)),
      options(settings),
      feet(feet_of(*mechanism)),
      schedule(*mechanism, feet, *motion, level),
      feasible(*mechanism, feet, schedule, *motion, settings, level),
      floor(level),
      map(std::move(ground)),
      now(*mechanism),
      ref(*mechanism) {
  mass_ = mechanism->mass();
  carried.reserve(BalanceInput::max_held);
  UGOKI_CHECK(mechanism->link_count() > 0 && mechanism->link(0).joint.type == JointType::floating);
  UGOKI_CHECK(feet.size() <= BalanceState::max_feet);
  const auto nv = at(mechanism->nv());
  q_ref.resize(at(mechanism->nq()));
  v_ref.resize(nv);
  a_ref.resize(nv);
  is_leg.resize(nv);
  part_of.assign(at(mechanism->link_count()), -1);
  for (std::size_t f = 0; f < feet.size(); ++f) {
    for (const int d : feet[f].dofs) is_leg[at(d)] = 1;
    for (const int link : feet[f].parts) part_of[at(link)] = static_cast<int>(f);
  }
  for (int i = 0; i < mechanism->link_count(); ++i)
    if (mechanism->link(i).label == "chest") chest = i;
  std::vector<Pose> X(at(mechanism->link_count()));
  calc_poses(*mechanism, mechanism->neutral(), X);
  rest_pelvis = X[0].R;
  double sole_height = 0;
  for (std::size_t f = 0; f < feet.size(); ++f) sole_height += (X[link_of(f)] * feet[f].sole).z / static_cast<double>(feet.size());
  options = sized_for(settings, centre_of_mass(*mechanism, X).z - sole_height, feet.size());
  for (std::size_t f = 1; f < feet.size(); ++f)
    if (X[link_of(f)].p.y > X[link_of(left_foot)].p.y) left_foot = f;
}

void BalanceModel::sample_reference(const BalanceState& state) {
  const Mechanism& m = *mechanism;
  motion->sample(state.time, q_ref, v_ref, a_ref);
  displace_root(m, {state.x, state.y, state.z - state.lower, state.heading}, q_ref);
  const Joint& root = m.link(0).joint;
  const Mat3 turn = root.X_PJ.R.transposed() * rotation_about({0, 0, 1}, state.heading) * root.X_PJ.R;
  for (std::vector<double>* x : {&v_ref, &a_ref}) {
    const Vec3 linear = turn * Vec3{(*x)[3], (*x)[4], (*x)[5]};
    for (int k = 0; k < 3; ++k) (*x)[at(3 + k)] = linear[k];
  }
  for (double& v : v_ref) v *= state.rate;
  for (double& a : a_ref) a *= state.rate * state.rate;
  dynamics::update_kinematics(m, q_ref, v_ref, ref);
  // The wanted velocity of the centre of mass is the velocity at rate 1, also while the time of the reference runs faster or slower.
  want = dynamics::calc_centroidal(m, ref);
  want_rate = dynamics::calc_centroidal_momentum_rate(m, ref, a_ref);
  if (!carried.empty()) add_carried(ref, a_ref, want, &want_rate);
  want_rate = want_rate * (1 / (state.rate * state.rate));
  want.velocity = want.velocity / state.rate;
  want.momentum = want.momentum * (1 / state.rate);
  const Mat3 heading = rotation_about({0, 0, 1}, state.heading);
  const FeasibleCentre::Shift shift = feasible.at(state.time);
  want.centre += heading * shift.position;
  want.velocity += heading * shift.velocity;
  want_rate.v += heading * shift.acceleration * mass_;
}

void BalanceModel::carry(std::span<const HeldPoint> held) {
  carried.clear();
  mass_ = mechanism->mass();
  for (const HeldPoint& h : held) {
    if (h.fixed || h.mass <= 0) continue;
    carried.push_back({h.link, now.X_WB[at(h.link)].inverse() * h.p, h.mass});
    mass_ += h.mass;
  }
  if (!carried.empty()) add_carried(now, {}, centroid, nullptr);
}

void BalanceModel::add_carried(const dynamics::Workspace& ws, std::span<const double> acceleration, dynamics::Centroidal& c,
                               Vec6* rate) const {
  Vec3 centre = c.centre * c.mass, momentum = c.velocity * c.mass;
  for (const Carried& load : carried) {
    const Vec3 p = ws.X_WB[at(load.link)] * load.point;
    centre += p * load.mass;
    momentum += dynamics::point_velocity(ws, load.link, p) * load.mass;
    c.mass += load.mass;
    if (!rate) continue;
    Vec3 a = dynamics::calc_jacobian_bias(*mechanism, ws, load.link, dynamics::JacobianFrame::world, p).v;
    for (const int i : dynamics::chain_of_link(ws, load.link)) a += (ws.S[at(i)].v + cross(ws.S[at(i)].w, p - ws.p0)) * acceleration[at(i)];
    rate->v += a * load.mass;
  }
  c.centre = centre / c.mass;
  c.velocity = momentum / c.mass;
  c.momentum.v = momentum;
}

Vec3 BalanceModel::left() const { return normalized(horizontal(now.X_WB[0].R * transpose_times(rest_pelvis, Vec3{0, 1, 0})), {0, 1, 0}); }

double BalanceModel::map_height(const BalanceState& state, const Vec3& p) const {
  const double near = floor + state.z + ground_rise(state, p), step = max_step(state);
  return std::max(map.below({p.x, p.y, near + step}).height, near - step);
}

const Flight* BalanceModel::flight(const BalanceState& state) const {
  for (std::size_t f = 0; f < feet.size(); ++f)
    if (state.feet[f].stands) return nullptr;
  return schedule.flight(state.time);
}

void BalanceModel::lift(std::size_t f, BalanceState& state) const {
  BalanceState::FootState& foot = state.feet[f];
  foot.stands = foot.early = foot.reacts = 0;
  const Vec3 here = sole(f), p = here - reference_sole(f);
  foot.from[0] = here.x;
  foot.from[1] = here.y;
  foot.from[2] = map_height(state, here) + state.loose;
  for (int k = 0; k < 3; ++k) {
    foot.offset[k] = p[k];
    foot.to[k] = foot.from[k];
  }
  foot.offset[2] += floor + state.z - state.lower - foot.from[2];
  foot.raise = 0;
  for (int k = 0; k < 2; ++k) {
    foot.shift[k] = foot.place[k] = 0;
    foot.tilt[k] = state.tilt[k];
  }
  foot.bump = 0;
  foot.sharp[0] = foot.sharp[1] = 1;
}

}  // namespace ugoki::control
