#pragma once
// Resources that the standard LSIs (function blocks) request while a circuit is built: characters, their editing tracks, scheduled events.

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "ugoki/base/executor.h"
#include "ugoki/circuit/resources.h"
#include "ugoki/collision/contact_point.h"
#include "ugoki/lsi/payload.h"
#include "ugoki/lsi/tick_kinematics.h"
#include "ugoki/mechanism/mechanism.h"
#include "ugoki/motion/clip.h"

namespace ugoki::lsi {

class TrackSampler;

/// A clip of an editing track, and its motion.
struct TrackClip {
  Clip clip;
  MotionPtr motion;
};

/// A character as the host program specifies it.
struct CharacterSpec {
  std::string id;
  MechanismPtr mechanism;
  std::vector<TrackClip> track;  ///< sorted by start; may be empty
  std::vector<TrackClip> moves;  ///< clips that rules play instead of the track (LSI `motion choice`); their start is 0
  std::vector<double> q0;        ///< [nq] position at time 0 of a character without a track; empty: neutral position
  bool as_recorded = false;      ///< the track's motions are not filtered, and the first frame is not raised above the ground
  MotionPtr torques;             ///< motion whose torques drive the character from its first state (LSI `motion torques`); null: none
};

/// A character as LSIs see it.
struct Character {
  static constexpr const char* resource_kind = "character";
  std::string id;
  int index = 0;  ///< index of the character in the world; the subject of its payloads (circuit::Shape::subject)
  MechanismPtr mechanism;
  std::shared_ptr<const TrackSampler> track;  ///< null: the character has no track
  std::shared_ptr<const TrackSampler> moves;  ///< the clips that rules play; null: none
  MotionPtr torques;                          ///< motion whose torques drive the character; null: none
  std::vector<double> q0, v0;                 ///< [nq], [nv] position and velocity at time 0
  std::vector<int> feet;                      ///< indices of links, from find_feet
  std::vector<unsigned char> fixed;           ///< [links] 1: no joint with DOFs lies between the world and the link
  std::size_t q_offset = 0, v_offset = 0;     ///< index of the first number of q, and of v, in a state payload
  std::size_t first_link = 0;                 ///< index of the character's first link in the poses of the display LSI
};

/// An event of the scenario.
struct ScheduledEvent {
  EventRecord record;                              ///< record of kind push, grab, throwing, gripping or opening
  double time = 0;                                 ///< s, time at which the event begins
  double duration = 0;                             ///< s (push, grab)
  std::vector<std::pair<double, Vec3>> path = {};  ///< times since the begin, s, and targets of a grab, m; each holds until the next one
};

/// All characters and events of a piece of content. Provides itself and its characters as resources.
class World final : public circuit::Resources {
 public:
  static constexpr const char* resource_kind = "world";

  World(std::vector<CharacterSpec> characters, std::vector<ScheduledEvent> events, const Vec3& gravity, const collision::Ground& ground);

  [[nodiscard]] const void* find(std::string_view kind, std::string_view name) const override;

  [[nodiscard]] std::span<const Character> characters() const { return characters_; }
  [[nodiscard]] std::span<const ScheduledEvent> events() const { return events_; }
  [[nodiscard]] const Vec3& gravity() const { return gravity_; }
  [[nodiscard]] const collision::Ground& ground() const { return ground_; }
  [[nodiscard]] std::vector<MechanismPtr> mechanisms() const;
  /// True for the ground (character -1) and for links that cannot move, on which others stand as on the ground.
  [[nodiscard]] bool is_ground(int character, int link) const {
    return character < 0 || characters_[static_cast<std::size_t>(character)].fixed[static_cast<std::size_t>(link)] != 0;
  }
  /// The contact as one of the character `own` with the ground (body b) if it is one with the ground or with a link that cannot move;
  /// otherwise as it is.
  [[nodiscard]] collision::ContactPoint on_ground(const collision::ContactPoint& contact, int own) const;
  [[nodiscard]] std::size_t state_size() const { return state_size_; }  ///< total nq + nv over all characters
  [[nodiscard]] std::size_t link_count() const { return link_count_; }  ///< total number of links of all characters
  /// Number of elements of a state payload: state_size(), but at least 1.
  [[nodiscard]] std::uint32_t state_count() const { return payload_count(state_size_); }
  /// Number of elements of a payload for n values: payloads have at least 1 element.
  [[nodiscard]] static std::uint32_t payload_count(std::size_t n) { return n ? static_cast<std::uint32_t>(n) : 1; }
  /// Sets the threads on which LSIs compute systems in parallel; null: none. Results have the same bits. Call it before circuits are built.
  void set_executor(Executor* executor) { executor_ = executor; }
  [[nodiscard]] Executor* executor() const { return executor_; }
  /// Kinematics of all characters that LSIs share.
  [[nodiscard]] TickKinematics& kinematics() const { return *kinematics_; }
  /// Maximum number of records of a contacts payload: 8 for each shape (4 corners on the ground, and 4 other contacts), from 64 to 4096.
  [[nodiscard]] std::uint32_t contact_capacity() const { return contact_capacity_; }

 private:
  std::vector<Character> characters_;
  std::vector<ScheduledEvent> events_;
  Vec3 gravity_;
  collision::Ground ground_;
  Executor* executor_ = nullptr;
  std::unique_ptr<TickKinematics> kinematics_;
  std::size_t state_size_ = 0, link_count_ = 0;
  std::uint32_t contact_capacity_ = 64;
};

/// Returns a character's q and v in a state payload.
inline std::span<const double> q_of(const Character& c, const double* state) {
  return {state + c.q_offset, static_cast<std::size_t>(c.mechanism->nq())};
}
inline std::span<const double> v_of(const Character& c, const double* state) {
  return {state + c.v_offset, static_cast<std::size_t>(c.mechanism->nv())};
}
inline std::span<double> q_of(const Character& c, double* state) {
  return {state + c.q_offset, static_cast<std::size_t>(c.mechanism->nq())};
}
inline std::span<double> v_of(const Character& c, double* state) {
  return {state + c.v_offset, static_cast<std::size_t>(c.mechanism->nv())};
}

}  // namespace ugoki::lsi
