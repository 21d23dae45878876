// Synthetic markers on a character with known joints, and recordings with a published solution.
#include "ugoki/capture/capture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <iterator>
#include <random>

#include "ugoki/capture/model.h"
#include "ugoki/formats/asf.h"
#include "ugoki/formats/c3d.h"
#include "ugoki/formats/trc.h"

namespace ugoki::capture {
namespace {

/// A synthetic motion of a character whose proportions differ from the model's, and its markers with placement errors.
struct Known {
  MeasuredMotion truth;  ///< the exact motion
  MarkerMotion markers;
};

Known make_known(const MarkerSet& set, double size, unsigned seed, double placement_error) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> within(-1, 1);
  Known k;
  MeasuredMotion& t = k.truth;
  t.rate = 100;
  t.frames = 200;
  for (const ModelSegment& s : set.segments) {
    SkeletonJoint j;
    j.name = s.name;
    j.parent = s.parent;
    const double longer = s.mirror >= 0 ? 1.04 : 0.97;
    j.offset = s.offset * (size * longer);
    t.skeleton.joints.push_back(j);
  }
  const std::size_t n = set.segments.size();
  std::vector<double> phase, swing;
  for (std::size_t i = 0; i < n; ++i) {
    phase.push_back(3 * within(random));
    swing.push_back(0.25 + 0.1 * within(random));
  }
  for (int f = 0; f < t.frames; ++f) {
    const double w = 6.2831853 * f / 100;
    for (std::size_t i = 0; i < n; ++i) {
      const ModelSegment& s = set.segments[i];
      const double a = swing[i] * std::sin(w + phase[i]), b = swing[i] * std::sin(2 * w + phase[i]);
      Quat q;
      if (s.joint == ModelJoint::root) q = axis_angle({0, 0, 1}, 0.7 + 0.2 * a) * exp_map({0.2 * a, 0.2 * b, 0});
      if (s.joint == ModelJoint::ball)
        q = exp_map({a * s.stiffness_sigma, b * std::min(1.0, s.stiffness_sigma), 0.3 * a * s.stiffness_sigma});
      if (s.joint == ModelJoint::hinge) q = axis_angle(s.axis, 0.5 + a);
      if (s.joint == ModelJoint::universal) q = axis_angle(s.axis, 0.5 + a) * axis_angle(s.second_axis, 0.5 * b);
      t.rotations.push_back(q);
      t.translations.push_back(s.parent < 0 ? Vec3{0.01 * f, 0.3, 0.95 * size + 0.02 * a} : t.skeleton.joints[i].offset);
    }
  }
  MarkerMotion& m = k.markers;
  m.name = "known";
  m.source = "known";
  m.rate = t.rate;
  m.frames = t.frames;
  std::vector<Vec3> offsets;
  for (const ModelMarker& marker : set.markers) {
    m.labels.push_back(marker.labels[0]);
    const Vec3 error{within(random), within(random), within(random)};
    offsets.push_back(marker.at * size + error * (placement_error * std::min(1.0, marker.sigma / 0.01)));
  }
  std::vector<Pose> X;
  for (int f = 0; f < m.frames; ++f) {
    t.calc_joint_poses(f, X);
    for (std::size_t i = 0; i < offsets.size(); ++i) {
      m.positions.push_back(X[static_cast<std::size_t>(set.markers[i].segment)] * offsets[i]);
      m.residuals.push_back(0);
    }
  }
  return k;
}

int joint_of(const MeasuredMotion& m, const std::string& name) {
  for (int i = 0; i < m.joint_count(); ++i)
    if (m.skeleton.joints[static_cast<std::size_t>(i)].name == name) return i;
  ADD_FAILURE() << "no joint " << name;
  return 0;
}

Vec3 position(const MeasuredMotion& m, int frame, const std::string& joint) {
  std::vector<Pose> X;
  m.calc_joint_poses(frame, X);
  return X[static_cast<std::size_t>(joint_of(m, joint))].p;
}

/// Root mean square [m] of the distance between corresponding joints of two motions.
double rms_distance(const MeasuredMotion& a, const MeasuredMotion& b, const std::vector<std::pair<std::string, std::string>>& joints) {
  double sum = 0;
  std::vector<Pose> X, Y;
  for (int f = 0; f < b.frames; ++f) {
    a.calc_joint_poses(f, X);
    b.calc_joint_poses(f, Y);
    for (const auto& [in_a, in_b] : joints) {
      const Vec3 d = X[static_cast<std::size_t>(joint_of(a, in_a))].p - Y[static_cast<std::size_t>(joint_of(b, in_b))].p;
      sum += dot(d, d);
    }
  }
  return std::sqrt(sum / (static_cast<double>(joints.size()) * b.frames));
}

/// Angle [degrees] between the segments a b and b c.
double flexion(const MeasuredMotion& m, int frame, const std::string& a, const std::string& b, const std::string& c) {
  const Vec3 u = position(m, frame, b) - position(m, frame, a), v = position(m, frame, c) - position(m, frame, b);
  return std::atan2(norm(cross(u, v)), dot(u, v)) * 57.29577951308232;
}

TEST(Capture, SyntheticMotionIsRecovered) {
  const Known k = make_known(human_markers(), 0.9, 5, 0);
  const auto c = solve_markers(k.markers, {.cutoff = -1});
  ASSERT_TRUE(c.has_value()) << c.error().text();
  EXPECT_LT(c->rms, 0.003);
  std::vector<std::pair<std::string, std::string>> joints;
  for (const char* name : {"LeftUpLeg", "RightLeg", "LeftFoot", "RightFoot", "LeftArm", "RightForeArm", "LeftHand", "Head"})
    joints.emplace_back(name, name);
  EXPECT_LT(rms_distance(c->measured, k.truth, joints), 0.015);
  EXPECT_TRUE(c->unused.empty());
}

TEST(Capture, MisplacedMarkersCauseSmallErrors) {
  for (const unsigned seed : {1U, 2U}) {
    SCOPED_TRACE(seed);
    const Known k = make_known(human_markers(), 1.05, seed, 0.006);
    const auto c = solve_markers(k.markers);
    ASSERT_TRUE(c.has_value()) << c.error().text();
    EXPECT_LT(c->rms, 0.006);
    double worst = 0;
    for (int f = 0; f < k.truth.frames; f += 7)
      worst = std::max(worst, std::fabs(flexion(c->measured, f, "LeftUpLeg", "LeftLeg", "LeftFoot") -
                                        flexion(k.truth, f, "LeftUpLeg", "LeftLeg", "LeftFoot")));
    EXPECT_LT(worst, 6);
  }
}

TEST(Capture, AnimalMotionIsRecovered) {
  const Known k = make_known(quadruped_key_points(), 3, 9, 0.001);
  const auto c = solve_markers(k.markers, {.cutoff = -1});
  ASSERT_TRUE(c.has_value()) << c.error().text();
  EXPECT_LT(c->rms, 0.01);
  EXPECT_NEAR(c->size, 3, 0.3);
}

TEST(Capture, ResidualsNameMarkerAndFrame) {
  Known k = make_known(human_markers(), 1, 3, 0);
  const int knee = k.markers.find("LKNE");
  k.markers.positions[k.markers.index(120, knee)] += Vec3{0, 0.015, 0};  // this error is too small to be removed as a spike
  const auto c = solve_markers(k.markers, {.cutoff = -1});
  ASSERT_TRUE(c.has_value());
  for (const MarkerResidual& r : c->residuals)
    if (r.label == "LKNE") EXPECT_EQ(r.worst_frame, 120);
  EXPECT_EQ(c->frame_rms.size(), 200U);
  EXPECT_GT(c->frame_rms[120], c->frame_rms[119]);
}

void hide(MarkerMotion& m, const std::string& label, int first, int last) {
  const int marker = m.find(label);
  for (int f = first; f <= last; ++f) {
    m.positions[m.index(f, marker)] = {};
    m.residuals[m.index(f, marker)] = -1;
  }
}

TEST(Capture, CancelledWorkEndsBeforeTheNextFrame) {
  const Known k = make_known(human_markers(), 1.05, 4, 0.006);
  MarkerMotion gaps = k.markers;
  hide(gaps, "RKNE", 60, 119);  // this gap is filled from the pose of the body, which needs a second pass over the frames
  for (const MarkerMotion* motion : {&k.markers, static_cast<const MarkerMotion*>(&gaps)}) {
    for (const int allowed : {0, 1, 40}) {
      int calls = 0;
      const auto c = solve_markers(*motion, {.cutoff = -1, .cancelled = [&] { return ++calls > allowed; }});
      ASSERT_FALSE(c);
      EXPECT_EQ(static_cast<int>(c.error().problems.front().code), static_cast<int>(ErrorCode::cancelled));
      EXPECT_LE(calls, allowed + 5);  // each of the two passes may call it one more time, and solve_markers() after each pass
    }
  }
}

TEST(Capture, CalibrationIsCancellableAndBounded) {
  const auto calls_for = [](const MarkerMotion& motion) {
    int calls = 0;
    EXPECT_TRUE(solve_markers(motion, {.cutoff = -1, .cancelled = [&] { return ++calls < 0; }}));
    return calls;
  };
  const Known k = make_known(human_markers(), 1.05, 4, 0.006);
  EXPECT_GT(calls_for(k.markers), k.markers.frames + 40) << "one call for each of 40 frames and each round of the calibration";
  // A damaged file, whose numbers are read in a wrong format: the positions are random.
  MarkerMotion damaged = k.markers;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> within(-1, 1);
  for (Vec3& x : damaged.positions) x = {within(random), within(random), within(random)};
  EXPECT_LT(calls_for(damaged), 1000 + 3 * k.markers.frames);
}

/// Maximum distance [m] of a marker's filled positions from the true ones.
double max_error(const FilledMarkers& filled, const MarkerMotion& truth, const std::string& label) {
  double out = 0;
  for (int f = 0; f < truth.frames; ++f) {
    EXPECT_TRUE(filled.markers.seen(f, truth.find(label)));
    out = std::max(out, norm(filled.markers.at(f, truth.find(label)) - truth.at(f, truth.find(label))));
  }
  return out;
}

TEST(Capture, LongGapsAreFilledFromTheBodyPose) {
  const Known k = make_known(human_markers(), 1.05, 4, 0.006);
  MarkerMotion m = k.markers;
  // Markers of limbs have no rigid neighbours. The gaps overlap, and two of them are at the ends of the recording.
  const std::vector<std::string> lost = {"LELB", "RWRA", "RKNE", "LANK", "LFHD"};
  hide(m, "LELB", 60, 119);
  hide(m, "RWRA", 100, 149);
  hide(m, "RKNE", 0, 59);
  hide(m, "LANK", 150, 199);
  hide(m, "LFHD", 30, 189);
  const FilledMarkers filled = fill_markers(m, {.cutoff = -1});
  for (const std::string& label : lost) EXPECT_LT(max_error(filled, k.markers, label), 0.012) << label;
  for (int f = 0; f < m.frames; ++f)
    for (int i = 0; i < m.marker_count(); ++i)
      if (m.seen(f, i)) EXPECT_EQ(filled.markers.at(f, i), m.at(f, i));
  const auto complete = solve_markers(k.markers, {.cutoff = -1}), c = solve_markers(m, {.cutoff = -1});
  ASSERT_TRUE(complete && c);
  for (int f = 0; f < m.frames; ++f)
    EXPECT_NEAR(flexion(c->measured, f, "LeftArm", "LeftForeArm", "LeftHand"),
                flexion(complete->measured, f, "LeftArm", "LeftForeArm", "LeftHand"), 2)
        << f;
}

TEST(Capture, UnseenMarkerUsesTheMirroredOffsetOfItsPartner) {
  Known k = make_known(human_markers(), 1, 6, 0);
  // Both thigh markers are 4 cm lower than in the marker set.
  MarkerMotion truth = k.markers;
  std::vector<Pose> X;
  for (int f = 0; f < truth.frames; ++f) {
    k.truth.calc_joint_poses(f, X);
    for (const char* side : {"Left", "Right"}) {
      const std::string label = std::string(1, side[0]) + "THI";
      truth.positions[truth.index(f, truth.find(label))] +=
          X[static_cast<std::size_t>(joint_of(k.truth, std::string(side) + "UpLeg"))].R * Vec3{0, 0, -0.04};
    }
  }
  MarkerMotion m = truth;
  hide(m, "LTHI", 0, m.frames - 1);
  const FilledMarkers filled = fill_markers(m, {.cutoff = -1});
  EXPECT_LT(max_error(filled, truth, "LTHI"), 0.02);
}

TEST(Capture, UnknownMarkersAreFilledFromRigidNeighboursOrStayOpen) {
  Known k = make_known(human_markers(), 1, 3, 0);
  MarkerMotion m = k.markers;
  for (std::string& label : m.labels) label = "X" + label;  // no marker set contains these labels
  hide(m, "XLFHD", 50, 120);
  for (const std::string& label : m.labels) hide(m, label, 150, 180);
  const FilledMarkers filled = fill_markers(m);
  for (int f = 50; f <= 120; ++f) EXPECT_LT(norm(filled.markers.at(f, m.find("XLFHD")) - k.markers.at(f, m.find("XLFHD"))), 0.01);
  for (const float r : std::span(filled.markers.residuals).subspan(m.index(150, 0), m.index(181, 0) - m.index(150, 0))) EXPECT_LT(r, 0);
  EXPECT_NE(filled.report.back().find("stay unseen"), std::string::npos);

  // With known labels a body is found, but its pose is unknown in frames without any marker.
  m.labels = k.markers.labels;
  const FilledMarkers body = fill_markers(m);
  EXPECT_FALSE(body.markers.seen(165, 0));
  const auto c = solve_markers(m);
  ASSERT_TRUE(c);
  EXPECT_TRUE(std::ranges::any_of(c->report, [](const std::string& line) { return line.find("In 31 frames") != std::string::npos; }));
}

TEST(Capture, IsDeterministic) {
  const Known k = make_known(human_markers(), 1, 3, 0.004);
  const auto a = solve_markers(k.markers), b = solve_markers(k.markers);
  ASSERT_TRUE(a.has_value() && b.has_value());
  EXPECT_EQ(a->measured.rotations, b->measured.rotations);
  EXPECT_EQ(a->measured.translations, b->measured.translations);
}

TEST(Capture, JointCentresOfBothLegsGiveABody) {
  // The points of the bone axes that Plug-in Gait writes: pelvis, hips, knees and ankles.
  const Known k = make_known(human_key_points(), 1, 5, 0);
  const std::vector<std::pair<std::string, std::string>> names = {{"MIDHIP", "MIDPEL"}, {"LHIP", "LFEP"},  {"RHIP", "RFEP"},
                                                                  {"LKNEE", "LFEO"},    {"RKNEE", "RFEO"}, {"LANKLE", "LTIO"},
                                                                  {"RANKLE", "RTIO"}};
  MarkerMotion legs = k.markers;
  legs.labels.clear();
  legs.positions.clear();
  legs.residuals.clear();
  std::vector<int> columns;
  for (const auto& [known, label] : names) {
    columns.push_back(k.markers.find(known));
    ASSERT_GE(columns.back(), 0) << known;
    legs.labels.push_back(label);
  }
  for (int f = 0; f < k.markers.frames; ++f)
    for (const int c : columns) {
      legs.positions.push_back(k.markers.at(f, c));
      legs.residuals.push_back(0);
    }
  const auto solved = solve_markers(legs);
  ASSERT_TRUE(solved.has_value()) << solved.error().text();
  EXPECT_LT(solved->rms, 0.01);
}

TEST(Capture, InvalidRecordingIsRejectedWithAReason) {
  Known k = make_known(human_markers(), 1, 3, 0);
  MarkerMotion unknown = k.markers;
  for (std::string& label : unknown.labels) label = "X" + label;
  const auto no_labels = solve_markers(unknown);
  ASSERT_FALSE(no_labels.has_value());
  EXPECT_NE(no_labels.error().text().find("Plug-in Gait"), std::string::npos);

  MarkerMotion flat = k.markers;
  for (Vec3& x : flat.positions) x.y = 0;
  const auto planar = solve_markers(flat);
  ASSERT_FALSE(planar.has_value());
  EXPECT_NE(planar.error().text().find("plane"), std::string::npos);

  MarkerMotion unseen = k.markers;
  for (float& r : unseen.residuals) r = -1;
  EXPECT_FALSE(solve_markers(unseen).has_value());
  EXPECT_FALSE(solve_markers(MarkerMotion{}).has_value());
}

std::string slurp(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

const std::string shared_data = std::string(UGOKI_SOURCE_DIR) + "/../shared/data/";

/// Hides a fifth of all samples, and five gaps of half a second (60 frames).
void damage(MarkerMotion& m, unsigned seed) {
  std::mt19937 random(seed);
  const auto share = [&] { return static_cast<double>(random() % 10000) / 10000; };
  const auto hide = [&](int f, int i) {
    m.positions[m.index(f, i)] = {};
    m.residuals[m.index(f, i)] = -1;
  };
  for (int f = 0; f < m.frames; ++f)
    for (int i = 0; i < m.marker_count(); ++i)
      if (share() < 0.2) hide(f, i);
  for (int gap = 0; gap < 5; ++gap) {
    const int i = static_cast<int>(share() * m.marker_count()), first = static_cast<int>(share() * (m.frames - 60));
    for (int f = first; f < first + 60; ++f) hide(f, i);
  }
}

/// Differences [degrees rms] of knee and elbow flexion between our solution and the published one of the same trial.
std::vector<double> flexion_errors(const MeasuredMotion& ours, const MeasuredMotion& amc) {
  std::vector<double> out;
  for (const auto& [a, b, c, x, y, z] :
       std::vector<std::array<const char*, 6>>{{"LeftUpLeg", "LeftLeg", "LeftFoot", "lfemur", "ltibia", "lfoot"},
                                               {"RightUpLeg", "RightLeg", "RightFoot", "rfemur", "rtibia", "rfoot"},
                                               {"LeftArm", "LeftForeArm", "LeftHand", "lhumerus", "lradius", "lhand"},
                                               {"RightArm", "RightForeArm", "RightHand", "rhumerus", "rradius", "rhand"}}) {
    double sum = 0;
    int count = 0;
    for (int f = 0; f < amc.frames; f += 3) {
      const double d = flexion(ours, f, a, b, c) - flexion(amc, f, x, y, z);
      sum += d * d;
      ++count;
    }
    out.push_back(std::sqrt(sum / count));
  }
  return out;
}

TEST(Capture, RecordingWithClustersOnlyIsRefusedForThatReason) {
  MarkerMotion m;
  m.rate = 50;
  m.frames = 4;
  for (const char* segment : {"TH", "SK"})
    for (const char* side : {"L", "R"})
      for (const char* number : {"1", "2", "3"}) m.labels.push_back(std::string(side) + segment + number);
  for (int f = 0; f < m.frames; ++f)
    for (std::size_t i = 0; i < m.labels.size(); ++i) {
      m.positions.push_back({0.05 * static_cast<double>(i % 3), 0.1 * static_cast<double>(i), 0.3 + 0.02 * static_cast<double>(i * i % 5)});
      m.residuals.push_back(0);
    }
  const auto c = solve_markers(m);
  ASSERT_FALSE(c.has_value());
  EXPECT_NE(c.error().text().find("clusters"), std::string::npos) << c.error().text();
}

TEST(Capture, MeasuredWalkAgreesWithThePublishedSolution) {
  const std::string bytes = slurp(shared_data + "human/c3d/02_01.c3d");
  if (bytes.empty()) GTEST_SKIP() << "no " << shared_data;
  const auto markers = formats::read_c3d(std::as_bytes(std::span(bytes)), "02_01.c3d");
  const auto asf = formats::read_asf(slurp(shared_data + "human/asf_amc/02.asf"), "02.asf");
  ASSERT_TRUE(markers.has_value() && asf.has_value());
  const auto amc = formats::read_amc(slurp(shared_data + "human/asf_amc/02_01.amc"), "02_01.amc", *asf);
  ASSERT_TRUE(amc.has_value());
  const auto c = solve_markers(*markers);
  ASSERT_TRUE(c.has_value()) << c.error().text();
  EXPECT_LT(c->rms, 0.015);
  const std::vector<std::pair<std::string, std::string>> joints = {
      {"LeftUpLeg", "lfemur"},    {"RightUpLeg", "rfemur"},    {"LeftLeg", "ltibia"},   {"RightLeg", "rtibia"},
      {"LeftFoot", "lfoot"},      {"RightFoot", "rfoot"},      {"LeftArm", "lhumerus"}, {"RightArm", "rhumerus"},
      {"LeftForeArm", "lradius"}, {"RightForeArm", "rradius"}, {"LeftHand", "lhand"},   {"RightHand", "rhand"}};
  EXPECT_LT(rms_distance(c->measured, *amc, joints), 0.04);
  const std::vector<double> errors = flexion_errors(c->measured, *amc);
  for (const double e : errors) EXPECT_LT(e, 6);
  for (const unsigned seed : {1U, 2U, 3U, 4U, 5U}) {
    SCOPED_TRACE(seed);
    MarkerMotion damaged = *markers;
    damage(damaged, seed);
    if (seed > 2)  // also hide arm markers: arms have few
      for (const char* label : {"LELB", "RELB", "RWRA", "LWRB", "RKNE"})
        hide(damaged, label, 40 * static_cast<int>(seed) - 60, 40 * static_cast<int>(seed));
    const auto d = solve_markers(damaged);
    ASSERT_TRUE(d.has_value()) << d.error().text();
    const std::vector<double> worse = flexion_errors(d->measured, *amc);
    for (std::size_t i = 0; i < errors.size(); ++i) EXPECT_LT(worse[i], errors[i] + 1);
  }
}

TEST(Capture, FilledPositionsJoinTheMeasuredOnesWithoutAJump) {
  const std::string bytes = slurp(shared_data + "human/c3d/02_01.c3d");
  if (bytes.empty()) GTEST_SKIP() << "no " << shared_data;
  const auto recorded = formats::read_c3d(std::as_bytes(std::span(bytes)), "02_01.c3d");
  ASSERT_TRUE(recorded.has_value());
  for (const char* label : {"LELB", "RKNE", "LWRA", "RTHI", "C7"}) {
    SCOPED_TRACE(label);
    MarkerMotion m = *recorded;
    hide(m, label, 100, 159);
    const FilledMarkers filled = fill_markers(m);
    const int i = m.find(label);
    for (const int edge : {100, 160}) {
      const Vec3 bend = filled.markers.at(edge, i) - filled.markers.at(edge - 1, i) * 2 + filled.markers.at(edge - 2, i);
      EXPECT_LT(norm(bend), 0.006) << edge;
    }
    for (int f = 100; f < 160; ++f) EXPECT_LT(norm(filled.markers.at(f, i) - recorded->at(f, i)), 0.05) << f;
  }
}

TEST(Capture, MeasuredRatBecomesAMovingBody) {
  const std::string text = slurp(shared_data + "animal/rat_walk_23.trc");
  if (text.empty()) GTEST_SKIP() << "no " << shared_data;
  const auto markers = formats::read_trc(text, "rat_walk_23.trc");
  ASSERT_TRUE(markers.has_value());
  const auto c = solve_markers(*markers);
  ASSERT_TRUE(c.has_value()) << c.error().text();
  EXPECT_LT(c->rms, 0.006);
  EXPECT_EQ(c->measured.frames, 1000);
  EXPECT_TRUE(c->unused.empty());
}

}  // namespace
}  // namespace ugoki::capture
