// Closest points that are appended to frames, compared with closed forms.

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "ugoki/content/display_frame.h"
#include "ugoki/samples/samples.h"
#include "ugoki/studio/closest_pairs.h"

namespace ugoki::studio {
namespace {

constexpr double radius = 0.11;  // m, radius of the sample's ball

std::vector<std::byte> frame_of(const std::vector<Vec3>& places) {
  content::DisplayFrame frame;
  for (const Vec3& p : places) {
    content::DisplayCharacter c;
    c.links = {{p, Quat{}}};
    frame.characters.push_back(c);
  }
  frame.contacts.push_back({{1, 2, 3}, {0, 0, 5}, {0, 0, 1}, 0, 0});
  std::vector<std::byte> bytes;
  content::encode_frame(frame, 7, 0, bytes);
  return bytes;
}

template <class T>
T at(std::span<const std::byte> bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

TEST(ClosestPairs, DistancesOfBallsMatchTheirCentres) {
  const std::vector<Vec3> places = {{0, 0, 1}, {1, 0, 1}, {0, 0, 1.15}, {9, 0, 0}};
  ClosestPairs pairs(std::vector<MechanismPtr>(places.size(), samples::make_ball()));
  const std::vector<std::byte> frame = frame_of(places);
  const std::span<const std::byte> out = pairs.append_to(frame);
  ASSERT_EQ(at<std::uint32_t>(out, 56), 3u) << "the fourth ball is farther away than max_distance";
  ASSERT_EQ(out.size(), frame.size() + 3 * 32);
  EXPECT_EQ(std::memcmp(out.data() + 64, frame.data() + 64, frame.size() - 64), 0);
  const struct {
    int a, b;
    double distance;
  } expected[] = {{0, 2, 0.15 - 2 * radius}, {0, 1, 1 - 2 * radius}, {1, 2, std::hypot(1, 0.15) - 2 * radius}};
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t p = frame.size() + 32 * i;
    EXPECT_EQ(at<std::uint32_t>(out, p + 28), static_cast<std::uint32_t>(expected[i].a << 16 | expected[i].b));
    EXPECT_NEAR(at<float>(out, p + 24), expected[i].distance, 1e-6);
    double gap = 0;
    for (std::size_t k = 0; k < 3; ++k) gap += std::pow(at<float>(out, p + 4 * k) - at<float>(out, p + 12 + 4 * k), 2);
    EXPECT_NEAR(std::sqrt(gap), std::fabs(expected[i].distance), 1e-6);
  }
}

TEST(ClosestPairs, FrameWithOtherCharactersIsReturnedUnchanged) {
  ClosestPairs pairs({samples::make_ball(), samples::make_ball()});
  const std::vector<std::byte> other = frame_of({{0, 0, 1}});
  EXPECT_EQ(pairs.append_to(other).data(), other.data());
  EXPECT_EQ(pairs.append_to({}).size(), 0u);
}

}  // namespace
}  // namespace ugoki::studio
