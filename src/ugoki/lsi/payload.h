#pragma once
// How the payloads of the physical pin types are used by the standard LSIs.

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>

#include "ugoki/collision/contact_point.h"
#include "ugoki/spatial/spatial.h"

namespace ugoki::lsi {

/// What happens (pin type `event`). Vectors by kind:
///   push     a force [N], world, at the link's centre of mass; `duration` s (live input), 0 where it is for this tick
///   grab     a point in the link's frame [m], b target in the world [m]
///   drag     b target                                      (live input only)
///   release                                                (live input only)
///   throwing a position [m], b velocity [m/s], c spin [rad/s] of the root, world
///   touch    a where [m], b impulse of its first step on the link [N s], world; c other character (-1: the ground) and link
///   parting  a where the touch began, b its whole impulse; c as in touch; `duration` of the touch
enum class EventKind : std::uint32_t { none = 0, push = 1, grab = 2, drag = 3, release = 4, throwing = 5, touch = 6, parting = 7 };

struct EventRecord {
  EventKind kind = EventKind::none;
  std::uint32_t character = 0;
  std::int32_t link = 0;
  std::uint32_t reserved = 0;
  Vec3 a, b, c;
  double duration = 0;
  double spare[4] = {0, 0, 0, 0};
};
static_assert(sizeof(EventRecord) == 128 && std::is_trivially_copyable_v<EventRecord>);

/// A contact and the force [N] on its body a, world axes (pin type `contacts`).
struct ContactRecord {
  collision::ContactPoint point;
  Vec3 force;
  double spare = 0;
};
static_assert(sizeof(ContactRecord) == 128 && std::is_trivially_copyable_v<ContactRecord>);

/// Records of a payload with a header that counts them.
template <class Record>
std::span<const Record> records(const void* payload) {
  if (!payload) return {};
  std::uint64_t count = 0;
  std::memcpy(&count, payload, sizeof count);
  return {reinterpret_cast<const Record*>(static_cast<const std::byte*>(payload) + sizeof count), static_cast<std::size_t>(count)};
}
/// Room for records; set_count says how many are in use.
template <class Record>
Record* record_room(void* payload) {
  return reinterpret_cast<Record*>(static_cast<std::byte*>(payload) + sizeof(std::uint64_t));
}
inline void set_count(void* payload, std::uint64_t count) { std::memcpy(payload, &count, sizeof count); }

/// Numbers of the report that motion control gives of the root assist (joint values, 10).
enum Report : std::size_t {
  report_force = 0,       ///< 3, N, world
  report_moment = 3,      ///< 3, N m, world, about the root link's origin
  report_ratio = 6,       ///< wanted / cap
  report_size = 7,        ///< applied, body weights
  report_let_go = 8,      ///< 1 once it has let go
  report_force_size = 9,  ///< applied force alone, body weights
  report_count = 10,
};

/// Numbers of each character in the display's `figures` (joint values).
enum Figure : std::size_t {
  figure_state = 0,   ///< 0 tracking, 1 let go, 2 passive
  figure_force = 1,   ///< 3, N
  figure_moment = 4,  ///< 3, N m
  figure_ratio = 7,   ///< assist / cap
  figure_weight = 8,  ///< N
  figure_centre = 9,  ///< 3, m: centre of mass
  figure_count = 12,
};

/// Numbers of the naturalness measures (joint values), over the time since the start.
enum Measure : std::size_t {
  measure_tracking = 0,         ///< rms angle between joints and reference, degrees, while it tracks
  measure_assist = 1,           ///< rms root assist, body weights (moments count at the lever of the root's height)
  measure_assist_force = 2,     ///< rms force of the root assist alone, body weights
  measure_assist_max = 3,       ///< greatest root assist, body weights
  measure_skate = 4,            ///< mean path of a standing foot, cm
  measure_skate_worst = 5,      ///< cm
  measure_penetration = 6,      ///< worst depth in the ground, mm
  measure_penetration_rms = 7,  ///< mm
  measure_fell = 8,             ///< 1 once the root is far below its reference, or lies
  measure_let_go_time = 9,      ///< s, -1: it has not let go
  measure_feet = 10,            ///< feet that bear on the ground now; -1: it has none
  measure_count = 11,
};

}  // namespace ugoki::lsi
