// The constraint rows of a step: contacts, rolling resistance, joint limits, dry friction.

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "ugoki/contact/stepper.h"
#include "ugoki/mechanism/state.h"

namespace ugoki::contact {
namespace {

// High bits that keep the warm-start keys of limits and of rolling rows apart from contact keys.
constexpr std::uint64_t limit_key = 0x8000000000000000ULL;
constexpr std::uint64_t roll_key = 0x4000000000000000ULL;
// Softness of contacts in deep overlaps (RowBlock::softness). It bounds the impulses of contacts with contradictory normals.
// Tests: overlap_test.cpp.
constexpr double deep_softness = 0.3;
// Recovery speed of deep overlaps as a fraction of StepperOptions::recovery_speed. It is below 1 because contacts near a joint move the far
// end of a limb up to ten times as fast. Tests: overlap_test.cpp.
constexpr double deep_recovery = 0.5;
// 1/s: recovery speed of deep overlaps relative to their depth, so that a character who stands hip-deep in the ground rises within 2 s.
constexpr double deep_rate = 0.8;

// Length of the mean of unit normals, weighted by depth, below which they contradict each other and the deepest contact decides.
constexpr double contradiction = 0.2;

std::uint64_t pair_of(const collision::ContactPoint& c) {
  const auto a = static_cast<std::uint64_t>(c.system_a + 1), b = static_cast<std::uint64_t>(c.system_b + 1);
  return std::min(a, b) << 32 | std::max(a, b);
}

}  // namespace

/// Finds the direction in which each pair of different systems with deep overlaps comes apart.
void Stepper::find_separations(std::span<const collision::ContactPoint> contacts) {
  separations_.clear();
  for (const collision::ContactPoint& c : contacts) {
    if (!(c.distance < -StepperOptions::deep_overlap) || c.system_a == c.system_b) continue;
    const Vec3 n = c.system_a > c.system_b ? c.n : -c.n;
    separations_.push_back({pair_of(c), separations_.size(), n * -c.distance, n, -c.distance, -c.distance});
  }
  if (separations_.empty()) return;
  std::ranges::sort(separations_, {}, [](const Separation& x) { return std::pair(x.pair, x.index); });
  std::size_t kept = 0;
  for (std::size_t i = 1; i < separations_.size(); ++i) {
    const Separation& next = separations_[i];
    Separation& last = separations_[kept];
    if (next.pair != last.pair) {
      separations_[++kept] = next;
      continue;
    }
    last.sum += next.sum;
    last.total += next.total;
    if (next.depth <= last.depth) continue;
    last.depth = next.depth;
    last.deepest = next.deepest;
  }
  separations_.resize(kept + 1);
}

/// Direction along which a contact of a deep overlap pushes, from b towards a. The normals of several contacts may contradict each other,
/// for example if limbs are on both sides of a trunk; all contacts of two systems therefore push in the same direction.
Vec3 Stepper::recovery_direction(const collision::ContactPoint& c) const {
  const auto found = std::ranges::lower_bound(separations_, pair_of(c), {}, &Separation::pair);
  if (c.system_a == c.system_b || found == separations_.end() || found->pair != pair_of(c)) return c.n;
  const Vec3 n = norm(found->sum) > contradiction * found->total ? normalized(found->sum) : found->deepest;
  return c.system_a > c.system_b ? n : -n;
}

/// Adds a segment for one side of a block.
/// @return [chain length of DOF `last`][4] memory for that side's whitened rows
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

/// Sets free_motion to the velocities, about p0, of the links that the DOFs move, at the velocity v [nv].
void Stepper::move_links(std::size_t s, std::span<const double> v) {
  std::vector<Vec6>& V = scratch_[s].free_motion;
  const std::span<const int> parents = mechanisms_[s]->dof_parents();
  for (std::size_t k = 0; k < V.size(); ++k) {
    const Vec6 own = workspaces_[s].S[k] * v[k];
    V[k] = parents[k] < 0 ? own : V[static_cast<std::size_t>(parents[k])] + own;
  }
}

/// Velocity without impulses, about p0, of the link that DOF `last` moves. Computed for all links of the system at the first call in a
/// step.
const Vec6& Stepper::free_velocity(std::size_t s, int last) {
  SystemScratch& x = scratch_[s];
  if (!x.has_free_motion) {
    move_links(s, x.free_v);
    x.has_free_motion = true;
  }
  return x.free_motion[static_cast<std::size_t>(last)];
}

void Stepper::add_contact(int index, const collision::ContactPoint& c, double dt, bool forced) {
  if (is_gripped(c)) return;
  const double gap = c.distance, impact_impulse = impact_impulses_[static_cast<std::size_t>(index)];
  // Overlaps of this depth exist from the beginning. Their normals may contradict each other, and friction would then lock the bodies.
  const bool deep = gap < -StepperOptions::deep_overlap;
  const Vec3 n = deep ? recovery_direction(c) : c.n;
  double before = 0, whip = 0;
  Vec3 free;
  struct Side {
    std::size_t s;
    int last;
    double sign;
  } sides[2];
  std::size_t count = 0;
  for (int side = 0; side < 2; ++side) {
    const int s = side == 0 ? c.system_a : c.system_b, link = side == 0 ? c.link_a : c.link_b;
    if (s < 0) continue;
    const dynamics::Workspace& ws = workspaces_[static_cast<std::size_t>(s)];
    const int last = ws.link_chain[static_cast<std::size_t>(link)];
    if (last < 0) continue;
    const double sign = side == 0 ? 1.0 : -1.0;
    sides[count++] = {static_cast<std::size_t>(s), last, sign};
    const Vec3 r = c.p - ws.p0;
    const Vec6& V = free_velocity(static_cast<std::size_t>(s), last);
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
  for (const Side& side : std::span(sides).first(count)) scratch_[side.s].deep = scratch_[side.s].deep || deep;
  const double fastest = deep ? std::max(deep_recovery * options_.recovery_speed, -deep_rate * gap) : options_.recovery_speed;
  const double wanted = gap > 0 || forced ? -gap / dt : recovery_ * std::min(-gap / options_.recovery_time, fastest);
  const double target[3] = {free_n - wanted, dot(t1, free), dot(t2, free)};
  double first[3] = {0, 0, 0};  // the last impulse, in the frame of this step: n may turn slightly, and t1 with it by a right angle
  if (const Warm* warm = warm_.find(c.key))
    for (int d = 0; d < 3; ++d) first[d] = dot(frame[d], Vec3{warm->p[0], warm->p[1], warm->p[2]});
  const auto wrenches = [&](const Side& side) {
    const Vec3 r = c.p - workspaces_[side.s].p0;
    std::array<Vec6, 3> w;
    for (std::size_t d = 0; d < 3; ++d) w[d] = {cross(r, frame[d]) * side.sign, frame[d] * side.sign};
    return w;
  };
  const auto describe = [&](RowBlock& block) {
    block.contact = index;
    block.mu = deep ? 0 : c.friction;
    block.softness = deep ? deep_softness : 0;
    block.impact_impulse = impact_impulse;
  };
  if (SystemScratch& x = scratch_[sides[0].s]; x.by_tree) {  // the other side does not move
    describe(x.tree->add_contact(c.key, sides[0].sign > 0 ? c.link_a : c.link_b, wrenches(sides[0]), target, first));
    return;
  }
  describe(solver_.begin_block(RowKind::contact, c.key));
  for (const Side& side : std::span(sides).first(count)) {
    scratch_[side.s].factor.whiten_wrenches(side.last, wrenches(side).data(), add_side(side.s, side.last));
    if (scratch_[side.s].loops) spread_over_loops(side.s, side.last);
  }
  solver_.end_block(target, first);
  add_rolling(c);
}

/// Rolling resistance of a free round body: a moment against its rolling and spinning, with a bound proportional to the normal force.
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
    int last = ws.link_chain[static_cast<std::size_t>(link)];
    if (last < 0) continue;
    const double sign = side == 0 ? 1.0 : -1.0;
    spin += free_velocity(s, last).w * sign;
    // A moment does not act on the translations at the end of a chain: their entries would be zero.
    const std::span<const int> parents = mechanisms_[s]->dof_parents();
    while (parents[static_cast<std::size_t>(last)] >= 0 && ws.S[static_cast<std::size_t>(last)].w == Vec3{})
      last = parents[static_cast<std::size_t>(last)];
    const Vec6 moments[3] = {{{sign, 0, 0}, {}}, {{0, sign, 0}, {}}, {{0, 0, sign}, {}}};
    scratch_[s].factor.whiten_wrenches(last, moments, add_side(s, last));
    if (scratch_[s].loops) spread_over_loops(s, last);
  }
  const double target[3] = {spin.x, spin.y, spin.z};
  const Warm* warm = warm_.find(block.key);
  solver_.end_block(target, warm ? std::span<const double>(warm->p) : std::span<const double>());
}

