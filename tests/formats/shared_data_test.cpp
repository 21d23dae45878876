// Recorded BVH, ASF and AMC files: frame counts, joints and durations; world positions compared with an independent computation; round
// trip through BVH.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include "expect.h"
#include "ugoki/formats/asf.h"
#include "ugoki/formats/bvh.h"

namespace ugoki::formats {
namespace {

const std::string folder = std::string(UGOKI_SHARED_DATA) + "/human/";

#define NEEDS_SHARED_DATA() \
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "the shared data are not available (" << folder << ")"

std::string load(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

std::vector<std::string> files(const std::string& sub, const std::string& extension) {
  std::vector<std::string> out;
  for (const auto& e : std::filesystem::directory_iterator(folder + sub))
    if (e.path().extension() == extension) out.push_back(e.path().filename().string());
  std::sort(out.begin(), out.end());
  return out;
}

MeasuredMotion read_bvh_file(const std::string& name, ReadNotes* notes = nullptr) {
  auto m = read_bvh(load(folder + "bvh/" + name), name, {}, notes);
  EXPECT_TRUE(m.has_value()) << (m ? std::string() : m.error().text());
  return m ? std::move(*m) : MeasuredMotion{};
}

std::string skeleton_of(const std::string& amc) { return amc.substr(0, amc.find('_')) + ".asf"; }

MeasuredMotion read_amc_file(const std::string& name) {
  const std::string skeleton = skeleton_of(name);
  const auto asf = read_asf(load(folder + "asf_amc/" + skeleton), skeleton);
  EXPECT_TRUE(asf.has_value()) << (asf ? std::string() : asf.error().text());
  if (!asf) return {};
  auto m = read_amc(load(folder + "asf_amc/" + name), name, *asf);
  EXPECT_TRUE(m.has_value()) << (m ? std::string() : m.error().text());
  return m ? std::move(*m) : MeasuredMotion{};
}

// ---- independent kinematics: 4x4 matrices in file axes and units, parsed directly from the text

struct Matrix4 {
  double a[4][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
  friend Matrix4 operator*(const Matrix4& x, const Matrix4& y) {
    Matrix4 z;
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) {
        z.a[i][j] = 0;
        for (int k = 0; k < 4; ++k) z.a[i][j] += x.a[i][k] * y.a[k][j];
      }
    return z;
  }
  [[nodiscard]] Matrix4 transposed() const {
    Matrix4 z;
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) z.a[i][j] = a[j][i];
    return z;
  }
};
Matrix4 moved(double x, double y, double z) {
  Matrix4 m;
  m.a[0][3] = x;
  m.a[1][3] = y;
  m.a[2][3] = z;
  return m;
}
Matrix4 turned(char axis, double degrees) {
  const double t = degrees * 3.14159265358979323846 / 180, c = std::cos(t), s = std::sin(t);
  const int p = axis == 'X' ? 1 : axis == 'Y' ? 2 : 0, q = (p + 1) % 3;
  Matrix4 m;
  m.a[p][p] = c;
  m.a[p][q] = -s;
  m.a[q][p] = s;
  m.a[q][q] = c;
  return m;
}
/// Translation of a matrix [file units] as a position in our axes [m]: x forward (file z), y left (file x), z up (file y).
Vec3 position_of(const Matrix4& m, double unit) { return Vec3{m.a[2][3], m.a[0][3], m.a[1][3]} * unit; }

/// World positions of all joints and end sites of a BVH text, in file order.
struct BvhPositions {
  struct Node {
    int parent;
    bool end;
    double offset[3];
    std::vector<std::string> channels;
  };
  std::vector<Node> nodes;
  std::vector<double> numbers;
  std::size_t channel_count = 0;

