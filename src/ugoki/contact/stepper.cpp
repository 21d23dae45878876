#include "ugoki/contact/stepper.h"

#include <algorithm>
#include <cmath>

#include "ugoki/base/check.h"
#include "ugoki/mechanism/state.h"

namespace ugoki::contact {

namespace {
constexpr std::uint64_t limit_key = 0x8000000000000000ULL;
}

Stepper::Stepper(std::vector<MechanismPtr> systems, const StepperOptions& options) : mechanisms_(std::move(systems)), options_(options) {
  workspaces_.reserve(mechanisms_.size());
  scratch_.resize(mechanisms_.size());
  std::size_t longest = 1;
  for (std::size_t s = 0; s < mechanisms_.size(); ++s) {
    const Mechanism& m = *mechanisms_[s];
    workspaces_.emplace_back(m);
    const auto n = static_cast<std::size_t>(m.nv());
    SystemScratch& x = scratch_[s];
    for (std::vector<double>* array : {&x.extra, &x.free_v, &x.root_D_inverse, &x.impulse, &x.displacement}) array->resize(n);
    for (int i = 0; i < m.link_count(); ++i) {
      const Joint& joint = m.link(i).joint;
      bool limited = false;
      for (int k = 0; k < joint.nv(); ++k) {
        const Freedom& f = joint.freedoms[static_cast<std::size_t>(k)];
        if (joint.type != JointType::floating) limited = limited || std::isfinite(f.lower) || std::isfinite(f.upper);
        x.springs = x.springs || f.stiffness > 0;
        if (f.friction > 0) x.rubbed.push_back(m.link(i).v_index + k);
      }
      if (limited) x.limited.push_back(i);
    }
    if (std::ranges::any_of(m.loops(), &Loop::closed)) x.loops = std::make_unique<SystemScratch::Loops>(m);
    for (const int d : workspaces_[s].depth) longest = std::max(longest, static_cast<std::size_t>(d) + 1);
  }
  point_rows_.resize(longest);
}

void Stepper::prepare(std::size_t s, const StepSystem& system, double dt, StepReport& report) {
  const Mechanism& m = *mechanisms_[s];
  dynamics::Workspace& ws = workspaces_[s];
  SystemScratch& x = scratch_[s];
  const std::size_t n = x.free_v.size();
  dynamics::update_kinematics(m, system.q, system.v, ws);
  if (x.loops) dynamics::share_virtual_inertias(x.loops->links, ws);
  dynamics::calc_inertia_rows(m, ws);
  const bool servo = !system.servo_gain.empty();
  for (std::size_t i = 0; i < n; ++i) {
    x.extra[i] = dt * (ws.freedoms[i].damping + dt * ws.freedoms[i].stiffness);
    if (servo) x.extra[i] += dt * system.servo_gain[i];
  }
  if (const int bad = dynamics::factor(ws, x.extra); bad >= 0) {
    report.status = StepStatus::singular;
    report.system = static_cast<int>(s);
    report.freedom = bad;
    return;
  }
  if (x.springs || !x.limited.empty())
    for (const Link& link : m.links()) joint_displacement(link.joint, system.q.data() + link.q_index, x.displacement.data() + link.v_index);
  dynamics::calc_inverse_dynamics(m, ws, {}, options_.gravity, system.external, x.free_v);
  for (std::size_t i = 0; i < n; ++i) {
    const Freedom& f = ws.freedoms[i];
    double passive = f.damping * system.v[i];
    if (f.stiffness > 0) passive += f.stiffness * (x.displacement[i] - f.rest + dt * system.v[i]);
    if (servo) passive += system.servo_gain[i] * (system.v[i] - system.servo_velocity[i]);
    x.free_v[i] = dt * (system.tau[i] - x.free_v[i] - passive);
  }
  dynamics::solve(ws, x.free_v);
  for (std::size_t i = 0; i < n; ++i) {
    x.free_v[i] += system.v[i];
    x.impulse[i] = 0;
    x.root_D_inverse[i] = std::sqrt(ws.D_inverse[i]);
  }
}

int Stepper::add_segment(std::size_t s, int last, int rows) {
  const int length = workspaces_[s].depth[static_cast<std::size_t>(last)] + 1;
  const int offset = static_cast<int>(data_.size());
  segments_.push_back({static_cast<int>(s), last, offset, length});
  data_.resize(data_.size() + static_cast<std::size_t>(length * rows));
  return offset;
}

void Stepper::add_contact(int index, const collision::ContactPoint& c, double dt) {
  const Vec3 n = c.n;
  const Vec3 t1 = any_perpendicular(n), t2 = cross(n, t1);
  frames_[static_cast<std::size_t>(3 * index)] = n;
  frames_[static_cast<std::size_t>(3 * index + 1)] = t1;
  frames_[static_cast<std::size_t>(3 * index + 2)] = t2;

  Block block{RowKind::contact, static_cast<int>(target_.size()), 3, static_cast<int>(segments_.size()), 0, index, c.friction, 0, c.key};
  double before = 0, free_n = 0, free_1 = 0, free_2 = 0;
  for (int side = 0; side < 2; ++side) {
    const int s = side == 0 ? c.system_a : c.system_b;
    const int link = side == 0 ? c.link_a : c.link_b;
    if (s < 0) continue;
    const dynamics::Workspace& ws = workspaces_[static_cast<std::size_t>(s)];
    const int last = ws.link_chain[static_cast<std::size_t>(link)];
    if (last < 0) continue;
    const double sign = side == 0 ? 1.0 : -1.0;
    const std::span<const int> chain = dynamics::chain_of_link(ws, link);
    dynamics::calc_point_jacobian(ws, link, c.p, point_rows_);
    const int offset = add_segment(static_cast<std::size_t>(s), last, 3);
    ++block.segments;
    const std::size_t length = chain.size();
    double* rows = data_.data() + offset;
    const std::vector<double>& free_v = scratch_[static_cast<std::size_t>(s)].free_v;
    for (std::size_t k = 0; k < length; ++k) {
      const Vec3 j = point_rows_[k] * sign;
      const double v = free_v[static_cast<std::size_t>(chain[k])];
      rows[k] = dot(n, j);
      rows[length + k] = dot(t1, j);
      rows[2 * length + k] = dot(t2, j);
      free_n += rows[k] * v;
      free_1 += rows[length + k] * v;
      free_2 += rows[2 * length + k] * v;
    }
    before += sign * dot(n, dynamics::point_velocity(ws, link, c.p));
  }
  const double gap = c.distance;
  const bool out_of_reach = gap > 1e-3 && gap + dt * std::min(free_n, before) > 1e-3;
  if (block.segments == 0 || out_of_reach) {
    if (block.segments > 0) {
      data_.resize(static_cast<std::size_t>(segments_[static_cast<std::size_t>(block.first_segment)].offset));
      segments_.resize(static_cast<std::size_t>(block.first_segment));
    }
    return;
  }
  double wanted = gap > 0 ? -gap / dt : std::min(std::max(-gap - options_.slop, 0.0) / options_.recovery_time, options_.recovery_speed);
  if (c.restitution > 0 && before < -options_.impact_speed && gap + dt * before <= 0) wanted = std::max(wanted, -c.restitution * before);
  target_.push_back(free_n - wanted);
  target_.push_back(free_1);
  target_.push_back(free_2);
  finish_rows(block);
}

void Stepper::add_joint_rows(std::size_t s, double dt) {
  const Mechanism& m = *mechanisms_[s];
  const dynamics::Workspace& ws = workspaces_[s];
  const SystemScratch& x = scratch_[s];
  const auto add_row = [&](RowKind kind, const Link& link, const double* direction, double target, double bound, std::uint64_t key) {
    const int last = link.v_index + link.joint.nv() - 1;
    Block block{kind, static_cast<int>(target_.size()), 1, static_cast<int>(segments_.size()), 1, -1, 0, bound, key};
    const int offset = add_segment(s, last, 1);
    const int above = ws.depth[static_cast<std::size_t>(last)] + 1 - link.joint.nv();
    for (int k = 0; k < above; ++k) data_[static_cast<std::size_t>(offset + k)] = 0;
    double u = 0;
    for (int k = 0; k < link.joint.nv(); ++k) {
      data_[static_cast<std::size_t>(offset + above + k)] = direction[k];
      u += direction[k] * x.free_v[static_cast<std::size_t>(link.v_index + k)];
    }
    target_.push_back(u - target);
    finish_rows(block);
  };
  for (const int i : x.limited) {
    const Link& link = m.link(i);
    const int nv = link.joint.nv();
    for (int k = 0; k < nv; ++k) {
      const Freedom& f = link.joint.freedoms[static_cast<std::size_t>(k)];
      const auto at = static_cast<std::size_t>(link.v_index + k);
      const double displacement = x.displacement[at];
      for (int side = 0; side < 2; ++side) {
        const double sign = side == 0 ? 1.0 : -1.0;
        const double room = side == 0 ? displacement - f.lower : f.upper - displacement;
        if (!(room < 0.2)) continue;
        double direction[6] = {0, 0, 0, 0, 0, 0};
        if (link.joint.type == JointType::spherical) {
          // rate of the rotation vector's component k: row k of 1 + [r]/2 + c [r]^2, the inverse of the exponential's differential
          const auto first = static_cast<std::size_t>(link.v_index);
          const Vec3 r{x.displacement[first], x.displacement[first + 1], x.displacement[first + 2]};
          const Vec3 e{k == 0 ? sign : 0.0, k == 1 ? sign : 0.0, k == 2 ? sign : 0.0};
          const double angle2 = dot(r, r), half = 0.5 * std::sqrt(angle2);
          const SinCos sc = sin_cos(half);
          const double c = angle2 > 1e-6 ? (1 - half * sc.cos / sc.sin) / angle2 : 1.0 / 12.0;
          const Vec3 row = e + cross(e, r) * 0.5 + cross(r, cross(r, e)) * c;
          direction[0] = row.x;
          direction[1] = row.y;
          direction[2] = row.z;
        } else {
          direction[k] = sign;
        }
        double rate = 0;
        for (int c = 0; c < nv; ++c) rate += direction[c] * x.free_v[static_cast<std::size_t>(link.v_index + c)];
        if (room > 0 && room + dt * rate > 0) continue;
        const double wanted = room > 0 ? -room / dt : std::min(-room / (5 * options_.recovery_time), 1.0);
        add_row(
            RowKind::limit, link, direction, wanted, 0,
            limit_key | (static_cast<std::uint64_t>(s) << 40) | (static_cast<std::uint64_t>(at) << 4) | static_cast<std::uint64_t>(side));
      }
    }
  }
  for (const int f : x.rubbed) {
    const Link& link = m.link(m.link_of_freedom(f));
    double direction[6] = {0, 0, 0, 0, 0, 0};
    direction[f - link.v_index] = 1;
    add_row(RowKind::friction, link, direction, 0, dt * ws.freedoms[static_cast<std::size_t>(f)].friction,
            limit_key | (static_cast<std::uint64_t>(s) << 40) | (static_cast<std::uint64_t>(f) << 4) | 2);
  }
}

void Stepper::finish_rows(Block& block) {
  for (int k = 0; k < block.segments; ++k) {
    const Segment& segment = segments_[static_cast<std::size_t>(block.first_segment + k)];
    const dynamics::Workspace& ws = workspaces_[static_cast<std::size_t>(segment.system)];
    const std::vector<double>& root = scratch_[static_cast<std::size_t>(segment.system)].root_D_inverse;
    const int* chain = ws.chain.data() + ws.row_start[static_cast<std::size_t>(segment.last)];
    for (int r = 0; r < block.rows; ++r) {
      const std::span<double> y(data_.data() + segment.offset + r * segment.length, static_cast<std::size_t>(segment.length));
      dynamics::apply_inverse_transposed_factor(ws, segment.last, y);
      for (int e = 0; e < segment.length; ++e) y[static_cast<std::size_t>(e)] *= root[static_cast<std::size_t>(chain[e])];
    }
  }
  blocks_.push_back(block);
}

void Stepper::build_delassus() {
  const std::size_t rows = target_.size();
  A_.resize(rows * rows);
  diagonal_.resize(rows);
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      const Block& a = blocks_[i];
      const Block& b = blocks_[j];
      double sum[3][3] = {};
      for (int sa = 0; sa < a.segments; ++sa) {
        const Segment& x = segments_[static_cast<std::size_t>(a.first_segment + sa)];
        for (int sb = 0; sb < b.segments; ++sb) {
          const Segment& y = segments_[static_cast<std::size_t>(b.first_segment + sb)];
          if (x.system != y.system) continue;
          const dynamics::Workspace& ws = workspaces_[static_cast<std::size_t>(x.system)];
          const int* cx = ws.chain.data() + ws.row_start[static_cast<std::size_t>(x.last)];
          const int* cy = ws.chain.data() + ws.row_start[static_cast<std::size_t>(y.last)];
          int common = std::min(x.length, y.length);
          while (common > 0 && cx[common - 1] != cy[common - 1]) --common;  // chains share a prefix only
          for (int ra = 0; ra < a.rows; ++ra) {
            const double* px = data_.data() + x.offset + ra * x.length;
            for (int rb = 0; rb < b.rows; ++rb) {
              const double* py = data_.data() + y.offset + rb * y.length;
              double even = 0, odd = 0;
              int e = 0;
              for (; e + 1 < common; e += 2) {
                even += px[e] * py[e];
                odd += px[e + 1] * py[e + 1];
              }
              if (e < common) even += px[e] * py[e];
              sum[ra][rb] += even + odd;
            }
          }
        }
      }
      for (int ra = 0; ra < a.rows; ++ra)
        for (int rb = 0; rb < b.rows; ++rb) {
          const auto r = static_cast<std::size_t>(a.row + ra), c = static_cast<std::size_t>(b.row + rb);
          A_[r * rows + c] = A_[c * rows + r] = sum[ra][rb];
        }
    }
  }
  for (auto r = static_cast<std::size_t>(loop_rows_); r < rows; ++r) A_[r * rows + r] *= 1 + options_.softness;
  eliminate_loops();
  for (std::size_t r = 0; r < rows; ++r) diagonal_[r] = A_[r * rows + r];
}

