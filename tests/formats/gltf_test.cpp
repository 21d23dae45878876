#include "ugoki/formats/gltf.h"

#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "expect.h"

namespace ugoki::formats {
namespace {

std::string base64(const std::vector<float>& numbers) {
  std::vector<unsigned char> bytes(numbers.size() * 4);
  std::memcpy(bytes.data(), numbers.data(), bytes.size());
  constexpr const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    unsigned v = 0;
    for (std::size_t k = 0; k < 3; ++k) v = v << 8 | (i + k < bytes.size() ? bytes[i + k] : 0U);
    for (int k = 3; k >= 0; --k) out.push_back(i + static_cast<std::size_t>(3 - k) > bytes.size() ? '=' : digits[v >> (6 * k) & 63]);
  }
  return out;
}

/// A file with a node "arm" 1 m up and its child "hand" at 2 m along the arm's y. An animation with keys at 0, 1, 2 s moves the hand, or
/// rotates the arm if `path` is "rotation".
std::string arm(const std::string& interpolation, const std::string& path, const std::vector<float>& values) {
  const std::size_t components = path == "rotation" ? 4 : 3;
  std::vector<float> numbers = {0, 1, 2};
  numbers.insert(numbers.end(), values.begin(), values.end());
  return R"({"asset": {"version": "2.0"}, "nodes": [
    {"name": "arm", "translation": [0, 1, 0], "rotation": [0, 0, 0.7071067811865476, 0.7071067811865476], "children": [1]},
    {"name": "hand", "translation": [0, 2, 0], "scale": [1, 1, 1]}],
    "animations": [{"name": "wave", "channels": [{"sampler": 0, "target": {"node": )" +
         std::string(path == "rotation" ? "0" : "1") + R"(, "path": ")" + path + R"("}}],
      "samplers": [{"input": 0, "output": 1, "interpolation": ")" +
         interpolation + R"("}]}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "SCALAR"},
      {"bufferView": 0, "byteOffset": 12, "componentType": 5126, "count": )" +
         std::to_string(values.size() / components) + R"(, "type": "VEC)" + std::to_string(components) + R"("}],
    "bufferViews": [{"buffer": 0, "byteLength": )" +
         std::to_string(4 * numbers.size()) + R"(}],
    "buffers": [{"byteLength": )" +
         std::to_string(4 * numbers.size()) + R"(, "uri": "data:application/octet-stream;base64,)" + base64(numbers) + R"("}]})";
}

Result<std::vector<MeasuredMotion>> read(const std::string& text, GltfOptions options = {}, ReadNotes* notes = nullptr) {
  return read_gltf(std::as_bytes(std::span(text)), "arm.gltf", options, notes);
}

Vec3 hand_at(const MeasuredMotion& m, int frame) {
  std::vector<Pose> X;
  m.calc_joint_poses(frame, X);
  return X[1].p;
}

// (x, y, z) of the file is (z, x, y) in our axes. The arm is rotated by 90 degrees about the file's z axis, so that its y axis points
// along -x of the file.

TEST(Gltf, LinearKeysAreInterpolatedLinearly) {
  const auto m = read(arm("LINEAR", "translation", {0, 2, 0, 0, 4, 0, 1, 4, 0}), {.rate = 4});
  ASSERT_TRUE(m.has_value()) << text_of(m.error());
  ASSERT_EQ(m->size(), 1U);
  EXPECT_EQ((*m)[0].name, "wave");
  EXPECT_EQ((*m)[0].frames, 9);
  expect_near(hand_at((*m)[0], 0), {0, -2, 1}, 1e-6, "start");
  expect_near(hand_at((*m)[0], 2), {0, -3, 1}, 1e-6, "half way");
  expect_near(hand_at((*m)[0], 6), {0, -4, 1.5}, 1e-6, "second half");
  EXPECT_TRUE((*m)[0].skeleton.joints[1].translates);
}

TEST(Gltf, StepKeysHoldAndCubicKeysFollowTangents) {
  const auto step = read(arm("STEP", "translation", {0, 2, 0, 0, 4, 0, 1, 4, 0}), {.rate = 4});
  ASSERT_TRUE(step.has_value());
  expect_near(hand_at((*step)[0], 3), {0, -2, 1}, 1e-6, "held");
  expect_near(hand_at((*step)[0], 4), {0, -4, 1}, 1e-6, "next");
  // Each key has an in-tangent, a value and an out-tangent. In the first second y starts at 0 with slope 1, y = s (1 - s)^2, and z ends
  // at 0 with slope 1, z = s^2 (s - 1).
  const auto cubic = read(
      arm("CUBICSPLINE", "translation", {0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}), {.rate = 4});
  ASSERT_TRUE(cubic.has_value()) << text_of(cubic.error());
  for (int f = 0; f <= 4; ++f) {
    const double s = f / 4.0;
    expect_near(hand_at((*cubic)[0], f), {s * s * (s - 1), -s * (1 - s) * (1 - s), 1}, 1e-6, "cubic");
  }
}

TEST(Gltf, TurningNodesOutsideAPartialSkinAreJoints) {
  // The skin contains the head only, as in a file of a face; the animation turns pelvis and leg.
  const std::vector<float> numbers = {0, 1, 2, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
  const auto file = [&](const std::string& channels) {
    return R"({"asset": {"version": "2.0"}, "nodes": [
      {"name": "pelvis", "children": [1, 2]}, {"name": "head", "translation": [0, 1, 0]}, {"name": "leg", "translation": [0, -1, 0]}],
      "skins": [{"joints": [1]}], "animations": [{"channels": [)" +
           channels + R"(], "samplers": [{"input": 0, "output": 1}]}],
      "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "SCALAR"},
        {"bufferView": 0, "byteOffset": 12, "componentType": 5126, "count": 3, "type": "VEC4"}],
      "bufferViews": [{"buffer": 0, "byteLength": 60}],
      "buffers": [{"byteLength": 60, "uri": "data:application/octet-stream;base64,)" +
           base64(numbers) + R"("}]})";
  };
  const auto channel = [](int node) { return R"({"sampler": 0, "target": {"path": "rotation", "node": )" + std::to_string(node) + "}}"; };
  const auto names = [&](const std::string& channels) {
    const auto m = read(file(channels));
    EXPECT_TRUE(m.has_value()) << text_of(m.error());
    std::string out;
    for (const SkeletonJoint& j : (*m)[0].skeleton.joints) out += j.name + " ";
    return out;
  };
  EXPECT_EQ(names(channel(0) + "," + channel(2)), "pelvis head leg ");
  // A single node that turns beside the skin (a weapon, a target) is no joint.
  EXPECT_EQ(names(channel(1) + "," + channel(2)), "head ");
}

TEST(Gltf, BonesOfTheBindPoseHaveTheirLengthsInTheScene) {
  // An arm under a node with scale 0.01: shoulder 100 units up, elbow 30 units further. The skin's matrices are those of the scene, of the
  // node's own space, or of a space with another scale.
  const auto file = [](float up, float bone, float scale) {
    const std::vector<float> numbers = {0,     1, 0, 0, 0, 1,     0, 0, 0, 1,  // two keys of a rotation
                                        scale, 0, 0, 0, 0, scale, 0, 0, 0, 0, scale, 0, 0, -up * scale,          0, 1,
                                        scale, 0, 0, 0, 0, scale, 0, 0, 0, 0, scale, 0, 0, -(up + bone) * scale, 0, 1};
    return R"({"asset": {"version": "2.0"}, "nodes": [
      {"name": "armature", "scale": [0.01, 0.01, 0.01], "children": [1, 3]}, {"name": "shoulder", "translation": [0, 100, 0], "children": [2]},
      {"name": "elbow", "translation": [0, 30, 0]}, {"name": "mesh", "skin": 0}],
      "skins": [{"joints": [1, 2], "inverseBindMatrices": 2}],
      "animations": [{"channels": [{"sampler": 0, "target": {"path": "rotation", "node": 2}}], "samplers": [{"input": 0, "output": 1}]}],
      "accessors": [{"bufferView": 0, "componentType": 5126, "count": 2, "type": "SCALAR"},
        {"bufferView": 0, "byteOffset": 8, "componentType": 5126, "count": 2, "type": "VEC4"},
        {"bufferView": 0, "byteOffset": 40, "componentType": 5126, "count": 2, "type": "MAT4"}],
      "bufferViews": [{"buffer": 0, "byteLength": 168}],
      "buffers": [{"byteLength": 168, "uri": "data:application/octet-stream;base64,)" +
           base64(numbers) + R"("}]})";
  };
  for (const std::string& text : {file(1, 0.3F, 100), file(100, 30, 1), file(1000, 300, 0.1F)}) {
    const auto m = read(text);
    ASSERT_TRUE(m.has_value()) << text_of(m.error());
    ASSERT_EQ((*m)[0].joint_count(), 2);
    expect_near((*m)[0].skeleton.joints[1].offset, {0, 0, 0.3}, 1e-6, "elbow at rest");
    expect_near(hand_at((*m)[0], 0), {0, 0, 1.3}, 1e-6, "elbow in the motion");
    EXPECT_FALSE((*m)[0].skeleton.joints[1].translates);
  }
}

