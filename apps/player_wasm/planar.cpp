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

using Pixels = std::uint32_t __attribute__((vector_size(16)));  // 4 pixels
using Pairs = std::int16_t __attribute__((vector_size(16)));    // two channels of 4 pixels: red and blue, or green and alpha
using Sums = std::int32_t __attribute__((vector_size(16)));
using Bytes = std::uint8_t __attribute__((vector_size(16)));

constexpr std::uint32_t at_once = 16;        // pixels of a row
constexpr std::uint32_t outer = 0x00ff00ff;  // the first and third byte of a pixel, each with room for a sum of four

/// Sum of both products of each pair, one instruction of processors.
Sums dot(Pairs a, Pairs b) {
#if defined(__wasm_simd128__)
  return __builtin_wasm_dot_s_i32x4_i16x8(a, b);
#elif defined(__SSE2__)
  return __builtin_ia32_pmaddwd128(a, b);
#else
  Sums out{};
  for (int i = 0; i < 4; ++i) out[i] = a[2 * i] * b[2 * i] + a[2 * i + 1] * b[2 * i + 1];
  return out;
#endif
}

/// Row of the matrix for sums of pixels as fixed-point numbers with 16 bits, with the offset that rounds.
struct Row {
  std::int16_t red, green, blue;
  std::int32_t offset;
  int shift;  ///< number of bits behind the point
};
/// Weights of red, green and blue in luma, ITU-R BT.709 item 3.2.
constexpr double weights[3] = {0.2126, 0.7152, 0.0722};
/// `range`: levels of the result for a full change. The sums are of `pixels` pixels.
constexpr Row row(double range, double pixels, double red, double green, double blue, double offset, int shift) {
  const double one = 1 << shift, scale = one * range / 255 / pixels;
  const auto rounded = [](double value) { return static_cast<std::int32_t>(value + (value < 0 ? -0.5 : 0.5)); };
  const auto weight = [&](double value) { return static_cast<std::int16_t>(rounded(value * scale)); };
  return {weight(red), weight(green), weight(blue), rounded((offset + 0.5) * one), shift};
}
// The largest number of bits with which all weights are below 2^15.
constexpr Row luma = row(219, 1, weights[0], weights[1], weights[2], 16, 15);
constexpr Row cb = row(224 / 1.8556, 4, -weights[0], -weights[1], 1 - weights[2], 128, 18);
constexpr Row cr = row(224 / 1.5748, 4, 1 - weights[0], -weights[1], -weights[2], 128, 18);

template <const Row& m>
Sums apply(Pairs red_blue, Pairs green_alpha) {
  constexpr Pairs of_red_blue = {m.red, m.blue, m.red, m.blue, m.red, m.blue, m.red, m.blue};
  constexpr Pairs of_green = {m.green, 0, m.green, 0, m.green, 0, m.green, 0};
  return (dot(red_blue, of_red_blue) + dot(green_alpha, of_green) + m.offset) >> m.shift;
}
template <const Row& m>
std::uint8_t apply(std::uint32_t red, std::uint32_t green, std::uint32_t blue) {
  const std::int32_t sum = m.red * static_cast<std::int32_t>(red) + m.green * static_cast<std::int32_t>(green) +
                           m.blue * static_cast<std::int32_t>(blue) + m.offset;
  return static_cast<std::uint8_t>(sum >> m.shift);
}

template <class T, class From>
T load(const From* from) {
  T out;
  std::memcpy(&out, from, sizeof out);
  return out;
}
/// The lowest byte of each of the 8 sums, in the first half of the result.
Bytes narrowed(Sums a, Sums b) {
  return __builtin_shufflevector(reinterpret_cast<Bytes>(a), reinterpret_cast<Bytes>(b), 0, 4, 8, 12, 16, 20, 24, 28, 0, 4, 8, 12, 16, 20,
                                 24, 28);
}

/// Luma of `at_once` pixels.
void luma_of(const Pixels (&pixels)[4], std::uint8_t* out) {
  Sums y[4];
  for (int i = 0; i < 4; ++i)
    y[i] = apply<luma>(reinterpret_cast<Pairs>(pixels[i] & outer), reinterpret_cast<Pairs>((pixels[i] >> 8) & outer));
  const Bytes all =
      __builtin_shufflevector(narrowed(y[0], y[1]), narrowed(y[2], y[3]), 0, 1, 2, 3, 4, 5, 6, 7, 16, 17, 18, 19, 20, 21, 22, 23);
  std::memcpy(out, &all, sizeof all);
}

/// Sums of neighbours: two channels of 8 pixels become those of 4 blocks.
Pairs joined(Pixels left, Pixels right) {
  return reinterpret_cast<Pairs>(__builtin_shufflevector(left, right, 0, 2, 4, 6) + __builtin_shufflevector(left, right, 1, 3, 5, 7));
}

/// Two rows of pixels: luma of both, and chroma of their blocks of 2 x 2 pixels.
void convert_rows(const std::uint32_t* upper, const std::uint32_t* lower, std::uint32_t width, std::uint8_t* upper_out,
                  std::uint8_t* lower_out, std::uint8_t* cb_out, std::uint8_t* cr_out) {
  std::uint32_t x = 0;
  for (; x + at_once <= width; x += at_once) {
    Pixels a[4], b[4], red_blue[4], green_alpha[4];
    for (int i = 0; i < 4; ++i) {
      a[i] = load<Pixels>(upper + x + 4 * i);
      b[i] = load<Pixels>(lower + x + 4 * i);
      red_blue[i] = (a[i] & outer) + (b[i] & outer);
      green_alpha[i] = ((a[i] >> 8) & outer) + ((b[i] >> 8) & outer);
    }
    luma_of(a, upper_out + x);
    luma_of(b, lower_out + x);
    const Pairs rb[2] = {joined(red_blue[0], red_blue[1]), joined(red_blue[2], red_blue[3])};
    const Pairs ga[2] = {joined(green_alpha[0], green_alpha[1]), joined(green_alpha[2], green_alpha[3])};
    const Bytes blue = narrowed(apply<cb>(rb[0], ga[0]), apply<cb>(rb[1], ga[1]));
    const Bytes red = narrowed(apply<cr>(rb[0], ga[0]), apply<cr>(rb[1], ga[1]));
    std::memcpy(cb_out + x / 2, &blue, at_once / 2);
    std::memcpy(cr_out + x / 2, &red, at_once / 2);
  }
  for (; x < width; x += 2) {
    std::uint32_t red = 0, green = 0, blue = 0;
    const auto take = [&](std::uint32_t pixel, std::uint8_t* out) {
      const std::uint32_t r = pixel & 255, g = (pixel >> 8) & 255, b = (pixel >> 16) & 255;
      *out = apply<luma>(r, g, b);
      red += r;
      green += g;
      blue += b;
    };
    for (std::uint32_t i = x; i < x + 2; ++i) {
      take(upper[i], upper_out + i);
      take(lower[i], lower_out + i);
    }
    cb_out[x / 2] = apply<cb>(red, green, blue);
    cr_out[x / 2] = apply<cr>(red, green, blue);
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
  for (std::uint32_t y = 0; y < height; y += 2) {
    const std::uint32_t* upper = pixels + std::size_t{height - 1 - y} * width;
    std::uint8_t* const luma_at = out + std::size_t{y} * width;
    std::uint8_t* const cb_at = out + size + std::size_t{y / 2} * half;
    convert_rows(upper, upper - width, width, luma_at, luma_at + width, cb_at, cb_at + size / 4);
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
