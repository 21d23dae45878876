// Bodies from measured skeletons: masses, mirror symmetry, positions, limits, all shared files.

#include "ugoki/body/body.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "measured_files.h"
#include "ugoki/body/anatomy.h"
#include "ugoki/body/segments.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/motion/contact_labels.h"
#include "ugoki/samples/samples.h"

namespace ugoki::body {
namespace {

#define SKIP_WITHOUT_DATA() \
  if (testing::all_files().empty()) GTEST_SKIP() << "The shared measured data are absent."

double total_mass(const Mechanism& m) {
  double sum = 0;
  for (const Link& l : m.links()) sum += l.inertia.mass;
  return sum;
}

std::string mirrored_label(std::string label) {
  if (label.ends_with(" left")) return label.replace(label.size() - 4, 4, "right");
  if (label.ends_with(" right")) return label.replace(label.size() - 5, 5, "left");
  return {};
}

const Link* labelled(const Mechanism& m, const std::string& label) {
  for (const Link& l : m.links())
    if (l.label == label) return &l;
  return nullptr;
}

/// Checks of every human body: labels, mass, mirror symmetry, positions, limits.
void check_human(const MeasuredMotion& measured, const Body& body) {
  const Mechanism& m = *body.mechanism;
  EXPECT_TRUE(body.human) << body.report.front();
  EXPECT_NEAR(total_mass(m) / body.mass, 1, 1e-9);
  EXPECT_GT(body.height, 1.45);
  EXPECT_LT(body.height, 2.0);
  for (const char* label : {"pelvis", "abdomen", "chest", "neck", "head", "thigh left", "shank right", "foot left", "toes right",
                            "upper arm left", "forearm right", "hand left"})
    EXPECT_NE(labelled(m, label), nullptr) << label;
  // Left and right are bitwise mirror images.
  for (const Link& l : m.links()) {
    const std::string other = mirrored_label(l.label);
    if (other.empty()) continue;
    const Link* r = labelled(m, other);
    ASSERT_NE(r, nullptr) << other;
    EXPECT_EQ(l.inertia.mass, r->inertia.mass) << l.label;
    EXPECT_EQ(l.inertia.h, (Vec3{r->inertia.h.x, -r->inertia.h.y, r->inertia.h.z})) << l.label;
    const Sym3 &a = l.inertia.I, &b = r->inertia.I;
    EXPECT_EQ(a, (Sym3{b.xx, b.yy, b.zz, -b.xy, b.xz, -b.yz})) << l.label;
  }
  // Movable end links have enough mass and inertia for a well-conditioned mass matrix.
  for (const Link& l : m.links())
    if (l.joint.nv() > 0 && m.link_count() > 0 && l.child < 0) {
      EXPECT_GT(l.inertia.mass, 0.001) << l.name;
      const Sym3 c = l.inertia.about_centre();
      EXPECT_GT(std::min({c.xx, c.yy, c.zz}), 2e-5) << l.name;
    }
  const Motion motion = to_motion(body, measured);
  EXPECT_TRUE(check_motion(motion, m).empty()) << check_motion(motion, m).text();
  EXPECT_LT(calc_position_error(body, measured, motion), 1e-6);
  // The joint limits contain the measured motion.
  for (int f = 0; f < motion.frames; ++f)
    for (const Link& l : m.links()) {
      double x[6];
      joint_displacement(l.joint, motion.frame(f) + l.q_index, x);
      for (int k = 0; k < l.joint.nv(); ++k) {
        const Dof& dof = l.joint.dofs[static_cast<std::size_t>(k)];
        ASSERT_GE(x[k], dof.lower) << l.name << " in frame " << f;
        ASSERT_LE(x[k], dof.upper) << l.name << " in frame " << f;
      }
    }
}

TEST(Segments, MassesSumToOneAndMeanIsTheAverage) {
  for (const Sex sex : {Sex::male, Sex::female, Sex::mean}) {
    const SegmentTable t = segment_table(sex);
    const double sum = t.head.mass + t.upper_trunk.mass + t.middle_trunk.mass + t.lower_trunk.mass +
                       2 * (t.upper_arm.mass + t.forearm.mass + t.hand.mass + t.thigh.mass + t.shank.mass + t.foot.mass);
    EXPECT_NEAR(sum, 1, 2e-3);
  }
  EXPECT_NEAR(segment_table(Sex::mean).thigh.mass, 0.1447, 1e-12);
}

TEST(Body, SyntheticCharacterGetsTheSimplestJoints) {
  const MeasuredMotion measured = testing::made_character();
  BodyOptions options;
  options.height = 1.75;
  options.mass = 70;
  const auto body = make_body(measured, options);
  ASSERT_TRUE(body.has_value()) << body.error().text();
  check_human(measured, *body);
  EXPECT_NEAR(body->mechanism->mass(), 70, 70e-9);
  EXPECT_EQ(body->height, 1.75);
  // Knees only bend, so they are hinges about the sideways axis. Arms are spherical. The spine does not move, so it is fixed.
  const Mechanism& m = *body->mechanism;
  EXPECT_EQ(m.link(m.find_link("LeftLeg")).joint.type, JointType::revolute);
  EXPECT_NEAR(std::fabs(m.link(m.find_link("LeftLeg")).joint.axis.y), 1, 1e-9);
  EXPECT_EQ(m.link(m.find_link("LeftArm")).joint.type, JointType::spherical);
  EXPECT_EQ(m.link(m.find_link("Spine")).joint.type, JointType::fixed);
  EXPECT_EQ(m.link(0).joint.type, JointType::floating);
}

TEST(Body, CentreOfMassOfAnUprightCharacterIsThatOfHumans) {
  // With arms down the centre of mass is at about 57 % of the height (Winter 2009); with arms sideways it is about 3 cm higher.
  const MeasuredMotion measured = testing::made_character(1);
  BodyOptions options;
  options.height = 1.75;
  options.mass = 70;
  const auto body = make_body(measured, options);
  ASSERT_TRUE(body.has_value());
  const Mechanism& m = *body->mechanism;
  std::vector<Pose> X(static_cast<std::size_t>(m.link_count()));
  calc_poses(m, m.neutral(), X);
  const double ground = -(0.02 + 0.43 + 0.43 + 0.035 + 0.03);
  const Vec3 c = centre_of_mass(m, X);
  EXPECT_NEAR((c.z - ground) / 1.75, 0.575, 0.025);
  EXPECT_NEAR(c.y, 0, 1e-12);
  EXPECT_NEAR(c.x, 0.02, 0.03);
}

TEST(Body, ATrunkJointThatIsNoLowerThanTheNextOneHasAMass) {
  MeasuredMotion measured = testing::made_character();
  const auto chest = std::ranges::find(measured.skeleton.joints, "Chest", &SkeletonJoint::name);
  ASSERT_NE(chest, measured.skeleton.joints.end());
  const auto index = static_cast<std::size_t>(chest - measured.skeleton.joints.begin());
  chest->offset = {0.02, 0, -0.01};
  for (int f = 0; f < measured.frames; ++f)
    measured.translations[static_cast<std::size_t>(f) * measured.skeleton.joints.size() + index] = chest->offset;
  const auto body = make_body(measured, {});
  ASSERT_TRUE(body.has_value()) << body.error().text();
  ASSERT_TRUE(body->human);
  const Mechanism& m = *body->mechanism;
  const double spine = m.link(m.find_link("Spine")).inertia.mass;
  EXPECT_GT(spine, 0.002 * m.mass());
  EXPECT_LT(spine, 0.05 * m.mass());
}

TEST(Body, SegmentsHaveTheMassesOfTheTable) {
  const MeasuredMotion measured = testing::made_character();
  BodyOptions options;
  options.mass = 100;
  options.sex = Sex::male;
  const auto body = make_body(measured, options);
  ASSERT_TRUE(body.has_value());
  const Mechanism& m = *body->mechanism;
  const SegmentTable t = segment_table(Sex::male);
  EXPECT_NEAR(labelled(m, "thigh left")->inertia.mass, 100 * t.thigh.mass, 0.1);
  EXPECT_NEAR(labelled(m, "shank left")->inertia.mass, 100 * t.shank.mass, 0.1);
  EXPECT_NEAR(labelled(m, "foot left")->inertia.mass + labelled(m, "toes left")->inertia.mass, 100 * t.foot.mass, 0.1);
  // Centre of mass and radii of gyration of the thigh are those of the segment table, times the length of 0.43 m from hip to knee.
  const Inertia& thigh = labelled(m, "thigh left")->inertia;
  EXPECT_NEAR(norm(thigh.centre()), t.thigh.centre * 0.43, 1e-9);
  EXPECT_NEAR(std::sqrt(thigh.about_centre().yy / thigh.mass), t.thigh.transverse * 0.43, 1e-9);
  EXPECT_NEAR(std::sqrt(thigh.about_centre().zz / thigh.mass), t.thigh.longitudinal * 0.43, 1e-9);
}

TEST(Body, MassFromTheFileIsUsedIfPlausible) {
  MeasuredMotion measured = testing::made_character(10);
  measured.skeleton.mass = 81;
  EXPECT_NEAR(make_body(measured)->mass, 81, 1e-9);
  measured.skeleton.mass = 1;  // kg, a placeholder in CMU's files
  const auto body = make_body(measured);
  EXPECT_NEAR(body->mass, 22.5 * body->height * body->height, 1e-9);
}

TEST(Body, RestPostureMayFaceAnyDirection) {
  MeasuredMotion measured = testing::made_character(60);
  // Turn the whole rest position by 90 degrees: left is now -x.
  const Quat turn = axis_angle({0, 0, 1}, pi / 2);
  for (SkeletonJoint& j : measured.skeleton.joints) {
    j.offset = rotate(turn, j.offset);
    for (Vec3& e : j.end_sites) e = rotate(turn, e);
  }
  for (std::size_t i = 0; i < measured.rotations.size(); ++i) {
    measured.rotations[i] = turn * measured.rotations[i] * turn.conjugate();
    measured.translations[i] = rotate(turn, measured.translations[i]);
  }
  const auto turned = make_body(measured), straight = make_body(testing::made_character(60));
  ASSERT_TRUE(turned.has_value());
  EXPECT_TRUE(turned->human);
  const Link* a = labelled(*straight->mechanism, "foot left");
  const Link* b = labelled(*turned->mechanism, "foot left");
  ASSERT_TRUE(a && b);
  EXPECT_EQ(a->name, b->name);
  EXPECT_NEAR(norm(a->inertia.centre() - b->inertia.centre()), 0, 1e-9);  // both bodies have the canonical rest pose
  EXPECT_LT(calc_position_error(*turned, measured, to_motion(*turned, measured)), 1e-9);
}

TEST(Body, UnmovedJointsAreFixedUnlessKept) {
  MeasuredMotion measured = testing::made_character(2);
  const std::size_t joints = measured.skeleton.joints.size();
  std::copy_n(measured.rotations.begin(), joints, measured.rotations.begin() + static_cast<std::ptrdiff_t>(joints));
  std::copy_n(measured.translations.begin(), joints, measured.translations.begin() + static_cast<std::ptrdiff_t>(joints));
  BodyOptions keep;
  keep.keep_unmoved = true;
  EXPECT_EQ(make_body(measured)->mechanism->nv(), 6);
  EXPECT_EQ(make_body(measured, keep)->mechanism->nv(), 6 + 3 * 18);
}

TEST(Body, SingleFrameLeavesBonesMovable) {
  const MeasuredMotion rig = testing::made_character(1);
  const auto body = make_body(rig);
  ASSERT_TRUE(body);
  const std::vector<SkeletonJoint>& joints = rig.skeleton.joints;
  std::vector<bool> carries(joints.size());
  for (std::size_t i = 0; i < joints.size(); ++i) {
    if (!joints[i].end_sites.empty()) carries[i] = true;
    if (joints[i].parent >= 0) carries[static_cast<std::size_t>(joints[i].parent)] = true;
  }
  for (std::size_t i = 0; i < joints.size(); ++i)
    if (carries[i]) EXPECT_GT(body->mechanism->link(body->mechanism->find_link(joints[i].name)).joint.nv(), 0) << joints[i].name;
  EXPECT_LT(calc_position_error(*body, rig, to_motion(*body, rig)), 1e-9);
}

TEST(Body, SmearedCalibrationPoseIsReplaced) {
  // A T pose before the motion, as converters write it, and the same after a low-pass filter, which mixes it into the next frames.
  const MeasuredMotion walk = samples::make_human_walk();
  EXPECT_EQ(count_calibration_frames(walk), 0);
  const std::size_t n = walk.skeleton.joints.size();
  const auto with_pose = [&](std::initializer_list<double> shares) {
    MeasuredMotion m = walk;
    std::size_t f = 0;
    for (const double share : shares) {
      for (std::size_t i = 0; i < n; ++i) {
        Quat& q = m.rotations[f * n + i];
        q = q * exp_map(log_map(q.conjugate() * exp_map({0.4, -0.6, 0.5})) * share);
      }
      ++f;
    }
    return m;
  };
  const MeasuredMotion sharp = with_pose({1}), smeared = with_pose({1, 0.55, 0.3, 0.12});
  EXPECT_EQ(count_calibration_frames(sharp), 1);
  EXPECT_EQ(count_calibration_frames(smeared), 4);
  const auto body = make_body(smeared);
  ASSERT_TRUE(body) << body.error().text();
  EXPECT_NE(std::ranges::find_if(body->report, [](const std::string& r) { return r.find("first 4 frames") != std::string::npos; }),
            body->report.end());
  // The extrapolated frames are close to the walk, and the others are unchanged.
  const auto original = make_body(walk);
  ASSERT_TRUE(original);
  const Motion a = to_motion(*body, smeared), b = to_motion(*original, walk);
  std::vector<Pose> X(n), Y(n);
  for (const int f : {0, 3, 4, 20}) {
    calc_poses(*body->mechanism, std::span<const double>(a.frame(f), static_cast<std::size_t>(a.nq)), X);
    calc_poses(*original->mechanism, std::span<const double>(b.frame(f), static_cast<std::size_t>(b.nq)), Y);
    for (std::size_t i = 0; i < n; ++i) EXPECT_LT(norm(X[i].p - Y[i].p), f < 4 ? 0.05 : 0.01) << f << " " << i;
  }
}

TEST(Body, JointThatTurnsOverIsReported) {
  MeasuredMotion measured = testing::made_character(20);
  const std::size_t joints = measured.skeleton.joints.size();
  const auto reports_jump = [](const Body& body) {
    return std::any_of(body.report.begin(), body.report.end(), [](const std::string& s) {
      return s.find("turn over from one frame to the next in the data: Chest (2);") != s.npos;
    });
  };
  EXPECT_FALSE(reports_jump(*make_body(measured)));
  for (std::size_t f = 8; f < 12; ++f) measured.rotations[f * joints + 2] = exp_map({0, 0, pi}) * measured.rotations[f * joints + 2];
  EXPECT_TRUE(reports_jump(*make_body(measured)));
}

TEST(Body, ShiftingJointIsReported) {
  MeasuredMotion measured = testing::made_character(20);
  measured.translations[5 * measured.skeleton.joints.size() + 2].z += 0.01;
  const auto body = make_body(measured);
  ASSERT_TRUE(body.has_value());
  EXPECT_TRUE(std::any_of(body->report.begin(), body->report.end(),
                          [](const std::string& s) { return s.find("Joint Chest is measured to shift by up to 10.0 mm") == 0; }));
  // A joint at a constant position that differs from the skeleton's offset is reproduced exactly.
  measured = testing::made_character(20);
  for (std::size_t f = 0; f < 20; ++f) measured.translations[f * measured.skeleton.joints.size() + 2].z += 0.01;
  const auto held = make_body(measured);
  EXPECT_LT(calc_position_error(*held, measured, to_motion(*held, measured)), 1e-9);
}

TEST(Body, InvalidSkeletonIsRejected) {
  MeasuredMotion empty;
  EXPECT_FALSE(make_body(empty).has_value());
  MeasuredMotion bad = testing::made_character(3);
  bad.skeleton.joints[4].offset.x = std::nan("");
  const auto body = make_body(bad);
  ASSERT_FALSE(body.has_value());
  EXPECT_NE(body.error().text().find("Head"), std::string::npos);
}

TEST(Body, SharedWalksPassAllChecks) {
  SKIP_WITHOUT_DATA();
  for (const char* file : {"bvh/cmu_12_01_walk.bvh", "asf_amc/35_01.amc"}) {
    const MeasuredMotion measured = testing::read(file);
    const auto body = make_body(measured);
    ASSERT_TRUE(body.has_value()) << body.error().text();
    check_human(measured, *body);
  }
}

TEST(Body, SkeletonsThatAreNotHumanGetCapsules) {
  SKIP_WITHOUT_DATA();
  for (const char* file : {"bvh/sinusoidal.bvh", "bvh/full_precision_frame_time.bvh", "bvh/rotation_first_root.bvh"}) {
    const MeasuredMotion measured = testing::read(file);
    const auto body = make_body(measured);
    ASSERT_TRUE(body.has_value()) << body.error().text();
    EXPECT_FALSE(body->human);
    EXPECT_NE(body->report.front().find("No human anatomy"), std::string::npos);
    EXPECT_GT(body->mass, 0);
    const Motion motion = to_motion(*body, measured);
    EXPECT_TRUE(check_motion(motion, *body->mechanism).empty());
    EXPECT_LT(calc_position_error(*body, measured, motion), 1e-6) << file;
    BodyOptions options;
    options.mass = 3;
    EXPECT_NEAR(make_body(measured, options)->mechanism->mass(), 3, 3e-9);
  }
}

TEST(SlowBody, EverySharedHumanPassesAllChecks) {
  SKIP_WITHOUT_DATA();
  for (const std::string& file : testing::human_files()) {
    SCOPED_TRACE(file);
    const MeasuredMotion measured = testing::read(file);
    const auto body = make_body(measured);
    ASSERT_TRUE(body.has_value()) << body.error().text();
    check_human(measured, *body);
  }
}

TEST(Body, AnatomyWithoutNamesIsFoundForEveryHeading) {
  const Skeleton named = testing::made_character(1).skeleton;
  const Anatomy expected = find_anatomy(named);
  ASSERT_TRUE(expected.human) << expected.why_not;
  for (const double degrees : {0.0, 30.0, 90.0, 135.0, 180.0, 250.0, 270.0, 330.0}) {
    const double c = std::cos(degrees * pi / 180), s = std::sin(degrees * pi / 180);
    const Mat3 turn = Mat3::columns({c, s, 0}, {-s, c, 0}, {0, 0, 1});
    Skeleton nameless = named;
    for (std::size_t i = 0; i < nameless.joints.size(); ++i) {
      SkeletonJoint& joint = nameless.joints[i];
      joint.name = "node_" + std::to_string(i);
      joint.offset = turn * joint.offset;
      for (Vec3& e : joint.end_sites) e = turn * e;
    }
    const Anatomy found = find_anatomy(nameless);
    ASSERT_TRUE(found.human) << degrees << " degrees: " << found.why_not;
    for (std::size_t i = 0; i < nameless.joints.size(); ++i) {
      const SidedPart a = expected.parts[i], b = found.parts[i];
      EXPECT_EQ(a.part, b.part) << named.joints[i].name << ", " << degrees << " degrees";
      EXPECT_EQ(a.side, b.side) << named.joints[i].name << ", " << degrees << " degrees";
    }
  }
}

}  // namespace
}  // namespace ugoki::body
