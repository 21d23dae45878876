// Metamorphic tests with animals: a fox and a rat give the same body and the same simulated result in all dialects.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <map>

#include "dialects.h"
#include "outcome.h"
#include "ugoki/files/files.h"
#include "ugoki/formats/asf.h"
#include "ugoki/intake/intake.h"

namespace ugoki::dialects {
namespace {

const std::string folder = std::string(UGOKI_SHARED_DATA) + "/animal/";

/// The measured motion of a shared file, its first `frames` frames.
Result<MeasuredMotion> animal(const std::string& name, const std::string& take, int frames) {
  const auto bytes = files::read_file(folder + name);
  if (!bytes) return fail(bytes.error());
  intake::IntakeOptions options;
  options.take = take;
  options.travel = true;
  const auto in = intake::take_in(*bytes, name, nullptr, options);
  if (!in) return fail(in.error());
  MeasuredMotion m = *in->measured;
  const std::size_t n = m.skeleton.joints.size();
  m.frames = std::min(m.frames, frames);
  m.translations.resize(n * static_cast<std::size_t>(m.frames));
  m.rotations.resize(n * static_cast<std::size_t>(m.frames));
  return m;
}

/// Imports a dialect. Unit and up axis are given, because a BVH file does not specify them: the unit cannot follow from the height of an
/// animal, which varies, nor the up axis from its legs, which may have any direction when the animal lies. An AMC file does not specify the
/// frame rate.
/// @param rate frames per second of the file
Result<intake::Intake> import(const DialectFile& file, const Dialect& d, double rate) {
  intake::IntakeOptions options;
  options.rate = rate;
  if (d.format != "glb") options.unit = d.unit;
  if (d.z_up) options.axes = intake::usual_orientation(true);
  if (file.asf.empty()) return intake::take_in(file.bytes, file.name, nullptr, options);
  const auto asf = formats::read_asf(file.asf, "skeleton.asf", {.metres_per_unit = d.unit});
  if (!asf) return fail(asf.error());
  return intake::take_in(file.bytes, file.name, &*asf, options);
}

std::map<std::string, double> masses_by_label(const Mechanism& m) {
  std::map<std::string, double> out;
  for (const Link& link : m.links())
    if (link.inertia.mass > 0) out[link.label] += link.inertia.mass;
  return out;
}

void compare(const std::string& name, const std::string& take, int frames, bool dynamics) {
  if (!std::filesystem::exists(folder + name)) GTEST_SKIP() << "The shared animal data are absent.";
  const auto motion = animal(name, take, frames);
  ASSERT_TRUE(motion) << motion.error().text();
  Dialect plain;
  const auto original = import(write(rewrite(*motion, plain), plain, "plain"), plain, motion->rate);
  ASSERT_TRUE(original) << original.error().text();
  ASSERT_EQ(original->body->anatomy.plan, "four legs");
  const Outcome expected = dynamics ? simulate(*original) : Outcome{};
  const auto masses = masses_by_label(*original->mechanism);
  for (const Dialect& d : all_dialects()) {
    // Twist bones are inserted into the human skeleton of the test data only. The calibration pose is a T pose of a human.
    if (d.twists || d.calibration_frame) continue;
    SCOPED_TRACE(name + " as " + d.name);
    const auto other = import(write(rewrite(*motion, d), d, "dialect"), d, motion->rate);
    ASSERT_TRUE(other) << other.error().text();
    EXPECT_EQ(other->body->anatomy.plan, "four legs");
    // In files that store bone ends and offsets as joints, the body has other links and another lowest joint.
    const bool other_links = d.format != "bvh" || d.helpers;
    // The height is measured in the sampled frame closest to the mean pose, so it depends on the sampling.
    if (!other_links) {
      EXPECT_NEAR(other->body->height / original->body->height, 1, 0.05);
    }
    EXPECT_NEAR(other->body->mass / original->body->mass, 1, 0.02);
    const auto others = masses_by_label(*other->mechanism);
    for (const auto& [label, mass] : masses) {
      // AMC files have other names and bones, but joints at the same places.
      if (mass < 0.01 * original->body->mass || (other_links && d.format != "amc")) continue;
      ASSERT_TRUE(others.contains(label)) << label;
      EXPECT_NEAR(others.at(label) / mass, 1, 0.02) << label;
    }
    if (!dynamics) continue;
    const Outcome outcome = simulate(*other);
    EXPECT_EQ(outcome.released >= 0, expected.released >= 0);
    EXPECT_NEAR(outcome.tracking, expected.tracking, 0.3);
    EXPECT_NEAR(outcome.assist, expected.assist, 0.01);
  }
}

TEST(AnimalDialects, AFoxGivesTheSameBody) { compare("Fox.glb", "Walk", 200, false); }
TEST(AnimalDialects, ARatGivesTheSameBody) { compare("rat_walk_23.trc", "", 150, false); }
TEST(SlowAnimalDialects, AFoxGivesTheSameSimulation) { compare("Fox.glb", "Walk", 200, true); }
TEST(SlowAnimalDialects, ARatGivesTheSameSimulation) { compare("rat_walk_23.trc", "", 150, true); }

}  // namespace
}  // namespace ugoki::dialects
