#pragma once
// The grips of a world: made and opened by events, opened by overload.

#include <span>
#include <vector>

#include "ugoki/contact/grip.h"
#include "ugoki/dynamics/dynamics.h"
#include "ugoki/lsi/world.h"

namespace ugoki::lsi {

/// A grip that holds now. Plain data, which is saved with a simulation.
struct HeldGrip {
  contact::Grip grip;   ///< p_b is the target of the present tick
  Vec3 target, offset;  ///< m, frame of link b: the final target; the gripping point minus the final target when the grip was made
  double limit = 0;     ///< N: a larger force for more than Grips::patience opens the grip
  double age = 0;       ///< s since the grip was made
  double overload = 0;  ///< s for which the force has been above the limit
  Vec6 force;           ///< N m, N, world: on link a in the last tick
};

class Grips {
 public:
  static constexpr std::size_t capacity = 32;        ///< maximum number of grips; further ones are not made
  static constexpr double patience = 0.05;           ///< s
  static constexpr double max_approach = 0.5;        ///< m/s: speed at which a grip pulls its two points together
  static constexpr double min_approach_time = 0.02;  ///< s

  Grips() { held_.reserve(capacity); }
  /// Makes or opens a grip. A grip whose points are further apart than its reach is not made.
  void apply(const World& world, std::span<dynamics::Workspace> scratch, const EventRecord& event, const double* state);
  /// Moves the targets of new grips for the next tick of dt [s].
  void approach(double dt);
  /// Takes the forces of the tick, and opens grips that are overloaded. @param forces [held()]
  void take(std::span<const Vec6> forces, double dt);
  /// Writes one record for each grip (EventKind::gripping). @return their number
  std::size_t report(const World& world, std::span<dynamics::Workspace> scratch, const double* state, EventRecord* out) const;

  [[nodiscard]] std::span<const HeldGrip> held() const { return held_; }
  void set_held(std::span<const HeldGrip> held) { held_.assign(held.begin(), held.end()); }

 private:
  std::vector<HeldGrip> held_;
};

}  // namespace ugoki::lsi
