// Tests: pictures are converted to the planar form of video coders as ITU-R BT.709 specifies.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <vector>

extern "C" void ugoki_planar(const std::uint8_t* rgba, std::uint32_t width, std::uint32_t height, std::uint8_t* out);

namespace ugoki::player_wasm {
namespace {

TEST(Planar, ValuesAreThoseOfBt709InLimitedRangeWithRowsFromTheTop) {
  constexpr std::uint32_t width = 38, height = 6;  // no multiple of the number of pixels that a processor converts at once
  std::vector<std::uint32_t> pixels(width * height);
  std::mt19937 random(1);
  for (std::uint32_t& p : pixels)
    for (int k = 0; k < 4; ++k) p = (p << 8) | std::array{0u, 255u, static_cast<std::uint32_t>(random() & 255)}[random() % 3];
  std::vector<std::uint8_t> out(width * height * 3 / 2 + 1, 7);
  ugoki_planar(reinterpret_cast<const std::uint8_t*>(pixels.data()), width, height, out.data());
  const auto color = [&](std::uint32_t x, std::uint32_t y) {
    const std::uint32_t p = pixels[(height - 1 - y) * width + x];
    return std::array{(p & 255) / 255.0, ((p >> 8) & 255) / 255.0, ((p >> 16) & 255) / 255.0};
  };
  const auto luma = [](const std::array<double, 3>& c) { return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2]; };
  constexpr double limit = 0.51;  // half a level of rounding, and the error of the 16-bit coefficients
  for (std::uint32_t y = 0; y < height; ++y)
    for (std::uint32_t x = 0; x < width; ++x) EXPECT_NEAR(out[y * width + x], 16 + 219 * luma(color(x, y)), limit) << x << ' ' << y;
  for (std::uint32_t y = 0; y < height / 2; ++y)
    for (std::uint32_t x = 0; x < width / 2; ++x) {
      std::array<double, 3> mean{};
      for (std::uint32_t i = 0; i < 4; ++i)
        for (std::size_t k = 0; k < 3; ++k) mean[k] += color(2 * x + i % 2, 2 * y + i / 2)[k] / 4;
      const std::size_t at = width * height + y * width / 2 + x;
      EXPECT_NEAR(out[at], 128 + 224 * (mean[2] - luma(mean)) / 1.8556, limit) << x << ' ' << y;
      EXPECT_NEAR(out[at + width * height / 4], 128 + 224 * (mean[0] - luma(mean)) / 1.5748, limit) << x << ' ' << y;
    }
  EXPECT_EQ(out.back(), 7) << "written beyond the picture";
}

}  // namespace
}  // namespace ugoki::player_wasm