TEST(Gltf, DataCompressedWithMeshoptAreNamed) {
  std::string text = arm("STEP", "translation", {0, 2, 0, 0, 4, 0, 1, 4, 0});
  const std::string view = R"("bufferViews": [{)";
  text.insert(text.find(view) + view.size(), R"("extensions": {"EXT_meshopt_compression": {"buffer": 0}}, )");
  const auto m = read(text);
  ASSERT_FALSE(m.has_value());
  EXPECT_NE(m.error().text().find("EXT_meshopt_compression"), std::string::npos) << m.error().text();
}

TEST(Gltf, RotationsFollowTheShortestArc) {
  const float h = 0.70710678f;
  const auto m = read(arm("LINEAR", "rotation", {0, 0, 0, 1, 0, 0, -h, -h, 0, 0, 0, 1}), {.rate = 2});
  ASSERT_TRUE(m.has_value()) << text_of(m.error());
  const double r = std::sqrt(2.0);
  expect_near(hand_at((*m)[0], 0), {0, 0, 3}, 1e-6, "upright");
  expect_near(hand_at((*m)[0], 1), {0, -r, 1 + r}, 1e-6, "half way");
  expect_near(hand_at((*m)[0], 2), {0, -2, 1}, 1e-6, "turned");
}

TEST(Gltf, RoundTripKeepsPositions) {
  const float h = 0.70710678f;
  for (const std::string& text :
       {arm("LINEAR", "translation", {0, 2, 0, 0, 4, 0, 1, 4, 0}), arm("LINEAR", "rotation", {0, 0, 0, 1, h, 0, 0, h, 0, h, 0, h})}) {
    const auto m = read(text, {.rate = 10});
    ASSERT_TRUE(m.has_value());
    const std::vector<std::byte> bytes = write_glb((*m)[0]);
    EXPECT_EQ(bytes.size() % 4, 0U);
    const auto back = read_gltf(bytes, "arm.glb");
    ASSERT_TRUE(back.has_value()) << text_of(back.error());
    EXPECT_EQ((*back)[0].rate, 10);
    EXPECT_LT(max_distance((*m)[0], (*back)[0], 1), 1e-6);
  }
}

