#pragma once
// The scenario document: who moves where and when, in a piece of content. Form and meaning: docs/scenario.md.

#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/spatial/vec3.h"

namespace ugoki::content {

inline constexpr int scenario_version = 1;

/// A clip of a character's editing track, as people write it.
struct ScenarioClip {
  std::string id;
  std::string motion;  ///< id
  double start = 0;    ///< s on the track
  double length = 0;   ///< s on the track, above 0
  double offset = 0;   ///< s into the motion at the clip's start
  double speed = 1;    ///< s of motion per s of track
  double blend = 0.3;  ///< s of cross-fade from what played before
  bool loop = false;   ///< repeat a cyclic motion
  friend bool operator==(const ScenarioClip&, const ScenarioClip&) = default;
};

enum class ControlMode { track, passive };

struct ScenarioControl {
  ControlMode mode = ControlMode::track;
  double tracking = 1;        ///< factor on the tracking gains, 0 ... 2
  double balance = 1;         ///< factor on the balance gains, 0 ... 2
  double assist_limit = 0.5;  ///< cap of the root-assist wrench, body weights; beyond it the figure lets go
  friend bool operator==(const ScenarioControl&, const ScenarioControl&) = default;
};

struct ScenarioPlace {
  double x = 0, y = 0, z = 0;  ///< m
  double heading = 0;          ///< degrees about Z
  friend bool operator==(const ScenarioPlace&, const ScenarioPlace&) = default;
};

struct ScenarioCharacter {
  std::string id, name;
  std::string mechanism;  ///< id
  std::string color = "#e6e6ea";
  ScenarioPlace place;
  ScenarioControl control;
  std::vector<ScenarioClip> track;  ///< by start
  friend bool operator==(const ScenarioCharacter&, const ScenarioCharacter&) = default;
};

enum class EventType { push, throw_ };

struct ScenarioEvent {
  std::string id;
  EventType type = EventType::push;
  double time = 0;            ///< s
  std::string character;      ///< id
  double duration = 0.2;      ///< s (push)
  std::string link;           ///< name or label of the link (push)
  Vec3 force;                 ///< N, world (push)
  Vec3 from, velocity, spin;  ///< m, m/s, rad/s, world (throw)
  friend bool operator==(const ScenarioEvent&, const ScenarioEvent&) = default;
};

struct ScenarioGround {
  double height = 0, friction = 0.9, restitution = 0;
  friend bool operator==(const ScenarioGround&, const ScenarioGround&) = default;
};

struct ScenarioCamera {
  std::string follow;                      ///< character's id; empty: nobody
  double distance = 5;                     ///< m
  double azimuth = 0.7, elevation = 0.25;  ///< rad
  friend bool operator==(const ScenarioCamera&, const ScenarioCamera&) = default;
};

struct ScenarioLook {
  double light = 0.9;  ///< 0 ... 2
  std::string floor = "#2a2c31";
  friend bool operator==(const ScenarioLook&, const ScenarioLook&) = default;
};

struct Scenario {
  std::string name = "untitled";
  double duration = 10;    ///< s
  double frame_rate = 60;  ///< display frames a second
  double step = 0.002;     ///< s
  Vec3 gravity = {0, 0, -9.81};
  ScenarioGround ground;
  std::vector<ScenarioCharacter> characters;
  std::vector<ScenarioEvent> events;  ///< by time
  ScenarioCamera camera;
  ScenarioLook look;
  std::string circuit;  ///< JSON object of docs/circuit.md; empty: the default circuit
  friend bool operator==(const Scenario&, const Scenario&) = default;

  [[nodiscard]] const ScenarioCharacter* find_character(std::string_view id) const;
  [[nodiscard]] ScenarioCharacter* find_character(std::string_view id);
};

/// What a document's checks must know of the mechanisms and motions that it names.
struct MechanismFacts {
  std::string name;
  int nq = 0;
  bool free_root = false;                  ///< its first joint is floating: it can be placed and thrown
  std::vector<std::string> links, labels;  ///< names, and labels where they have one
};
struct MotionFacts {
  std::string name;
  double duration = 0;  ///< s
  int nq = 0;
  bool cyclic = false;
};
struct Catalogue {
  std::map<std::string, MechanismFacts, std::less<>> mechanisms;  ///< by id
  std::map<std::string, MotionFacts, std::less<>> motions;        ///< by id
};

/// Reads the JSON form. All problems are reported, each with its JSON path ("characters/0/track/2/speed") after `name`.
/// Fields that are absent have their defaults; unknown fields are refused. Clips and events are put in order.
[[nodiscard]] Result<Scenario> read_scenario(std::string_view json, std::string_view name);

/// The canonical JSON form, two blanks of indentation: equal documents give equal text.
[[nodiscard]] std::string write_scenario(const Scenario& scenario);

/// Problems of the whole document: ranges, ids, and with `catalogue` everything that it names.
[[nodiscard]] Error check_scenario(const Scenario& scenario, const Catalogue* catalogue = nullptr, std::string_view name = "scenario");

/// 1 ... 40 letters, digits, '-', '_', '.'; ids of mechanisms and motions at most 21, so that they name sections of *.ugx.
[[nodiscard]] bool is_id(std::string_view text, std::size_t max_size = 40);
inline constexpr std::size_t max_resource_id = 21;

/// Puts clips in order of start and events in order of time (equal ones by id).
void put_in_order(Scenario& scenario);

}  // namespace ugoki::content
