// The constraint rows of a step: contacts, rolling resistance, joint limits, dry friction.

#include <algorithm>
#include <cmath>

#include "ugoki/contact/stepper.h"
#include "ugoki/mechanism/state.h"

namespace ugoki::contact {
namespace {

// High bits that keep the warm-start keys of limits and of rolling rows apart from contact keys.
constexpr std::uint64_t limit_key = 0x8000000000000000ULL;
constexpr std::uint64_t roll_key = 0x4000000000000000ULL;

}  // namespace

/// Whitens a row in place: y = D^-1/2 L^-T J^T. @param y [chain length of DOF `last`] in: row of J on that chain, out: whitened
void Stepper::whiten(std::size_t s, int last, std::span<double> y) const {
  const dynamics::Workspace& ws = workspaces_[s];
  dynamics::apply_inverse_transposed_factor(ws, last, y);
  const int* chain = ws.chain.data() + ws.row_start[static_cast<std::size_t>(last)];
  const std::vector<double>& root = scratch_[s].sqrt_D_inverse;
  for (std::size_t e = 0; e < y.size(); ++e) y[e] *= root[static_cast<std::size_t>(chain[e])];
}

/// Adds a segment for one side of a block.
/// @return [rows * chain length] memory for that side's rows of J on the chain of DOF `last`
double* Stepper::add_side(std::size_t s, int last) {
  const dynamics::Workspace& ws = workspaces_[s];
  SystemScratch& x = scratch_[s];
  if (x.loops) {  // rows projected onto the loops have entries on all DOFs
    (void)solver_.add_segment(static_cast<int>(s), nullptr, static_cast<int>(x.v.size()));
    return x.loops->sparse.data();
  }
  const auto l = static_cast<std::size_t>(last);
  const int length = ws.depth[l] + 1;
  const int* chain = x.contiguous_chain[l] ? nullptr : ws.chain.data() + ws.row_start[l];
  return solver_.add_segment(static_cast<int>(s), chain, length).data();
}

/// Whitens the rows written to the memory from add_side() and projects them onto what the loops allow.
void Stepper::finish_side(std::size_t s, int last, int rows, double* row) {
  const dynamics::Workspace& ws = workspaces_[s];
  const auto length = static_cast<std::size_t>(ws.depth[static_cast<std::size_t>(last)] + 1);
  for (int r = 0; r < rows; ++r) whiten(s, last, {row + static_cast<std::size_t>(r) * length, length});
  if (scratch_[s].loops) spread_over_loops(s, last, rows, row);
}

void Stepper::add_contact(int index, const collision::ContactPoint& c, double dt, bool forced) {
  const double gap = c.distance, impact_impulse = impact_impulses_[static_cast<std::size_t>(index)];
  const Vec3 n = c.n;
  double before = 0, whip = 0;
  Vec3 free;
  struct Side {
    std::size_t s;
    int last;
    double sign;
  } sides[2];
  int count = 0;
  for (int side = 0; side < 2; ++side) {
    const int s = side == 0 ? c.system_a : c.system_b, link = side == 0 ? c.link_a : c.link_b;
    if (s < 0) continue;
    const dynamics::Workspace& ws = workspaces_[static_cast<std::size_t>(s)];
    const int last = ws.link_chain[static_cast<std::size_t>(link)];
    if (last < 0) continue;
    const double sign = side == 0 ? 1.0 : -1.0;
    sides[count++] = {static_cast<std::size_t>(s), last, sign};
    const Vec3 r = c.p - ws.p0;
    const std::span<const int> chain = dynamics::chain_of_link(ws, link);
    const std::vector<double>& free_v = scratch_[static_cast<std::size_t>(s)].free_v;
    Vec6 V;
    for (const int k : chain) V += ws.S[static_cast<std::size_t>(k)] * free_v[static_cast<std::size_t>(k)];
    free += (V.v + cross(V.w, r)) * sign;
    const Vec3 now = dynamics::point_velocity(ws, link, c.p);
    before += sign * dot(n, now);
    if (scratch_[static_cast<std::size_t>(s)].free_body) whip += 1.5 * (norm(now) + norm(V.w) * norm(r));
  }
  const double free_n = dot(n, free);
  // Another contact may make a free body rotate this point towards the surface: `whip` [m/s] bounds the speed of the point in that case.
  // A gap that stays above 1 mm in the step cannot carry a force and gets no rows.
  const bool out_of_reach = !forced && gap > 1e-3 && gap + dt * std::min({free_n, before, -whip}) > 1e-3 && impact_impulse == 0;
  if (count == 0 || out_of_reach) return;

  const Vec3 t1 = any_perpendicular(n), t2 = cross(n, t1);
  Vec3* const frame = frames_.data() + 3 * index;
  frame[0] = n;
  frame[1] = t1;
  frame[2] = t2;
  RowBlock& block = solver_.begin_block(RowKind::contact, c.key);
  block.contact = index;
  block.mu = c.friction;
  block.impact_impulse = impact_impulse;
  for (int k = 0; k < count; ++k) {
    const auto& [s, last, sign] = sides[k];
    const dynamics::Workspace& ws = workspaces_[s];
    double* const row = add_side(s, last);
    const int* chain = ws.chain.data() + ws.row_start[static_cast<std::size_t>(last)];
    const int length = ws.depth[static_cast<std::size_t>(last)] + 1;
    const Vec3 r = c.p - ws.p0;
    Vec6 directions[3];
    for (int d = 0; d < 3; ++d) directions[d] = {cross(r, frame[d]) * sign, frame[d] * sign};
    for (int e = 0; e < length; ++e) {
      const Vec6& S = ws.S[static_cast<std::size_t>(chain[e])];
      for (int d = 0; d < 3; ++d) row[d * length + e] = dot(directions[d], S);
    }
    finish_side(s, last, 3, row);
  }
  const double wanted = gap > 0 || forced ? -gap / dt : std::min(-gap / options_.recovery_time, options_.recovery_speed);
  const double target[3] = {free_n - wanted, dot(t1, free), dot(t2, free)};
  const Warm* warm = warm_.find(c.key);
  solver_.end_block(target, warm ? std::span<const double>(warm->p) : std::span<const double>());
  add_rolling(c);
}

/// Rolling resistance of a free round body: a moment against its rolling and spinning, bounded in proportion to the normal force.
void Stepper::add_rolling(const collision::ContactPoint& c) {
  const double a = c.system_a < 0 ? 0 : scratch_[static_cast<std::size_t>(c.system_a)].rolling_radius;
  const double b = c.system_b < 0 ? 0 : scratch_[static_cast<std::size_t>(c.system_b)].rolling_radius;
  const double lever = a > 0 && b > 0 ? std::min(a, b) : std::max(a, b);
  if (lever == 0 || options_.rolling == 0) return;
  const int leader = static_cast<int>(solver_.blocks().size()) - 1;
  RowBlock& block = solver_.begin_block(RowKind::roll, roll_key | c.key);
  block.contact_block = leader;
  block.mu = options_.rolling * lever;
  block.lever = lever;
  Vec3 spin;
  for (int side = 0; side < 2; ++side) {
    const int at = side == 0 ? c.system_a : c.system_b, link = side == 0 ? c.link_a : c.link_b;
    if (at < 0) continue;
    const auto s = static_cast<std::size_t>(at);
    const dynamics::Workspace& ws = workspaces_[s];
    const int last = ws.link_chain[static_cast<std::size_t>(link)];
    if (last < 0) continue;
    const double sign = side == 0 ? 1.0 : -1.0;
    double* const row = add_side(s, last);
    const int* chain = ws.chain.data() + ws.row_start[static_cast<std::size_t>(last)];
    const int length = ws.depth[static_cast<std::size_t>(last)] + 1;
    for (int e = 0; e < length; ++e) {
      const Vec3 w = ws.S[static_cast<std::size_t>(chain[e])].w * sign;
      for (int d = 0; d < 3; ++d) row[d * length + e] = w[d];
      spin += w * scratch_[s].free_v[static_cast<std::size_t>(chain[e])];
    }
    finish_side(s, last, 3, row);
  }
  const double target[3] = {spin.x, spin.y, spin.z};
  const Warm* warm = warm_.find(block.key);
  solver_.end_block(target, warm ? std::span<const double>(warm->p) : std::span<const double>());
}

void Stepper::add_joint_rows(std::size_t s, double dt) {
  const Mechanism& m = *mechanisms_[s];
  const dynamics::Workspace& ws = workspaces_[s];
  const SystemScratch& x = scratch_[s];
  if (inertial_only_) return;
  const auto add_row = [&](RowKind kind, const Link& link, const double* direction, double target, double bound, std::uint64_t key) {
    const int last = link.v_index + link.joint.nv() - 1, length = ws.depth[static_cast<std::size_t>(last)] + 1;
    RowBlock& block = solver_.begin_block(kind, key);
    block.bound = bound;
    double* const row = add_side(s, last);
    std::fill_n(row, length, 0.0);
    double u = 0;
    for (int k = 0; k < link.joint.nv(); ++k) {
      row[length - link.joint.nv() + k] = direction[k];
      u += direction[k] * x.free_v[static_cast<std::size_t>(link.v_index + k)];
    }
    finish_side(s, last, 1, row);
    u -= target;
    const Warm* warm = warm_.find(key);
    solver_.end_block({&u, 1}, warm ? std::span<const double>(warm->p) : std::span<const double>());
  };
  for (const int i : x.limited_links) {
    const Link& link = m.link(i);
    const int nv = link.joint.nv();
    for (int k = 0; k < nv; ++k) {
      const Dof& f = link.joint.dofs[static_cast<std::size_t>(k)];
      const auto at = static_cast<std::size_t>(link.v_index + k);
      const double displacement = x.displacement[at];
      for (int side = 0; side < 2; ++side) {
        const double sign = side == 0 ? 1.0 : -1.0;
        const double room = side == 0 ? displacement - f.lower : f.upper - displacement;
        if (!(room < 0.2)) continue;  // rad | m: too far away from this limit to reach it in a usual step
        double direction[6] = {0, 0, 0, 0, 0, 0};
        if (link.joint.type == JointType::spherical) {
          // Rate of component k of the rotation vector r: row k of 1 + [r]/2 + c [r]^2, the inverse of the exponential map's differential.
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
  for (const int f : x.dry_friction_dofs) {
    const Link& link = m.link(m.link_of_dof(f));
    double direction[6] = {0, 0, 0, 0, 0, 0};
    direction[f - link.v_index] = 1;
    add_row(RowKind::friction, link, direction, 0, dt * ws.dofs[static_cast<std::size_t>(f)].friction,
            limit_key | (static_cast<std::uint64_t>(s) << 40) | (static_cast<std::uint64_t>(f) << 4) | 2);
  }
}

}  // namespace ugoki::contact
