// Tests of glTF files whose animations EXT_meshopt_compression packs.
#include "ugoki/scene_formats/meshopt.h"

#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include <cmath>
#include <cstring>
#include <string>

#include "ugoki/formats/gltf_unpack.h"

namespace ugoki::scene_formats {
namespace {

constexpr int keys = 50;

std::vector<std::byte> packed(const void* data, std::size_t count, std::size_t stride) {
  std::vector<unsigned char> out(meshopt_encodeVertexBufferBound(count, stride));
  meshopt_encodeVertexVersion(0);
  out.resize(meshopt_encodeVertexBuffer(out.data(), out.size(), data, count, stride));
  const auto* p = reinterpret_cast<const std::byte*>(out.data());
  return {p, p + out.size()};
}

/// A GLB file with two joints. The second moves along x, the first turns about z. Times, positions and rotations are packed.
/// @param stride of the positions, in the description of the packed data  @param lost number of bytes that are cut off the packed positions
std::vector<std::byte> packed_glb(int stride = 12, std::size_t lost = 0, const std::string& filter = "EXPONENTIAL", int count = keys) {
  std::vector<float> times, positions, rotations;
  for (int k = 0; k < keys; ++k) {
    times.push_back(static_cast<float>(k) / 30);
    positions.insert(positions.end(), {1.0F + 0.25F * static_cast<float>(k), 0.5F, 0.0F});
    const float angle = 0.02F * static_cast<float>(k);
    rotations.insert(rotations.end(), {0, 0, std::sin(angle / 2), std::cos(angle / 2)});
  }
  std::vector<unsigned> exponents(3 * keys);
  meshopt_encodeFilterExp(exponents.data(), keys, 12, 23, positions.data());
  std::vector<std::int16_t> quaternions(4 * keys);
  meshopt_encodeFilterQuat(quaternions.data(), keys, 8, 16, rotations.data());
  std::vector<std::byte> data;
  std::string views;
  const auto add = [&](const std::vector<std::byte>& bytes, int elements, int width, const std::string& name) {
    views += std::string(views.empty() ? "" : ",") + R"({"buffer":1,"byteLength":)" + std::to_string(keys * width) +
             R"(,"extensions":{"EXT_meshopt_compression":{"buffer":0,"byteOffset":)" + std::to_string(data.size()) + R"(,"byteLength":)" +
             std::to_string(bytes.size()) + R"(,"byteStride":)" + std::to_string(width) + R"(,"count":)" + std::to_string(elements) +
             R"(,"mode":"ATTRIBUTES","filter":")" + name + R"("}}})";
    data.insert(data.end(), bytes.begin(), bytes.end());
    data.resize((data.size() + 3) / 4 * 4);
  };
  add(packed(times.data(), keys, 4), keys, 4, "NONE");
  std::vector<std::byte> moved = packed(exponents.data(), keys, 12);
  moved.resize(moved.size() - lost);
  add(moved, count, stride, filter);
  add(packed(quaternions.data(), keys, 8), keys, 8, "QUATERNION");
  const std::string n = std::to_string(keys);
  std::string json = R"({"asset":{"version":"2.0"},"nodes":[{"name":"a","children":[1]},{"name":"b","translation":[1,0.5,0]}],)"
                     R"("skins":[{"joints":[0,1]}],"buffers":[{"byteLength":)" +
                     std::to_string(data.size()) +
                     R"(},{"byteLength":2000,"extensions":{"EXT_meshopt_compression":{"fallback":true}}}],"bufferViews":[)" + views +
                     R"(],"accessors":[{"bufferView":0,"componentType":5126,"count":)" + n +
                     R"(,"type":"SCALAR"},{"bufferView":1,"componentType":5126,"count":)" + n +
                     R"(,"type":"VEC3"},{"bufferView":2,"componentType":5122,"normalized":true,"count":)" + n +
                     R"(,"type":"VEC4"}],"animations":[{"channels":[{"sampler":0,"target":{"node":1,"path":"translation"}},)"
                     R"({"sampler":1,"target":{"node":0,"path":"rotation"}}],"samplers":[{"input":0,"output":1},{"input":0,"output":2}]}]})";
  json.resize((json.size() + 3) / 4 * 4, ' ');
  std::vector<std::byte> glb;
  const auto word = [&](std::size_t value) {
    const auto v = static_cast<std::uint32_t>(value);
    std::byte b[4];
    std::memcpy(b, &v, 4);
    glb.insert(glb.end(), b, b + 4);
  };
  word(0x46546C67), word(2), word(28 + json.size() + data.size());
  word(json.size()), word(0x4E4F534A);
  for (const char c : json) glb.push_back(static_cast<std::byte>(c));
  word(data.size()), word(0x004E4942);
  glb.insert(glb.end(), data.begin(), data.end());
  return glb;
}

TEST(Meshopt, PackedAnimationsAreRead) {
  const auto m = formats::read_gltf(packed_glb(), "packed.glb", {.metres_per_unit = 1}, unpack_meshopt);
  ASSERT_TRUE(m.has_value()) << m.error().text();
  ASSERT_EQ((*m)[0].frames, keys);
  std::vector<Pose> X;
  for (int f = 0; f < keys; ++f) {
    (*m)[0].calc_joint_poses(f, X);
    // glTF: y up, so x, y, z of the file are y, z, x here. The first joint turns about the file's z.
    const double angle = 0.02 * f, x = 1 + 0.25 * f;
    const Vec3 p{0, x * std::cos(angle) - 0.5 * std::sin(angle), x * std::sin(angle) + 0.5 * std::cos(angle)};
    EXPECT_LT(norm(X[1].p - X[0].p - p), 2e-3) << "rotations have 16 bits";
  }
}

TEST(Meshopt, DamagedDataAreRefused) {
  for (const auto& glb : {packed_glb(12, 9), packed_glb(12, 0, "QUATERNION"), packed_glb(12, 0, "OTHER"), packed_glb(10), packed_glb(260),
                          packed_glb(12, 0, "NONE", 1'000'000)}) {
    const auto m = formats::read_gltf(glb, "packed.glb", {}, unpack_meshopt);
    ASSERT_FALSE(m.has_value());
    EXPECT_NE(m.error().text().find("bufferViews/1"), std::string::npos) << m.error().text();
  }
}

}  // namespace
}  // namespace ugoki::scene_formats
