#pragma once
// Contact events: begin and end of every touch between two links, with the impulse of the touch.

#include <cstdint>
#include <span>
#include <vector>

#include "ugoki/collision/contact_point.h"

namespace ugoki::contact {

/// A current touch between two links. Plain data, so that it can be saved with a simulation.
struct Touch {
  std::int32_t system_a = -1, link_a = -1, system_b = -1, link_b = -1;  ///< indices as in ContactPoint; both -1: the ground
  Vec3 point;                                                           ///< m, world: first point of contact
  Vec3 impulse;                                                         ///< N s, world: impulse on link a since the touch began
  double duration = 0;                                                  ///< s: since the touch began
  double apart = 0;                                                     ///< s: time since a contact force last acted
};

enum class TouchPhase : std::uint8_t { begin, end };

struct TouchEvent {
  TouchPhase phase = TouchPhase::begin;
  Touch touch;  ///< at `begin`, impulse is that of the first step; at `end`, that of the complete touch
};

/// Tracks touches from step to step, in the order in which they began, so that every run yields the same events.
class ContactEvents {
 public:
  /// @param patience s: a touch ends after this time without a force, so that a chattering contact is one touch
  explicit ContactEvents(double patience = 0.05) : patience_(patience) {}

  /// Updates the touches after a step of dt [s]. @param forces [contacts] N, world @return touches that began or ended; valid until the
  /// next call
  std::span<const TouchEvent> update(std::span<const collision::ContactPoint> contacts, std::span<const Vec3> forces, double dt);

  [[nodiscard]] std::span<const Touch> touches() const { return touches_; }
  void set_touches(std::span<const Touch> touches) { touches_.assign(touches.begin(), touches.end()); }

 private:
  double patience_;
  std::vector<Touch> touches_;
  std::vector<Vec3> now_;  // [touches] N s: impulse of each touch in the present step
  std::vector<TouchEvent> events_;
};

}  // namespace ugoki::contact
