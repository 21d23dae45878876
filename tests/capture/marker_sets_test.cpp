// One person recorded with eight marker sets: virtual markers on the body of a shared clip, with errors of placement, noise, gaps,
// unlabelled markers and exchanged labels.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <random>
#include <sstream>
#include <string_view>
#include <tuple>

#include "ugoki/body/body.h"
#include "ugoki/capture/capture.h"
#include "ugoki/capture/marker_set.h"
#include "ugoki/capture/unlabelled.h"
#include "ugoki/formats/bvh.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/spatial/elementary.h"

namespace ugoki::capture {
namespace {

/// Labels of a marker set; '<' stands for both sides.
struct Set {
  const char* name;
  const char* labels;
};
constexpr Set sets[] = {
    {"Plug-in Gait", "<FHD <BHD C7 T10 CLAV STRN RBAK <SHO <ELB <WRA <WRB <FIN <ASI <PSI <THI <KNE <TIB <ANK <HEE <TOE"},
    {"Helen Hayes", "<SHO <ELB <WRI <ASI SACR <THI <KNE <TIB <ANK <HEE <TOE C7 <FHD"},
    {"IOR", "<IAS <IPS <FTC <FLE <FME <FAX <TTC <FAL <TAM <FCC <FM1 <FM2 <FM5 CV7 SJN MAI SXS <CAJ <HLE <HME <RSP <USP <TEMPLE"},
    {"CAST",
     "<ASIS <PSIS <TH1 <TH2 <TH3 <TH4 <SK1 <SK2 <SK3 <SK4 <LFC <MFC <LMAL <MMAL <CA <VM <FMH C7 CLAV <ACR <LEE <MEE <WRA <WRB <HEAD"},
    {"OpenSim",
     "<.ASIS V.Sacral <.Thigh.Upper <.Thigh.Front <.Thigh.Rear <.Shank.Upper <.Shank.Front <.Shank.Rear <.Knee.Lat <.Knee.Med "
     "<.Ankle.Lat <.Ankle.Med <.Heel <.Midfoot.Sup <.Midfoot.Lat <.Toe.Lat <.Toe.Med <.Toe.Tip Top.Head <.Acromium Sternum "
     "<.Elbow <.Wrist.Med <.Wrist.Lat"},
    {"CMU", "<FWT <BWT <THI <KNE <SHN <ANK <HEE <TOE <MT5 C7 T10 CLAV STRN RBAC <SHO <UPA <ELB <FRM <WRA <WRB <FIN <FHD <BHD ARIEL"},
    {"OptiTrack Baseline",
     "HeadTop HeadFront BackTop Chest BackLeft BackRight <ShoulderTop <ShoulderBack <UArmHigh <ElbowOut <WristOut <WristIn "
     "<HandOut Waist<Front Waist<Back <Thigh <KneeOut <Shin <AnkleOut <ToeIn <ToeOut <Heel"},
    {"HALPE key points", "Nose <Eye <Ear <Shoulder <Elbow <Wrist <Hip <Knee <Ankle Head Neck Hip <BigToe <SmallToe <Heel"}};

std::vector<std::string> labels_of(const Set& set) {
  std::vector<std::string> out;
  std::istringstream words(set.labels);
  for (std::string w; words >> w;) {
    const std::size_t side = w.find('<');
    for (const char letter : side == std::string::npos ? std::string("-") : std::string("LR")) {
      std::string label = w;
      if (side != std::string::npos) label[side] = letter;
      out.push_back(std::move(label));
    }
  }
  return out;
}

/// A shared walk on its body.
struct Person {
  body::Body body;
  Motion motion;
};
std::optional<Person> person_of(const std::string& clip) {
  std::ifstream file(std::string(UGOKI_SHARED_DATA) + "/human/bvh/" + clip, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  if (text.empty()) return std::nullopt;
  const auto measured = formats::read_bvh(text, clip);
  if (!measured) return std::nullopt;
  auto body = body::make_body(*measured);
  if (!body) return std::nullopt;
  Motion motion = body::to_motion(*body, *measured);
  return Person{std::move(*body), std::move(motion)};
}
const Person* shared_person() {
  static const std::optional<Person> person = person_of("cmu_12_01_walk.bvh");
  return person ? &*person : nullptr;
}

/// Label of the body's link that corresponds to a segment of the marker set.
std::string link_label(const std::string& segment) {
  static const std::map<std::string, std::string> names = {
      {"Hips", "pelvis"}, {"Spine1", "chest"}, {"Head", "head"},         {"UpLeg", "thigh"},   {"Leg", "shank"},
      {"Foot", "foot"},   {"ToeBase", "toes"}, {"Shoulder", "shoulder"}, {"Arm", "upper arm"}, {"ForeArm", "forearm"},
      {"Hand", "hand"},   {"Neck", "neck"},    {"Spine", "abdomen"}};
  for (const std::string side : {"Left", "Right"})
    if (segment.starts_with(side)) return names.at(segment.substr(side.size())) + (side == "Left" ? " left" : " right");
  return names.at(segment);
}
int link_with(const Mechanism& m, const std::string& label) {
  for (int i = 0; i < m.link_count(); ++i)
    if (m.link(i).label == label) return i;
  ADD_FAILURE() << "no link " << label;
  return 0;
}

/// Virtual recording of the person with the labels. Each marker is at the landmark that its label names, scaled to the person's segments,
/// with an error of placement of 6 mm (standard deviation), noise of 1 mm, and two gaps.
MarkerMotion record(const Person& person, const std::vector<std::string>& labels, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  const MarkerSet* best = nullptr;
  int max_known = 0;
  for (const MarkerSet* set : {&human_markers(), &human_key_points()}) {
    const auto match = match_labels(*set, labels);
    const int known = static_cast<int>(std::ranges::count_if(match, [](int m) { return m >= 0; }));
    if (known > max_known) best = set;
    max_known = std::max(max_known, known);
  }
  EXPECT_EQ(max_known, static_cast<int>(labels.size()));
  const std::vector<int> match = match_labels(*best, labels);
  const Mechanism& mech = *person.body.mechanism;
  // Places of the joints at rest. Bodies have joints between these, so the offset of a joint from its parent is not the segment's length.
  std::vector<Pose> rest(static_cast<std::size_t>(mech.link_count()));
  calc_poses(mech, mech.neutral(), rest);
  const auto place_of = [&](const std::string& label) { return rest[static_cast<std::size_t>(link_with(mech, label))].p; };
  const auto length = [&](int segment) {  // ratio of the person's segment length to the model's
    const std::string own = best->segments[static_cast<std::size_t>(segment)].name;
    for (std::size_t k = 0; k < best->segments.size(); ++k)
      if (best->segments[k].parent == segment && best->segments[k].mirror >= 0 && own != "Hips" && own != "Spine1")
        return norm(place_of(link_label(best->segments[k].name)) - place_of(link_label(own))) / norm(best->segments[k].offset);
    return person.body.height / 1.75;
  };
  // The frames of model and body differ: places on pelvis, chest and shoulders are taken relative to the hip or shoulder joints, and the
  // model's palms point forwards at rest, the body's downwards (the forearms are pronated).
  const auto from = [&](const char* link, const std::string& joint) {
    return transpose_times(rest[static_cast<std::size_t>(link_with(mech, link))].R, place_of(joint) - place_of(link));
  };
  const Vec3 hips = (from("pelvis", "thigh left") + from("pelvis", "thigh right")) * 0.5;
  const Vec3 shoulders = (from("chest", "upper arm left") + from("chest", "upper arm right")) * 0.5;
  const Mat3 palms_down = rotation_about({0, 1, 0}, 0.5 * pi);
  // Axes of an upper arm in its link's frame: along the bone, and towards the outer side of the elbow, from the mean bend of the elbow.
  const auto arm_axes = [&](bool left) {
    const int arm = link_with(mech, left ? "upper arm left" : "upper arm right"),
              elbow = link_with(mech, left ? "forearm left" : "forearm right");
    const int hand = link_with(mech, left ? "hand left" : "hand right");
    Vec3 bend{};
    std::vector<Pose> X(static_cast<std::size_t>(mech.link_count()));
    for (int f = 0; f < person.motion.frames; f += 5) {
      calc_poses(mech, std::span<const double>(person.motion.frame(f), static_cast<std::size_t>(person.motion.nq)), X);
      const Pose &A = X[static_cast<std::size_t>(arm)], &E = X[static_cast<std::size_t>(elbow)], &H = X[static_cast<std::size_t>(hand)];
      bend += transpose_times(A.R, cross(E.p - A.p, H.p - E.p));
    }
    const Vec3 along =
        normalized(from(left ? "upper arm left" : "upper arm right", left ? "forearm left" : "forearm right")) * (left ? 1.0 : -1.0);
    Vec3 outer = bend * (left ? -1.0 : 1.0);
    outer = normalized(outer - along * dot(outer, along));
    return Mat3::columns(cross(along, outer), along, outer);
  };
  std::vector<Vec3> at;
  std::vector<int> link;
  for (const int m : match) {
    const ModelMarker& marker = best->markers[static_cast<std::size_t>(m)];
    const std::string& segment = best->segments[static_cast<std::size_t>(marker.segment)].name;
    const double size = length(marker.segment);
    Vec3 place = marker.at * size;
    if (segment == "Hips") place += hips;
    if (segment == "Spine1") place = shoulders + (marker.at - Vec3{0.01, 0, 0.205}) * size;
    if (segment.ends_with("Shoulder")) {
      const bool left = segment.starts_with("Left");
      place = from(left ? "shoulder left" : "shoulder right", left ? "upper arm left" : "upper arm right") +
              (marker.at - Vec3{0, left ? 0.17 : -0.17, 0.005}) * size;
    }
    if (segment == "LeftArm" || segment == "RightArm") place = arm_axes(segment == "LeftArm") * place;
    if (segment.ends_with("ForeArm") || segment.ends_with("Hand")) place = palms_down * place;
    link.push_back(link_with(mech, link_label(segment)));
    at.push_back(place + Vec3{normal(random), normal(random), normal(random)} * 0.006);
  }
  MarkerMotion out;
  out.name = out.source = "person";
  out.rate = person.motion.rate;
  out.frames = std::min(person.motion.frames, 300);
  out.labels = labels;
  std::vector<Pose> X(static_cast<std::size_t>(mech.link_count()));
  for (int f = 0; f < out.frames; ++f) {
    calc_poses(mech, std::span<const double>(person.motion.frame(f), static_cast<std::size_t>(person.motion.nq)), X);
    for (std::size_t i = 0; i < at.size(); ++i) {
      const bool gap = (i % 5 == 1 && f >= 40 && f < 70) || (i % 7 == 2 && f >= 150 && f < 200);
      out.positions.push_back(
          gap ? Vec3{} : X[static_cast<std::size_t>(link[i])] * at[i] + Vec3{normal(random), normal(random), normal(random)} * 0.001);
      out.residuals.push_back(gap ? -1.0F : 0.0F);
    }
  }
  return out;
}

/// Adds unlabelled markers: reflections that stay in the laboratory.
void add_unlabelled(MarkerMotion& m) {
  const std::size_t n = m.labels.size();
  MarkerMotion out = m;
  out.labels.insert(out.labels.end(), {"*10", "*11"});
  out.positions.clear();
  out.residuals.clear();
  for (std::size_t f = 0; f < static_cast<std::size_t>(m.frames); ++f) {
    out.positions.insert(out.positions.end(), m.positions.begin() + static_cast<std::ptrdiff_t>(f * n),
                         m.positions.begin() + static_cast<std::ptrdiff_t>((f + 1) * n));
    out.residuals.insert(out.residuals.end(), m.residuals.begin() + static_cast<std::ptrdiff_t>(f * n),
                         m.residuals.begin() + static_cast<std::ptrdiff_t>((f + 1) * n));
    out.positions.insert(out.positions.end(), {Vec3{2, 1, 0.1}, Vec3{-1, 0.5, 1.2}});
    out.residuals.insert(out.residuals.end(), {0.0F, 0.0F});
  }
  m = std::move(out);
}

/// Root mean square [m] of the distances between the reconstructed joints and those of the body.
double joint_error(const Person& person, const MeasuredMotion& m, double& worst, std::string& worst_joint) {
  const Mechanism& mech = *person.body.mechanism;
  std::vector<Pose> X(static_cast<std::size_t>(mech.link_count())), Y;
  const std::string names[] = {"LeftUpLeg", "RightUpLeg", "LeftLeg",     "RightLeg",     "LeftFoot", "RightFoot",
                               "LeftArm",   "RightArm",   "LeftForeArm", "RightForeArm", "LeftHand", "RightHand"};
  double all = 0;
  worst = 0;
  for (const std::string& name : names) {
    const auto joint = std::ranges::find(m.skeleton.joints, name, &SkeletonJoint::name) - m.skeleton.joints.begin();
    const auto link = static_cast<std::size_t>(link_with(mech, link_label(name)));
    double squares = 0;
    for (int f = 0; f < m.frames; ++f) {
      calc_poses(mech, std::span<const double>(person.motion.frame(f), static_cast<std::size_t>(person.motion.nq)), X);
      m.calc_joint_poses(f, Y);
      const Vec3 d = X[link].p - Y[static_cast<std::size_t>(joint)].p;
      squares += dot(d, d);
    }
    all += squares / m.frames;
    if (std::sqrt(squares / m.frames) > worst) {
      worst = std::sqrt(squares / m.frames);
      worst_joint = name;
    }
  }
  return std::sqrt(all / std::size(names));
}

TEST(MarkerSets, JointsAgreeWithTheBodyForEightSets) {
  const Person* person = shared_person();
  if (person == nullptr) GTEST_SKIP() << "The shared measured data are absent.";
  for (const Set& set : sets) {
    SCOPED_TRACE(set.name);
    MarkerMotion markers = record(*person, labels_of(set), 7);
    add_unlabelled(markers);
    const auto c = solve_markers(markers);
    ASSERT_TRUE(c.has_value()) << c.error().text();
    ASSERT_EQ(c->measured.frames, markers.frames);
    EXPECT_EQ(c->unused, (std::vector<std::string>{"*10", "*11"}));
    double worst = 0;
    std::string joint;
    const double rms = joint_error(*person, c->measured, worst, joint);
    // Key points are on the joints themselves.
    EXPECT_LT(rms, std::string_view(set.name).ends_with("key points") ? 0.016 : 0.025) << "worst: " << joint << " " << worst;
    for (const std::string& r : c->report) EXPECT_EQ(r.find("exchanged"), std::string::npos) << r;
  }
}

TEST(SlowMarkerSets, JointsAgreeForFurtherClipsAndPlacements) {
  for (const char* clip : {"01_01.bvh", "131_01.bvh", "131_02.bvh", "cmu_12_01_walk.bvh"}) {
    const std::optional<Person> person = person_of(clip);
    if (!person) GTEST_SKIP() << "The shared measured data are absent.";
    for (const Set& set : sets)
      for (const unsigned seed : {1U, 21U, 33U}) {
        SCOPED_TRACE(std::string(clip) + ", " + set.name + ", seed " + std::to_string(seed));
        const auto c = solve_markers(record(*person, labels_of(set), seed));
        ASSERT_TRUE(c.has_value()) << c.error().text();
        double worst = 0;
        std::string joint;
        const double rms = joint_error(*person, c->measured, worst, joint);
        EXPECT_LT(rms, 0.03) << "worst: " << joint << " " << worst;
        for (const std::string& r : c->report) EXPECT_EQ(r.find("exchanged in the whole"), std::string::npos) << r;
      }
  }
}

TEST(MarkerSets, ExchangedLabelsAreNamed) {
  const Person* person = shared_person();
  if (person == nullptr) GTEST_SKIP() << "The shared measured data are absent.";
  for (const auto& [k, a, b] : {std::tuple{0, "LKNE", "RKNE"},
                                {2, "LFLE", "LFAL"},
                                {3, "RLFC", "RLMAL"},
                                {6, "LKneeOut", "RKneeOut"},
                                {4, "R.Knee.Lat", "L.Knee.Lat"}}) {
    SCOPED_TRACE(std::string(sets[k].name) + " " + a + " " + b);
    MarkerMotion m = record(*person, labels_of(sets[k]), 11);
    const int i = m.find(a), j = m.find(b);
    ASSERT_GE(std::min(i, j), 0);
    for (int f = 100; f < 200; ++f) {
      std::swap(m.positions[m.index(f, i)], m.positions[m.index(f, j)]);
      std::swap(m.residuals[m.index(f, i)], m.residuals[m.index(f, j)]);
    }
    const auto c = solve_markers(m);
    ASSERT_TRUE(c.has_value()) << c.error().text();
    int reports = 0;
    for (const std::string& r : c->report) {
      if (r.find("exchanged in") == std::string::npos) continue;
      ++reports;
      EXPECT_NE(r.find(std::string(" ") + a + " "), std::string::npos) << r;
      EXPECT_NE(r.find(std::string(" ") + b + " "), std::string::npos) << r;
      EXPECT_NE(r.find("first in frame 10"), std::string::npos) << r;
    }
    EXPECT_EQ(reports, 1);
  }
}

/// Exchanges two labels in all frames.
void exchange(MarkerMotion& m, const std::string& a, const std::string& b) {
  std::swap(m.labels[static_cast<std::size_t>(m.find(a))], m.labels[static_cast<std::size_t>(m.find(b))]);
}

TEST(MarkerSets, LabelsExchangedInTheWholeRecordingAreCorrected) {
  const Person* person = shared_person();
  if (person == nullptr) GTEST_SKIP() << "The shared measured data are absent.";
  for (const auto& [k, a, b] : {std::tuple{0, "LKNE", "RKNE"},
                                {0, "LKNE", "LANK"},
                                {1, "LELB", "LWRI"},
                                {2, "LFLE", "LFAL"},
                                {3, "RLFC", "RLMAL"},
                                {5, "LWRA", "RWRA"},
                                {6, "LKneeOut", "RKneeOut"},
                                {7, "LKnee", "RKnee"}}) {
    SCOPED_TRACE(std::string(sets[k].name) + " " + a + " " + b);
    MarkerMotion m = record(*person, labels_of(sets[k]), 11);
    exchange(m, a, b);
    CaptureOptions options;
    options.correct_labels = true;
    const auto c = solve_markers(m, options);
    ASSERT_TRUE(c.has_value()) << c.error().text();
    int reports = 0;
    for (const std::string& r : c->report) {
      if (r.find("exchanged in the whole") == std::string::npos) continue;
      ++reports;
      EXPECT_NE(r.find(std::string(" ") + a + " "), std::string::npos) << r;
      EXPECT_NE(r.find(std::string(" ") + b + " "), std::string::npos) << r;
    }
    EXPECT_EQ(reports, 1);
    double worst = 0;
    std::string joint;
    EXPECT_LT(joint_error(*person, c->measured, worst, joint), 0.03) << joint << " " << worst;
  }
}

TEST(MarkerSets, ExchangedSidesAreFoundForEightSets) {
  const Person* person = shared_person();
  if (person == nullptr) GTEST_SKIP() << "The shared measured data are absent.";
  for (const Set& set : sets) {
    SCOPED_TRACE(set.name);
    const std::vector<std::string> labels = labels_of(set);
    MarkerMotion m = record(*person, labels, 5);
    for (std::size_t k = 0; k + 1 < labels.size(); ++k) {  // labels_of() lists the two sides of a label one after the other
      std::string other = labels[k];
      for (char& c : other)
        if (c == 'L' && labels[k + 1][static_cast<std::size_t>(&c - other.data())] == 'R') c = 'R';
      if (other == labels[k + 1] && other != labels[k]) exchange(m, labels[k], labels[k + 1]);
    }
    if (m.find("BackLeft") >= 0) exchange(m, "BackLeft", "BackRight");
    CaptureOptions options;
    options.correct_labels = true;
    const auto c = solve_markers(m, options);
    ASSERT_TRUE(c.has_value()) << c.error().text();
    double worst = 0;
    std::string joint;
    EXPECT_LT(joint_error(*person, c->measured, worst, joint), 0.03) << joint << " " << worst;
    int reports = 0;
    for (const std::string& r : c->report) {
      reports += r.find("Left and right are exchanged in the whole") != std::string::npos ? 1 : 0;
      EXPECT_EQ(r.find("The labels"), std::string::npos) << r;
    }
    EXPECT_EQ(reports, 1);
  }
}

// Gait laboratories often record pelvis and legs only. In a file with left-handed axes, its person is a mirror image.
TEST(MarkerSets, AMirroredRecordingOfLegsIsNamed) {
  const Person* person = shared_person();
  if (person == nullptr) GTEST_SKIP() << "The shared measured data are absent.";
  const Set legs = {"legs", "<.ASIS <.PSIS <.GTR <.Knee <.HF <.TT <.Ankle <.Heel <.MT1 <.MT5 <.Knee.Medial <.Ankle.Medial <.MT2"};
  for (const bool mirrored : {false, true}) {
    MarkerMotion m = record(*person, labels_of(legs), 5);
    if (mirrored)
      for (Vec3& p : m.positions) p.x = -p.x;
    CaptureOptions options;
    options.correct_labels = true;
    const auto c = solve_markers(m, options);
    ASSERT_TRUE(c.has_value()) << c.error().text();
    EXPECT_TRUE(c->unused.empty());
    EXPECT_EQ(std::ranges::count_if(c->report, [](const std::string& r) { return r.starts_with("Left and right are exchanged"); }),
              mirrored ? 1 : 0);
    const auto joint = [&](const char* name) {
      const auto& joints = c->measured.skeleton.joints;
      return static_cast<std::size_t>(std::ranges::find(joints, name, &SkeletonJoint::name) - joints.begin());
    };
    std::vector<Pose> X;
    c->measured.calc_joint_poses(c->measured.frames / 2, X);
    EXPECT_GT(X[joint("Head")].p.z, X[joint("Hips")].p.z + 0.4);
    EXPECT_LT(c->rms, 0.012);
  }
}

TEST(MarkerSets, UnlabelledLabelsAreKnown) {
  for (const char* label : {"*10", "U7", "Unlabeled 3", "unlabeled_12", "C_1004", "15", "*"}) EXPECT_TRUE(is_unlabelled(label)) << label;
  for (const char* label : {"C7", "LKNE", "T10", "CLAV", "M1", "UARM", "LTH1"}) EXPECT_FALSE(is_unlabelled(label)) << label;
}

// Markers lose their labels for a while, one of them to two trajectories; other points stay in the laboratory.
TEST(MarkerSets, UnlabelledTrajectoriesFillTheGapsOfTheirMarkers) {
  const Person* person = shared_person();
  if (person == nullptr) GTEST_SKIP() << "The shared measured data are absent.";
  MarkerMotion whole = record(*person, labels_of(sets[1]), 13);
  add_unlabelled(whole);
  MarkerMotion m;
  const std::tuple<const char*, const char*, int, int> lost[] = {
      {"LKNE", "*12", 60, 119}, {"LKNE", "*13", 120, 180}, {"RANK", "*14", 80, 260}, {"LWRI", "*15", 30, 100}};
  m = whole;
  const std::size_t n = whole.labels.size(), extra = std::size(lost);
  m.positions.assign(static_cast<std::size_t>(m.frames) * (n + extra), Vec3{});
  m.residuals.assign(m.positions.size(), -1.0F);
  for (const auto& l : lost) m.labels.emplace_back(std::get<1>(l));
  for (int f = 0; f < m.frames; ++f)
    for (std::size_t i = 0; i < n; ++i) {
      const int column = static_cast<int>(i);
      std::size_t to = i;
      for (std::size_t k = 0; k < extra; ++k)
        if (const auto& [label, point, from, last] = lost[k]; whole.labels[i] == label && f >= from && f <= last) to = n + k;
      m.positions[m.index(f, static_cast<int>(to))] = whole.at(f, column);
      m.residuals[m.index(f, static_cast<int>(to))] = whole.residuals[whole.index(f, column)];
    }
  const auto a = solve_markers(whole), b = solve_markers(m);
  ASSERT_TRUE(a && b);
  std::vector<Pose> X, Y;
  double max_error = 0;
  for (int f = 0; f < m.frames; ++f) {
    a->measured.calc_joint_poses(f, X);
    b->measured.calc_joint_poses(f, Y);
    for (std::size_t i = 0; i < X.size(); ++i) max_error = std::max(max_error, norm(X[i].p - Y[i].p));
  }
  EXPECT_LT(max_error, 0.02);
  for (const auto& [label, point, from, last] : lost) {
    const std::string wanted = std::string("trajectory ") + point + " was used as " + label;
    EXPECT_TRUE(std::ranges::any_of(b->report, [&](const std::string& r) { return r.find(wanted) != std::string::npos; })) << wanted;
  }
  EXPECT_TRUE(std::ranges::none_of(b->report, [](const std::string& r) { return r.find("trajectory *10") != std::string::npos; }));
}

// Exchanges of two labels at random. Neighbouring markers can be exchanged without notice, but not with large errors of the joints.
TEST(SlowMarkerSets, JointsAgreeAlthoughTwoLabelsAreExchanged) {
  for (const char* clip : {"01_01.bvh", "131_01.bvh", "131_02.bvh", "cmu_12_01_walk.bvh"}) {
    const std::optional<Person> person = person_of(clip);
    if (!person) GTEST_SKIP() << "The shared measured data are absent.";
    int number = 0;
    for (const Set& set : sets) {
      std::mt19937 random(static_cast<unsigned>(++number));
      const std::vector<std::string> labels = labels_of(set);
      MarkerMotion m = record(*person, labels, 3);
      add_unlabelled(m);
      const std::size_t a = random() % labels.size(), b = (a + 1 + random() % (labels.size() - 1)) % labels.size();
      SCOPED_TRACE(std::string(clip) + ", " + set.name + ", " + labels[a] + " and " + labels[b]);
      exchange(m, labels[a], labels[b]);
      CaptureOptions options;
      options.correct_labels = true;
      const auto c = solve_markers(m, options);
      ASSERT_TRUE(c.has_value()) << c.error().text();
      double worst = 0;
      std::string joint;
      EXPECT_LT(joint_error(*person, c->measured, worst, joint), 0.03) << "worst: " << joint << " " << worst;
    }
  }
}

}  // namespace
}  // namespace ugoki::capture
