#include "ugoki/lsi/world.h"

#include <algorithm>
#include <utility>

#include "ugoki/base/check.h"
#include "ugoki/lsi/track_sampler.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/motion/contact_labels.h"
#include "ugoki/motion/torques.h"

namespace ugoki::lsi {
namespace {

/// Raises a character whose first frame penetrates the ground, so that contact forces do not push it out at the start.
void raise_above(const Mechanism& m, double ground, std::span<double> q) {
  if (m.link(0).joint.type != JointType::floating) return;
  std::vector<Pose> X(static_cast<std::size_t>(m.link_count()));
  calc_poses(m, q, X);
  double low = ground;
  for (int i = 0; i < m.link_count(); ++i)
    for (const SupportPoint& s : support_points(m.link(i))) low = std::min(low, (X[static_cast<std::size_t>(i)] * s.p).z - s.radius);
  displace_root(m, {0, 0, ground - low, 0}, q);
}

}  // namespace

collision::ContactPoint World::on_ground(const collision::ContactPoint& contact, int own) const {
  collision::ContactPoint c = contact;
  if (c.system_b == own && c.system_a != own && is_ground(c.system_a, c.link_a)) {
    std::swap(c.system_a, c.system_b);
    std::swap(c.link_a, c.link_b);
    c.n = -c.n;
  }
  if (c.system_a == own && c.system_b != own && is_ground(c.system_b, c.link_b)) c.system_b = c.link_b = -1;
  return c;
}

World::World(std::vector<CharacterSpec> characters, std::vector<ScheduledEvent> events, const Vec3& gravity,
             const collision::Ground& ground)
    : events_(std::move(events)), gravity_(gravity), ground_(ground) {
  std::size_t shapes = 0;
  for (CharacterSpec& spec : characters) {
    UGOKI_CHECK(spec.mechanism && spec.mechanism->link_count() > 0);
    const Mechanism& m = *spec.mechanism;
    Character c;
    c.id = std::move(spec.id);
    c.index = static_cast<int>(characters_.size());
    c.mechanism = spec.mechanism;
    c.feet = find_feet(m);
    for (const Link& link : m.links())
      c.fixed.push_back(link.joint.nv() == 0 && (link.parent < 0 || c.fixed[static_cast<std::size_t>(link.parent)]));
    c.q0 = spec.q0.empty() ? m.neutral() : std::move(spec.q0);
    c.v0.resize(static_cast<std::size_t>(m.nv()));
    UGOKI_CHECK(c.q0.size() == static_cast<std::size_t>(m.nq()));
    c.q_offset = state_size_;
    c.v_offset = state_size_ + c.q0.size();
    state_size_ += c.q0.size() + c.v0.size();
    c.first_link = link_count_;
    link_count_ += static_cast<std::size_t>(m.link_count());
    for (const Link& link : m.links()) shapes += link.shapes.size();
    if (!spec.track.empty()) {
      c.track = std::make_shared<const TrackSampler>(c.mechanism, std::move(spec.track), c.feet, !spec.as_recorded);
      std::vector<double> reference(c.track->layout().size());
      c.track->sample(0, reference);
      const ReferenceLayout& at = c.track->layout();
      std::copy_n(reference.data(), c.q0.size(), c.q0.data());
      std::copy_n(reference.data() + at.v(), c.v0.size(), c.v0.data());
      if (!spec.as_recorded) raise_above(m, ground_.height, c.q0);
    }
    if (spec.torques) {
      c.torques = std::move(spec.torques);
      c.q0 = c.torques->torques->q0;
      c.v0 = c.torques->torques->v0;
    }
    if (!spec.moves.empty()) c.moves = std::make_shared<const TrackSampler>(c.mechanism, std::move(spec.moves), c.feet, true);
    characters_.push_back(std::move(c));
  }
  kinematics_ = std::make_unique<TickKinematics>(mechanisms());
  contact_capacity_ = static_cast<std::uint32_t>(std::clamp<std::size_t>(8 * shapes, 64, 4096));  // contact_capacity() explains the numbers
}

const void* World::find(std::string_view kind, std::string_view name) const {
  if (kind == resource_kind) return this;
  if (kind == Character::resource_kind)
    for (const Character& c : characters_)
      if (c.id == name) return &c;
  return nullptr;
}

std::vector<MechanismPtr> World::mechanisms() const {
  std::vector<MechanismPtr> out;
  for (const Character& c : characters_) out.push_back(c.mechanism);
  return out;
}

}  // namespace ugoki::lsi
