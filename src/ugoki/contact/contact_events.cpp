#include "ugoki/contact/contact_events.h"

#include <algorithm>

namespace ugoki::contact {

std::span<const TouchEvent> ContactEvents::update(std::span<const collision::ContactPoint> contacts, std::span<const Vec3> forces,
                                                  double dt) {
  events_.clear();
  now_.assign(touches_.size(), Vec3{});
  const std::size_t old = touches_.size();
  std::size_t at = old;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const collision::ContactPoint& c = contacts[i];
    if (forces[i] == Vec3{}) continue;
    const auto same = [&](const Touch& t) {
      return t.system_a == c.system_a && t.link_a == c.link_a && t.system_b == c.system_b && t.link_b == c.link_b;
    };
    if (at >= touches_.size() || !same(touches_[at]))  // the points of one pair are consecutive, so usually the index is unchanged
      at = static_cast<std::size_t>(std::ranges::find_if(touches_, same) - touches_.begin());
    if (at == touches_.size()) {
      touches_.push_back({c.system_a, c.link_a, c.system_b, c.link_b, c.p, {}, 0, 0});
      now_.emplace_back();
    }
    now_[at] += forces[i] * dt;
  }
  for (std::size_t i = 0; i < touches_.size(); ++i) {
    Touch& t = touches_[i];
    t.impulse += now_[i];
    t.apart = now_[i] == Vec3{} ? t.apart + dt : 0;
    t.duration += dt;
    if (i >= old) events_.push_back({TouchPhase::begin, t});
  }
  const auto ended = [&](const Touch& t) {
    if (t.apart < patience_) return false;
    Touch last = t;
    last.duration -= t.apart;
    events_.push_back({TouchPhase::end, last});
    return true;
  };
  touches_.erase(std::remove_if(touches_.begin(), touches_.end(), ended), touches_.end());
  return events_;
}

}  // namespace ugoki::contact
