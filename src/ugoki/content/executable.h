#pragma once
// Executable data in memory: what the player runs. Everything is resolved: indices instead of ids, clips laid on the
// floor, radians, the circuit as data. Its form on disk is described in ugx.h.

#include <span>
#include <string>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/content/scenario.h"
#include "ugoki/mechanism/mechanism.h"
#include "ugoki/motion/clip.h"
#include "ugoki/motion/motion.h"

namespace ugoki::content {

struct ExecutableClip {
  std::string id;
  int motion = 0;  ///< index into Executable::motions
  Clip clip;       ///< placed
};

struct ExecutableCharacter {
  std::string id, name;
  std::string color;  ///< "#rrggbb"
  int mechanism = 0;  ///< index into Executable::mechanisms
  ScenarioControl control;
  Placement place;                    ///< where it stands at the start; heading in rad
  std::vector<double> q0;             ///< [nq] position at time 0
  std::vector<ExecutableClip> track;  ///< by start; may be empty
};

struct ExecutableEvent {
  std::string id;
  EventType type = EventType::push;
  double time = 0;            ///< s
  int character = 0;          ///< index
  double duration = 0;        ///< s (push)
  int link = 0;               ///< index of the link (push)
  Vec3 force;                 ///< N, world, at the link's centre of mass (push)
  Vec3 from, velocity, spin;  ///< m, m/s, rad/s, world (throw)
};

struct Executable {
  std::string name;
  double duration = 0;     ///< s
  double frame_rate = 60;  ///< display frames a second
  double step = 0.002;     ///< s
  Vec3 gravity = {0, 0, -9.81};
  ScenarioGround ground;
  std::vector<std::string> mechanism_ids, motion_ids;  ///< of the entries below
  std::vector<MechanismPtr> mechanisms;
  std::vector<MotionPtr> motions;
  std::vector<ExecutableCharacter> characters;
  std::vector<ExecutableEvent> events;  ///< by time
  ScenarioCamera camera;
  ScenarioLook look;
  std::string circuit;  ///< JSON, docs/circuit.md
};

/// Reads and checks everything: container, document, every index and number, motions against mechanisms.
/// @param name for messages, usually the file's name
[[nodiscard]] Result<Executable> read_executable(std::span<const std::byte> bytes, std::string_view name);

}  // namespace ugoki::content
