#pragma once
// The form in which pages send pictures for videos.

#include <cstddef>
#include <string>
#include <string_view>

namespace ugoki::cli {

/// Unpacks what ugoki_pack() (apps/player_wasm/planar.cpp) has packed.
/// @param row bytes, as when it was packed @param size bytes of the picture @return the picture; empty if `packed` is none of this size
[[nodiscard]] std::string unpacked_picture(std::string_view packed, std::size_t row, std::size_t size);

}  // namespace ugoki::cli
