// Tests of the cut at poses that a file holds in mid-motion.
#include <gtest/gtest.h>

#include <string>

#include "ugoki/intake/arrange.h"
#include "ugoki/samples/samples.h"

namespace ugoki::intake {
namespace {

/// Repeats a frame of a motion `times` more times.
MeasuredMotion with_hold(const MeasuredMotion& motion, int frame, int times) {
  MeasuredMotion out = motion;
  const auto n = static_cast<std::ptrdiff_t>(motion.skeleton.joints.size());
  const auto repeat = [&](auto& list, const auto& from) {
    for (int k = 0; k < times; ++k) list.insert(list.begin() + (frame + 1) * n, from.begin() + frame * n, from.begin() + (frame + 1) * n);
  };
  repeat(out.translations, motion.translations);
  repeat(out.rotations, motion.rotations);
  out.frames += times;
  return out;
}

TEST(Holds, APoseHeldInMidMotionCutsTheMotion) {
  MeasuredMotion walk = samples::make_human_walk();
  std::vector<std::string> report;
  const body::Character character = arrange(std::span(&walk, 1), report);
  EXPECT_EQ(cut_at_holds(character, walk), "");
  const int hold = walk.frames * 3 / 5, times = static_cast<int>(0.5 * walk.rate);
  MeasuredMotion held = with_hold(walk, hold, times);
  const std::string sentence = cut_at_holds(character, held);
  EXPECT_NE(sentence.find("frames 1 to " + std::to_string(hold + 1) + " of " + std::to_string(walk.frames + times)), std::string::npos)
      << sentence;
  EXPECT_EQ(held.frames, hold + 1);
  EXPECT_EQ(held.rotations.size(), walk.skeleton.joints.size() * static_cast<std::size_t>(held.frames));
  for (std::size_t i = 0; i < held.translations.size(); ++i) EXPECT_EQ(norm(held.translations[i] - walk.translations[i]), 0);
  // At the start of a file, the hold itself is left out, and the motion after it stays.
  MeasuredMotion late = with_hold(walk, 0, times);
  EXPECT_NE(cut_at_holds(character, late).find("first at 0.00 s"), std::string::npos);
  EXPECT_EQ(late.frames, walk.frames - 1);
  // A frame that is stored twice is no gap.
  MeasuredMotion twice = with_hold(walk, hold, 1);
  EXPECT_EQ(cut_at_holds(character, twice), "");
  // A person who moves slowly before and after the hold can stand still: the frames are farther apart in time.
  MeasuredMotion slow = with_hold(walk, hold, times);
  slow.rate /= 20;
  EXPECT_EQ(cut_at_holds(character, slow), "");
}

}  // namespace
}  // namespace ugoki::intake
