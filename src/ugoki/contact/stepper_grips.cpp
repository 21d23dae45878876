// The rows of grips (grip.h).

#include <algorithm>

#include "ugoki/contact/stepper.h"
#include "ugoki/mechanism/state.h"

namespace ugoki::contact {
namespace {

// High bits that keep the warm-start keys of grips apart from those of other blocks (stepper_rows.cpp).
constexpr std::uint64_t grip_key = 0xc000000000000000ULL, turn_key = 0xc000000100000000ULL;

}  // namespace

void Stepper::set_grips(std::span<const Grip> grips) {
  grips_.assign(grips.begin(), grips.end());
  grip_forces_.assign(grips.size(), Vec6{});
  for (SystemScratch& x : scratch_) x.gripped = false;
  for (const Grip& g : grips_)
    for (const int s : {g.system_a, g.system_b})
      if (s >= 0) scratch_[static_cast<std::size_t>(s)].gripped = true;
}

bool Stepper::is_gripped(const collision::ContactPoint& c) const {
  return std::ranges::any_of(grips_, [&](const Grip& g) {
    const bool same = g.system_a == c.system_a && g.link_a == c.link_a && g.system_b == c.system_b && g.link_b == c.link_b;
    const bool turned = g.system_a == c.system_b && g.link_a == c.link_b && g.system_b == c.system_a && g.link_b == c.link_a;
    return g.system_b >= 0 && c.system_b >= 0 && (same || turned);
  });
}

/// Computes the poses of gripped systems after motion for dt [s] at the velocities before the step.
void Stepper::predict_grips(std::span<const StepSystem> systems, double dt) {
  for (std::size_t s = 0; s < scratch_.size(); ++s) {
    SystemScratch& x = scratch_[s];
    if (!x.gripped) continue;
    integrate(*mechanisms_[s], systems[s].q, x.v, dt, x.next_q);
    calc_poses(*mechanisms_[s], x.next_q, x.next_X);
  }
}

void Stepper::add_grip(const Grip& g, double dt) {
  const auto pose = [&](int s, int link) {
    return s < 0 ? Pose{} : workspaces_[static_cast<std::size_t>(s)].X_WB[static_cast<std::size_t>(link)];
  };
  const auto next_pose = [&](int s, int link) {
    return s < 0 ? Pose{} : scratch_[static_cast<std::size_t>(s)].next_X[static_cast<std::size_t>(link)];
  };
  const Pose X_a = pose(g.system_a, g.link_a), X_b = pose(g.system_b, g.link_b);
  const Pose Y_a = next_pose(g.system_a, g.link_a), Y_b = next_pose(g.system_b, g.link_b);
  const Vec3 P = X_a * g.p_a, T = X_b * g.p_b, gap_after = Y_a * g.p_a - Y_b * g.p_b;
  struct Side {
    int s, link;
    Vec3 at;
    double sign;
  };
  const Side sides[2] = {{g.system_a, g.link_a, P, 1}, {g.system_b, g.link_b, T, -1}};
  Vec3 now, free, turn_free;  // relative velocity of the points before the step; relative velocities without impulses
  Vec3 turn_now;
  int movable = 0;
  for (const Side& side : sides) {
    if (side.s < 0) continue;
    const dynamics::Workspace& ws = workspaces_[static_cast<std::size_t>(side.s)];
    const int last = ws.link_chain[static_cast<std::size_t>(side.link)];
    if (last < 0) continue;
    ++movable;
    now += dynamics::point_velocity(ws, side.link, side.at) * side.sign;
    const Vec6& V = free_velocity(static_cast<std::size_t>(side.s), last);
    free += (V.v + cross(V.w, side.at - ws.p0)) * side.sign;
    turn_free += V.w * side.sign;
    Vec6 W;
    for (const int k : dynamics::chain_of_link(ws, side.link))
      W += ws.S[static_cast<std::size_t>(k)] * scratch_[static_cast<std::size_t>(side.s)].v[static_cast<std::size_t>(k)];
    turn_now += W.w * side.sign;
  }
  if (movable == 0) return;
  const auto add = [&](std::uint64_t key, const Vec3& target, bool turns) {
    const RowBlock& block = solver_.begin_block(RowKind::grip, key);
    for (const Side& side : sides) {
      if (side.s < 0) continue;
      const auto s = static_cast<std::size_t>(side.s);
      const dynamics::Workspace& ws = workspaces_[s];
      const int last = ws.link_chain[static_cast<std::size_t>(side.link)];
      if (last < 0) continue;
      Vec6 wrenches[3];
      for (int d = 0; d < 3; ++d) {
        Vec3 e;
        e[d] = side.sign;
        wrenches[d] = turns ? Vec6{e, {}} : Vec6{cross(side.at - ws.p0, e), e};
      }
      scratch_[s].factor.whiten_wrenches(last, wrenches, add_side(s, last));
      if (scratch_[s].loops) spread_over_loops(s, last);
    }
    const double values[3] = {target.x, target.y, target.z};
    const Warm* warm = warm_.find(block.key);
    solver_.end_block(values, warm ? std::span<const double>(warm->p) : std::span<const double>());
  };
  // Wanted velocity: now - gap_after / dt, because g + N = gap_after - dt J v.
  add(grip_key | g.key, free - (now - gap_after / dt), false);
  if (g.rigid == 0) return;
  const Vec3 turned = log_map(to_quat(Y_a.R * (Y_b.R * to_matrix(g.hold)).transposed()));
  add(turn_key | g.key, turn_free - (turn_now - turned / dt), true);
}

/// Sets grip_forces_ from the impulses of the step.
void Stepper::take_grip_forces(double dt) {
  for (const RowBlock& b : solver_.blocks()) {
    if (b.kind != RowKind::grip) continue;
    const std::span<const double> p = solver_.impulses(b);
    const bool turns = (b.key & ~0xffffffffULL) == turn_key;
    for (std::size_t i = 0; i < grips_.size(); ++i)
      if (grips_[i].key == (b.key & 0xffffffffULL)) (turns ? grip_forces_[i].w : grip_forces_[i].v) = Vec3{p[0], p[1], p[2]} / dt;
  }
}

}  // namespace ugoki::contact