  explicit BvhPositions(const std::string& text) {
    std::istringstream in(text);
    std::vector<int> stack;
    std::string w;
    bool end = false;
    while (in >> w && w != "MOTION") {
      if (w == "ROOT" || w == "JOINT" || w == "End") end = w == "End";
      if (w == "{") {
        nodes.push_back({stack.empty() ? -1 : stack.back(), end, {0, 0, 0}, {}});
        stack.push_back(static_cast<int>(nodes.size()) - 1);
      } else if (w == "}") {
        stack.pop_back();
      } else if (w == "OFFSET") {
        for (double& x : nodes.back().offset) in >> x;
      } else if (w == "CHANNELS") {
        std::size_t n = 0;
        in >> n;
        nodes.back().channels.resize(n);
        for (std::string& c : nodes.back().channels) in >> c;
        channel_count += n;
      }
    }
    for (int i = 0; i < 5; ++i) in >> w;  // skip "Frames: n Frame Time: t"
    while (in >> w) numbers.push_back(std::strtod(w.c_str(), nullptr));
  }
  [[nodiscard]] std::size_t frames() const { return numbers.size() / channel_count; }
  [[nodiscard]] std::vector<Vec3> at(std::size_t frame, double unit) const {
    const double* x = numbers.data() + frame * channel_count;
    std::vector<Matrix4> world;
    std::vector<Vec3> out;
    for (const Node& n : nodes) {
      double p[3] = {n.offset[0], n.offset[1], n.offset[2]};
      Matrix4 rotation;
      for (const std::string& c : n.channels) {
        if (c.substr(1) == "position")
          p[c[0] - 'X'] = *x++;
        else
          rotation = rotation * turned(c[0], *x++);
      }
      const Matrix4 local = moved(p[0], p[1], p[2]) * rotation;
      world.push_back(n.parent < 0 ? local : world[static_cast<std::size_t>(n.parent)] * local);
      out.push_back(position_of(world.back(), unit));
    }
    return out;
  }
};

/// World positions [m] of a motion in one frame, in the order of `order`.
std::vector<Vec3> positions_of(const MeasuredMotion& m, const BvhPositions& order, int frame) {
  std::vector<Pose> X;
  m.calc_joint_poses(frame, X);
  std::vector<Vec3> out;
  std::vector<int> joint_of;
  std::map<int, std::size_t> ends;
  int next = 0;
  for (const auto& n : order.nodes) {
    if (n.end) {
      const int j = joint_of[static_cast<std::size_t>(n.parent)];
      const std::size_t e = ends[j]++;
      out.push_back(X[static_cast<std::size_t>(j)] * m.skeleton.joints[static_cast<std::size_t>(j)].end_sites.at(e));
      joint_of.push_back(-1);
    } else {
      joint_of.push_back(next);
      out.push_back(X[static_cast<std::size_t>(next++)].p);
    }
  }
  return out;
}

void check_bvh(const std::string& name, int stride) {
  SCOPED_TRACE(name);
  const MeasuredMotion m = read_bvh_file(name);
  const BvhPositions reference(load(folder + "bvh/" + name));
  ASSERT_EQ(static_cast<std::size_t>(m.frames), reference.frames());
  double worst = 0;
  for (int f = 0; f < m.frames; f += stride) {
    const auto a = positions_of(m, reference, f), b = reference.at(static_cast<std::size_t>(f), m.skeleton.unit);
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) worst = std::max(worst, norm(a[i] - b[i]));
  }
  EXPECT_LT(worst, 1e-12) << "independent computation of the positions";  // m: rounding of about 30 products of lengths below 10 m
  const std::string written = write_bvh(m);
  const auto back = read_bvh(written, name);
  ASSERT_TRUE(back.has_value()) << back.error().text();
  EXPECT_EQ(back->skeleton.unit, m.skeleton.unit);
  EXPECT_EQ(back->rate, m.rate);
  EXPECT_LT(max_distance(m, *back, stride), 1e-6) << "round trip";
}

// ---- independent kinematics of ASF/AMC by the formula of the CMU motion capture database: C R_dof C^-1 for each bone, C: its axes

struct CmuBone {
  std::string parent;
  double direction[3] = {0, 0, 0}, length = 0, axis[3] = {0, 0, 0};
  std::vector<std::string> dof;
};

std::map<std::string, CmuBone> read_cmu_bones(const std::string& text) {
  std::map<std::string, CmuBone> bones;
  std::istringstream in(text);
  std::string line, section;
  CmuBone bone;
  std::string name;
  while (std::getline(in, line)) {
    std::istringstream words(line);
    std::string key;
    if (!(words >> key)) continue;
    if (key[0] == ':') section = key;
    if (section == ":bonedata") {
      if (key == "begin") bone = {};
      if (key == "name") words >> name;
      if (key == "direction") words >> bone.direction[0] >> bone.direction[1] >> bone.direction[2];
      if (key == "length") words >> bone.length;
      if (key == "axis") words >> bone.axis[0] >> bone.axis[1] >> bone.axis[2];
      if (key == "dof")
        for (std::string d; words >> d;) bone.dof.push_back(d);
      if (key == "end") bones[name] = bone;
    } else if (section == ":hierarchy" && key != "begin" && key != "end" && key[0] != ':') {
      for (std::string child; words >> child;) bones[child].parent = key;
    }
  }
  return bones;
}

Matrix4 cmu_axis(const double* a) { return turned('Z', a[2]) * turned('Y', a[1]) * turned('X', a[0]); }

/// World transforms of the start and the end of a bone, in file axes and units.
struct CmuPose {
  Matrix4 start, end;
};

CmuPose cmu_pose(const std::map<std::string, CmuBone>& bones, const std::map<std::string, std::vector<double>>& frame,
                 const std::string& name) {
  if (name == "root") {
    const auto& v = frame.at("root");
    const Matrix4 m = moved(v[0], v[1], v[2]) * turned('Z', v[5]) * turned('Y', v[4]) * turned('X', v[3]);
    return {m, m};
  }
  const CmuBone& b = bones.at(name);
  const CmuPose parent = cmu_pose(bones, frame, b.parent);
  double r[3] = {0, 0, 0};
  for (std::size_t i = 0; i < b.dof.size(); ++i) r[b.dof[i][1] - 'x'] = frame.at(name)[i];
  const Matrix4 C = cmu_axis(b.axis);
  const Matrix4 start = parent.end * C * turned('Z', r[2]) * turned('Y', r[1]) * turned('X', r[0]) * C.transposed();
  return {start, start * moved(b.direction[0] * b.length, b.direction[1] * b.length, b.direction[2] * b.length)};
}

void check_amc(const std::string& name, int stride) {
  SCOPED_TRACE(name);
  const MeasuredMotion m = read_amc_file(name);
  ASSERT_GT(m.frames, 0);
  EXPECT_EQ(m.joint_count(), 31);
  EXPECT_EQ(m.rate, 120);
  EXPECT_GT(rest_height(m.skeleton), 1.2) << "height of a person without the top of the head, m";
  EXPECT_LT(rest_height(m.skeleton), 2.1);

  const auto bones = read_cmu_bones(load(folder + "asf_amc/" + skeleton_of(name)));
  std::istringstream in(load(folder + "asf_amc/" + name));
  std::map<std::string, std::vector<double>> frame;
  std::string line;
  int number = -1;
  double worst = 0;
  std::vector<Pose> X;
  const auto compare = [&] {
    if (number < 0 || number % stride != 0) return;
    ASSERT_LT(number, m.frames);
    m.calc_joint_poses(number, X);
    for (std::size_t i = 0; i < X.size(); ++i) {
      const SkeletonJoint& j = m.skeleton.joints[i];
      const CmuPose p = cmu_pose(bones, frame, j.name);
      worst = std::max(worst, norm(X[i].p - position_of(p.start, m.skeleton.unit)));
      if (!j.end_sites.empty()) worst = std::max(worst, norm(X[i] * j.end_sites[0] - position_of(p.end, m.skeleton.unit)));
    }
  };
  while (std::getline(in, line)) {
    std::istringstream words(line);
    std::string key;
    if (!(words >> key) || key[0] == '#' || key[0] == ':') continue;
    if (std::isdigit(static_cast<unsigned char>(key[0]))) {
      compare();
      frame.clear();
      ++number;
    } else {
      for (double v; words >> v;) frame[key].push_back(v);
    }
  }
  compare();
  EXPECT_EQ(number + 1, m.frames);
  EXPECT_LT(worst, 1e-12);

  const auto back = read_bvh(write_bvh(m), name);
  ASSERT_TRUE(back.has_value()) << back.error().text();
  EXPECT_EQ(back->skeleton.unit, m.skeleton.unit);
  EXPECT_LT(max_distance(m, *back, stride), 1e-6) << "round trip";
}

struct Expected {
  const char* name;
  int frames, joints;
  double rate;
};

TEST(SharedBvh, FramesJointsAndRateMatchTheFiles) {
  NEEDS_SHARED_DATA();
  const Expected all[] = {{"01_01.bvh", 2752, 31, 120},
                          {"131_01.bvh", 994, 31, 120},
                          {"131_02.bvh", 1247, 31, 120},
                          {"cmu_12_01_walk.bvh", 524, 31, 120},
                          {"sinusoidal.bvh", 120, 4, 60},
                          {"rotation_first_root.bvh", 4, 4, 25},
                          {"full_precision_frame_time.bvh", 3, 2, 23.976}};
  EXPECT_EQ(files("bvh", ".bvh").size(), std::size(all));
  for (const Expected& e : all) {
    SCOPED_TRACE(e.name);
    ReadNotes notes;
    const MeasuredMotion m = read_bvh_file(e.name, &notes);
    EXPECT_EQ(m.frames, e.frames);
    EXPECT_EQ(m.joint_count(), e.joints);
    EXPECT_NEAR(m.rate, e.rate, 1e-9 * e.rate);
    EXPECT_NEAR(m.duration(), (e.frames - 1) * notes.frame_time, 2e-3);
  }
}

TEST(SharedBvh, PositionsMatchIndependentComputationAndRoundTrip) {
  NEEDS_SHARED_DATA();
  for (const std::string& name : files("bvh", ".bvh")) check_bvh(name, name == "01_01.bvh" ? 40 : 10);
}

TEST(SharedAmc, PositionsMatchCmuFormulaAndRoundTrip) {
  NEEDS_SHARED_DATA();
  EXPECT_EQ(files("asf_amc", ".amc").size(), 18U);
  for (const std::string& name : files("asf_amc", ".amc")) {
    const auto size = std::filesystem::file_size(folder + "asf_amc/" + name);
    if (size < 800'000) check_amc(name, 25);  // larger files are covered by SlowSharedAmc
  }
}

TEST(SlowSharedBvh, PositionsMatchInEveryFrame) {
  NEEDS_SHARED_DATA();
  for (const std::string& name : files("bvh", ".bvh")) check_bvh(name, 1);
}

TEST(SlowSharedAmc, PositionsMatchInEveryFrame) {
  NEEDS_SHARED_DATA();
  for (const std::string& name : files("asf_amc", ".amc")) check_amc(name, 1);
}

}  // namespace
}  // namespace ugoki::formats
