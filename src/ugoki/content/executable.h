#pragma once
// Executable data in memory: what the generator makes of a project and the player runs. Everything is resolved: indices
// instead of ids, clips laid on the floor, radians, the circuit as data. On disk: docs/files.md.

#include <span>
#include <string>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/mechanism/mechanism.h"
#include "ugoki/motion/clip.h"
#include "ugoki/motion/motion.h"

namespace ugoki::content {

struct ExecutableClip {
  std::string id;
  int motion = 0;      ///< index into Executable::motions
  Clip clip;           ///< placed
};

struct ExecutableCharacter {
  std::string id, name;
  std::string color;            ///< "#rrggbb"
  int mechanism = 0;            ///< index into Executable::mechanisms
  bool tracks = true;           ///< motion control follows the track; otherwise no drive torque
  double tracking = 1;          ///< factor on the gains
  double balance = 1;           ///< factor on the balance gains
  double assist_limit = 0.5;    ///< cap of the root-assist wrench, body weights
  bool let_go = true;           ///< beyond the cap the figure becomes a ragdoll; otherwise the wrench stays at the cap
  Placement place;              ///< where it stands at the start
  std::vector<double> q0;       ///< [nq] position at time 0
  std::vector<ExecutableClip> track;  ///< by start; may be empty
};

enum class EventType { push, throw_ };

struct ExecutableEvent {
  std::string id;
  EventType type = EventType::push;
  double time = 0;              ///< s
  int character = 0;            ///< index
  double duration = 0;          ///< s (push)
  int link = 0;                 ///< index of the link (push)
  Vec3 force;                   ///< N, world, at the link's centre of mass (push)
  Vec3 from, velocity, spin;    ///< m, m/s, rad/s, world (throw)
};

struct Executable {
  std::string name;
  double duration = 0;      ///< s
  double frame_rate = 60;   ///< display frames a second
  double step = 0.002;      ///< s
  Vec3 gravity = {0, 0, -9.81};
  double ground_height = 0, ground_friction = 0.9, ground_restitution = 0;
  std::vector<MechanismPtr> mechanisms;
  std::vector<MotionPtr> motions;
  std::vector<ExecutableCharacter> characters;
  std::vector<ExecutableEvent> events;  ///< by time
  std::string circuit;      ///< JSON, docs/circuit.md
  std::string camera;       ///< JSON object as in the scenario document
  std::string look;         ///< JSON object as in the scenario document
};

/// Lays everything out as a container. Equal data give equal bytes.
[[nodiscard]] std::vector<std::byte> write_executable(const Executable& executable);

/// Reads and checks: container, structure, every index, every number, motions against mechanisms.
/// @param name for messages, usually the file's name
[[nodiscard]] Result<Executable> read_executable(std::span<const std::byte> bytes, std::string_view name);

}  // namespace ugoki::content
