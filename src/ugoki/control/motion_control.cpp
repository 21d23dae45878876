#include "ugoki/control/motion_control.h"

#include <algorithm>
#include <cmath>

#include "ugoki/base/check.h"
#include "ugoki/dynamics/centroidal.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/spatial/heading.h"

namespace ugoki::control {
namespace {

constexpr std::size_t max_supports = 64;

/// Scale of each drive's torque for LoopDrives, N m: its effort, at most that which lifts the whole mechanism.
std::vector<double> drive_strengths(const Mechanism& m, const Vec3& gravity) {
  double size = 0;
  std::vector<Pose> X(static_cast<std::size_t>(m.link_count()));
  calc_poses(m, m.neutral(), X);
  for (const Pose& pose : X) size = std::max(size, norm(pose.p - X[0].p));
  const double max_strength = std::max(1.0, m.mass() * norm(gravity) * size);
  std::vector<double> strength(static_cast<std::size_t>(m.nv()));
  for (int i = 0; i < m.nv(); ++i) strength[static_cast<std::size_t>(i)] = std::min(m.dof(i).effort, max_strength);
  return strength;
}

/// Height [m, world] of the shape's lowest point.
double lowest_point(const Shape& s, const Pose& X_WB) {
  const Pose X = X_WB * s.X_BS;
  return X.p.z - reach(s, -X.R.row(2));
}

}  // namespace

MotionControl::Scratch::Scratch(const Mechanism& m)
    : workspace(m), reference(m), reference_known(static_cast<std::size_t>(m.link_count())), problem(max_supports) {}

MotionControl::MotionControl(MechanismPtr mechanism, const ControlOptions& options)
    : mechanism_(std::move(mechanism)),
      options_(options),
      scratch_(*mechanism_),
      loop_drives_(*mechanism_, drive_strengths(*mechanism_, options.gravity)) {
  const Mechanism& m = *mechanism_;
  wanted_.resize(static_cast<std::size_t>(m.nv()));
  displacement_.resize(wanted_.size());
  bears_load_.resize(wanted_.size());
  touches_.resize(wanted_.size());
  supports_.reserve(max_supports);
  offsets_.reserve(max_supports);
  support_links_.reserve(max_supports);
  forces_.resize(max_supports);
  weight_ = m.mass() * norm(options_.gravity);
  floating_ = m.link(0).joint.type == JointType::floating;
  for (int i = floating_ ? 6 : 0; i < m.nv(); ++i)
    if (m.dof(i).effort == 0 && !loop_drives_.contains(i)) undriven_.push_back(i);
  for (int i = 0; i < m.link_count(); ++i) {
    const Joint& joint = m.link(i).joint;
    const auto dofs = std::span(joint.dofs).first(static_cast<std::size_t>(joint.nv()));
    if (std::ranges::any_of(dofs, [](const Dof& f) { return f.stiffness > 0; })) sprung_links_.push_back(i);
  }
  if (!undriven_.empty()) {
    extra_.resize(wanted_.size());
    response_.resize(wanted_.size());
    if (scratch_.workspace.chain.empty()) scratch_.workspace.make_rows(m);
  }
  std::vector<Pose> X(static_cast<std::size_t>(m.link_count()));
  calc_poses(m, m.neutral(), X);
  rest_root_ = X[0].R;
  double low = X[0].p.z, high = low;
  for (std::size_t i = 0; i < X.size(); ++i) {
    low = std::min(low, X[i].p.z);
    high = std::max(high, X[i].p.z);
    for (const Shape& s : m.links()[i].shapes) low = std::min(low, lowest_point(s, X[i]));
  }
  // For long, low characters (a snake, a crocodile), and characters whose root is their lowest link, the lever is the horizontal distance
  // of their mass from the root.
  double spread = 0;
  for (std::size_t i = 0; i < X.size(); ++i) {
    const double mass = m.links()[i].inertia.mass;
    const Vec3 d = mass > 0 ? X[i] * m.links()[i].inertia.centre() - X[0].p : Vec3{};
    spread += mass * (d.x * d.x + d.y * d.y);
  }
  const double size = std::max({X[0].p.z - low, 0.5 * (high - low), m.mass() > 0 ? std::sqrt(spread / m.mass()) : 0.0});
  lever_ = std::max(0.1, size);
  scale_to_size(size);
}

void MotionControl::scale_to_size(double size) {
  constexpr double person = 0.8, smallest = 0.02;  // m: the options hold for a small adult and for larger characters
  const double length = std::clamp(size / person, smallest / person, 1.0), time = std::sqrt(length), speed = time;
  ControlOptions& o = options_;
  o.joint_frequency /= time;
  o.root_frequency /= time;
  o.joint_hold *= time / length;  // muscles of small animals are stronger in relation to their weight (Hill 1950)
  for (double* t : {&o.patience, &o.shift_time, &o.return_time}) *t *= time;
  o.planted_height *= length;
  for (double* v : {&o.planted_speed, &o.lifting_speed, &o.sliding_speed, &o.slip_speed, &o.sliding_limit}) *v *= speed;
}

void MotionControl::predict_undriven(const ControlInput& in, std::span<double> tau, dynamics::Workspace& ws) {
  // A very large inertia holds the driven joints at their wanted accelerations while M is solved for the change of the others.
  constexpr double held = 1e9;  // multiple of a joint's inertia
  dynamics::calc_inertia_rows(*mechanism_, ws);
  for (std::size_t i = 0; i < extra_.size(); ++i) {
    extra_[i] = held * std::max(ws.M[static_cast<std::size_t>(ws.row_start[i + 1] - 1)], 1e-6);
    response_[i] = 0;
  }
  for (const int k : undriven_) {
    const auto i = static_cast<std::size_t>(k);
    const Dof& f = ws.dofs[i];
    const double next_v = in.v[i] + in.dt * wanted_[i], spring = f.stiffness > 0 ? f.stiffness : 0;
    extra_[i] = in.dt * (f.damping + in.dt * spring);
    response_[i] = -tau[i] - f.damping * next_v - spring * (displacement_[i] + in.dt * next_v - f.rest);
  }
  if (dynamics::factor(ws, extra_) >= 0) return;  // a joint without inertia: keep the wanted accelerations
  dynamics::solve(ws, response_);
  for (const int k : undriven_) wanted_[static_cast<std::size_t>(k)] += response_[static_cast<std::size_t>(k)];
  dynamics::calc_inverse_dynamics(*mechanism_, ws, wanted_, options_.gravity, {}, tau);
}

void MotionControl::find_supports(const ControlInput& in, const Vec3& shift) {
  Scratch& scratch = scratch_;
  const Mechanism& m = *mechanism_;
  const dynamics::Workspace& ws = scratch.workspace;
  dynamics::Workspace& reference = scratch.reference;
  supports_.clear();
  support_links_.clear();
  for (unsigned char& b : bears_load_) b = 0;
  for (unsigned char& b : touches_) b = 0;
  if (!floating_) return;
  std::ranges::fill(scratch.reference_known, char{0});
  offsets_.clear();
  const Vec3 heading = heading_of(ws.X_WB[0].R * rest_root_.transposed());
  for (const collision::ContactPoint& c : in.contacts) {
    if (c.system_a != in.system || c.system_b >= 0 || supports_.size() == max_supports) continue;
    const double approach = dot(c.n, dynamics::point_velocity(ws, c.link_a, c.p));
    if (c.distance > options_.contact_margin && c.distance + in.dt * approach > 0) continue;
    dynamics::update_path_kinematics(m, in.q_ref, in.v_ref, c.link_a, scratch.reference_known, reference);
    const auto link = static_cast<std::size_t>(c.link_a);
    const Vec3 p_ref = reference.X_WB[link] * (ws.X_WB[link].inverse() * c.p);
    const Vec3 v_ref = dynamics::point_velocity(reference, c.link_a, p_ref);
    // A character that has lost its reference stands on whatever touches the ground.
    const double height = dot(c.n, p_ref + shift - c.p), rise = (1 - lost_) * dot(c.n, v_ref);
    const double slide = (1 - lost_) * norm(v_ref - c.n * dot(c.n, v_ref));
    if (height > options_.planted_height + lost_ * lever_ || rise > options_.planted_speed || slide > options_.sliding_limit) {
      for (const int f : dynamics::chain_of_link(ws, c.link_a)) touches_[static_cast<std::size_t>(f)] = 1;
      continue;
    }
    // Load on a point that is about to lift (a heel) or that slides is costly, so that other points (the toes) carry it.
    const double lift = std::max(0.0, rise) / options_.lifting_speed,
                 slip = std::max(0.0, slide - options_.sliding_speed) / options_.slip_speed;
    const double cost = 1 + lift * lift + slip * slip;
    supports_.push_back({c.p, c.n, 0.7 * c.friction, cost * cost, heading});  // 0.7: margin to the edge of the friction cone
    support_links_.push_back(c.link_a);
    offsets_.push_back(c.p - p_ref);
    for (const int f : dynamics::chain_of_link(ws, c.link_a)) bears_load_[static_cast<std::size_t>(f)] = 1;
  }
}

double MotionControl::apply_free_fall(const Vec3& ahead, Vec6& missing, Vec3& gravity, std::span<double> tau, dynamics::Workspace& ws) {
  if (options_.assist_limit >= 1 || !(weight_ > 0)) return 0;  // free fall is not needed, because the assist can carry the whole weight
  const double depth = std::clamp(-ahead.z / (options_.flight_depth * lever_), 0.0, 1.0);
  const double up = missing.v.z > 0 ? missing.v.z * (1 - depth * depth) : missing.v.z;  // the assist must not pull the character down
  const double share = std::min(1.0, std::fabs(up) / weight_);
  if (share < 1e-3) return 0;
  const Vec3 given_up{share * missing.v.x, share * missing.v.y, up};
  const Vec6 before = ws.F[0];
  gravity += given_up / mechanism_->mass();
  dynamics::calc_inverse_dynamics(*mechanism_, ws, wanted_, gravity, {}, tau);
  missing += ws.F[0] - before;
  return share;
}

void MotionControl::give_up(const Vec6& lack, const Vec3& gravity, std::span<double> tau, dynamics::Workspace& ws) {
  const dynamics::Centroidal body = dynamics::calc_centroidal(*mechanism_, ws);
  const Vec3 arm = body.centre - ws.p0;
  const Vec3 angular = inverse(body.inertia.matrix()) * (lack.w - cross(arm, lack.v));
  const Vec3 linear = lack.v / body.mass - cross(angular, arm);
  for (std::size_t k = 0; k < 3; ++k) {
    wanted_[k] -= dot(ws.S[k].w, angular);
    wanted_[3 + k] -= dot(ws.S[3 + k].v, linear);
  }
  dynamics::calc_inverse_dynamics(*mechanism_, ws, wanted_, gravity, {}, tau);
}

double MotionControl::calc_departure(const ControlInput& in, const Vec3& ahead, const double (&shift)[3]) const {
  const Joint& root = mechanism_->link(0).joint;
  const Mat3 R = root.X_PJ.R * joint_pose(root, in.q.data()).R, R_ref = root.X_PJ.R * joint_pose(root, in.q_ref.data()).R;
  const double tilt = acos(std::clamp(dot(R.row(2), R_ref.row(2)), -1.0, 1.0));
  const double distance = norm(Vec3{ahead.x - shift[0], ahead.y - shift[1], 0});
  return std::max({-ahead.z / (options_.fall_depth * lever_), distance / (options_.fall_depth * lever_), tilt / options_.release_tilt});
}

void MotionControl::update_shift(const ControlInput& in, std::span<const Vec3> forces, const Vec3& ahead, double falling,
                                 double (&shift)[3]) const {
  Vec3 next{shift[0], shift[1], shift[2]}, weighted;
  double load = 0;
  for (std::size_t c = 0; c < supports_.size(); ++c) {  // mean offset of the supports, weighted by their loads
    const double share = dot(forces[c], supports_[c].n);
    weighted += offsets_[c] * share;
    load += share;
  }
  next += (ahead - next) * falling;
  const bool is_standing = load > 0.05 * weight_;
  if (is_standing) next += (weighted / load - next) * std::min(1.0, in.dt / options_.shift_time);
  const double decay = 1 - in.dt / options_.return_time;
  shift[0] = next.x * decay;
  shift[1] = next.y * decay;
  shift[2] = is_standing || falling > 0 ? next.z : next.z * decay;
}

ControlOutput MotionControl::step(const ControlInput& in, ControlState& state, std::span<double> tau, std::span<double> servo_gain,
                                  std::span<double> servo_velocity) {
  const Mechanism& m = *mechanism_;
  dynamics::Workspace& ws = scratch_.workspace;
  const std::size_t n = wanted_.size();
  UGOKI_CHECK(tau.size() == n && in.q_ref.size() == in.q.size() && in.v_ref.size() == n && in.a_ref.size() == n);
  ControlOutput out;
  out.released = state.released != 0;
  for (std::size_t i = 0; i < n; ++i) tau[i] = servo_gain[i] = servo_velocity[i] = 0;
  if (out.released) return out;

  // Supports: contact points that touch the ground and that are planted in the reference.
  const std::size_t root_dofs = floating_ ? 6 : 0;
  dynamics::update_kinematics(m, in.q, in.v, in.known, ws);
  const Vec3 from_reference = floating_ ? Vec3{in.q[0] - in.q_ref[0], in.q[1] - in.q_ref[1], in.q[2] - in.q_ref[2]} : Vec3{};
  lost_ =
      floating_ ? std::clamp((calc_departure(in, from_reference, state.shift) - options_.lost_from) / options_.lost_range, 0.0, 1.0) : 0;
  find_supports(in, {state.shift[0], state.shift[1], state.shift[2]});

  // 1. Wanted accelerations, from the errors predicted for the end of the step (stable PD). The root and the joints between root and
  // supports share one gain: feet on the ground couple these DOFs, and unequal gains on coupled DOFs are unstable.
  difference(m, in.q, in.q_ref, wanted_);
  if (floating_)
    for (std::size_t k = 0; k < 3; ++k) wanted_[3 + k] += state.shift[k];
  const double joint_w = options_.joint_frequency * std::sqrt(std::max(0.0, options_.tracking));
  const double root_w = options_.root_frequency * std::sqrt(std::max(0.0, options_.balance));
  struct Gains {  // of the predicted error and of its rate
    double kp, kd;
    Gains(double w, double dt) {
      const double scale = 1 / (1 + dt * 2 * w + dt * dt * w * w);
      kp = scale * w * w;
      kd = scale * 2 * w;
    }
  };
  const Gains of_root(root_w, in.dt), of_joints(joint_w, in.dt);
  for (std::size_t i = 0; i < n; ++i) {
    const Gains& gains = i < root_dofs || bears_load_[i] ? of_root : of_joints;
    const double slip = in.v_ref[i] - in.v[i];
    wanted_[i] = in.a_ref[i] + (gains.kp * (wanted_[i] + in.dt * slip) + gains.kd * slip);
  }

  // 2. Inverse dynamics
  dynamics::calc_inverse_dynamics(m, ws, wanted_, options_.gravity, {}, tau);
  for (const int i : sprung_links_) {
    const Link& link = m.link(i);
    joint_displacement(link.joint, in.q.data() + link.q_index, displacement_.data() + link.v_index);
  }
  if (!undriven_.empty()) predict_undriven(in, tau, ws);

  // 3. Contact forces
  if (floating_) {
    const std::span<Vec3> forces(forces_.data(), supports_.size());
    out.wanted = scratch_.problem.solve(supports_, ws.p0, ws.F[0], lever_, 1e-4, forces);
    // 4. Free fall: the weight that neither the ground nor an assist below one body weight can carry
    const Vec3 ahead{in.q[0] - in.q_ref[0], in.q[1] - in.q_ref[1], in.q[2] - in.q_ref[2]};
    Vec3 gravity = options_.gravity;
    const double falling = apply_free_fall(ahead, out.wanted, gravity, tau, ws);
    // 5. Root assist
    const double wanted_size = std::sqrt(dot(out.wanted.v, out.wanted.v) + dot(out.wanted.w, out.wanted.w) / (lever_ * lever_));
    const double cap = options_.assist_limit * weight_;
    out.ratio = cap > 0 ? wanted_size / cap : wanted_size > 1e-9 * weight_ ? 1e9 : 0.0;
    out.assist = out.wanted * (out.ratio > 1 ? 1 / out.ratio : 1.0);
    if (out.ratio > 1) give_up(out.wanted - out.assist, gravity, tau, ws);
    for (std::size_t c = 0; c < supports_.size(); ++c) {
      Vec6 wrench{cross(supports_[c].p - ws.p0, forces[c]), forces[c]};
      for (; c + 1 < supports_.size() && support_links_[c + 1] == support_links_[c]; ++c)
        wrench += Vec6{cross(supports_[c + 1].p - ws.p0, forces[c + 1]), forces[c + 1]};
      for (const int f : dynamics::chain_of_link(ws, support_links_[c]))
        tau[static_cast<std::size_t>(f)] -= dot(ws.S[static_cast<std::size_t>(f)], wrench);
    }
    update_shift(in, forces, ahead, falling, state.shift);
    state.departure += in.dt / options_.patience * (calc_departure(in, ahead, state.shift) - state.departure);
    if (state.departure > 1) {
      state.released = 1;
      out.released = true;
      out.assist = {};
      for (double& t : tau) t = 0;
      return out;
    }
    out.size_bw = std::min(wanted_size, cap) / weight_;
    for (std::size_t i = 0; i < root_dofs; ++i) tau[i] = 0;
  }

  // The stepper applies the joints' springs and dampers; the drive adds the difference to the wanted torque, within its effort limit.
  for (std::size_t i = root_dofs; i < n; ++i) {
    const Dof& f = ws.dofs[i];
    const double next_v = in.v[i] + in.dt * wanted_[i];
    tau[i] += f.damping * next_v;
    if (f.stiffness > 0) tau[i] += f.stiffness * (displacement_[i] + in.dt * next_v - f.rest);
  }
  if (!loop_drives_.empty()) loop_drives_.distribute(m, ws, in.q, in.v, tau);
  for (std::size_t i = root_dofs; i < n; ++i) {
    const Dof& f = ws.dofs[i];
    tau[i] = std::clamp(tau[i], -f.effort, f.effort);
    servo_velocity[i] = in.v[i] + in.dt * wanted_[i];
    const double strength = std::min(f.effort, weight_ * lever_);
    const double hold = bears_load_[i] ? 1 : touches_[i] ? 1 - lost_ : 0;
    servo_gain[i] = hold > 0 && weight_ > 0 ? hold * options_.joint_hold * strength * strength / (weight_ * lever_) : 0;
  }
  return out;
}

}  // namespace ugoki::control
