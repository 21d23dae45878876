#include "ugoki/content/executable.h"

#include <gtest/gtest.h>

#include <cstring>
#include <random>

#include "fixture.h"
#include "ugoki/content/generate.h"
#include "ugoki/content/track.h"
#include "ugoki/content/ugx.h"

namespace ugoki::content {
namespace {

using testing::make_resources;
using testing::make_scenario;

/// Position coordinates that a clip of a character has at time `t` [s].
std::vector<double> pose_at(const Executable& e, std::size_t character, std::size_t clip, double t) {
  const ExecutableCharacter& c = e.characters[character];
  std::vector<double> q(static_cast<std::size_t>(e.mechanisms[static_cast<std::size_t>(c.mechanism)]->nq()));
  sample(c.track[clip].clip, *e.motions[static_cast<std::size_t>(c.track[clip].motion)],
         *e.mechanisms[static_cast<std::size_t>(c.mechanism)], t, q);
  return q;
}

TEST(Executable, ContainsTheDocumentsContent) {
  const auto bytes = generate(make_scenario(), make_resources());
  ASSERT_TRUE(bytes) << bytes.error().text();
  const auto e = read_executable(*bytes, "park.ugx");
  ASSERT_TRUE(e) << e.error().text();
  EXPECT_EQ(e->name, "park");
  ASSERT_EQ(e->characters.size(), 2u);
  EXPECT_EQ(e->mechanisms[static_cast<std::size_t>(e->characters[0].mechanism)]->name(), "walker");
  EXPECT_EQ(e->characters[1].control.mode, ControlMode::passive);
  ASSERT_EQ(e->characters[0].track.size(), 3u);
  EXPECT_EQ(e->motions[static_cast<std::size_t>(e->characters[0].track[1].motion)]->name, "step");
  ASSERT_EQ(e->events.size(), 2u);
  EXPECT_EQ(e->events[0].link, 1) << "found by its label";
  EXPECT_EQ(e->events[1].character, 1);
  EXPECT_EQ(e->events[1].velocity, (Vec3{-6, 0, 2}));
  EXPECT_FALSE(e->circuit.empty());
  EXPECT_EQ(e->characters[1].q0, (std::vector<double>{3, 0, 0.11, 1, 0, 0, 0})) << "without clips: neutral pose at the character's place";
}

TEST(Executable, EqualInputGivesEqualBytes) {
  EXPECT_EQ(generate(make_scenario(), make_resources()).value(), generate(make_scenario(), make_resources()).value());
}

TEST(Executable, LeavesOutMutedTracksAndTracksThatAreNotSolo) {
  Scenario s = make_scenario();
  s.characters[0].muted = true;
  auto e = read_executable(generate(s, make_resources()).value(), "park.ugx");
  ASSERT_TRUE(e) << e.error().text();
  ASSERT_EQ(e->characters.size(), 1u);
  EXPECT_EQ(e->characters[0].id, "ball");
  ASSERT_EQ(e->events.size(), 1u) << "without the events of the left-out character";
  EXPECT_EQ(e->events[0].id, "e2");
  EXPECT_TRUE(e->camera.follow.empty());
  s.characters[0].muted = false;
  s.characters[0].solo = true;
  e = read_executable(generate(s, make_resources()).value(), "park.ugx");
  ASSERT_TRUE(e) << e.error().text();
  ASSERT_EQ(e->characters.size(), 1u);
  EXPECT_EQ(e->characters[0].id, "human");
}

TEST(Executable, MarkersRangeAndLocksDoNotChangeIt) {
  Scenario s = make_scenario();
  s.markers = {{"m1", 1, "Jump"}};
  s.range = {1, 2};
  s.characters[0].locked = true;
  EXPECT_EQ(generate(s, make_resources()).value(), generate(make_scenario(), make_resources()).value());
}

TEST(Executable, ContainsOnlyUsedResources) {
  Scenario s = make_scenario();
  s.characters.pop_back();
  s.events.pop_back();
  const auto bytes = generate(s, make_resources());
  ASSERT_TRUE(bytes);
  const auto ugx = read_ugx(*bytes);
  ASSERT_TRUE(ugx);
  EXPECT_EQ(ugx->find("mechanism/m-ball"), nullptr);
  EXPECT_NE(ugx->find("mechanism/m-walker"), nullptr);
}

TEST(Executable, FirstClipStartsAtTheCharactersPlace) {
  const auto bytes = generate(make_scenario(), make_resources());
  const auto e = read_executable(*bytes, "park.ugx");
  ASSERT_TRUE(e);
  const Placement root = root_placement(*e->mechanisms[static_cast<std::size_t>(e->characters[0].mechanism)], e->characters[0].q0);
  EXPECT_NEAR(root.x, 1, 1e-12);
  EXPECT_NEAR(root.y, 2, 1e-12);
  EXPECT_NEAR(root.z, 0.9, 1e-12);
  EXPECT_NEAR(root.heading, pi / 2, 1e-12);
}

TEST(Executable, EachClipContinuesAtTheEndOfThePreviousOne) {
  const auto bytes = generate(make_scenario(), make_resources());
  const auto e = read_executable(*bytes, "park.ugx");
  ASSERT_TRUE(e);
  const Mechanism& walker = *e->mechanisms[static_cast<std::size_t>(e->characters[0].mechanism)];
  for (std::size_t i = 1; i < 3; ++i) {
    const double t = e->characters[0].track[i].clip.start;
    const Placement before = root_placement(walker, pose_at(*e, 0, i - 1, t)), after = root_placement(walker, pose_at(*e, 0, i, t));
    EXPECT_NEAR(before.x, after.x, 1e-12) << i;
    EXPECT_NEAR(before.y, after.y, 1e-12) << i;
    EXPECT_NEAR(std::remainder(before.heading - after.heading, 2 * pi), 0, 1e-12) << i;
  }
}

TEST(Executable, LoopedClipIsContinuousAcrossCycles) {
  const auto bytes = generate(make_scenario(), make_resources());
  const auto e = read_executable(*bytes, "park.ugx");
  ASSERT_TRUE(e);
  const Mechanism& walker = *e->mechanisms[static_cast<std::size_t>(e->characters[0].mechanism)];
  double max_step = 0, path = 0;  // m: longest displacement of the root in 1 ms; length of the root's path
  Placement last = root_placement(walker, pose_at(*e, 0, 1, 2));
  for (double t = 2.001; t < 5.5; t += 0.001) {
    const Placement now = root_placement(walker, pose_at(*e, 0, 1, t));
    const double step = std::hypot(now.x - last.x, now.y - last.y);
    max_step = std::max(max_step, step);
    path += step;
    last = now;
  }
  EXPECT_LT(max_step, 0.0015) << "1.2 m/s is 0.0012 m per sample; a jump would be larger";
  EXPECT_NEAR(path, 1.2 * 3.5, 0.01);
}

TEST(Executable, ProblemsOfTheDocumentAreReported) {
  Scenario s = make_scenario();
  s.characters[0].mechanism = "m-none";
  s.events[1].velocity.x = 1e9;
  const auto bytes = generate(s, make_resources());
  ASSERT_FALSE(bytes);
  EXPECT_EQ(bytes.error().problems.size(), 2u) << bytes.error().text();
  Resources broken = make_resources();
  Motion bad = *broken.motions["n-walk"];
  bad.q[9] = std::numeric_limits<double>::quiet_NaN();
  broken.motions["n-walk"] = std::make_shared<const Motion>(bad);
  EXPECT_FALSE(generate(make_scenario(), broken));
}

TEST(Executable, RefusesTruncatedAndFlippedBytes) {
  const auto bytes = generate(make_scenario(), make_resources());
  ASSERT_TRUE(bytes);
  for (std::size_t size = 0; size < bytes->size(); size += size < 2000 ? 1 : 997) {
    const auto e = read_executable(std::span(*bytes).first(size), "cut.ugx");
    ASSERT_FALSE(e) << size;
    EXPECT_TRUE(e.error().problems.front().location.starts_with("cut.ugx")) << e.error().text();
    EXPECT_FALSE(e.error().problems.front().remedy.empty());
  }
  std::mt19937 random(20260302);
  for (int round = 0; round < 300; ++round) {
    std::vector<std::byte> spoiled = *bytes;
    spoiled[random() % spoiled.size()] ^= std::byte(1 + random() % 255);
    (void)read_executable(spoiled, "flipped.ugx");  // may succeed if only padding changed; must not crash
  }
}

/// The same file with one section replaced and valid checksums.
std::vector<std::byte> with_section(const std::vector<std::byte>& bytes, std::string_view name, std::vector<std::byte> data) {
  UgxWriter writer;
  const auto ugx = read_ugx(bytes);
  for (const UgxSection& s : ugx->sections()) {
    if (s.name == name)
      writer.add(s.name, data);
    else
      writer.add(s.name, std::vector<std::byte>(s.bytes.begin(), s.bytes.end()));
  }
  return writer.finish();
}
std::vector<std::byte> to_bytes(std::string_view text) {
  const auto* p = reinterpret_cast<const std::byte*>(text.data());
  return {p, p + text.size()};
}

TEST(Executable, RefusesHostileSectionsWithValidChecksums) {
  const auto bytes = generate(make_scenario(), make_resources());
  ASSERT_TRUE(bytes);
  Scenario unknown = make_scenario();
  unknown.characters[0].track[0].motion = "n-other";
  Scenario misfit = make_scenario();
  misfit.characters[1].track = {{"k9", "n-walk", 0, 1, 0, 1, 0, false}};
  std::vector<std::byte> nan_placements(3 * 4 * sizeof(double), std::byte(0xff));
  const std::pair<const char*, std::vector<std::byte>> cases[] = {
      {"scenario", to_bytes("")},
      {"scenario", to_bytes("{\"version\": 1, \"characters\": 3}")},
      {"scenario", to_bytes(write_scenario(unknown))},
      {"scenario", to_bytes(write_scenario(misfit))},
      {"placements", {}},
      {"placements", nan_placements},
      {"mechanism/m-walker", to_bytes("{}")},
      {"mechanism/m-walker", to_bytes("\xff\xff")},
      {"motion/n-walk", to_bytes("not a motion")},
      {"motion/n-walk", {}},
  };
  for (const auto& [name, data] : cases) {
    const auto e = read_executable(with_section(*bytes, name, data), "hostile.ugx");
    ASSERT_FALSE(e) << name;
    for (const Problem& p : e.error().problems) {
      EXPECT_TRUE(p.location.starts_with("hostile.ugx")) << p.text();
      EXPECT_FALSE(p.remedy.empty()) << p.text();
    }
  }
}

TEST(Clip, PlacementsObeyTheGroupLaws) {
  const Placement a = {1, 2, 3, 0.4}, b = {-2, 0.5, 1, 2.1}, c = {0.3, -4, 0, -1};
  const auto expect_near = [](const Placement& x, const Placement& y) {
    EXPECT_NEAR(x.x, y.x, 1e-13);
    EXPECT_NEAR(x.y, y.y, 1e-13);
    EXPECT_NEAR(x.z, y.z, 1e-13);
    EXPECT_NEAR(x.heading, y.heading, 1e-13);
  };
  expect_near((a * b) * c, a * (b * c));
  expect_near(a * inverse(a), {});
  expect_near(repeated(a, 5), a * a * a * a * a);
  expect_near(repeated(a, 0), {});
  const Pose p = to_pose(a * b), pp = to_pose(a) * to_pose(b);
  EXPECT_NEAR(norm(p.p - pp.p), 0, 1e-13);
}

TEST(Clip, DisplacingATiltedRootJointMovesItsPose) {
  MechanismSpec spec = testing::make_walker()->spec();
  spec.links[0].joint.X_PJ = {rotation_about(normalized(Vec3{1, 2, 3}), 0.7), {0.3, -0.2, 0.5}};
  const auto tilted = Mechanism::make(spec);
  ASSERT_TRUE(tilted);
  std::vector<double> q = (*tilted)->neutral();
  q[0] = 0.4;
  q[1] = -1;
  const Pose before = (*tilted)->link(0).joint.X_PJ * joint_pose((*tilted)->link(0).joint, q.data());
  const Placement by = {1, 2, 0.5, 1.1};
  displace_root(**tilted, by, q);
  const Pose after = (*tilted)->link(0).joint.X_PJ * joint_pose((*tilted)->link(0).joint, q.data());
  const Pose wanted = to_pose(by) * before;
  EXPECT_NEAR(norm(after.p - wanted.p), 0, 1e-12);
  EXPECT_NEAR(norm(after.R.column(0) - wanted.R.column(0)), 0, 1e-12);
  EXPECT_NEAR(norm(after.R.column(1) - wanted.R.column(1)), 0, 1e-12);
}

}  // namespace
}  // namespace ugoki::content