TEST(Gltf, BrokenFilesAreRejectedWithLocationAndRemedy) {
  const std::string good = arm("LINEAR", "translation", {0, 2, 0, 0, 4, 0, 1, 4, 0});
  const auto refused = [](const std::string& text, const std::string& what, const std::string& location) {
    const auto m = read(text);
    ASSERT_FALSE(m.has_value()) << what;
    const Problem& p = m.error().problems.at(0);
    EXPECT_NE(p.location.find(location), std::string::npos) << what << ": " << p.text();
    EXPECT_TRUE(p.message.ends_with('.')) << p.text();
    EXPECT_FALSE(p.remedy.empty()) << p.text();
  };
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
  };
  refused("", "empty", "arm.gltf");
  refused(good.substr(0, 300), "truncated", "arm.gltf");
  refused("{}", "no asset", "asset/version");
  refused(with("\"2.0\"", "\"1.0\""), "version 1", "asset/version");
  refused(with("\"children\": [1]", "\"children\": [7]"), "no such child", "nodes/0/children");
  refused(with("\"children\": [1]", "\"children\": [0]"), "own child", "nodes/0");
  refused(with("[0, 1, 0]", "[0, 1]"), "two numbers", "nodes/0");
  refused(with("[0, 1, 0]", "[0, 1e300, 0]"), "huge", "nodes/0");
  refused(with("\"sampler\": 0", "\"sampler\": 3"), "no sampler", "animations/0/channels/0");
  refused(with("\"node\": 1", "\"node\": 9"), "no node", "animations/0/channels/0");
  refused(with("\"count\": 3", "\"count\": 4000000000"), "count", "animations/0/channels/0");
  refused(with("\"byteOffset\": 12", "\"byteOffset\": 1200"), "offset", "animations/0/channels/0");
  refused(with("\"byteLength\": 48", "\"byteLength\": 4800"), "view beyond buffer", "animations/0/channels/0");
  refused(with("VEC3", "VEC4"), "type", "animations/0/channels/0");
  refused(with("data:application/octet-stream;base64,", "data:application/octet-stream;base64,*"), "base64", "buffers/0");
  refused(with("data:application/octet-stream;base64,", "other.bin?"), "another file", "buffers/0");
  std::string glb("glTF\x02\x00\x00\x00\xff\xff\x00\x00\x10\x00\x00\x00JSON", 20);
  refused(glb, "short GLB", "header");
}