void Stepper::warm_start() {
  p_.assign(target_.size(), 0.0);
  std::size_t at = 0;
  for (const Block& block : blocks_) {
    if (block.kind == RowKind::loop) continue;
    for (std::size_t tried = 0; tried < warm_.size(); ++tried) {
      const Warm& w = warm_[at];
      at = at + 1 < warm_.size() ? at + 1 : 0;
      if (w.key != block.key) continue;
      for (int r = 0; r < block.rows; ++r) p_[static_cast<std::size_t>(block.row + r)] = w.p[r];
      break;
    }
  }
}

void Stepper::sweep_all(StepReport& report) {
  const std::size_t rows = target_.size();
  const auto velocity = [&](std::size_t r) {
    const double* row = A_.data() + r * rows;
    double even = target_[r], odd = 0;
    std::size_t c = 0;
    for (; c + 1 < rows; c += 2) {
      even += row[c] * p_[c];
      odd += row[c + 1] * p_[c + 1];
    }
    if (c < rows) even += row[c] * p_[c];
    return even + odd;
  };
  for (report.sweeps = 0; report.sweeps < options_.iterations;) {
    ++report.sweeps;
    double change = 0;
    for (const Block& block : blocks_) {
      if (block.kind == RowKind::loop) continue;
      const auto r = static_cast<std::size_t>(block.row);
      const double old = p_[r];
      double next = old - velocity(r) / diagonal_[r];
      next = block.kind == RowKind::friction ? std::clamp(next, -block.bound, block.bound) : std::max(0.0, next);
      p_[r] = next;
      change = std::max(change, std::fabs(next - old) * diagonal_[r]);
      if (block.kind != RowKind::contact) continue;
      const double old1 = p_[r + 1], old2 = p_[r + 2];
      const double stiff = std::max(diagonal_[r + 1], diagonal_[r + 2]);
      const double u1 = velocity(r + 1), u2 = velocity(r + 2);
      double p1 = old1 - u1 / stiff, p2 = old2 - u2 / stiff;
      const double cone = block.mu * next, size = std::sqrt(p1 * p1 + p2 * p2);
      if (size > cone) {
        const double scale = size > 0 ? cone / size : 0;
        p1 *= scale;
        p2 *= scale;
      }
      p_[r + 1] = p1;
      p_[r + 2] = p2;
      change = std::max(change, std::max(std::fabs(p1 - old1), std::fabs(p2 - old2)) * stiff);
    }
    report.residual = change;
    if (change < options_.tolerance) break;
  }
}