/// Adds the rows of joint limits and dry joint friction of one system. @return number of rows
int Stepper::add_joint_rows(std::size_t s, double dt) {
  const Mechanism& m = *mechanisms_[s];
  const dynamics::Workspace& ws = workspaces_[s];
  const SystemScratch& x = scratch_[s];
  int rows = 0;
  const auto add_row = [&](RowKind kind, const Link& link, const double* direction, double target, double bound, std::uint64_t key) {
    ++rows;
    const int nv = link.joint.nv(), last = link.v_index + nv - 1;
    double u = 0;
    for (int k = 0; k < nv; ++k) u += direction[k] * x.free_v[static_cast<std::size_t>(link.v_index + k)];
    const Warm* warm = warm_.find(key);
    if (x.by_tree) {
      u -= target;
      int k = 0;
      while (direction[k] == 0) ++k;  // one DOF, because TreeIsland::can_treat() excludes limits of spherical joints
      x.tree
          ->add_joint_row(kind, key, link.v_index + k, direction[k], u, warm ? std::span<const double>(warm->p) : std::span<const double>())
          .bound = bound;
      return;
    }
    solver_.begin_block(kind, key).bound = bound;
    x.factor.whiten_row(last, {direction, static_cast<std::size_t>(nv)}, add_side(s, last));
    // Near a dead point of its loops a joint turns a whole mechanism at a huge ratio. Recovery from beyond a limit must then be slower, so
    // that it costs no more energy than with open loops: the kinetic energy of the recovery is target^2 / (2 y . y).
    const double mobility = x.loops ? spread_over_loops(s, last) : 1;
    u -= target > 0 ? target * std::sqrt(mobility) : target;
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
        if (!(room < 0.2)) continue;  // rad | m: too far from the limit to reach it in a usual step
        double direction[6] = {0, 0, 0, 0, 0, 0};
        if (link.joint.type == JointType::spherical) {
          // Rate of component k of the rotation vector r: row k of 1 + [r]/2 + c [r]^2, times the angular velocity. [r] x = cross(r, x).
          // The matrix is the inverse of the exponential map's differential.
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
        const double wanted = room > 0 ? -room / dt : recovery_ * std::min(-room / (5 * options_.recovery_time), 1.0);
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
  return rows;
}

}  // namespace ugoki::contact
