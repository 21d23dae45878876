// Retargeting of the sample characters: exact results, joint limits, sliding feet, hands held in place, mapping files, errors.

#include "ugoki/retarget/retarget.h"

#include <gtest/gtest.h>

#include <cmath>

#include "characters.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/motion_edit/foot_contacts.h"
#include "ugoki/retarget/chain_solver.h"
#include "ugoki/retarget/holds.h"
#include "ugoki/samples/samples.h"

namespace ugoki::retarget_test {
namespace {

using retarget::RetargetOptions;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// The mechanism with all lengths multiplied by `s` at constant density.
MechanismPtr scaled(const Mechanism& m, double s) {
  MechanismSpec spec = m.spec();
  for (LinkSpec& l : spec.links) {
    l.joint.X_PJ.p *= s;
    l.inertia = {l.inertia.mass * s * s * s, l.inertia.h * (s * s * s * s), l.inertia.I * (s * s * s * s * s)};
    for (Shape& shape : l.shapes) {
      shape.X_BS.p *= s;
      shape.radius *= s;
      shape.half_length *= s;
      shape.half_extents *= s;
    }
  }
  return *Mechanism::make(std::move(spec));
}

/// Maximum distance [m], over all frames, between the position of a link of `b` and `scale` times the position of the link in `a`.
double worst_distance(const Mechanism& a, const Motion& x, const Mechanism& b, const Motion& y, double scale) {
  double worst = 0;
  std::vector<Pose> X(at(a.link_count())), Y(at(b.link_count()));
  for (int f = 0; f < x.frames; ++f) {
    calc_poses(a, {x.frame(f), at(x.nq)}, X);
    calc_poses(b, {y.frame(f), at(y.nq)}, Y);
    for (int i = 0; i < a.link_count(); ++i) worst = std::max(worst, norm(X[at(i)].p * scale - Y[at(i)].p));
  }
  return worst;
}

TEST(Retarget, ToTheSameMechanismReturnsTheSameMotion) {
  RetargetOptions options;
  options.keep_contacts = false;
  for (const Clip& clip : {human_walk(), dog_trot()}) {
    const auto out = retarget::retarget(clip.mechanism, clip.motion, clip.mechanism, options);
    ASSERT_TRUE(out) << out.error().text();
    EXPECT_LT(worst_distance(*clip.mechanism, clip.motion, *clip.mechanism, out->motion, 1), 1e-9) << clip.name;
  }
}

TEST(Retarget, ToAScaledBodyScalesTheMotion) {
  for (const double s : {0.5, 1.7})
    for (const bool contacts : {false, true})
      for (const Clip& clip : {human_walk(), dog_trot()}) {
        const MechanismPtr other = scaled(*clip.mechanism, s);
        RetargetOptions options;
        options.keep_contacts = contacts;
        const auto out = retarget::retarget(clip.mechanism, clip.motion, other, options);
        ASSERT_TRUE(out) << out.error().text();
        EXPECT_NEAR(out->report.scale, s, 1e-9);
        // Foot correction removes the sliding of the sample motions (3 and 7 mm), so positions differ slightly.
        EXPECT_LT(worst_distance(*clip.mechanism, clip.motion, *other, out->motion, s), (contacts ? 0.03 : 1e-9) * s) << clip.name << s;
      }
}

TEST(Retarget, FeetDoNotSlideAndLimitsAreKeptOnEveryCharacter) {
  const std::vector<MechanismPtr> characters = {make_person(1.1), make_person(2.4), samples::make_dog(), make_hinged_robot()};
  for (const Clip& clip : {human_walk(), dog_trot()})
    for (const MechanismPtr& character : characters) {
      const auto out = retarget::retarget(clip.mechanism, clip.motion, character);
      ASSERT_TRUE(out) << clip.name << " to " << character->name() << ": " << out.error().text();
      const std::string label = clip.name + " to " + character->name();
      EXPECT_EQ(out->motion.frames, clip.motion.frames);
      EXPECT_TRUE(check_motion(out->motion, *character).empty()) << label;
      EXPECT_LE(worst_excess(*character, out->motion), 0) << label;
      EXPECT_LT(worst_skate(*character, out->motion), 0.01) << label;
      for (const retarget::Miss& miss : out->report.misses) EXPECT_LT(miss.maximum, 0.01) << label << ": " << miss.link;
      double standing = 0, frames = 0;
      for (const ContactTrack& track : out->motion.contacts)
        for (const std::uint8_t on : track.on) {
          standing += on;
          frames += 1;
        }
      EXPECT_GT(standing, 0.35 * frames) << label << ": feet must still have stances";
    }
}

TEST(Retarget, LabelledFeetTouchTheGround) {
  const Clip clip = human_walk();
  for (const MechanismPtr& character : {make_person(1.1), samples::make_dog(), make_hinged_robot()}) {
    const auto out = retarget::retarget(clip.mechanism, clip.motion, character);
    ASSERT_TRUE(out);
    std::vector<Pose> X(at(character->link_count()));
    for (int f = 0; f < out->motion.frames; ++f) {
      calc_poses(*character, {out->motion.frame(f), at(out->motion.nq)}, X);
      for (const ContactTrack& track : out->motion.contacts) {
        double low = 1e300;
        const int foot = character->find_link(track.link);
        for (int i = foot; i < character->link_count(); ++i)
          if (i == foot || character->link(i).parent == foot)
            for (const SupportPoint& p : support_points(character->link(i))) low = std::min(low, (X[at(i)] * p.p).z - p.radius);
        EXPECT_GT(low, -0.005) << character->name() << " frame " << f;
        if (track.on[at(f)]) {
          EXPECT_LT(low, 0.03) << character->name() << " frame " << f;
        }
      }
    }
  }
}

TEST(Retarget, KneesAndElbowsBendTheRightWay) {
  const Clip clip = human_walk();
  const MechanismPtr robot = make_hinged_robot();
  const auto out = retarget::retarget(clip.mechanism, clip.motion, robot);
  ASSERT_TRUE(out);
  double max_knee = 0, max_elbow = 0;
  const int knee = robot->link(robot->find_link("left_knee")).q_index, elbow = robot->link(robot->find_link("left_elbow")).q_index;
  for (int f = 0; f < out->motion.frames; ++f) {
    max_knee = std::max(max_knee, out->motion.frame(f)[knee]);
    max_elbow = std::min(max_elbow, out->motion.frame(f)[elbow]);
  }
  // The walk flexes the knee by 58 and the elbow by 34 degrees (docs/design/samples.md).
  EXPECT_NEAR(max_knee, 58 * pi / 180, 0.15);
  EXPECT_NEAR(max_elbow, -34 * pi / 180, 0.15);
}

TEST(Retarget, IsDeterministic) {
  const Clip clip = human_walk();
  const MechanismPtr dog = samples::make_dog();
  const auto a = retarget::retarget(clip.mechanism, clip.motion, dog), b = retarget::retarget(clip.mechanism, clip.motion, dog);
  ASSERT_TRUE(a && b);
  EXPECT_EQ(a->motion.q, b->motion.q);
}

TEST(Retarget, CancelledRunReturnsAnError) {
  const Clip clip = human_walk();
  bool cancelled = true;
  for (const bool balance : {false, true}) {
    RetargetOptions options;
    options.balance = balance;
    options.cancelled = [&] { return cancelled; };
    const auto out = retarget::retarget(clip.mechanism, clip.motion, samples::make_dog(), options);
    ASSERT_FALSE(out);
    EXPECT_EQ(out.error().problems[0].code, ErrorCode::cancelled);
  }
  cancelled = false;
  RetargetOptions options;
  options.cancelled = [&] { return cancelled; };
  EXPECT_TRUE(retarget::retarget(clip.mechanism, clip.motion, samples::make_dog(), options));
}

TEST(Retarget, GaitPhaseDelaysTheForeLegs) {
  const Clip clip = human_walk();
  const MechanismPtr dog = samples::make_dog();
  RetargetOptions walk;
  walk.gait_phase = 0.25;
  const auto trot = retarget::retarget(clip.mechanism, clip.motion, dog),
             other = retarget::retarget(clip.mechanism, clip.motion, dog, walk);
  ASSERT_TRUE(trot && other);
  const auto track = [](const Motion& m, const std::string& link) {
    for (const ContactTrack& t : m.contacts)
      if (t.link == link) return t.on;
    return std::vector<std::uint8_t>();
  };
  // In a trot the left fore leg stands with the right hind leg.
  const auto hind = track(trot->motion, "RightHindPaw"), fore = track(trot->motion, "LeftForePaw"),
             later = track(other->motion, "LeftForePaw");
  ASSERT_EQ(hind.size(), fore.size());
  int same = 0, changed = 0;
  for (std::size_t f = 0; f < hind.size(); ++f) {
    same += hind[f] == fore[f] ? 1 : 0;
    changed += fore[f] != later[f] ? 1 : 0;
  }
  EXPECT_GT(same, 0.9 * static_cast<double>(hind.size()));
  EXPECT_GT(changed, 0.1 * static_cast<double>(hind.size()));
}

TEST(Retarget, SpeedLimitIsReportedOrSlowsTheMotion) {
  Clip clip = human_walk();
  clip.motion.cyclic = false;
  const MechanismPtr robot = make_hinged_robot();
  RetargetOptions options;
  options.mapping.speed = 2;
  const auto reported = retarget::retarget(clip.mechanism, clip.motion, robot, options);
  ASSERT_TRUE(reported);
  EXPECT_GT(reported->report.max_speed, 1);
  EXPECT_EQ(reported->motion.rate, clip.motion.rate);
  options.slow_down = true;
  const auto slow = retarget::retarget(clip.mechanism, clip.motion, robot, options);
  ASSERT_TRUE(slow);
  double fastest = 0;
  for (int f = 1; f < slow->motion.frames; ++f)
    for (int k = 7; k < slow->motion.nq; ++k)
      fastest = std::max(fastest, std::fabs(slow->motion.frame(f)[k] - slow->motion.frame(f - 1)[k]) * slow->motion.rate);
  EXPECT_LE(fastest, 2 + 1e-9);
  EXPECT_GT(fastest, 1.99);
}

TEST(Retarget, RestingHandIsFoundAsAHold) {
  // Hips travel 0.4 m in 2 s; the left hand rests for the middle second.
  std::array<std::vector<Vec3>, 2> hands;
  std::vector<Vec3> hips;
  for (int f = 0; f < 240; ++f) {
    const double t = f / 120.0;
    hips.push_back({0.2 * t, 0, 0.9});
    const double x = f < 60 ? 0.3 * t : f < 180 ? 0.15 : 0.15 + 0.3 * (t - 1.5);
    hands[0].push_back({x, 0.3, 1.2});
    hands[1].push_back({0.2 * t + 0.6 * sin(4 * t), -0.5, 1.0});
  }
  const std::vector<retarget::Hold> holds = retarget::find_holds(hands, hips, 120, 0.9);
  ASSERT_EQ(holds.size(), 1U);
  EXPECT_EQ(holds[0].hand, 0);
  EXPECT_NEAR(holds[0].first, 60, 3);
  EXPECT_NEAR(holds[0].last, 180, 3);
  EXPECT_NEAR(holds[0].point.x, 0.15, 0.005);
  EXPECT_EQ(retarget::weight_of(holds[0], 120, 120), 1);
  EXPECT_EQ(retarget::weight_of(holds[0], 239, 120), 0);
}

TEST(Retarget, HoldingHandStaysAtItsPoint) {
  // The person bends and stretches the knees by 12 cm while both wrists stay at fixed points.
  Clip clip = human_walk();
  const MechanismPtr person = make_person(1.75), child = make_person(1.1);
  Motion motion;
  motion.name = "knee bend";
  motion.rate = 120;
  motion.frames = 240;
  motion.nq = person->nq();
  std::vector<double> q = person->neutral();
  std::vector<Pose> X(at(person->link_count()));
  retarget::ChainSolver solver(*person);
  const auto chain_to = [&](const char* end, int count) {
    std::vector<int> chain;
    for (int i = person->find_link(end); count-- > 0; i = person->link(i).parent) chain.insert(chain.begin(), i);
    return chain;
  };
  const auto put = [&](const char* end, int count, const Vec3& target) {
    const std::vector<int> chain = chain_to(end, count);
    retarget::ChainGoal goal;
    goal.target = target;
    goal.turn = false;
    goal.iterations = 60;
    EXPECT_LT(solver.solve(chain, goal, q.data(), X), 1e-6);
  };
  calc_poses(*person, q, X);
  const double ankle = 0.07;
  for (int f = 0; f < motion.frames; ++f) {
    q[2] += (f == 0 ? -X[at(person->find_link("LeftFoot"))].p.z + ankle - 0.10 : 0) -
            (f > 0 ? 0.06 * (sin(2 * pi * f / 240.0) - sin(2 * pi * (f - 1) / 240.0)) : 0);
    if (f == 0)
      for (const char* knee : {"LeftLeg", "RightLeg"}) q[at(person->link(person->find_link(knee)).q_index)] = 0.5;
    calc_poses(*person, q, X);
    put("LeftFoot", 3, {0, 0.1, ankle});
    put("RightFoot", 3, {0, -0.1, ankle});
    put("LeftHand", 3, {0.35, 0.25, 1.15});
    put("RightHand", 3, {0.35, -0.25, 1.15});
    motion.q.insert(motion.q.end(), q.begin(), q.end());
  }
  const auto out = retarget::retarget(person, motion, child);
  ASSERT_TRUE(out) << out.error().text();
  ASSERT_FALSE(out->report.holds.empty());
  std::vector<Pose> Y(at(child->link_count()));
  const int hand = child->find_link("LeftHand");
  double path = 0;
  Vec3 before;
  for (int f = 60; f < 180; ++f) {  // in the middle of the motion the hips are fast
    calc_poses(*child, {out->motion.frame(f), at(out->motion.nq)}, Y);
    if (f > 60) path += norm(Y[at(hand)].p - before);
    before = Y[at(hand)].p;
  }
  EXPECT_LT(path, 0.002);
  EXPECT_NEAR(before.x, 0.35 * out->report.scale, 0.002);
}

TEST(ChainSolver, ReachesReachablePosesWithinLimits) {
  const MechanismPtr robot = make_hinged_robot();
  retarget::ChainSolver solver(*robot);
  std::vector<int> chain;
  for (int i = robot->find_link("left_ankle_roll"); robot->link(i).parent >= 0; i = robot->link(i).parent) chain.insert(chain.begin(), i);
  std::uint64_t seed = 20240607;
  std::printf("seed %llu\n", static_cast<unsigned long long>(seed));
  const auto random = [&] {
    seed = seed * 6364136223846793005ULL + 1442695040888963407ULL;
    return static_cast<double>(seed >> 11) / 9007199254740992.0;
  };
  int reached = 0;
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<double> q = robot->neutral(), start = q;
    for (const int i : chain) {
      const Link& l = robot->link(i);
      const double low = l.joint.dofs[0].lower, high = l.joint.dofs[0].upper;
      q[at(l.q_index)] = low + (high - low) * random();
      start[at(l.q_index)] = q[at(l.q_index)] + 0.3 * (random() - 0.5);
      start[at(l.q_index)] = std::min(std::max(start[at(l.q_index)], low), high);
    }
    std::vector<Pose> X(at(robot->link_count()));
    calc_poses(*robot, q, X);
    retarget::ChainGoal goal;
    goal.target = X[at(chain.back())].p;
    goal.R = X[at(chain.back())].R;
    goal.iterations = 100;
    calc_poses(*robot, start, X);
    const double miss = solver.solve(chain, goal, start.data(), X);
    reached += miss < 1e-6 ? 1 : 0;
    for (const int i : chain) {
      const Link& l = robot->link(i);
      EXPECT_GE(start[at(l.q_index)], l.joint.dofs[0].lower);
      EXPECT_LE(start[at(l.q_index)], l.joint.dofs[0].upper);
    }
    calc_poses(*robot, start, X);
    EXPECT_NEAR(norm(X[at(chain.back())].p - goal.target), miss, 1e-12);
  }
  EXPECT_GE(reached, 190);
}

TEST(Anatomy, IsFoundOnARobotAndAnAnimal) {
  const auto robot = retarget::find_anatomy(*make_hinged_robot());
  ASSERT_TRUE(robot);
  EXPECT_FALSE(robot->four_legs);
  EXPECT_EQ(robot->limb(retarget::LimbName::left_leg).links.size(), 6U);
  EXPECT_TRUE(robot->limb(retarget::LimbName::right_arm).found());
  const MechanismPtr dog = samples::make_dog();
  const auto animal = retarget::find_anatomy(*dog);
  ASSERT_TRUE(animal);
  EXPECT_TRUE(animal->four_legs);
  EXPECT_EQ(dog->link(animal->pelvis).name, "Pelvis");
  EXPECT_EQ(dog->link(animal->chest()).name, "Chest");
  EXPECT_EQ(dog->link(animal->head()).name, "Head");
  EXPECT_EQ(animal->tail.size(), 4U);
  // Without labels the shape of the tree and the link names give the same anatomy.
  MechanismSpec spec = dog->spec();
  for (LinkSpec& l : spec.links) l.label.clear();
  const auto unlabelled = retarget::find_anatomy(**Mechanism::make(std::move(spec)));
  ASSERT_TRUE(unlabelled);
  EXPECT_TRUE(unlabelled->four_legs);
  for (int k = 0; k < retarget::limb_count; ++k) EXPECT_EQ(unlabelled->limbs[at(k)].begin, animal->limbs[at(k)].begin) << k;
}

TEST(Mapping, IsReadAndApplied) {
  const MechanismPtr robot = make_hinged_robot();
  const auto mapping = retarget::read_mapping(
      R"({"target": {"legs": 2, "left leg": {"upper": "left_hip_yaw", "lower": "left_knee", "end": "left_ankle_pitch"},
    "head": "head_yaw"}, "links": {"head_yaw": "Head"}, "soles": {"left_ankle_roll": [[0.1, 0, -0.09], [-0.1, 0, -0.09], [0, 0.03, -0.09]]}, "speed": 3,
    "speeds": {"left_knee": 1}})",
      "m.json");
  ASSERT_TRUE(mapping) << mapping.error().text();
  EXPECT_EQ(mapping->target.limbs[0][2], "left_knee");
  EXPECT_EQ(mapping->soles[0].points.size(), 3U);
  EXPECT_EQ(mapping->link_speeds[0].second, 1);
  RetargetOptions options;
  options.mapping = *mapping;
  const Clip clip = human_walk();
  const auto out = retarget::retarget(clip.mechanism, clip.motion, robot, options);
  ASSERT_TRUE(out) << out.error().text();
  EXPECT_GT(out->report.max_speed, 1);
}

