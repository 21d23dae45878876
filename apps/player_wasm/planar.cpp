// Converts drawn pictures for video coders, in the pages that draw them (web/src/player/planar.ts).

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

#ifdef __wasm__
#define UGOKI_EXPORT(name) extern "C" __attribute__((export_name(#name), used))
#else
#define UGOKI_EXPORT(name) extern "C"  // the tests compile this file for the processor
#endif

namespace {

static_assert(std::endian::native == std::endian::little, "red is the lowest byte of a pixel");

// Fixed-point numbers with 16 bits behind the point.
constexpr double one = 1 << 16;
constexpr std::int32_t fixed(double value) { return static_cast<std::int32_t>(value * one + (value < 0 ? -0.5 : 0.5)); }

/// Weights of red, green and blue in luma, ITU-R BT.709 item 3.2.
constexpr double weights[3] = {0.2126, 0.7152, 0.0722};
struct Row {
  std::int32_t red, green, blue, offset;
};
/// Row of the matrix for a sum of `pixels` pixels, with the offset that rounds. `range`: levels of the result for a full change.
constexpr Row row(double range, double pixels, double red, double green, double blue, double offset) {
  const double scale = range / 255 / pixels;
  return {fixed(red * scale), fixed(green * scale), fixed(blue * scale), fixed(offset + 0.5)};
}
constexpr Row luma = row(219, 1, weights[0], weights[1], weights[2], 16);
constexpr Row cb = row(224 / 1.8556, 4, -weights[0], -weights[1], 1 - weights[2], 128);
constexpr Row cr = row(224 / 1.5748, 4, 1 - weights[0], -weights[1], -weights[2], 128);

std::uint8_t apply(const Row& m, std::uint32_t red, std::uint32_t green, std::uint32_t blue) {
  const std::uint32_t sum = static_cast<std::uint32_t>(m.red) * red + static_cast<std::uint32_t>(m.green) * green +
                            static_cast<std::uint32_t>(m.blue) * blue + static_cast<std::uint32_t>(m.offset);
  return static_cast<std::uint8_t>(sum >> 16);
}

// The loops are simple, so that the compiler computes several pixels at once.
void luma_row(const std::uint32_t* __restrict pixels, std::uint32_t width, std::uint8_t* __restrict out) {
  for (std::uint32_t x = 0; x < width; ++x) out[x] = apply(luma, pixels[x] & 255, (pixels[x] >> 8) & 255, (pixels[x] >> 16) & 255);
}

void chroma_row(const std::uint32_t* __restrict upper, const std::uint32_t* __restrict lower, std::uint32_t half,
                std::uint8_t* __restrict out_cb, std::uint8_t* __restrict out_cr) {
  constexpr std::uint32_t outer = 0x00ff00ff;  // red and blue, each with room for a sum of four
  for (std::uint32_t x = 0; x < half; ++x) {
    const std::uint32_t a = upper[2 * x], b = upper[2 * x + 1], c = lower[2 * x], d = lower[2 * x + 1];
    const std::uint32_t red_blue = (a & outer) + (b & outer) + (c & outer) + (d & outer);
    const std::uint32_t green = ((a >> 8) & 255) + ((b >> 8) & 255) + ((c >> 8) & 255) + ((d >> 8) & 255);
    out_cb[x] = apply(cb, red_blue & 0xffff, green, red_blue >> 16);
    out_cr[x] = apply(cr, red_blue & 0xffff, green, red_blue >> 16);
  }
}

}  // namespace

/// Converts a picture by the matrix of ITU-R BT.709 with limited range (luma 16 ... 235, chroma 16 ... 240). Chroma is the mean of 2 x 2
/// pixels, at their centre.
/// @param rgba [4 * width * height] rows from the bottom to the top, as WebGL reads them
/// @param width, height px; even
/// @param out [3 * width * height / 2, out] luma, then Cb, then Cr, each row by row from the top; must not overlap `rgba`
UGOKI_EXPORT(ugoki_planar)
void ugoki_planar(const std::uint8_t* rgba, std::uint32_t width, std::uint32_t height, std::uint8_t* out) {
  const auto* pixels = reinterpret_cast<const std::uint32_t*>(rgba);
  const std::size_t size = std::size_t{width} * height;
  const std::uint32_t half = width / 2;
  // Luma and chroma of two rows follow each other, because the rows are then still in the processor's cache.
  for (std::uint32_t y = 0; y < height; y += 2) {
    const std::uint32_t* upper = pixels + std::size_t{height - 1 - y} * width;
    const std::uint32_t* lower = upper - width;
    std::uint8_t* const luma_at = out + std::size_t{y} * width;
    luma_row(upper, width, luma_at);
    luma_row(lower, width, luma_at + width);
    std::uint8_t* const cb_at = out + size + std::size_t{y / 2} * half;
    chroma_row(upper, lower, half, cb_at, cb_at + size / 4);
  }
}

/// Packs a picture: a drawn picture is smooth, so most of its bytes are those of the row above, and messages are six times shorter.
/// The result is a sequence of [u16 e][u16 n][8 * n bytes], little-endian: e blocks of 8 bytes are equal to those `row` bytes before, the
/// next n follow. The last size % 8 bytes follow the sequence. apps/ugoki/packed_picture.h unpacks it.
/// @param row bytes; the blocks of the first row are never equal
/// @param out [size + size / 100'000 + 16, out] @return number of bytes of `out`
UGOKI_EXPORT(ugoki_pack)
std::uint32_t ugoki_pack(const std::uint8_t* picture, std::uint32_t row, std::uint32_t size, std::uint8_t* out) {
  constexpr std::uint32_t block = 8, longest = 0xffff;
  std::uint8_t* end = out;
  const auto equal = [&](std::uint32_t at) { return at >= row && std::memcmp(picture + at, picture + at - row, block) == 0; };
  const auto write_count = [](std::uint8_t* to, std::uint32_t count) {
    to[0] = static_cast<std::uint8_t>(count);
    to[1] = static_cast<std::uint8_t>(count >> 8);
  };
  std::uint32_t at = 0;
  while (at + block <= size) {
    std::uint32_t count = 0;
    for (; count < longest && at + block <= size && equal(at); at += block) ++count;
    write_count(end, count);
    std::uint8_t* const counted = end + 2;
    end += 4;
    for (count = 0; count < longest && at + block <= size && !equal(at); at += block, end += block, ++count)
      std::memcpy(end, picture + at, block);
    write_count(counted, count);
  }
  for (; at < size; ++at) *end++ = picture[at];
  return static_cast<std::uint32_t>(end - out);
}
