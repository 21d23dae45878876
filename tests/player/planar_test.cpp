// Tests: pictures are converted to the planar form of video coders as ITU-R BT.709 specifies, and come back from their packed form.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "../../apps/ugoki/packed_picture.h"

extern "C" std::uint32_t ugoki_pack(const std::uint8_t* picture, std::uint32_t row, std::uint32_t size, std::uint8_t* out);
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

std::string packed(const std::string& picture, std::size_t row) {
  std::string out(picture.size() + picture.size() / 100'000 + 17, 7);
  const auto* begin = reinterpret_cast<const std::uint8_t*>(picture.data());
  out.resize(ugoki_pack(begin, static_cast<std::uint32_t>(row), static_cast<std::uint32_t>(picture.size()),
                        reinterpret_cast<std::uint8_t*>(out.data())));
  EXPECT_LE(out.size(), picture.size() + picture.size() / 100'000 + 16) << "written beyond the memory";
  return out;
}

TEST(PackedPicture, PicturesOfAllKindsComeBackAndSmoothOnesAreShort) {
  std::mt19937 random(1);
  for (const std::size_t row : {2u, 6u, 38u, 1920u})
    for (const std::size_t rows : {3u, 9u, 1001u})
      for (const int noise : {0, 1, 30, 256}) {  // of 256 bytes that differ from the one above
        std::string picture(row * rows, 0);
        for (std::size_t i = 0; i < picture.size(); ++i)
          picture[i] = i < row || static_cast<int>(random() % 256) < noise ? static_cast<char>(random()) : picture[i - row];
        const std::string small = packed(picture, row);
        ASSERT_EQ(cli::unpacked_picture(small, row, picture.size()), picture) << row << " x " << rows << ", noise " << noise;
        if (noise == 0 && rows > 1000 && row >= 38) EXPECT_LT(small.size(), picture.size() / 100);
      }
}

TEST(PackedPicture, DamagedOnesAreRefused) {
  std::mt19937 random(2);
  std::string picture(38 * 9, 0);
  for (std::size_t i = 0; i < picture.size(); ++i)
    picture[i] = i < 38 || random() % 30 == 0 ? static_cast<char>(random()) : picture[i - 38];
  const std::string good = packed(picture, 38);
  for (std::size_t n = 0; n < good.size(); ++n) EXPECT_EQ(cli::unpacked_picture(good.substr(0, n), 38, picture.size()), "") << n;
  EXPECT_EQ(cli::unpacked_picture(good + "x", 38, picture.size()), "");
  EXPECT_EQ(cli::unpacked_picture(std::string("\1\0\0\0", 4), 38, picture.size()), "") << "equal to a row before the first";
  for (int i = 0; i < 20'000; ++i) {
    std::string bad = good;
    for (int k = 0; k < 3; ++k) bad[random() % bad.size()] = static_cast<char>(random());
    const std::string made = cli::unpacked_picture(bad, 38, picture.size());
    EXPECT_TRUE(made.empty() || made.size() == picture.size());
  }
}

}  // namespace
}  // namespace ugoki::player_wasm
