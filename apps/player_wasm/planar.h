#pragma once
// Converts drawn pictures for video coders.

#include <cstdint>

namespace ugoki::player_wasm {

/// Converts a picture by the matrix of ITU-R BT.709 with limited range (luma 16 ... 235, chroma 16 ... 240). Chroma is the mean of 2 x 2
/// pixels, at their centre.
/// @param rgba [4 * width * height] rows from the bottom to the top, as WebGL reads them
/// @param width, height px; even
/// @param out [3 * width * height / 2, out] luma, then Cb, then Cr, each row by row from the top; must not overlap `rgba`
void to_planar(const std::uint8_t* rgba, std::uint32_t width, std::uint32_t height, std::uint8_t* out);

}  // namespace ugoki::player_wasm
