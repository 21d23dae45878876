// Skins of glTF files: the world positions of their vertices on the imported body against linear blend skinning as glTF defines it
// (sum of weight * world matrix of the joint * inverse bind matrix * position), evaluated here from the file's nodes.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <string>

#include "ugoki/body/body.h"
#include "ugoki/formats/glb_chunk.h"
#include "ugoki/formats/mechanism_json.h"
#include "ugoki/intake/intake.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/mechanism_edit/combine.h"
#include "ugoki/mechanism_edit/cut.h"
#include "ugoki/mechanism_edit/mirror.h"
#include "ugoki/mechanism_edit/scale.h"
#include "ugoki/spatial/rotation.h"

namespace ugoki::intake {
namespace {

using json::Json;

struct Matrix {
  Mat3 A = Mat3::identity();
  Vec3 p;
  friend Matrix operator*(const Matrix& a, const Matrix& b) { return {a.A * b.A, a.A * b.p + a.p}; }
  Vec3 operator*(const Vec3& v) const { return A * v + p; }
};

constexpr int joints = 6, frames = 25;
constexpr double unit = 0.01;  // scale of the armature
const int parents[joints] = {-1, 0, 1, 2, 2, 4};

/// A rig of six joints in centimetres below an armature that is scaled to metres and turned; joints 3 and 5 never turn.
struct Rig {
  Quat armature_turn = normalized(Quat{0.7, -0.7, 0.1, 0});
  Vec3 armature_place{0.2, 1.1, -0.4};
  bool colored = false;       ///< vertices have the colours of color_of()
  double target_weight = -1;  ///< at rest, of a morph target that moves vertex v by target_offset(v); below 0: no target
  Vec3 offset[joints] = {{0, 0, 0}, {0, 30, 0}, {0, 35, 3}, {4, 20, 0}, {0, 40, 0}, {0, 25, 5}};

