#pragma once
// Display frame: the data that a viewer needs to show the content at one time, and its binary form
// (docs/studio-protocol.md, binary messages).

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "ugoki/spatial/spatial.h"

namespace ugoki::content {

/// State of a character. tracking: it follows its track. released: control has released it, because it fell or lost its reference.
/// passive: it is not controlled. edit: it is posed from its track, without physics.
enum class CharacterState : std::uint32_t { tracking = 0, released = 1, passive = 2, edit = 3 };

/// Position [m] and rotation of a link in the world.
struct DisplayPose {
  Vec3 p;
  Quat r;
};

struct DisplayCharacter {
  CharacterState state = CharacterState::passive;
  Vec3 assist_force;        ///< N, world
  Vec3 assist_moment;       ///< N m, world, about the root link's origin
  double assist_ratio = 0;  ///< root assist that control requested, divided by its cap
  double weight = 0;        ///< N, weight of the character
  Vec3 centre_of_mass;      ///< m, world
  std::vector<DisplayPose> links;
};

struct DisplayContact {
  Vec3 point;                   ///< m, world: contact point
  Vec3 force;                   ///< N, world: force on the link
  Vec3 normal;                  ///< unit vector, world; points towards the link
  int character = 0, link = 0;  ///< index of the character, and of the link in it
};

struct DisplayFrame {
  double time = 0;  ///< s, time of the frame
  bool grabbed = false;
  Vec3 grab_point, grab_target;  ///< m, world: grabbed point, and target of the pull
  std::vector<DisplayCharacter> characters;
  std::vector<DisplayContact> contacts;  ///< only contacts whose force is not zero
};

/// Bits of the frame's flags.
enum FrameFlag : std::uint32_t { frame_playing = 1, frame_simulate = 2, frame_live = 4, frame_grab = 8 };

/// Writes the frame in its binary form to `out`. Adds frame_grab to `flags` if frame.grabbed is true. Allocates only if `out` must grow.
/// @param number frame number @param flags bits of FrameFlag
void encode_frame(const DisplayFrame& frame, std::uint32_t number, std::uint32_t flags, std::vector<std::byte>& out);

}  // namespace ugoki::content
