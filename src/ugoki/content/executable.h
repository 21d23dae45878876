#pragma once
// Executable data in memory, the input of the player. All references are resolved: indices instead of ids, clips placed in the world,
// angles in radians. ugx.h describes the file format.

#include <span>
#include <string>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/content/scenario.h"
#include "ugoki/mechanism/mechanism.h"
#include "ugoki/motion/clip.h"
#include "ugoki/motion/motion.h"

namespace ugoki::content {

/// Limits of executable data. They prevent that a file of unknown origin exhausts memory, or keeps the player busy for minutes with one
/// step. Data beyond a limit are refused; documents of the studio are far below all limits.
struct ExecutableLimits {
  static constexpr double length = 1e4;           ///< m: sizes of shapes, and positions of shapes, joints and centres of mass
  static constexpr double mass = 1e9;             ///< kg, of a link
  static constexpr std::size_t links = 20'000;    ///< of all characters together
  static constexpr std::size_t shapes = 100'000;  ///< of all characters together
};

struct ExecutableClip {
  std::string id;
  int motion = 0;  ///< index into Executable::motions
  Clip clip;       ///< placed in the world
};

struct ExecutableCharacter {
  std::string id, name;
  std::string color;  ///< "#rrggbb"
  ScenarioMaterial material;
  int mechanism = 0;  ///< index into Executable::mechanisms
  MechanismPtr own;   ///< the mechanism at the character's place if its root is fixed, and with the springs of the secondary motion;
                      ///< null: as in Executable::mechanisms
  ScenarioControl control;
  Placement placement;                ///< planar pose in the world at the start; m, heading in rad
  std::vector<double> q0;             ///< [nq] position coordinates at time 0
  std::vector<ExecutableClip> track;  ///< sorted by start; may be empty
  std::vector<ExecutableClip> moves;  ///< motions that rules play, in the order of the rules, whose ids they have; start is 0
};

struct ExecutableEvent {
  std::string id;
  EventType type = EventType::push;
  double time = 0;                  ///< s, time at which the event begins
  int character = 0;                ///< index into Executable::characters
  double duration = 0;              ///< s (push, pull)
  int link = 0;                     ///< index of the link (push, pull, grab, release)
  Vec3 force;                       ///< N, at the link's centre of mass (push)
  PushAxes axes = PushAxes::world;  ///< of `force` (push)
  Vec3 from, velocity, spin;        ///< position (m), velocity (m/s) and angular velocity (rad/s) of the thrown root, world (throw)
  ScenarioGrip grip;                ///< (grab)
  Vec3 point;                       ///< m, pulled point in the frame of the link (pull)
  std::vector<PullTarget> path;     ///< (pull)
  int other = -1, other_link = -1;  ///< character and link that are gripped; -1: the world (grab)
};

struct Executable {
  std::string name;
  double duration = 0;           ///< s
  double frame_rate = 60;        ///< display frames per second
  double step = 0.002;           ///< s, simulation step
  Vec3 gravity = {0, 0, -9.81};  ///< m/s^2, world
  ScenarioGround ground;
  std::vector<std::string> mechanism_ids, motion_ids;  ///< ids of the entries of `mechanisms` and `motions`
  std::vector<MechanismPtr> mechanisms;
  std::vector<MotionPtr> motions;
  std::vector<ExecutableCharacter> characters;
  std::vector<ExecutableEvent> events;  ///< sorted by time
  ScenarioCamera camera;
  std::vector<FilmCamera> cameras;
  std::vector<FilmShot> shots;
  ScenarioLook look;
  std::vector<ScenarioVariable> variables;  ///< those that viewers show
  std::string circuit;                      ///< JSON, docs/circuit.md

  /// The mechanism with which the character is simulated.
  [[nodiscard]] const MechanismPtr& mechanism_of(const ExecutableCharacter& c) const {
    return c.own ? c.own : mechanisms[static_cast<std::size_t>(c.mechanism)];
  }
};

/// Reads executable data and checks them completely: file structure, document, indices, values, and that the motions fit the mechanisms.
/// @param name name of the data in messages, usually the file's name
[[nodiscard]] Result<Executable> read_executable(std::span<const std::byte> bytes, std::string_view name);

}  // namespace ugoki::content
