// Clips whose motion is made from a recipe.
#include "ugoki/studio/gait_clip.h"

#include <gtest/gtest.h>

#include "ugoki/motion/clip.h"
#include "ugoki/samples/samples.h"

namespace ugoki::studio {
namespace {

MechanismPtr person() {
  static const MechanismPtr made = samples::make_person(1.7).value();
  return made;
}

GaitRequest request_for(const MechanismPtr& body, content::GaitRecipe recipe) {
  GaitRequest r;
  r.mechanism = body;
  r.clip.id = "k1";
  r.clip.start = 2;
  r.clip.gait = std::move(recipe);
  return r;
}

TEST(GaitClip, NewClipPlaysTheWholeMotionAtTheUsualSpeed) {
  content::GaitRecipe recipe;
  recipe.seconds = 5;
  const EditedMotion made = make_gait_clip(request_for(person(), recipe)).value();
  EXPECT_TRUE(check_motion(made.motion, *person()).empty());
  EXPECT_EQ(made.clip.start, 2);
  EXPECT_NEAR(made.clip.length, made.motion.duration(), 1e-9);
  EXPECT_NEAR(made.motion.duration(), 5, 0.01);
  EXPECT_GT(made.clip.gait->speed, 0.8);
  EXPECT_LT(made.clip.gait->speed, 1.8);
}

TEST(GaitClip, ChangedGaitKeepsATrimmedClip) {
  content::GaitRecipe recipe;
  recipe.seconds = 5;
  EditedMotion made = make_gait_clip(request_for(person(), recipe)).value();
  GaitRequest again = request_for(person(), *made.clip.gait);
  again.old = std::make_shared<const Motion>(made.motion);
  again.clip = made.clip;
  again.clip.gait->seconds = 8;
  EXPECT_NEAR(make_gait_clip(again)->clip.length, 8, 0.01) << "a clip that was played to its end is played to its end";
  again.clip.length = 2;
  EXPECT_NEAR(make_gait_clip(again)->clip.length, 2, 1e-9);
  again.clip.gait->seconds = 1.5;
  EXPECT_NEAR(make_gait_clip(again)->clip.length, 1.5, 0.01);
}

TEST(GaitClip, PathDecidesTheDuration) {
  content::GaitRecipe recipe;
  recipe.speed = 1.2;
  recipe.path = {{3, 2}, {5, 2}};
  const EditedMotion made = make_gait_clip(request_for(person(), recipe)).value();
  EXPECT_NEAR(made.clip.gait->seconds, made.motion.duration(), 0.01);
  // the clip is placed by the heading of its first frame
  EXPECT_NEAR(root_placement(*person(), {made.motion.frame(0), static_cast<std::size_t>(made.motion.nq)}).heading, 0, 0.05);
  const double* last = made.motion.frame(made.motion.frames - 1);
  EXPECT_NEAR(last[0], 5, 0.15);
  EXPECT_NEAR(last[1], 2, 0.15);
}

TEST(GaitClip, WrongRecipesAreRefusedWithARemedy) {
  const auto refused = [](const MechanismPtr& body, const content::GaitRecipe& recipe) {
    const Result<EditedMotion> made = make_gait_clip(request_for(body, recipe));
    EXPECT_FALSE(made);
    if (!made) EXPECT_FALSE(made.error().problems.front().remedy.empty());
  };
  content::GaitRecipe recipe;
  recipe.kind = "moonwalk";
  refused(person(), recipe);
  recipe.kind = "gallop";  // not for two legs
  refused(person(), recipe);
  recipe.kind = "walk";
  recipe.style = "funny";
  refused(person(), recipe);
  recipe.style = "usual";
  recipe.seconds = 1e9;
  refused(person(), recipe);
  refused(samples::make_ball(), {});
}

TEST(GaitClip, KindsFitTheLegs) {
  EXPECT_EQ((*describe_gaits(person()))["kinds"].size(), 2u);  // walk, run
  EXPECT_GT((*describe_gaits(samples::make_dog()))["kinds"].size(), 5u);
  EXPECT_FALSE(describe_gaits(samples::make_ball()));
}

}  // namespace
}  // namespace ugoki::studio