TEST(Gltf, SharedFilesHaveExpectedJointsAndRoundTrip) {
  const std::string folder = std::string(UGOKI_SOURCE_DIR) + "/../shared/data/";
  struct Expected {
    const char* file;
    int joints;
    std::size_t animations;
    int first_frames;
  };
  for (const Expected& e : {Expected{"animal/Fox.glb", 24, 3, 83}, Expected{"animal/bird-animations.glb", 55, 5, 15},
                            Expected{"animal/fox-animations.glb", 49, 14, 84}, Expected{"animal/snake-animations.glb", 28, 8, 30},
                            Expected{"gltf/cesium_man.gltf", 19, 1, 49}, Expected{"gltf/rigged_simple.gltf", 2, 1, 50},
                            Expected{"gltf/rig-human.glb", 66, 1, 1}}) {
    std::ifstream in(folder + e.file, std::ios::binary);
    if (!in) GTEST_SKIP() << "no " << folder << e.file;
    const std::vector<char> raw{std::istreambuf_iterator<char>(in), {}};
    const auto m = read_gltf(std::as_bytes(std::span(raw)), e.file);
    ASSERT_TRUE(m.has_value()) << text_of(m.error());
    EXPECT_EQ(m->size(), e.animations) << e.file;
    EXPECT_EQ((*m)[0].joint_count(), e.joints) << e.file;
    EXPECT_EQ((*m)[0].frames, e.first_frames) << e.file;
    const auto back = read_gltf(write_glb((*m)[0]), "copy.glb", {.rate = (*m)[0].rate, .metres_per_unit = 1});
    ASSERT_TRUE(back.has_value()) << text_of(back.error());
    EXPECT_LT(max_distance((*m)[0], (*back)[0], 5), 1e-5) << e.file;
  }
}

}  // namespace
}  // namespace ugoki::formats
