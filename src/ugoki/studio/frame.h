#pragma once
// The head of binary display frames (docs/studio-protocol.md, written by content::encode_frame): what the interpreter knows
// and the player does not.

#include <cstddef>
#include <cstdint>
#include <span>

namespace ugoki::studio {

/// Sets the head's time, frame number and flags; "grab active" is kept.
void set_frame_marks(std::span<std::byte> frame, double time, std::uint32_t number, std::uint32_t flags);
[[nodiscard]] double frame_time(std::span<const std::byte> frame);

}  // namespace ugoki::studio
