#pragma once
// Access to binary display frames (docs/studio-protocol.md). content::encode_frame writes them; the interpreter adds the header
// fields that the player does not know: time, frame number and flags.

#include <cstddef>
#include <cstdint>
#include <span>

namespace ugoki::studio {

/// Sets the header's time [s], frame number and flags; the flag "grab active" is kept.
void set_frame_header(std::span<std::byte> frame, double time, std::uint32_t number, std::uint32_t flags);
/// Interpolates the links' poses in `frame` towards `next`. s = 0: `frame` is unchanged; s = 1: it gets the poses of `next`.
/// Both frames must have the same characters and links; interpolation stops at the first difference.
void blend_poses(std::span<std::byte> frame, std::span<const std::byte> next, double s);
/// The frame's time, s.
[[nodiscard]] double frame_time(std::span<const std::byte> frame);

}  // namespace ugoki::studio