TEST(Mapping, ProblemsNameTheirLocation) {
  for (const auto& [text, location] : std::vector<std::pair<std::string, std::string>>{
           {R"([1])", "m.json"},
           {R"({"sauce": {}})", "m.json/sauce"},
           {R"({"target": {"left leg": {"upper": "a"}}})", "m.json/target/left leg"},
           {R"({"target": {"left leg": {"knee": "a", "upper": "b", "lower": "c"}}})", "m.json/target/left leg/knee"},
           {R"({"soles": {"f": [[1, 2]]}})", "m.json/soles/f"},
           {R"({"speed": -1})", "m.json/speed"},
           {R"({"source": {"tail": [1]}})", "m.json/source/tail"}}) {
    const auto mapping = retarget::read_mapping(text, "m.json");
    ASSERT_FALSE(mapping) << text;
    EXPECT_EQ(mapping.error().problems[0].location, location);
  }
  EXPECT_FALSE(retarget::read_mapping("{", "m.json"));
}

TEST(Retarget, InvalidInputIsRejectedWithAReason) {
  const Clip clip = human_walk();
  MechanismSpec spec;
  spec.name = "pole";
  spec.links.push_back({.name = "pole",
                        .parent = "",
                        .joint = {},
                        .inertia = Inertia::from_centre(1, {}, {1, 1, 1, 0, 0, 0}),
                        .shapes = {},
                        .real = "",
                        .X_RV = {},
                        .label = ""});
  const auto pole = retarget::retarget(clip.mechanism, clip.motion, *Mechanism::make(spec));
  ASSERT_FALSE(pole);
  EXPECT_NE(pole.error().text().find("legs"), std::string::npos) << pole.error().text();
  MechanismSpec fixed = make_hinged_robot()->spec();
  fixed.links[0].joint.type = JointType::fixed;
  const auto bolted = retarget::retarget(clip.mechanism, clip.motion, *Mechanism::make(fixed));
  ASSERT_FALSE(bolted);
  EXPECT_NE(bolted.error().text().find("float"), std::string::npos) << bolted.error().text();
  Motion broken = clip.motion;
  broken.q[5] = NAN;
  EXPECT_FALSE(retarget::retarget(clip.mechanism, broken, make_person(1.1)));
  RetargetOptions options;
  options.mapping.target.pelvis = "nowhere";
  EXPECT_FALSE(retarget::retarget(clip.mechanism, clip.motion, make_person(1.1), options));
}

}  // namespace
}  // namespace ugoki::retarget_test
