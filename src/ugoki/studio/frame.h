#pragma once
// The head of binary display frames (docs/studio-protocol.md, written by content::encode_frame): what the interpreter knows
// and the player does not.

#include <cstddef>
#include <cstdint>
#include <span>

namespace ugoki::studio {

/// Sets the head's time, frame number and flags; "grab active" is kept.
void set_frame_marks(std::span<std::byte> frame, double time, std::uint32_t number, std::uint32_t flags);
/// Moves the links' poses in `frame` towards those in `next` (both of the same cast): s = 0 leaves them, s = 1 takes them over.
/// Does nothing where the two do not have the same form.
void blend_poses(std::span<std::byte> frame, std::span<const std::byte> next, double s);
[[nodiscard]] double frame_time(std::span<const std::byte> frame);

}  // namespace ugoki::studio