  Quat turn(int joint, double t) const {
    if (joint == 3 || joint == 5) return normalized(Quat{1, 0.2, 0.1, 0});
    const double a = 0.4 * std::sin(2 * t + joint) + 0.05 * joint, b = 0.3 * std::cos(3 * t + 2 * joint);
    return normalized(Quat{std::cos(a), std::sin(a), 0, 0} * Quat{std::cos(b), 0, 0, std::sin(b)});
  }
  Vec3 place(int joint, double t) const { return joint == 0 ? Vec3{20 * t, 80 + 5 * std::sin(4 * t), 0} : offset[joint]; }
  Matrix armature() const { return {to_matrix(armature_turn) * Mat3::diagonal(unit, unit, unit), armature_place}; }
  /// World matrix of a joint. @param t s; negative: in the pose of the bind
  Matrix world(int joint, double t) const {
    const Quat q = t < 0 ? normalized(Quat{1, 0.1 * joint, 0, 0.05}) : turn(joint, t);
    const Matrix local{to_matrix(q), t < 0 && joint == 0 ? Vec3{0, 80, 0} : place(joint, std::max(t, 0.0))};
    return (parents[joint] < 0 ? armature() : world(parents[joint], t)) * local;
  }
  /// Inverse of a matrix whose linear part is a rotation with a scale.
  static Matrix inverse(const Matrix& m) {
    const double s = dot(m.A.column(0), m.A.column(0));
    const Mat3 A = m.A.transposed() * (1 / s);
    return {A, -(A * m.p)};
  }
  Matrix bind(int joint) const { return inverse(world(joint, -1)); }
};

struct Vertex {
  Vec3 p;
  int joint[2];
  double weight;  // of the first joint
};

/// Vertices around each joint, in the world of the bind pose, shared with the next joint of the chain.
std::vector<Vertex> vertices_of(const Rig& rig) {
  std::vector<Vertex> out;
  for (int j = 0; j < joints; ++j)
    for (int k = 0; k < 6; ++k) {
      const Vec3 p = rig.world(j, -1).p + Vec3{0.1 * std::cos(k), 0.05 * k, 0.1 * std::sin(k)};
      out.push_back({p, {j, parents[j] < 0 ? 0 : parents[j]}, k / 5.0});
    }
  return out;
}

/// Linear red, green, blue and alpha of a vertex.
std::array<float, 4> color_of(std::size_t v) { return {static_cast<float>(v % 5) / 4, 0.25f, 1.5f, 0.5f}; }
/// In the unit of the mesh.
Vec3 target_offset(std::size_t v) { return {0.01 * static_cast<double>(v), 0, -0.02}; }

std::vector<std::byte> write_rig(const Rig& rig, const std::vector<std::byte>& picture) {
  formats::GlbChunk chunk;
  std::vector<float> times, positions, uvs, weights, binds;
  std::vector<std::uint16_t> bones, indices;
  for (int f = 0; f < frames; ++f) times.push_back(static_cast<float>(f) / 25);
  const std::vector<Vertex> vertices = vertices_of(rig);
  for (const Vertex& v : vertices) {
    for (int k = 0; k < 3; ++k) positions.push_back(static_cast<float>(v.p[k]));
    uvs.insert(uvs.end(), {0.25f, 0.75f});
    bones.insert(bones.end(), {static_cast<std::uint16_t>(v.joint[0]), static_cast<std::uint16_t>(v.joint[1]), 0, 0});
    weights.insert(weights.end(), {static_cast<float>(v.weight), static_cast<float>(1 - v.weight), 0, 0});
  }
  for (std::uint16_t i = 0; i + 2 < static_cast<std::uint16_t>(vertices.size()); ++i)
    indices.insert(indices.end(), {i, static_cast<std::uint16_t>(i + 1), static_cast<std::uint16_t>(i + 2)});
  for (int j = 0; j < joints; ++j) {
    const Matrix m = rig.bind(j);
    for (int c = 0; c < 3; ++c) {
      for (int k = 0; k < 3; ++k) binds.push_back(static_cast<float>(m.A.column(c)[k]));
      binds.push_back(0);
    }
    for (int k = 0; k < 3; ++k) binds.push_back(static_cast<float>(m.p[k]));
    binds.push_back(1);
  }
  const int time = chunk.floats(times, 1, "SCALAR");
  Json nodes = Json::array(), channels = Json::array(), samplers = Json::array();
  const Quat a = rig.armature_turn;
  nodes.push_back({{"name", "armature"},
                   {"children", {1}},
                   {"rotation", {a.x, a.y, a.z, a.w}},
                   {"scale", {unit, unit, unit}},
                   {"translation", {rig.armature_place.x, rig.armature_place.y, rig.armature_place.z}}});
  for (int j = 0; j < joints; ++j) {
    Json children = Json::array();
    std::vector<float> turns, places;
    for (int c = 0; c < joints; ++c)
      if (parents[c] == j) children.push_back(c + 1);
    for (int f = 0; f < frames; ++f) {
      const Quat q = rig.turn(j, f / 25.0);
      const Vec3 p = rig.place(j, f / 25.0);
      for (const double x : {q.x, q.y, q.z, q.w}) turns.push_back(static_cast<float>(x));
      for (int k = 0; k < 3; ++k) places.push_back(static_cast<float>(p[k]));
    }
    Json node{{"name", "joint " + std::to_string(j)}};
    if (!children.empty()) node["children"] = children;
    nodes.push_back(node);
    for (const auto& [path, output] :
         {std::pair{"rotation", chunk.floats(turns, 4, "VEC4")}, {"translation", chunk.floats(places, 3, "VEC3")}}) {
      channels.push_back({{"sampler", samplers.size()}, {"target", {{"node", j + 1}, {"path", path}}}});
      samplers.push_back({{"input", time}, {"output", output}});
    }
  }
  nodes.push_back({{"name", "body"}, {"mesh", 0}, {"skin", 0}});
  Json attributes = {{"POSITION", chunk.floats(positions, 3, "VEC3")},
                     {"TEXCOORD_0", chunk.floats(uvs, 2, "VEC2")},
                     {"JOINTS_0", chunk.add(bones, 4, "VEC4", 5123)},
                     {"WEIGHTS_0", chunk.floats(weights, 4, "VEC4")}};
  std::vector<float> colors, offsets;
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    const std::array<float, 4> color = color_of(v);
    colors.insert(colors.end(), color.begin(), color.end());
    for (int k = 0; k < 3; ++k) offsets.push_back(static_cast<float>(target_offset(v)[k]));
  }
  if (rig.colored) attributes["COLOR_0"] = chunk.floats(colors, 4, "VEC4");
  Json mesh = {{"primitives", {{{"attributes", attributes}, {"indices", chunk.add(indices, 1, "SCALAR", 5123)}, {"material", 0}}}}};
  if (rig.target_weight >= 0) {
    mesh["primitives"][0]["targets"] = {{{"POSITION", chunk.floats(offsets, 3, "VEC3")}}};
    mesh["weights"] = {rig.target_weight};
  }
  std::string encoded = "data:image/png;base64,";
  constexpr const char* letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  for (std::size_t i = 0; i + 2 < picture.size(); i += 3) {
    const unsigned bits = std::to_integer<unsigned>(picture[i]) << 16 | std::to_integer<unsigned>(picture[i + 1]) << 8 |
                          std::to_integer<unsigned>(picture[i + 2]);
    for (const unsigned shift : {18u, 12u, 6u, 0u}) encoded += letters[bits >> shift & 63];
  }
  Json root = {
      {"asset", {{"version", "2.0"}}},
      {"scene", 0},
      {"scenes", {{{"nodes", {0, joints + 1}}}}},
      {"nodes", nodes},
      {"images", {{{"uri", encoded}}}},
      {"textures", {{{"source", 0}}}},
      {"materials",
       {{{"pbrMetallicRoughness", {{"baseColorFactor", {1, 0, 0, 1}}, {"baseColorTexture", {{"index", 0}}}}}, {"doubleSided", true}}}},
      {"meshes", {mesh}},
      {"skins", {{{"joints", {1, 2, 3, 4, 5, 6}}, {"inverseBindMatrices", chunk.floats(binds, 16, "MAT4")}}}},
      {"animations", {{{"name", "sway"}, {"channels", channels}, {"samplers", samplers}}}}};
  return chunk.finish(std::move(root));
}

/// Head of a PNG file of the given size; only its size is read.
std::vector<std::byte> picture(int width, int height) {
  std::vector<std::byte> out;
  for (const int b : {0x89,    'P' + 0, 'N' + 0, 'G' + 0, 13, 10, 26,         10,          0, 0, 0,           13,
                      'I' + 0, 'H' + 0, 'D' + 0, 'R' + 0, 0,  0,  width >> 8, width & 255, 0, 0, height >> 8, height & 255,
                      8,       2,       0,       0,       0,  0,  0,          0,           0, 0, 0,           0})
    out.push_back(static_cast<std::byte>(b));
  return out;
}

Result<Intake> take_in_rig(const Rig& rig, const std::vector<std::byte>& image, const IntakeOptions& options = {}) {
  const std::vector<std::byte> file = write_rig(rig, image);
  return take_in({reinterpret_cast<const char*>(file.data()), file.size()}, "rig.glb", nullptr, options);
}

/// World positions of all vertices of the skin in a position of the mechanism.
std::vector<Vec3> skinned(const Mechanism& m, std::span<const double> q) {
  std::vector<Pose> X(static_cast<std::size_t>(m.link_count())), links;
  calc_poses(m, q, X);
  for (const SkinBone& bone : m.skin_bones()) links.push_back(X[static_cast<std::size_t>(m.find_link(bone.link))]);
  std::vector<Vec3> out;
  for (std::size_t v = 0; v < m.skin()->vertex_count(); ++v) out.push_back(skinned_point(*m.skin(), m.skin_bones(), links, v));
  return out;
}

std::span<const double> frame_of(const Motion& motion, int f) { return {motion.frame(f), static_cast<std::size_t>(motion.nq)}; }

TEST(Skin, FollowsTheBodyAsTheFileDefines) {
  const Rig rig;
  const Result<Intake> made = take_in_rig(rig, picture(64, 32));
  ASSERT_TRUE(made) << made.error().text();
  const Mechanism& m = *made->mechanism;
  ASSERT_TRUE(m.skin());
  EXPECT_EQ(m.name(), "rig") << "a character is named after its file";
  EXPECT_EQ(made->items[2].name, "sway");
  const std::vector<Vertex> vertices = vertices_of(rig);
  ASSERT_EQ(m.skin()->vertex_count(), vertices.size());
  ASSERT_EQ(m.skin()->textures.size(), 1U);
  EXPECT_EQ(m.skin()->textures[0].type, "image/png");
  EXPECT_EQ(m.skin()->parts.at(0).color, "#ff0000");
  EXPECT_TRUE(m.skin()->parts[0].both_sides);
  ASSERT_EQ(made->motion->frames, frames);
  const Pose floor = body::calc_floor_pose(*made->body, *made->measured);
  double worst = 0;
  for (int f = 0; f < frames; ++f) {
    const std::vector<Vec3> points = skinned(m, frame_of(*made->motion, f));
    for (std::size_t v = 0; v < vertices.size(); ++v) {
      Vec3 in_file;
      for (int k = 0; k < 2; ++k) {
        const int j = vertices[v].joint[k];
        in_file += (k == 0 ? vertices[v].weight : 1 - vertices[v].weight) * (rig.world(j, f / 25.0) * (rig.bind(j) * vertices[v].p));
      }
      worst = std::max(worst, norm(points[v] - floor * Vec3{in_file.z, in_file.x, in_file.y}));
    }
  }
  EXPECT_LT(worst, 1e-4) << "m";
}

TEST(Skin, KeepsItsPlaceOnEditedBodies) {
  const Result<Intake> made = take_in_rig({}, picture(64, 32));
  ASSERT_TRUE(made) << made.error().text();
  const Mechanism& m = *made->mechanism;
  const std::vector<double> q = m.neutral();
  const std::vector<Vec3> before = skinned(m, q);
  const Result<Edited> large = scale(m, {.length = 1.5});
  ASSERT_TRUE(large) << large.error().text();
  const std::vector<Vec3> after = skinned(*large->mechanism, large->mechanism->neutral());
  for (std::size_t v = 0; v < before.size(); ++v) EXPECT_NEAR(norm(after[v] - 1.5 * before[v]), 0, 1e-6);
  const Result<Edited> image = mirror(m, {});
  ASSERT_TRUE(image) << image.error().text();
  const std::vector<Vec3> mirrored = skinned(*image->mechanism, image->mechanism->neutral());
  for (std::size_t v = 0; v < before.size(); ++v) EXPECT_NEAR(norm(mirrored[v] - Vec3{before[v].x, -before[v].y, before[v].z}), 0, 1e-6);
  const Result<Edited> less = cut(m, "joint 4", {});
  ASSERT_TRUE(less) << less.error().text();
  EXPECT_FALSE(less->mechanism->skin());
  EXPECT_FALSE(less->report.empty());
  const Result<Combined> both = combine(m, m, {.link_a = "joint 1", .link_b = "joint 0"});
  ASSERT_TRUE(both) << both.error().text();
  EXPECT_TRUE(both->mechanism->skin());
}

TEST(Skin, IsStoredWithTheMechanism) {
  const Result<Intake> made = take_in_rig({}, picture(64, 32));
  ASSERT_TRUE(made) << made.error().text();
  const std::string text = formats::write_mechanism(*made->mechanism);
  const Result<MechanismPtr> back = formats::read_mechanism(text, "back");
  ASSERT_TRUE(back) << back.error().text();
  EXPECT_EQ(formats::write_mechanism(**back), text);
  std::string damaged = text;
  damaged.replace(damaged.find("\"weights\": \"") + 12, 4, "AAAA");
  EXPECT_FALSE(formats::read_mechanism(damaged, "damaged")) << "weights that do not add up to 1 are refused";
  damaged = text;
  damaged.replace(damaged.find("\"link\": \"joint", damaged.find("\"skin\"")) + 9, 5, "other");
  EXPECT_FALSE(formats::read_mechanism(damaged, "damaged")) << "a bone on an unknown link is refused";
}

TEST(Skin, KeepsTheColorsOfItsVertices) {
  Rig rig;
  rig.colored = true;
  const Result<Intake> made = take_in_rig(rig, picture(64, 32));
  ASSERT_TRUE(made) << made.error().text();
  const Skin& skin = *made->mechanism->skin();
  ASSERT_EQ(skin.colors.size(), 3 * skin.vertex_count());
  for (std::size_t v = 0; v < skin.vertex_count(); ++v) {
    EXPECT_NEAR(skin.colors[3 * v], 65535.0 * static_cast<double>(color_of(v)[0]), 1);
    EXPECT_EQ(skin.colors[3 * v + 1], 16384);
    EXPECT_EQ(skin.colors[3 * v + 2], 65535) << "clamped";
  }
  const std::string text = formats::write_mechanism(*made->mechanism);
  const Result<MechanismPtr> back = formats::read_mechanism(text, "back");
  ASSERT_TRUE(back) << back.error().text();
  EXPECT_EQ((*back)->skin()->colors, skin.colors);
  EXPECT_EQ(formats::write_mechanism(**back), text);
  std::string damaged = text;
  damaged.replace(damaged.find("\"colors\": \"") + 11, 8, "");
  EXPECT_FALSE(formats::read_mechanism(damaged, "damaged")) << "colours of fewer vertices are refused";
  const Result<Intake> plain = take_in_rig({}, picture(64, 32));
  ASSERT_TRUE(plain) << plain.error().text();
  EXPECT_TRUE(plain->mechanism->skin()->colors.empty());
}

TEST(Skin, HasTheShapeOfMorphTargetsAtRest) {
  const Result<Intake> plain = take_in_rig({}, picture(64, 32));
  ASSERT_TRUE(plain) << plain.error().text();
  for (const double weight : {0.0, 0.5}) {
    Rig rig;
    rig.target_weight = weight;
    const Result<Intake> made = take_in_rig(rig, picture(64, 32));
    ASSERT_TRUE(made) << made.error().text();
    EXPECT_NE(made->report[0].find("not animated"), std::string::npos) << made->report[0];
    const std::vector<float>&without = plain->mechanism->skin()->positions, &with = made->mechanism->skin()->positions;
    ASSERT_EQ(with.size(), without.size());
    for (std::size_t i = 0; i < with.size(); ++i)
      EXPECT_NEAR(with[i] - without[i], weight * target_offset(i / 3)[static_cast<int>(i % 3)], 1e-6);
  }
}

TEST(Skin, ReportsWhatIsLeftOut) {
  const Result<Intake> huge = take_in_rig({}, picture(20000, 16));
  ASSERT_TRUE(huge) << huge.error().text();
  EXPECT_TRUE(huge->mechanism->skin()->textures.empty());
  EXPECT_NE(huge->report[0].find("20000 x 16 pixels"), std::string::npos) << huge->report[0];
  const Result<Intake> other = take_in_rig({}, std::vector<std::byte>(48));
  ASSERT_TRUE(other) << other.error().text();
  EXPECT_NE(other->report[0].find("neither PNG nor JPEG"), std::string::npos) << other->report[0];
}

TEST(Skin, ValuesOutOfRangeLeaveTheSkinOut) {
  const Rig rig;
  std::vector<std::byte> bytes = write_rig(rig, picture(64, 32));
  const Vec3 vertex = vertices_of(rig)[3].p;
  float from[3], to[3] = {1e12f, 0, 0};
  for (int k = 0; k < 3; ++k) from[k] = static_cast<float>(vertex[k]);
  const auto place = std::ranges::search(bytes, std::as_bytes(std::span(from)));
  ASSERT_FALSE(place.empty());
  std::ranges::copy(std::as_bytes(std::span(to)), place.begin());
  const Result<Intake> made = take_in({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, "rig.glb");
  ASSERT_TRUE(made) << made.error().text();
  EXPECT_FALSE(made->mechanism->skin());
  EXPECT_NE(made->report[0].find("left out"), std::string::npos) << made->report[0];
}

}  // namespace
}  // namespace ugoki::intake
