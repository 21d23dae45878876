// SMPL motions (.npz): world positions against products of rotation matrices, body models, size from steps, and faults.
#include "ugoki/scene_formats/smpl.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <cmath>
#include <cstring>
#include <map>
#include <string>
#include <vector>

#include "ugoki/spatial/elementary.h"

namespace ugoki::scene_formats {
namespace {

struct Array {
  std::vector<std::size_t> shape;
  std::vector<double> values;
};
using Arrays = std::map<std::string, Array>;

template <class T>
std::string raw(T x) {
  return {reinterpret_cast<const char*>(&x), sizeof x};
}

/// The bytes of an .npy file. @param type NumPy's name of the numbers: <f8, <f4
std::string npy(const Array& a, const std::string& type) {
  std::string shape;
  for (const std::size_t n : a.shape) shape += std::to_string(n) + ", ";
  std::string header = "{'descr': '" + type + "', 'fortran_order': False, 'shape': (" + shape + "), }";
  header.resize((header.size() + 11 + 63) / 64 * 64 - 11, ' ');
  header += '\n';
  std::string out = "\x93NUMPY\x01" + std::string(1, '\0') + raw(static_cast<std::uint16_t>(header.size())) + header;
  for (const double x : a.values) out += type == "<f8" ? raw(x) : raw(static_cast<float>(x));
  return out;
}

/// A zip without compression, as numpy.savez writes it.
std::string zip(const std::map<std::string, std::string>& files) {
  std::string out, directory;
  for (const auto& [name, data] : files) {
    const auto crc = static_cast<std::uint32_t>(crc32(0, reinterpret_cast<const Bytef*>(data.data()), static_cast<uInt>(data.size())));
    const auto size = static_cast<std::uint32_t>(data.size());
    const std::string common = raw(std::uint16_t{20}) + raw(std::uint16_t{0}) + raw(std::uint16_t{0}) + raw(std::uint32_t{0x21 << 16}) +
                               raw(crc) + raw(size) + raw(size) + raw(static_cast<std::uint16_t>(name.size())) + raw(std::uint16_t{0});
    directory += "PK\x01\x02" + raw(std::uint16_t{20}) + common + raw(std::uint16_t{0}) + raw(std::uint16_t{0}) + raw(std::uint16_t{0}) +
                 raw(std::uint32_t{0}) + raw(static_cast<std::uint32_t>(out.size())) + name;
    out += "PK\x03\x04" + common + name + data;
  }
  const auto count = static_cast<std::uint16_t>(files.size());
  return out + directory + "PK\x05\x06" + raw(std::uint32_t{0}) + raw(count) + raw(count) +
         raw(static_cast<std::uint32_t>(directory.size())) + raw(static_cast<std::uint32_t>(out.size())) + raw(std::uint16_t{0});
}

std::string npz(const Arrays& arrays, const std::string& type = "<f8") {
  std::map<std::string, std::string> files;
  for (const auto& [name, a] : arrays) files[name + ".npy"] = npy(a, type);
  return zip(files);
}

Result<MeasuredMotion> read(const std::string& bytes, const std::string& model = {}, formats::ReadNotes* notes = nullptr) {
  return read_smpl(std::as_bytes(std::span(bytes)), "walk.npz", {std::as_bytes(std::span(model)), "model.npz"}, notes);
}

/// Rodrigues' formula.
Mat3 rodrigues(const Vec3& r) {
  const double a = norm(r);
  if (a < 1e-12) return Mat3::identity();
  const Vec3 k = r / a;
  const Mat3 K = Mat3::columns({0, k.z, -k.y}, {-k.z, 0, k.x}, {k.y, -k.x, 0});
  return Mat3::identity() + K * std::sin(a) + (K * K) * (1 - std::cos(a));
}

/// A motion of `joints` joints with deterministic poses. @param z_up the pelvis stands upright in a space with Z up, as in AMASS
Arrays motion(std::size_t joints, bool z_up) {
  Arrays out;
  const std::size_t frames = 5;
  Array poses{{frames, 3 * joints}, {}}, trans{{frames, 3}, {}};
  for (std::size_t f = 0; f < frames; ++f)
    for (std::size_t c = 0; c < 3 * joints; ++c) {
      const double small = 0.3 * std::sin(1.7 * static_cast<double>(c) + 0.4 * static_cast<double>(f));
      poses.values.push_back(c < 3 ? (c == 0 && z_up ? 0.5 * pi : 0) : small);
    }
  for (std::size_t i = 0; i < 3 * frames; ++i) trans.values.push_back(0.1 * static_cast<double>(i) - 0.3);
  out["poses"] = poses;
  out["trans"] = trans;
  out["mocap_framerate"] = {{}, {120}};
  return out;
}

constexpr int parents[22] = {-1, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 9, 9, 12, 13, 14, 16, 17, 18, 19};

/// A body model whose joints are its vertices; one shape moves all of them outwards.
Arrays model(std::size_t joints) {
  Array J{{joints, joints}, std::vector<double>(joints * joints, 0)}, v{{joints, 3}, {}}, S{{joints, 3, 2}, {}};
  for (std::size_t j = 0; j < joints; ++j) {
    J.values[j * joints + j] = 1;
    for (int k = 0; k < 3; ++k) {
      v.values.push_back(0.1 * std::sin(static_cast<double>(3 * j) + k));
      S.values.push_back(0);
      S.values.push_back(0.5 * v.values.back());  // the second shape makes the body larger
    }
  }
  return {{"J_regressor", J}, {"v_template", v}, {"shapedirs", S}};
}

TEST(Smpl, WorldPositionsAreProductsOfRotationMatrices) {
  for (const bool z_up : {true, false})
    for (const std::size_t joints : {std::size_t{22}, std::size_t{24}, std::size_t{52}}) {
      SCOPED_TRACE(std::to_string(joints) + (z_up ? " z" : " y"));
      Arrays file = motion(joints, z_up);
      file["betas"] = {{10}, {7, 0.4, 0, 0, 0, 0, 0, 0, 0, 0}};
      const Arrays body = model(joints);
      const auto m = read(npz(file), npz(body));
      ASSERT_TRUE(m.has_value()) << m.error().text();
      EXPECT_EQ(m->frames, 5);
      EXPECT_EQ(m->rate, 120);
      ASSERT_EQ(m->joint_count(), static_cast<int>(joints));
      const auto rest = [&](std::size_t j) {
        Vec3 p;
        for (int k = 0; k < 3; ++k) p[k] = 1.2 * body.at("v_template").values[3 * j + static_cast<std::size_t>(k)];
        return p;
      };
      std::vector<Pose> X;
      for (std::size_t f = 0; f < 5; ++f) {
        m->calc_joint_poses(static_cast<int>(f), X);
        Mat3 R[22];
        Vec3 p[22];
        for (std::size_t j = 0; j < 22; ++j) {
          const double* r = file["poses"].values.data() + (f * joints + j) * 3;
          const double* t = file["trans"].values.data() + 3 * f;
          const Mat3 own = rodrigues({r[0], r[1], r[2]});
          if (parents[j] < 0) {
            R[j] = own;
            p[j] = rest(0) + Vec3{t[0], t[1], t[2]};
          } else {
            const auto parent = static_cast<std::size_t>(parents[j]);
            R[j] = R[parent] * own;
            p[j] = p[parent] + R[parent] * (rest(j) - rest(parent));
          }
          const Vec3 ours = z_up ? p[j] : Vec3{p[j].z, p[j].x, p[j].y};
          EXPECT_LT(norm(X[j].p - ours), 1e-12) << f << " " << j;
          // A bone of the left hand points to the left (our +y) at rest, which is the model's +x.
          const Vec3 left = R[j] * Vec3{1, 0, 0}, ours_left = z_up ? left : Vec3{left.z, left.x, left.y};
          EXPECT_LT(norm(X[j].R * Vec3{0, 1, 0} - ours_left), 1e-12) << f << " " << j;
        }
      }
    }
}

TEST(Smpl, SeparateArraysAndSinglePrecisionGiveTheSameMotion) {
  const Arrays whole = motion(22, true);
  Arrays parts = {{"trans", whole.at("trans")}, {"mocap_frame_rate", {{1}, {120}}}};
  Array root{{5, 3}, {}}, body{{5, 63}, {}};
  for (std::size_t f = 0; f < 5; ++f)
    for (std::size_t c = 0; c < 66; ++c) (c < 3 ? root : body).values.push_back(whole.at("poses").values[f * 66 + c]);
  parts["root_orient"] = root;
  parts["pose_body"] = body;
  const auto a = read(npz(whole)), b = read(npz(parts)), c = read(npz(whole, "<f4"));
  ASSERT_TRUE(a && b && c);
  ASSERT_EQ(a->rotations.size(), b->rotations.size());
  std::vector<Pose> X, Y, Z;
  for (int f = 0; f < 5; ++f) {
    a->calc_joint_poses(f, X);
    b->calc_joint_poses(f, Y);
    c->calc_joint_poses(f, Z);
    for (std::size_t j = 0; j < X.size(); ++j) {
      EXPECT_LT(norm(X[j].p - Y[j].p), 1e-12);
      EXPECT_LT(norm(X[j].p - Z[j].p), 1e-5);
    }
  }
}

TEST(Smpl, SizeFollowsFromTheSteps) {
  // Legs that swing about the hips while the stance foot is fixed: a person of 0.9 times the usual size.
  Arrays file;
  const std::size_t frames = 200;
  Array poses{{frames, 66}, std::vector<double>(frames * 66, 0)}, trans{{frames, 3}, {}};
  const double leg = 0.9 * (0.42 + 0.415), phase = 2 * pi / 50;
  double x = 0, before = 0;
  for (std::size_t f = 0; f < frames; ++f) {
    const double swing = 0.4 * std::sin(phase * static_cast<double>(f));
    poses.values[f * 66 + 3] = swing;   // left hip, about the model's x axis (left)
    poses.values[f * 66 + 6] = -swing;  // right hip
    const bool left = std::cos(phase * static_cast<double>(f) - 0.5 * phase) > 0;
    // The knee of the leg that swings forward is bent, so that the other foot is lower.
    poses.values[f * 66 + (left ? 15 : 12)] = 1.2;
    const double z = leg * std::sin(left ? swing : -swing), last = leg * std::sin(left ? before : -before);
    x += f > 0 ? z - last : 0;
    before = swing;
    trans.values.insert(trans.values.end(), {0, leg * std::cos(swing), x});
  }
  file["poses"] = poses;
  file["trans"] = trans;
  formats::ReadNotes notes;
  const auto m = read(npz(file), {}, &notes);
  ASSERT_TRUE(m.has_value()) << m.error().text();
  EXPECT_FALSE(notes.z_up);
  EXPECT_EQ(m->rate, 30);
  std::vector<Pose> X;
  m->calc_joint_poses(0, X);
  EXPECT_NEAR(norm(X[4].p - X[1].p), 0.9 * 0.42, 0.02);
}

TEST(Smpl, FaultsAreReportedWithRemedy) {
  const Arrays good = motion(22, true);
  const auto without = [&](const char* name) {
    Arrays a = good;
    a.erase(name);
    return npz(a);
  };
  Arrays columns = good, infinite = good, rows = good;
  columns["poses"].shape = {10, 33};
  columns["trans"] = {{10, 3}, std::vector<double>(30, 0)};
  infinite["trans"].values[4] = std::nan("");
  rows["trans"] = {{4, 3}, std::vector<double>(12, 0)};
  const std::string bytes = npz(good);
  for (const auto& [text, message] : {std::pair{std::string("not a zip"), "not a zip"},
                                      {without("poses"), "'poses'"},
                                      {without("trans"), "'trans'"},
                                      {npz(columns), "33 columns"},
                                      {npz(infinite), "not finite"},
                                      {npz(rows), "has 5 rows"},
                                      {bytes.substr(0, bytes.size() / 2), "zip"},
                                      {zip({{"poses.npy", "\x93NUMPY"}, {"trans.npy", ""}}), "NPY"}}) {
    const auto m = read(text);
    ASSERT_FALSE(m.has_value()) << message;
    EXPECT_NE(m.error().text().find(message), std::string::npos) << m.error().text();
    for (const Problem& p : m.error().problems) EXPECT_FALSE(p.remedy.empty());
  }
  const auto small = read(bytes, npz(model(20)));
  ASSERT_FALSE(small.has_value());
  EXPECT_NE(small.error().text().find("20 joints"), std::string::npos) << small.error().text();
}

}  // namespace
}  // namespace ugoki::scene_formats
