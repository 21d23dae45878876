#pragma once
// The resources that the standard LSIs ask for while a circuit is built: who is there, what they play, what will happen.

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "ugoki/circuit/resources.h"
#include "ugoki/collision/contact_point.h"
#include "ugoki/lsi/payload.h"
#include "ugoki/mechanism/mechanism.h"
#include "ugoki/motion/clip.h"

namespace ugoki::lsi {

class TrackSampler;

/// A clip of an editing track, laid on the floor.
struct TrackClip {
  Clip clip;
  MotionPtr motion;
};

/// As the host gives it.
struct CharacterSpec {
  std::string id;
  MechanismPtr mechanism;
  std::vector<TrackClip> track;  ///< by start; may be empty
  std::vector<double> q0;        ///< [nq] position at time 0 of a character without track
};

/// As LSIs see it.
struct Character {
  static constexpr const char* resource_kind = "character";
  std::string id;
  int index = 0;  ///< in the world; the subject of its payloads
  MechanismPtr mechanism;
  std::shared_ptr<const TrackSampler> track;  ///< null: nothing to follow
  std::vector<double> q0, v0;                 ///< [nq], [nv] at time 0
  std::vector<int> feet;                      ///< links, as find_feet gives them
  std::size_t q_offset = 0, v_offset = 0;     ///< of its q and v in a state payload
  std::size_t first_link = 0;                 ///< in the display's poses
};

/// Something that the scenario lets happen.
struct ScheduledEvent {
  EventRecord record;   ///< push or throwing
  double time = 0;      ///< s
  double duration = 0;  ///< s (push)
};

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
  [[nodiscard]] std::size_t state_size() const { return state_size_; }  ///< numbers of all q and v
  [[nodiscard]] std::size_t link_count() const { return link_count_; }  ///< of all characters
  /// Numbers in a state payload: those of state_size(), and one where there is nobody.
  [[nodiscard]] std::uint32_t state_count() const { return payload_count(state_size_); }
  /// Elements of a payload of n things; payloads have at least one.
  [[nodiscard]] static std::uint32_t payload_count(std::size_t n) { return n ? static_cast<std::uint32_t>(n) : 1; }
  /// Records that a contacts payload has room for: every corner of every shape on the ground, and as many again.
  [[nodiscard]] std::uint32_t contact_capacity() const { return contact_capacity_; }

 private:
  std::vector<Character> characters_;
  std::vector<ScheduledEvent> events_;
  Vec3 gravity_;
  collision::Ground ground_;
  std::size_t state_size_ = 0, link_count_ = 0;
  std::uint32_t contact_capacity_ = 64;
};

/// A character's q and v in a state payload.
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
