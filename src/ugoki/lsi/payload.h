#pragma once
// Payloads (data on wires) of the physical pin types, as the standard LSIs use them.

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <type_traits>

#include "ugoki/collision/contact_point.h"
#include "ugoki/naturalness/measure_list.h"
#include "ugoki/spatial/spatial.h"

namespace ugoki::lsi {

/// Kind of an event (pin type `event`), and the meaning of the vectors a, b, c of its record. All vectors are in world axes, unless stated
/// otherwise.
///   push     a: force at the link's centre of mass, N, in the axes that PushFlag selects; `duration`, s: set in the user's input, 0 in an
///            event for one tick
///   grab     a: point in the frame of the link, m; b: target, m
///   drag     b: new target of the grab, m                  (user's input only)
///   release  end of the grab                               (user's input only)
///   throwing of the root, a: position, m; b: velocity, m/s; c: angular velocity, rad/s
///   touch    a: contact point, m; b: impulse on the link in the first step, N s; c: indices of the other character (-1: ground) and link
///   parting  a: point at which the touch began, m; b: total impulse of the touch, N s; c: as in touch; `duration`, s: of the touch
///   gripping of a link (scenario and rules), a: gripping point in the frame of the link, m; b: target in the frame of the other link or in
///   the
///            world, m; c: indices of the other character (-1: the world) and link, and Grip flags; spare: limit of the force, N, and
///            reach, m. In the output `grips` of `dynamics`: a: force on the link, N; b: gripping point, m; c: other character, link, force
///            / limit; `duration`, s: since the grip was made; spare: gap, m, and moment on the link, N m
///   opening  end of the grips of a link                    (scenario and rules)
///   omitted  a: x: number of further touches and partings of the tick, for which the output has no room; the last record of the tick
enum class EventKind : std::uint32_t {
  none = 0,
  push = 1,
  grab = 2,
  drag = 3,
  release = 4,
  throwing = 5,
  touch = 6,
  parting = 7,
  omitted = 8,
  gripping = 9,
  opening = 10
};

/// Flags of an event of the kind push, in EventRecord::flags.
enum PushFlag : std::uint32_t {
  push_body_axes = 1  ///< the force is in the axes of the link and turns with it; otherwise in world axes
};

/// Flags of an event of the kind gripping, added to one number.
enum GripFlag : std::uint32_t {
  grip_rigid = 1,      ///< the orientation is held as well
  grip_has_target = 2  ///< b is given; otherwise the target is where the gripping point is at the event
};

struct EventRecord {
  EventKind kind = EventKind::none;
  std::uint32_t character = 0;  ///< index in the world
  std::int32_t link = 0;        ///< index in the mechanism
  std::uint32_t flags = 0;      ///< of a push: PushFlag; in the output `grips` of `dynamics`: GripFlag
  Vec3 a, b, c;
  double duration = 0;  ///< s
  double spare[4] = {0, 0, 0, 0};
};
static_assert(sizeof(EventRecord) == 128 && std::is_trivially_copyable_v<EventRecord>);

/// A contact (pin type `contacts`).
struct ContactRecord {
  collision::ContactPoint point;
  Vec3 force;  ///< N, on body a of the contact, world axes
  double spare = 0;
};
static_assert(sizeof(ContactRecord) == 128 && std::is_trivially_copyable_v<ContactRecord>);

/// Returns the used records of a payload that begins with their number; empty for a null payload.
template <class Record>
std::span<const Record> records(const void* payload) {
  if (!payload) return {};
  std::uint64_t count = 0;
  std::memcpy(&count, payload, sizeof count);
  return {reinterpret_cast<const Record*>(static_cast<const std::byte*>(payload) + sizeof count), static_cast<std::size_t>(count)};
}
/// Returns the memory for a payload's records; set_count sets the number of used records.
template <class Record>
Record* record_room(void* payload) {
  return reinterpret_cast<Record*>(static_cast<std::byte*>(payload) + sizeof(std::uint64_t));
}
inline void set_count(void* payload, std::uint64_t count) { std::memcpy(payload, &count, sizeof count); }

/// Indices into the output `report` (pin type `joint values`) of a motion control LSI. The report describes the root assist.
enum Report : std::size_t {
  report_force = 0,       ///< force: 3 entries, N, world axes
  report_moment = 3,      ///< moment: 3 entries, N m, world axes, about the origin of the root link
  report_ratio = 6,       ///< wanted assist / limit of the assist
  report_size = 7,        ///< applied assist in body weights; a moment is divided by the lever of the root assist
  report_released = 8,    ///< 1 after the character was released, otherwise 0
  report_force_size = 9,  ///< applied force alone, without moments, body weights
  report_count = 10,      ///< number of entries
};

/// Indices into the record of one character. The output `characters` of the display LSI (pin type `joint values`) has one record for each
/// character.
enum CharacterEntry : std::size_t {
  character_state = 0,         ///< 0: follows its reference, 1: released, 2: passive (has no motion control)
  character_force = 1,         ///< 3 entries: force of the root assist, N, world axes
  character_moment = 4,        ///< 3 entries: moment of the root assist, N m, world axes, about the origin of the root link
  character_ratio = 7,         ///< wanted assist / limit of the assist
  character_weight = 8,        ///< weight, N
  character_centre = 9,        ///< 3 entries: centre of mass, m, world
  character_entry_count = 12,  ///< number of entries
};

/// Indices into the naturalness measures of one character (pin type `joint values`): since the start, and of the present instant.
enum Measure : std::size_t {
  measure_tracking = 0,         ///< rms angle between joints and reference until the release, degrees
  measure_assist = 1,           ///< rms root assist in body weights; a moment is divided by the lever of the root assist
  measure_assist_force = 2,     ///< rms force of the root assist alone, body weights
  measure_assist_max = 3,       ///< maximum root assist, body weights
  measure_skate = 4,            ///< net slip of a foot in one stance (FootSlip), mean over all stances, cm
  measure_skate_worst = 5,      ///< net slip of a foot in one stance, maximum, cm
  measure_penetration = 6,      ///< maximum depth below the ground, mm
  measure_penetration_rms = 7,  ///< rms depth below the ground, mm
  measure_fell = 8,             ///< 1: the root was far below its reference, or tilted from the reference by more than 1 rad; else 0
  measure_release_time = 9,     ///< time of the release, s; -1: not released
  measure_feet = 10,            ///< number of feet that touch the ground now; -1: the character has no feet
  measure_tracking_now = 11,    ///< rms angle between joints and reference now, degrees; 0 after the release
  measure_assist_now = 12,      ///< root assist now, body weights; 0 after the release
  measure_slip_now = 13,        ///< net slip of the present stance (FootSlip), maximum over the standing feet, cm
  measure_depth_now = 14,       ///< maximum depth below the ground now, mm
  /// values of the whole run of all measures of naturalness/measure_list.h, in its order; negative: naturalness::reason_words()
  measure_totals = 15,
  measure_values = measure_totals + naturalness::measure_count,  ///< the same measures now; negative: no value
  measure_count = measure_values + naturalness::measure_count,   ///< number of entries
};

}  // namespace ugoki::lsi
