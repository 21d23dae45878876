#include "ugoki/lsi/grips.h"

#include <algorithm>

namespace ugoki::lsi {
namespace {

/// Pose of a link at the state; identity for the world (character -1).
Pose pose_of(const World& world, std::span<dynamics::Workspace> scratch, int character, int link, const double* state) {
  if (character < 0) return {};
  const Character& c = world.characters()[static_cast<std::size_t>(character)];
  dynamics::Workspace& ws = scratch[static_cast<std::size_t>(character)];
  dynamics::update_kinematics(*c.mechanism, q_of(c, state), v_of(c, state), ws);
  return ws.X_WB[static_cast<std::size_t>(link)];
}

}  // namespace

void Grips::apply(const World& world, std::span<dynamics::Workspace> scratch, const EventRecord& e, const double* state) {
  if (e.kind != EventKind::gripping && e.kind != EventKind::opening) return;
  const auto character = static_cast<std::int32_t>(e.character);
  std::erase_if(held_, [&](const HeldGrip& h) { return h.grip.system_a == character && h.grip.link_a == e.link; });
  if (e.kind == EventKind::opening || held_.size() == capacity) return;
  HeldGrip h;
  contact::Grip& g = h.grip;
  g.system_a = character;
  g.link_a = e.link;
  g.system_b = static_cast<std::int32_t>(e.c.x);
  g.link_b = static_cast<std::int32_t>(e.c.y);
  const auto flags = static_cast<std::uint32_t>(e.c.z);
  const Pose X_a = pose_of(world, scratch, g.system_a, g.link_a, state), X_b = pose_of(world, scratch, g.system_b, g.link_b, state);
  g.p_a = e.a;
  const Vec3 point = X_b.inverse() * (X_a * g.p_a);
  h.target = (flags & grip_has_target) != 0 ? e.b : point;
  h.offset = point - h.target;
  if (norm(h.offset) > e.spare[1]) return;
  g.hold = to_quat(X_b.R.transposed() * X_a.R);
  g.rigid = (flags & grip_rigid) != 0 ? 1 : 0;
  g.key = (static_cast<std::uint64_t>(e.character) << 16 | static_cast<std::uint64_t>(e.link)) & 0xffffffffULL;
  h.limit = e.spare[0];
  held_.push_back(h);
}

void Grips::approach(double dt) {
  for (HeldGrip& h : held_) {
    // The speed of the quintic is at most 1.875 times its mean.
    const double duration = std::max(min_approach_time, 1.875 * norm(h.offset) / max_approach);
    const double x = std::min(1.0, (h.age + dt) / duration), s = x * x * x * (10 + x * (6 * x - 15));
    h.grip.p_b = h.target + h.offset * (1 - s);
  }
}

void Grips::take(std::span<const Vec6> forces, double dt) {
  for (std::size_t i = 0; i < held_.size(); ++i) {
    HeldGrip& h = held_[i];
    h.force = forces[i];
    h.age += dt;
    h.overload = norm(h.force.v) > h.limit ? h.overload + dt : 0;
  }
  std::erase_if(held_, [](const HeldGrip& h) { return h.overload > patience; });
}

std::size_t Grips::report(const World& world, std::span<dynamics::Workspace> scratch, const double* state, EventRecord* out) const {
  for (std::size_t i = 0; i < held_.size(); ++i) {
    const HeldGrip& h = held_[i];
    const contact::Grip& g = h.grip;
    const Vec3 P = pose_of(world, scratch, g.system_a, g.link_a, state) * g.p_a,
               T = pose_of(world, scratch, g.system_b, g.link_b, state) * g.p_b;
    EventRecord& r = out[i] = {};
    r.kind = EventKind::gripping;
    r.character = static_cast<std::uint32_t>(g.system_a);
    r.link = g.link_a;
    r.flags = g.rigid != 0 ? grip_rigid : 0;
    r.a = h.force.v;
    r.b = P;
    r.c = {static_cast<double>(g.system_b), static_cast<double>(g.link_b), norm(h.force.v) / h.limit};
    r.duration = h.age;
    r.spare[0] = norm(P - T);
    for (int k = 0; k < 3; ++k) r.spare[k + 1] = h.force.w[k];
  }
  return held_.size();
}

}  // namespace ugoki::lsi
