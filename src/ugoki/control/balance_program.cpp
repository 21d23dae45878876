#include "ugoki/control/balance_program.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "ugoki/dynamics/jacobian.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/spatial/heading.h"

namespace ugoki::control {
namespace {

constexpr std::size_t max_limits = 24;
constexpr double sliding = 0.03;  // m/s: a point that slides faster has its full friction, opposite to its motion

std::size_t at(int i) { return static_cast<std::size_t>(i); }

}  // namespace

BalanceProgram::BalanceProgram(const BalanceModel& model) : legs_(model), tasks_(model) {
  const std::size_t nv = model.v_ref.size();
  for (std::vector<double>* v : {&accelerations_, &bias_, &displacement_}) v->resize(nv);
  constexpr std::size_t max_loads = 4 * GroundSupport::max_bearing + 12 * BalanceInput::max_held;
  loads_.reserve(max_loads);
  limited_.reserve(max_limits);
  stopped_.reserve(max_limits);
  program_.reserve(static_cast<int>(nv), static_cast<int>(max_loads), BalanceTasks::max_equations(model),
                   6 + 2 * static_cast<int>(max_limits));
}

double BalanceProgram::load_on(const BalanceModel& model, std::size_t i, std::size_t k) const {
  const Vec6& S = model.now.S[i];
  return dot(S.w, loads_[k].moment + cross(loads_[k].p - model.now.p0, loads_[k].force)) + dot(S.v, loads_[k].force);
}

void BalanceProgram::collect_loads(const BalanceModel& model, const GroundSupport& support, const BalanceInput& in) {
  loads_.clear();
  int point = 0;
  const Vec3 heading = model.heading();
  for (const BearingPoint& b : support.bearing()) {
    const auto add = [&](const Vec3& force) { loads_.push_back({b.link, point, b.p, force}); };
    ++point;
    const Vec3 t1 = perpendicular_along(b.n, heading), t2 = cross(b.n, t1);
    const double slide = norm(b.slide);
    if (slide > sliding) {  // friction opposes the sliding; the force is inside a narrow pyramid around this direction
      const Vec3 back = b.slide * (-b.friction / slide), side = cross(b.n, back) * 0.1;
      for (const Vec3& t : {back + side, back - side, back, back * 0.9}) add(b.n + t);
      continue;
    }
    const double mu = model.options.friction_margin * b.friction;
    for (const Vec3& t : {t1 * mu, t1 * -mu, t2 * mu, t2 * -mu}) add(b.n + t);
  }
  // A grip pulls and pushes in all directions. Loads cannot be negative, so each direction has two.
  for (const HeldPoint& h : in.held) {
    if (!h.fixed) continue;
    ++point;
    for (const double sign : {1.0, -1.0})
      for (int k = 0; k < 3; ++k) {
        Vec3 e;
        e[k] = sign;
        loads_.push_back({h.link, point, h.p, e});
        if (h.rigid) loads_.push_back({h.link, point, h.p, {}, e});
      }
  }
}

void BalanceProgram::add_root_equations(BalanceModel& model) {
  const dynamics::Workspace& ws = model.now;
  for (std::size_t r = 0; r < 6; ++r) {
    const QuadraticProgram::Balance row = program_.add_balance(-bias_[r], -bias_[r], 0);
    for (std::size_t i = 0; i < bias_.size(); ++i) {
      if (i >= 6)
        row.c[i] = ws.M[at(ws.row_start[i]) + r];
      else
        row.c[i] = i >= r ? ws.M[at(ws.row_start[i]) + r] : ws.M[at(ws.row_start[r]) + i];
    }
    for (std::size_t k = 0; k < row.g.size(); ++k) row.g[k] = -load_on(model, r, k);
  }
}

std::size_t BalanceProgram::add_torque_limits(const BalanceModel& model, const BalanceInput& in, std::span<const double> tau) {
  const dynamics::Workspace& ws = model.now;
  const std::size_t known = limited_.size();
  for (std::size_t i = 6; i < tau.size() && limited_.size() < max_limits; ++i) {
    const Dof& d = ws.dofs[i];
    if (std::fabs(tau[i]) <= d.effort * (1 + 1e-6) || std::ranges::find(limited_, static_cast<int>(i)) != limited_.end()) continue;
    limited_.push_back(static_cast<int>(i));
    const double passive = d.damping * in.v[i] + (d.stiffness > 0 ? d.stiffness * (displacement_[i] + in.dt * in.v[i] - d.rest) : 0.0);
    const QuadraticProgram::Balance row = program_.add_balance(-d.effort - bias_[i] - passive, d.effort - bias_[i] - passive, 1e-4);
    for (std::size_t j = 0; j < tau.size(); ++j) {
      const std::size_t low = ws.depth[i] <= ws.depth[j] ? i : j, high = low == i ? j : i;
      const auto entry = at(ws.row_start[high] + ws.depth[low]);
      if (ws.chain[entry] == static_cast<int>(low)) row.c[j] = ws.M[entry];
    }
    row.c[i] += in.dt * d.damping + in.dt * in.dt * std::max(0.0, d.stiffness);
    for (std::size_t k = 0; k < row.g.size(); ++k) {
      const std::span<const int> chain = dynamics::chain_of_link(ws, loads_[k].link);
      if (std::ranges::find(chain, static_cast<int>(i)) != chain.end()) row.g[k] = -load_on(model, i, k);
    }
  }
  return limited_.size() - known;
}

std::size_t BalanceProgram::add_joint_limits(const BalanceModel& model, const BalanceInput& in) {
  // A joint at position x with velocity v and acceleration a is at x + v T + a T^2 / 2 after the time T.
  constexpr double max_braking = 1000;  // rad/s^2 | m/s^2: a joint beyond its limit is not thrown back
  const double T = model.options.limit_time, infinity = std::numeric_limits<double>::infinity();
  const std::size_t known = stopped_.size();
  for (std::size_t i = 6; i < accelerations_.size() && stopped_.size() < max_limits; ++i) {
    const Dof& d = model.now.dofs[i];
    const double ahead = displacement_[i] + in.v[i] * T;
    const double upper = std::max(2 * (d.upper - ahead) / (T * T), -max_braking);
    const double lower = std::min(2 * (d.lower - ahead) / (T * T), max_braking);
    const bool above = accelerations_[i] > upper + 1e-3, below = accelerations_[i] < lower - 1e-3;
    if ((!above && !below) || std::ranges::find(stopped_, static_cast<int>(i)) != stopped_.end()) continue;
    stopped_.push_back(static_cast<int>(i));
    program_.add_balance(below ? lower : -infinity, above ? upper : infinity, 1e-4).c[i] = 1;
  }
  return stopped_.size() - known;
}

void BalanceProgram::add_carried(BalanceModel& model) {
  dynamics::Workspace& ws = model.now;
  for (const BalanceModel::Carried& load : model.carried) {
    const Vec3 p = ws.X_WB[at(load.link)] * load.point;
    const Vec3 bias = dynamics::calc_jacobian_bias(*model.mechanism, ws, load.link, dynamics::JacobianFrame::world, p).v;
    const std::span<const int> chain = dynamics::chain_of_link(ws, load.link);
    const auto column = [&](int i) { return ws.S[at(i)].v + cross(ws.S[at(i)].w, p - ws.p0); };
    for (const int i : chain) {
      const Vec3 J = column(i) * load.mass;
      bias_[at(i)] += dot(J, bias - model.options.gravity);
      for (const int j : chain)
        if (j <= i) ws.M[at(ws.row_start[at(i)] + ws.depth[at(j)])] += dot(J, column(j));
    }
  }
}

void BalanceProgram::find_torques(BalanceModel& model, const BalanceInput& in, std::span<double> tau) {
  std::ranges::copy(program_.x(), accelerations_.begin());
  dynamics::calc_inverse_dynamics(*model.mechanism, model.now, accelerations_, model.options.gravity, {}, tau);
  for (const BalanceModel::Carried& load : model.carried) {
    const Vec3 p = model.now.X_WB[at(load.link)] * load.point;
    Vec3 a = dynamics::calc_jacobian_bias(*model.mechanism, model.now, load.link, dynamics::JacobianFrame::world, p).v;
    const std::span<const int> chain = dynamics::chain_of_link(model.now, load.link);
    const auto column = [&](int i) { return model.now.S[at(i)].v + cross(model.now.S[at(i)].w, p - model.now.p0); };
    for (const int i : chain) a += column(i) * accelerations_[at(i)];
    for (const int i : chain) tau[at(i)] += load.mass * dot(column(i), a - model.options.gravity);
  }
  for (std::size_t k = 0; k < loads_.size();) {
    const Load& first = loads_[k];
    Vec3 force, couple;
    for (; k < loads_.size() && loads_[k].point == first.point; ++k) {
      force += loads_[k].force * program_.loads()[k];
      couple += loads_[k].moment * program_.loads()[k];
    }
    const Vec3 moment = couple + cross(first.p - model.now.p0, force);
    for (const int i : dynamics::chain_of_link(model.now, first.link))
      tau[at(i)] -= dot(model.now.S[at(i)].w, moment) + dot(model.now.S[at(i)].v, force);
  }
  for (std::size_t i = 6; i < accelerations_.size(); ++i) {  // compensate the joints' dampers and springs, which the stepper applies
    const Dof& d = model.now.dofs[i];
    const double next = in.v[i] + in.dt * accelerations_[i];
    tau[i] += d.damping * next;
    if (d.stiffness > 0) tau[i] += d.stiffness * (displacement_[i] + in.dt * next - d.rest);
  }
}

void BalanceProgram::solve(BalanceModel& model, const GroundSupport& support, const BalanceInput& in, const Vec3& acceleration,
                           const ReleasePlan& release, BalanceState& state, std::span<double> tau, BalanceOutput& out) {
  const Mechanism& m = *model.mechanism;
  collect_loads(model, support, in);
  program_.begin(m.nv(), static_cast<int>(loads_.size()), model.options.load_cost);
  legs_.update(model, state);
  tasks_.add_posture(model, legs_, in, state, program_);
  const auto hang = static_cast<HangMode>(state.hang);
  if (hang != HangMode::hangs && hang != HangMode::drops) tasks_.add_momentum(model, acceleration, program_);
  if (release.rest > 0) tasks_.add_release(model, release, program_);
  tasks_.add_links(model, support, in, state, program_);
  dynamics::calc_inverse_dynamics(m, model.now, {}, model.options.gravity, {}, bias_);
  dynamics::calc_inertia_rows(m, model.now);
  add_carried(model);
  add_root_equations(model);
  out.solved = program_.solve(state.multipliers);
  out.iterations = program_.iterations();
  for (std::size_t r = 0; r < 6; ++r) state.multipliers[r] = program_.balance_multipliers()[r];
  for (const Link& link : m.links()) joint_displacement(link.joint, in.q.data() + link.q_index, displacement_.data() + link.v_index);
  find_torques(model, in, tau);
  // Add only those limits that the solution exceeds. They are few, so the other limits add no cost.
  limited_.clear();
  stopped_.clear();
  for (int round = 0; round < model.options.limit_rounds; ++round) {
    if (add_joint_limits(model, in) + add_torque_limits(model, in, tau) == 0) break;
    out.solved = program_.solve();
    out.iterations += program_.iterations();
    find_torques(model, in, tau);
  }
  out.limits = static_cast<int>(limited_.size());
  out.joint_limits = static_cast<int>(stopped_.size());
  out.residual = program_.residual();
  for (std::size_t i = 0; i < 6; ++i) tau[i] = 0;
  for (std::size_t i = 6; i < tau.size(); ++i) {
    const Dof& d = model.now.dofs[i];
    tau[i] = std::clamp(tau[i], -d.effort, d.effort);
  }
}

}  // namespace ugoki::control
