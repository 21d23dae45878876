// The sample content: feet of the human's and the dog's motions stay on the ground, do not slide, and the motions are cyclic.

#include "ugoki/samples/samples.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "ugoki/body/body.h"
#include "ugoki/content/generate.h"
#include "ugoki/content/scenario.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/motion/clip.h"
#include "ugoki/motion/measures.h"

namespace ugoki::samples {
namespace {

const Sample& sample_content() {
  static const Sample content = make_sample();
  return content;
}
const Mechanism& mechanism(const char* id) { return *sample_content().resources.mechanisms.find(id)->second; }
const Motion& motion(const char* id) { return *sample_content().resources.motions.find(id)->second; }

struct Kinematics {
  double skate_cm = 0, worst_skate_cm = 0, penetration_mm = 0, lowest_com = 1e9, highest_com = -1e9;
  Vec3 first, last;
};

Kinematics measure(const Mechanism& m, const Motion& motion) {
  const std::vector<int> feet = find_feet(m);
  FootSkate skate(m, feet);
  GroundPenetration penetration(m);
  Kinematics out;
  std::vector<Pose> X(static_cast<std::size_t>(m.link_count()));
  std::vector<std::uint8_t> on(feet.size());
  for (int f = 0; f < motion.frames; ++f) {
    calc_poses(m, std::span(motion.frame(f), static_cast<std::size_t>(motion.nq)), X);
    for (std::size_t k = 0; k < feet.size(); ++k) on[k] = motion.contacts[k].on[static_cast<std::size_t>(f)];
    skate.add(X, on, 1 / motion.rate);
    penetration.add(X);
    const Vec3 c = centre_of_mass(m, X);
    out.lowest_com = std::min(out.lowest_com, c.z);
    out.highest_com = std::max(out.highest_com, c.z);
    if (f == 0) out.first = c;
    out.last = c;
  }
  out.skate_cm = skate.mean_per_stance_cm();
  out.worst_skate_cm = skate.worst_stance_cm();
  out.penetration_mm = penetration.worst_mm();
  return out;
}

double angle_range(const Mechanism& m, const Motion& motion, const char* link, double& low, double& high) {
  const Link& l = m.link(m.find_link(link));
  EXPECT_EQ(l.joint.type, JointType::revolute) << link;
  low = 1e9;
  high = -1e9;
  for (int f = 0; f < motion.frames; ++f) {
    low = std::min(low, motion.frame(f)[l.q_index] * 180 / pi);
    high = std::max(high, motion.frame(f)[l.q_index] * 180 / pi);
  }
  return high - low;
}

TEST(Samples, EveryMotionFitsItsMechanismAndRepeats) {
  for (const auto& [id, m] : sample_content().resources.motions) {
    const Mechanism& character = mechanism(id.starts_with("dog") ? "dog" : "human");
    EXPECT_TRUE(check_motion(*m, character).empty()) << check_motion(*m, character).text();
    EXPECT_TRUE(m->cyclic) << id;
    EXPECT_EQ(m->mechanism, character.name());
    // The last frame equals the first frame displaced by one cycle.
    std::vector<double> last(m->frame(m->frames - 1), m->frame(m->frames - 1) + m->nq), v(static_cast<std::size_t>(character.nv()));
    displace_root(character, inverse(cycle_of(*m, character)), last);
    difference(character, std::span(m->frame(0), static_cast<std::size_t>(m->nq)), last, v);
    for (const double x : v) EXPECT_NEAR(x, 0, 1e-6) << id;
    // No joint moves faster than 40 rad/s, at 120 frames per second.
    for (int f = 0; f + 1 < m->frames; ++f) {
      difference(character, std::span(m->frame(f), static_cast<std::size_t>(m->nq)),
                 std::span(m->frame(f + 1), static_cast<std::size_t>(m->nq)), v);
      for (const double x : v) EXPECT_LT(std::fabs(x), 40.0 / 120) << id << " frame " << f;
    }
  }
}

TEST(Samples, LimitsContainTheMotions) {
  for (const auto& [id, m] : sample_content().resources.motions) {
    const Mechanism& character = mechanism(id.starts_with("dog") ? "dog" : "human");
    for (int f = 0; f < m->frames; ++f)
      for (const Link& l : character.links()) {
        double x[6];
        joint_displacement(l.joint, m->frame(f) + l.q_index, x);
        for (int k = 0; k < l.joint.nv(); ++k) {
          ASSERT_GE(x[k], l.joint.dofs[static_cast<std::size_t>(k)].lower) << id << " " << l.name << " frame " << f;
          ASSERT_LE(x[k], l.joint.dofs[static_cast<std::size_t>(k)].upper) << id << " " << l.name << " frame " << f;
        }
      }
  }
}

TEST(Human, HasMassAndHeightOfTheSkeleton) {
  EXPECT_NEAR(mechanism("human").mass(), 70, 70e-9);
  const MeasuredMotion walk = make_human_walk();
  EXPECT_NEAR(rest_height(walk.skeleton), 1.75 - 0.019 * 1.75, 0.003);  // rest_height() measures down to the ball of the foot
  const auto body = body::make_body(walk);
  ASSERT_TRUE(body.has_value());
  EXPECT_TRUE(body->human);
  EXPECT_NEAR(body->height, 1.75, 0.002);
  EXPECT_LT(body::calc_position_error(*body, walk, body::to_motion(*body, walk)), 1e-6);
}

TEST(Human, WalkHasPublishedKinematicsWithoutSliding) {
  const Kinematics k = measure(mechanism("human"), motion("human-walk"));
  EXPECT_LT(k.worst_skate_cm, 0.5);
  EXPECT_LT(k.penetration_mm, 1);
  EXPECT_NEAR((k.last.x - k.first.x) / motion("human-walk").duration(), 1.35, 1e-3);
  EXPECT_NEAR(k.last.y, k.first.y, 1e-6);
  // The centre of mass rises and falls by 3 to 5 cm (Winter 1991), at about 55 % of the height.
  EXPECT_GT(k.highest_com - k.lowest_com, 0.025);
  EXPECT_LT(k.highest_com - k.lowest_com, 0.055);
  EXPECT_NEAR(k.highest_com / 1.75, 0.55, 0.02);
  double low, high;
  for (const char* knee : {"LeftLeg", "RightLeg"}) {
    angle_range(mechanism("human"), motion("human-walk"), knee, low, high);
    EXPECT_GT(low, 0);
    EXPECT_LT(low, 12);
    EXPECT_GT(high, 50);
    EXPECT_LT(high, 70);
  }
}

TEST(Human, StandsStill) {
  const Kinematics k = measure(mechanism("human"), motion("human-stand"));
  EXPECT_LT(k.worst_skate_cm, 0.05);
  EXPECT_LT(k.penetration_mm, 0.5);
  for (const ContactTrack& c : motion("human-stand").contacts)
    EXPECT_EQ(std::count(c.on.begin(), c.on.end(), 1), motion("human-stand").frames);
}

TEST(Dog, HasMassSymmetryAndWeightDistributionOfAShepherd) {
  const Mechanism& dog = mechanism("dog");
  EXPECT_NEAR(dog.mass(), 32, 32e-9);
  EXPECT_GE(dog.link_count(), 6 + 4 + 4 * 4);
  // Mirror symmetry.
  for (const Link& l : dog.links()) {
    if (!l.name.starts_with("Left")) continue;
    const int r = dog.find_link("Right" + l.name.substr(4));
    ASSERT_GE(r, 0);
    EXPECT_NEAR(l.inertia.mass, dog.link(r).inertia.mass, 1e-12);
    EXPECT_NEAR(l.inertia.h.y, -dog.link(r).inertia.h.y, 1e-12) << l.name;
  }
  // Dogs carry about 60 % of their weight on the fore legs ("A 60:40 split: differential mass support in dogs", Anatomical Record 2020,
  // doi 10.1002/ar.24407).
  std::vector<Pose> X(static_cast<std::size_t>(dog.link_count()));
  calc_poses(dog, dog.neutral(), X);
  const double hind = X[static_cast<std::size_t>(dog.find_link("LeftHindPaw"))].p.x,
               fore = X[static_cast<std::size_t>(dog.find_link("LeftForePaw"))].p.x;
  const double share = (centre_of_mass(dog, X).x - hind) / (fore - hind);
  EXPECT_NEAR(share, 0.60, 0.04);
  // Paws are on the ground.
  for (const int paw : find_feet(dog)) {
    double low = 1e9;
    for (const SupportPoint& p : support_points(dog.link(paw))) low = std::min(low, (X[static_cast<std::size_t>(paw)] * p.p).z - p.radius);
    EXPECT_NEAR(low, 0, 1e-9);
  }
  EXPECT_EQ(find_feet(dog).size(), 4u);
}

TEST(Dog, TrotMovesDiagonalLegsInPhase) {
  const Mechanism& dog = mechanism("dog");
  const Motion& trot = motion("dog-trot");
  const Kinematics k = measure(dog, trot);
  EXPECT_LT(k.worst_skate_cm, 0.6);
  EXPECT_LT(k.penetration_mm, 5);
  EXPECT_NEAR((k.last.x - k.first.x) / trot.duration(), 1.35, 2e-3);
  EXPECT_LT(k.highest_com - k.lowest_com, 0.03);
  // One diagonal pair of legs stands while the other pair swings.
  const auto on = [&](const char* link, int f) {
    for (const ContactTrack& c : trot.contacts)
      if (c.link == link) return c.on[static_cast<std::size_t>(f)] != 0;
    return false;
  };
  const int quarter = trot.frames / 4;
  EXPECT_TRUE(on("LeftForePaw", quarter) && on("RightHindPaw", quarter));
  EXPECT_FALSE(on("RightForePaw", quarter) || on("LeftHindPaw", quarter));
  EXPECT_TRUE(on("RightForePaw", 3 * quarter) && on("LeftHindPaw", 3 * quarter));
  EXPECT_FALSE(on("LeftForePaw", 3 * quarter) || on("RightHindPaw", 3 * quarter));
}

TEST(Dog, StandsStill) {
  const Kinematics k = measure(mechanism("dog"), motion("dog-stand"));
  EXPECT_LT(k.worst_skate_cm, 0.15);
  EXPECT_LT(k.penetration_mm, 0.5);
}

TEST(Samples, ScenarioIsValidAndReproducible) {
  const Sample& s = sample_content();
  const auto scenario = content::read_scenario(s.document, "sample");
  ASSERT_TRUE(scenario.has_value()) << scenario.error().text();
  EXPECT_EQ(scenario->duration, 20);
  const auto bytes = content::generate(*scenario, s.resources);
  ASSERT_TRUE(bytes.has_value()) << bytes.error().text();
  EXPECT_EQ(*bytes, *content::generate(*scenario, make_sample().resources));  // making the sample twice gives the same bytes
}

}  // namespace
}  // namespace ugoki::samples
