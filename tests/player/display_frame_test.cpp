#include "ugoki/content/display_frame.h"

#include <gtest/gtest.h>

#include <cstring>

namespace ugoki::content {
namespace {

template <class T>
T at(const std::vector<std::byte>& bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

TEST(DisplayFrame, HasTheLayoutOfTheProtocol) {
  DisplayFrame frame;
  frame.time = 1.25;
  frame.grabbed = true;
  frame.grab_point = {1, 2, 3};
  frame.grab_target = {4, 5, 6};
  frame.characters.resize(2);
  frame.characters[0].links.resize(3);
  frame.characters[1].links.resize(1);
  frame.characters[1].state = CharacterState::released;
  frame.characters[1].assist_force = {7, 8, 9};
  frame.characters[1].assist_moment = {10, 11, 12};
  frame.characters[1].assist_ratio = 0.5;
  frame.characters[1].weight = 700;
  frame.characters[1].centre_of_mass = {13, 14, 15};
  frame.characters[1].links[0] = {{16, 17, 18}, {0.5, -0.5, 0.5, -0.5}};
  frame.contacts.push_back({{19, 20, 21}, {22, 23, 24}, {0, 0.6, 0.8}, 1, 2});
  std::vector<std::byte> bytes;
  encode_frame(frame, 75, frame_playing | frame_simulate, bytes);
  const std::size_t head = 64, person = 8 + 12 * 4, link = 7 * 4;
  ASSERT_EQ(bytes.size(), head + (person + 3 * link) + (person + link) + 32 + 12);
  EXPECT_EQ(std::memcmp(bytes.data(), "UKGF", 4), 0);
  EXPECT_EQ(at<std::uint32_t>(bytes, 4), 1u);
  EXPECT_EQ(at<double>(bytes, 8), 1.25);
  EXPECT_EQ(at<std::uint32_t>(bytes, 16), 75u);
  EXPECT_EQ(at<std::uint32_t>(bytes, 20), 1u | 2u | 8u);
  EXPECT_EQ(at<std::uint32_t>(bytes, 24), 2u);
  EXPECT_EQ(at<std::uint32_t>(bytes, 28), 1u);
  EXPECT_EQ(at<float>(bytes, 44), 4);
  EXPECT_EQ(at<std::uint32_t>(bytes, 56), 0u);
  EXPECT_EQ(at<std::uint32_t>(bytes, 60), 1u);
  const std::size_t second = head + person + 3 * link;
  EXPECT_EQ(at<std::uint32_t>(bytes, second), 1u);
  EXPECT_EQ(at<std::uint32_t>(bytes, second + 4), 1u);
  for (std::size_t k = 0; k < 6; ++k) EXPECT_EQ(at<float>(bytes, second + 8 + 4 * k), 7 + static_cast<float>(k));
  EXPECT_EQ(at<float>(bytes, second + 32), 0.5f);
  EXPECT_EQ(at<float>(bytes, second + 36), 700);
  EXPECT_EQ(at<float>(bytes, second + 40), 13);
  EXPECT_EQ(at<float>(bytes, second + person), 16);
  EXPECT_EQ(at<float>(bytes, second + person + 12), 0.5f);
  EXPECT_EQ(at<float>(bytes, second + person + 16), -0.5f);
  const std::size_t contact = second + person + link;
  EXPECT_EQ(at<float>(bytes, contact + 20), 24);
  EXPECT_EQ(at<std::uint32_t>(bytes, contact + 24), 1u);
  EXPECT_EQ(at<std::uint32_t>(bytes, contact + 28), 2u);
  EXPECT_EQ(at<float>(bytes, contact + 32), 0);
  EXPECT_EQ(at<float>(bytes, contact + 36), 0.6f);
  EXPECT_EQ(at<float>(bytes, contact + 40), 0.8f);
}

}  // namespace
}  // namespace ugoki::content
