// Metamorphic tests: files with the same motion in the world give the same body and the same simulated result in every dialect.
#include <gtest/gtest.h>

#include <filesystem>
#include <map>

#include "dialects.h"
#include "outcome.h"
#include "ugoki/files/files.h"
#include "ugoki/formats/asf.h"
#include "ugoki/formats/bvh.h"
#include "ugoki/intake/intake.h"

namespace ugoki::dialects {
namespace {

const std::string root = std::string(UGOKI_SHARED_DATA) + "/human/asf_amc/";

bool has_data() { return std::filesystem::exists(root + "02_01.amc"); }

/// Returns the first `frames` frames of the trial `name` ("02_01").
MeasuredMotion trial(const std::string& name, int frames) {
  const auto asf = formats::read_asf(*files::read_file(root + name.substr(0, 2) + ".asf"), name);
  MeasuredMotion m = *formats::read_amc(*files::read_file(root + name + ".amc"), name, *asf);
  const std::size_t n = m.skeleton.joints.size();
  m.frames = std::min(m.frames, frames);
  m.translations.resize(n * static_cast<std::size_t>(m.frames));
  m.rotations.resize(n * static_cast<std::size_t>(m.frames));
  return m;
}

Result<intake::Intake> import(const DialectFile& file) {
  if (file.asf.empty()) return intake::take_in(file.bytes, file.name);
  const auto asf = formats::read_asf(file.asf, "skeleton.asf", {.metres_per_unit = 0.0254});
  if (!asf) return fail(asf.error());
  return intake::take_in(file.bytes, file.name, &*asf);
}

/// Body segment of a link: its label without the number of the link in the segment.
std::string segment_of(const Link& link) {
  std::string out = link.label;
  if (out == "neck upper") return "neck";
  for (const char* number : {" 2", " 3", " 4", " 5"})
    if (const std::size_t i = out.find(number); i != std::string::npos) out.erase(i, 2);
  return out;
}

std::map<std::string, double> segment_masses(const Mechanism& m) {
  std::map<std::string, double> out;
  for (const Link& link : m.links())
    if (link.inertia.mass > 0) out[segment_of(link)] += link.inertia.mass;
  return out;
}

/// Expects that two bodies are the same in anatomy, height, masses of the segments and joint limits.
void expect_same_body(const intake::Intake& a, const intake::Intake& b) {
  ASSERT_TRUE(b.body && b.body->human) << b.report.front();
  EXPECT_NEAR(a.body->height, b.body->height, 0.01);
  EXPECT_NEAR(a.body->mass / b.body->mass, 1, 0.02);
  const auto masses = segment_masses(*a.mechanism), others = segment_masses(*b.mechanism);
  for (const auto& [segment, mass] : masses) {
    ASSERT_TRUE(others.contains(segment)) << segment;
    EXPECT_NEAR(others.at(segment) / mass, 1, 0.02) << segment;
  }
  EXPECT_EQ(masses.size(), others.size());
  for (const Link& link : a.mechanism->links()) {
    // Links of the neck may be numbered differently if a file inserts a joint.
    if (link.label.empty() || link.label.starts_with("neck") || link.joint.type != JointType::spherical) continue;
    for (const Link& other : b.mechanism->links()) {
      if (other.label != link.label || other.joint.type != link.joint.type) continue;
      for (std::size_t k = 0; k < 3; ++k) {
        const auto equal = [](double x, double y) { return x == y || std::fabs(x - y) < 2.5 * pi / 180; };
        EXPECT_TRUE(equal(link.joint.dofs[k].lower, other.joint.dofs[k].lower))
            << link.label << ' ' << link.joint.dofs[k].lower << ' ' << other.joint.dofs[k].lower;
        EXPECT_TRUE(equal(link.joint.dofs[k].upper, other.joint.dofs[k].upper))
            << link.label << ' ' << link.joint.dofs[k].upper << ' ' << other.joint.dofs[k].upper;
      }
    }
  }
}

/// Imports the trial in every dialect and compares it with the plain BVH file.
void compare(const std::string& name, int frames, bool dynamics) {
  if (!has_data()) GTEST_SKIP() << "The shared measured data are absent.";
  const MeasuredMotion motion = trial(name, frames);
  Dialect plain;
  const auto original = import(write(rewrite(motion, plain), plain, "plain"));
  ASSERT_TRUE(original) << original.error().text();
  ASSERT_TRUE(original->body->human);
  const Outcome expected = dynamics ? simulate(*original) : Outcome{};
  for (const Dialect& d : all_dialects()) {
    SCOPED_TRACE(name + " as " + d.name);
    const auto other = import(write(rewrite(motion, d), d, "dialect"));
    ASSERT_TRUE(other) << other.error().text();
    expect_same_body(*original, *other);
    if (!dynamics) continue;
    const Outcome outcome = simulate(*other);
    EXPECT_EQ(outcome.released >= 0, expected.released >= 0);
    EXPECT_NEAR(outcome.tracking, expected.tracking, 0.3);
    EXPECT_NEAR(outcome.assist, expected.assist, 0.01);
  }
}

TEST(Dialects, AWalkGivesTheSameBody) { compare("02_01", 1000, false); }
TEST(Dialects, ARunGivesTheSameBody) { compare("02_03", 1000, false); }
TEST(Dialects, AWalkGivesTheSameSimulation) { compare("07_01", 240, true); }
TEST(SlowDialects, WalkRunJumpAndClimbGiveTheSameSimulation) {
  for (const char* name : {"02_01", "02_03", "02_04", "01_01", "16_15"}) compare(name, 600, true);
  // In 03_01 the person walks over ground that the file does not describe. On a level floor the contacts of the feet are random, so only
  // the bodies are compared.
  compare("03_01", 600, false);
}

}  // namespace
}  // namespace ugoki::dialects