void Stepper::apply_impulses() {
  for (const Block& block : blocks_) {
    for (int k = 0; k < block.segments; ++k) {
      const Segment& segment = segments_[static_cast<std::size_t>(block.first_segment + k)];
      const dynamics::Workspace& ws = workspaces_[static_cast<std::size_t>(segment.system)];
      SystemScratch& x = scratch_[static_cast<std::size_t>(segment.system)];
      const int* chain = ws.chain.data() + ws.row_start[static_cast<std::size_t>(segment.last)];
      for (int r = 0; r < block.rows; ++r) {
        const double p = p_[static_cast<std::size_t>(block.row + r)];
        if (p == 0) continue;
        const double* y = data_.data() + segment.offset + r * segment.length;
        for (int e = 0; e < segment.length; ++e) x.impulse[static_cast<std::size_t>(chain[e])] += p * y[e];
      }
    }
  }
  for (std::size_t s = 0; s < scratch_.size(); ++s) {
    const dynamics::Workspace& ws = workspaces_[s];
    SystemScratch& x = scratch_[s];
    // v' = v_free + L^-1 D^-1/2 (sum of scaled rows times impulses)
    for (std::size_t k = 0; k < x.impulse.size(); ++k) {
      const double* row = ws.L.data() + ws.row_start[k];
      const int* chain = ws.chain.data() + ws.row_start[k];
      double sum = x.impulse[k] * x.root_D_inverse[k];
      for (int d = 0; d < ws.depth[k]; ++d) sum -= row[d] * x.impulse[static_cast<std::size_t>(chain[d])];
      x.impulse[k] = sum;
      x.free_v[k] += sum;
    }
  }
}

