#pragma once
// Who touches whom: begin and end of every touch between two links, with its impulse.

#include <cstdint>
#include <span>
#include <vector>

#include "ugoki/collision/contact_point.h"

namespace ugoki::contact {

/// A touch between two links that is going on; plain data, for saving a simulation.
struct Touch {
  std::int32_t system_a = -1, link_a = -1, system_b = -1, link_b = -1;  ///< as in ContactPoint; -1, -1: the ground
  Vec3 point;                                                           ///< m, world: where it began
  Vec3 impulse;                                                         ///< N s, world, on link a, so far
  double duration = 0;                                                  ///< s, so far
  double apart = 0;                                                     ///< s without a force
};

enum class TouchPhase : std::uint8_t { begin, end };

struct TouchEvent {
  TouchPhase phase = TouchPhase::begin;
  Touch touch;  ///< begin: with the impulse of the first step; end: with that of the whole touch
};

/// Follows the touches from step to step, in the order in which they began: the same events on every run.
class ContactEvents {
 public:
  /// @param patience s without a force after which a touch has ended, so that a chattering one is one touch
  explicit ContactEvents(double patience = 0.05) : patience_(patience) {}

  /// Takes over a step's contacts and their forces [N]. @return what began and ended; valid until the next call
  std::span<const TouchEvent> update(std::span<const collision::ContactPoint> contacts, std::span<const Vec3> forces, double dt);

  [[nodiscard]] std::span<const Touch> touches() const { return touches_; }
  void set_touches(std::span<const Touch> touches) { touches_.assign(touches.begin(), touches.end()); }

 private:
  double patience_;
  std::vector<Touch> touches_;
  std::vector<Vec3> now_;  // [touches] N s of this step
  std::vector<TouchEvent> events_;
};

}  // namespace ugoki::contact
