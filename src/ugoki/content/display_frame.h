#pragma once
// What a viewer needs of one moment, and its binary form (docs/studio-protocol.md, binary messages).

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "ugoki/spatial/spatial.h"

namespace ugoki::content {

enum class FigureState : std::uint32_t { tracking = 0, let_go = 1, passive = 2, edit = 3 };

/// Position [m] and rotation of a link in the world.
struct DisplayPose {
  Vec3 p;
  Quat r;
};

struct DisplayCharacter {
  FigureState state = FigureState::passive;
  Vec3 assist_force;        ///< N, world
  Vec3 assist_moment;       ///< N m, world, about the root link's origin
  double assist_ratio = 0;  ///< wanted assist / cap
  double weight = 0;        ///< N
  Vec3 centre_of_mass;      ///< m
  std::vector<DisplayPose> links;
};

struct DisplayContact {
  Vec3 point;   ///< m, world
  Vec3 force;   ///< N, world, on the link
  Vec3 normal;  ///< unit, world: towards the link
  int character = 0, link = 0;
};

struct DisplayFrame {
  double time = 0;  ///< s
  bool grabbed = false;
  Vec3 grab_point, grab_target;  ///< m, world
  std::vector<DisplayCharacter> characters;
  std::vector<DisplayContact> contacts;  ///< those that bear force
};

/// Bits of the frame's flags.
enum FrameFlag : std::uint32_t { frame_playing = 1, frame_simulate = 2, frame_live = 4, frame_grab = 8 };

/// The frame's bytes; frame_grab is added to `flags` while something is grabbed. Allocates only where `out` grows.
void encode_frame(const DisplayFrame& frame, std::uint32_t number, std::uint32_t flags, std::vector<std::byte>& out);

}  // namespace ugoki::content