StepReport Stepper::step(std::span<StepSystem> systems, std::span<const collision::ContactPoint> contacts, double dt) {
  UGOKI_CHECK(systems.size() == mechanisms_.size() && dt > 0);
  StepReport report;
  segments_.clear();
  data_.clear();
  blocks_.clear();
  target_.clear();
  forces_.assign(contacts.size(), Vec3{});
  frames_.resize(3 * contacts.size());
  for (std::size_t s = 0; s < systems.size(); ++s) {
    prepare(s, systems[s], dt, report);
    if (report.status != StepStatus::ok) return report;
  }
  for (std::size_t s = 0; s < systems.size(); ++s) add_loop_rows(s, systems[s], dt);
  loop_rows_ = static_cast<int>(blocks_.size());
  for (std::size_t i = 0; i < contacts.size(); ++i) add_contact(static_cast<int>(i), contacts[i], dt);
  report.contacts = static_cast<int>(blocks_.size()) - loop_rows_;
  for (std::size_t s = 0; s < systems.size(); ++s) add_joint_rows(s, dt);
  report.limits = static_cast<int>(blocks_.size()) - loop_rows_ - report.contacts;
  if (!blocks_.empty()) {
    build_delassus();
    warm_start();
    sweep_all(report);
    recover_loops();
    apply_impulses();
  }
  for (std::size_t s = 0; s < systems.size(); ++s) {
    const std::vector<double>& v = scratch_[s].free_v;
    for (std::size_t i = 0; i < v.size(); ++i) {
      if (std::isfinite(v[i]) && std::fabs(v[i]) < 1e6) continue;
      report.status = StepStatus::not_finite;
      report.system = static_cast<int>(s);
      report.freedom = static_cast<int>(i);
      return report;
    }
  }
  warm_.clear();
  for (const Block& block : blocks_) {
    if (block.kind == RowKind::loop) continue;
    Warm w;
    w.key = block.key;
    for (int r = 0; r < block.rows; ++r) w.p[r] = p_[static_cast<std::size_t>(block.row + r)];
    warm_.push_back(w);
    if (block.kind == RowKind::contact) {
      const Vec3* frame = frames_.data() + 3 * block.contact;
      forces_[static_cast<std::size_t>(block.contact)] = (frame[0] * w.p[0] + frame[1] * w.p[1] + frame[2] * w.p[2]) / dt;
    }
  }
  for (std::size_t s = 0; s < systems.size(); ++s) {
    const std::vector<double>& v = scratch_[s].free_v;
    for (std::size_t i = 0; i < v.size(); ++i) systems[s].v[i] = v[i];
    integrate(*mechanisms_[s], systems[s].q, v, dt, systems[s].q);
    if (scratch_[s].loops) close_loops(s, systems[s], report);
  }
  return report;
}

}  // namespace ugoki::contact
