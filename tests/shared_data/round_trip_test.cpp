// Every shared file that is written and read back is equal: bit by bit if the format stores all bits, otherwise to the format's digits.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include "shared_files.h"
#include "ugoki/body/body.h"
#include "ugoki/formats/asf.h"
#include "ugoki/formats/bvh.h"
#include "ugoki/formats/c3d.h"
#include "ugoki/formats/csv.h"
#include "ugoki/formats/gltf.h"
#include "ugoki/formats/mechanism_json.h"
#include "ugoki/formats/motion_binary.h"
#include "ugoki/formats/trc.h"

namespace ugoki {
namespace {

/// Maximum distance [m] between joints of equal name in `a` and `b`, in frames 0, stride, 2 stride ...; infinity if a joint is missing.
/// @param name_of_root name of the root in `b`, if it differs
double max_distance(const MeasuredMotion& a, const MeasuredMotion& b, int stride, const std::string& name_of_root = {}) {
  constexpr double other = std::numeric_limits<double>::infinity();
  if (a.frames != b.frames) return other;
  std::map<std::string, std::size_t> index;
  for (std::size_t i = 0; i < b.skeleton.joints.size(); ++i) index[b.skeleton.joints[i].name] = i;
  std::vector<std::size_t> in_b;
  for (const SkeletonJoint& j : a.skeleton.joints) {
    const auto it = index.find(j.parent < 0 && !name_of_root.empty() ? name_of_root : j.name);
    if (it == index.end()) return other;
    in_b.push_back(it->second);
  }
  double worst = 0;
  std::vector<Pose> X, Y;
  for (int f = 0; f < a.frames; f += stride) {
    a.calc_joint_poses(f, X);
    b.calc_joint_poses(f, Y);
    for (std::size_t i = 0; i < X.size(); ++i) {
      worst = std::max(worst, norm(X[i].p - Y[in_b[i]].p));
      const auto& ends = a.skeleton.joints[i].end_sites;
      const auto& others = b.skeleton.joints[in_b[i]].end_sites;
      for (std::size_t e = 0; e < ends.size() && ends.size() == others.size(); ++e)
        worst = std::max(worst, norm(X[i] * ends[e] - Y[in_b[i]] * others[e]));
    }
  }
  return worst;
}

/// Maximum absolute coordinate [m] of any joint; at least 1.
double reach_of(const MeasuredMotion& m, int stride) {
  double reach = 1;
  std::vector<Pose> X;
  for (int f = 0; f < m.frames; f += stride) {
    m.calc_joint_poses(f, X);
    for (const Pose& p : X) reach = std::max(reach, norm(p.p));
  }
  return reach;
}

void write_and_read(const MeasuredMotion& m, int stride) {
  SCOPED_TRACE(m.name);
  const auto same = [&](const MeasuredMotion& back) {
    EXPECT_EQ(back.frames, m.frames);
    EXPECT_NEAR(back.rate, m.rate, 1e-6 * m.rate);
  };
  const double reach = reach_of(m, stride);
  {
    const auto back = formats::read_bvh(formats::write_bvh(m, {.decimals = 13}), "again.bvh", {.metres_per_unit = m.skeleton.unit});
    ASSERT_TRUE(back) << back.error().text();
    same(*back);
    EXPECT_LT(max_distance(m, *back, stride), 1e-9 * reach) << "BVH";
  }
  {
    const formats::AmcText text = formats::write_amc(m, {.decimals = 13});
    const auto asf = formats::read_asf(text.asf, "again.asf");
    ASSERT_TRUE(asf) << asf.error().text();
    const auto back = formats::read_amc(text.amc, "again.amc", *asf, {.rate = m.rate});
    ASSERT_TRUE(back) << back.error().text();
    same(*back);
    const auto roots = std::ranges::count_if(m.skeleton.joints, [](const SkeletonJoint& j) { return j.parent < 0; });
    MeasuredMotion words = m;  // joint names in AMC are single words
    for (SkeletonJoint& j : words.skeleton.joints)
      for (char& c : j.name)
        if (c == ' ' || c == ':') c = '_';
    EXPECT_LT(max_distance(words, *back, stride, roots == 1 ? "root" : ""), 1e-9 * reach) << "AMC";
  }
  {
    const auto back = formats::read_gltf(formats::write_glb(m), "again.glb", {.rate = m.rate, .metres_per_unit = 1});
    ASSERT_TRUE(back) << back.error().text();
    ASSERT_EQ(back->size(), 1u);
    same((*back)[0]);
    EXPECT_LT(max_distance(m, (*back)[0], stride), 2e-6 * reach) << "glTF: errors of single precision add up along chains of joints";
  }
  {
    const auto back = formats::read_csv(formats::write_csv_positions(m), "again.csv");
    ASSERT_TRUE(back) << back.error().text();
    EXPECT_EQ(back->frames, m.frames);
    ASSERT_EQ(back->marker_count(), m.joint_count());
    std::vector<Pose> X;
    for (int f = 0; f < m.frames; f += stride) {
      m.calc_joint_poses(f, X);
      for (int i = 0; i < m.joint_count(); ++i)
        ASSERT_EQ(back->at(f, i), X[static_cast<std::size_t>(i)].p) << "CSV should be equal bit by bit";
    }
  }
  const std::vector<std::byte> bytes = formats::write_measured_motion(m);
  const auto back = formats::read_measured_motion(bytes, "again");
  ASSERT_TRUE(back) << back.error().text();
  EXPECT_EQ(formats::write_measured_motion(*back), bytes);
  EXPECT_EQ(max_distance(m, *back, stride), 0);
}

void write_and_read_motions(bool small, int stride) {
  for (const std::string& path : shared_files({".bvh", ".amc", ".gltf", ".glb"})) {
    if (!is_whole(path)) continue;
    if ((std::filesystem::file_size(std::string(UGOKI_SHARED_DATA) + "/" + path) < 300'000) != small) continue;
    SCOPED_TRACE(path);
    for (const MeasuredMotion& m : read_motions(path)) write_and_read(m, stride);
  }
}

TEST(SharedRoundTrip, Motions) {
  NEEDS_SHARED_FILES();
  write_and_read_motions(true, 7);
}

TEST(Slow_SharedRoundTrip, MotionsOfLargeFiles) {
  NEEDS_SHARED_FILES();
  write_and_read_motions(false, 1);
}

void expect_same_markers(const MarkerMotion& a, const MarkerMotion& b, double tolerance) {
  ASSERT_EQ(b.labels, a.labels);
  ASSERT_EQ(b.frames, a.frames);
  EXPECT_NEAR(b.rate, a.rate, 1e-9 * a.rate);
  double worst = 0;
  for (int f = 0; f < a.frames; ++f)
    for (int i = 0; i < a.marker_count(); ++i) {
      ASSERT_EQ(a.seen(f, i), b.seen(f, i)) << a.labels[static_cast<std::size_t>(i)] << " in frame " << f;
      worst = std::max(worst, norm(a.at(f, i) - b.at(f, i)));
    }
  EXPECT_LE(worst, tolerance);
}

TEST(SharedRoundTrip, Recordings) {
  NEEDS_SHARED_FILES();
  for (const std::string& path : shared_files({".c3d", ".trc"})) {
    SCOPED_TRACE(path);
    const MarkerMotion m = read_markers(path);
    double reach = 0;
    for (const Vec3& p : m.positions) reach = std::max(reach, norm(p));
    for (const bool z_up : {true, false}) {
      const auto bytes = formats::write_c3d(m, {.z_up = z_up});
      ASSERT_TRUE(bytes) << bytes.error().text();
      const auto back = formats::read_c3d(*bytes, "again.c3d");
      ASSERT_TRUE(back) << back.error().text();
      expect_same_markers(m, *back, 1.2e-7 * reach);  // single precision: 24 bits
      EXPECT_EQ(back->first_frame, m.first_frame);
      EXPECT_EQ(back->unit, m.unit);
      EXPECT_EQ(back->plates.size(), m.plates.size());
      EXPECT_EQ(back->events.size(), m.events.size());
      ASSERT_EQ(back->samples.size(), m.samples.size());
      for (std::size_t i = 0; i < m.samples.size(); ++i) ASSERT_EQ(back->samples[i], static_cast<double>(static_cast<float>(m.samples[i])));
      const auto text = formats::read_trc(formats::write_trc(m, {.z_up = z_up, .decimals = 10}), "again.trc",
                                          {.up = z_up ? formats::UpAxis::z : formats::UpAxis::y});
      ASSERT_TRUE(text) << text.error().text();
      expect_same_markers(m, *text, 1e-9);
      EXPECT_EQ(text->first_frame, m.first_frame);
    }
    const auto table = formats::read_csv(formats::write_csv(m), "again.csv");
    ASSERT_TRUE(table) << table.error().text();
    expect_same_markers(m, *table, 0);
  }
}

/// Writes and reads the coordinates of a body made for a motion as CSV, and motion and body in the library's formats.
void write_and_read_coordinates(const std::string& path) {
  SCOPED_TRACE(path);
  const MeasuredMotion m = read_motions(path).at(0);
  const auto body = body::make_body(m);
  ASSERT_TRUE(body) << body.error().text();
  const Motion motion = body::to_motion(*body, m);
  const auto back = formats::read_csv(formats::write_csv(motion, *body->mechanism, {.degrees = false}), "again.csv", *body->mechanism);
  ASSERT_TRUE(back) << back.error().text();
  ASSERT_EQ(back->q.size(), motion.q.size());
  double worst = 0;
  for (std::size_t i = 0; i < back->q.size(); ++i) worst = std::max(worst, std::fabs(back->q[i] - motion.q[i]));
  EXPECT_LT(worst, 1e-15) << "the reader normalises quaternions";
  EXPECT_EQ(back->rate, motion.rate);
  ASSERT_EQ(back->contacts.size(), motion.contacts.size());
  const std::vector<std::byte> bytes = formats::write_motion(motion);
  const auto binary = formats::read_motion(bytes, "again");
  ASSERT_TRUE(binary) << binary.error().text();
  EXPECT_EQ(formats::write_motion(*binary), bytes);
  const std::string text = formats::write_mechanism(*body->mechanism);
  const auto mechanism = formats::read_mechanism(text, "again.json");
  ASSERT_TRUE(mechanism) << mechanism.error().text();
  EXPECT_EQ(formats::write_mechanism(**mechanism), text);
}

TEST(Slow_SharedRoundTrip, CoordinatesOfBodies) {
  NEEDS_SHARED_FILES();
  for (const std::string& path : shared_files({".bvh", ".amc", ".gltf", ".glb"}))
    if (is_whole(path)) write_and_read_coordinates(path);
}

TEST(SharedRoundTrip, MechanismsAsJson) {
  NEEDS_SHARED_FILES();
  for (const std::string& path : shared_files({".urdf", ".sdf", ".xml"})) {
    SCOPED_TRACE(path);
    const auto robot = read_robot(path);
    if (!robot) continue;
    const std::string text = formats::write_mechanism(*robot->mechanism);
    const auto back = formats::read_mechanism(text, "again.json");
    ASSERT_TRUE(back) << back.error().text();
    EXPECT_EQ(formats::write_mechanism(**back), text);
  }
}

}  // namespace
}  // namespace ugoki
