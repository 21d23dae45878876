// Blocky persons: each limb is one node that carries a rigid mesh, without a skin and without ends of bones.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "ugoki/body/body.h"
#include "ugoki/formats/glb_chunk.h"
#include "ugoki/formats/gltf.h"
#include "ugoki/intake/arrange.h"
#include "ugoki/intake/intake.h"

namespace ugoki::intake {
namespace {

using json::Json;

struct Block {
  const char* name;
  int parent;
  Vec3 offset;     // m, y up, from the parent
  Vec3 low, high;  // m, corners of the box in the node's frame
};

const std::vector<Block> person = {{"root", -1, {0, 1.0, 0}, {}, {}},
                                   {"leg-left", 0, {0.15, 0, 0}, {-0.1, -1.0, -0.1}, {0.1, 0, 0.1}},
                                   {"leg-right", 0, {-0.15, 0, 0}, {-0.1, -1.0, -0.1}, {0.1, 0, 0.1}},
                                   {"torso", 0, {0, 0.1, 0}, {-0.25, 0, -0.1}, {0.25, 0.9, 0.1}},
                                   {"arm-left", 3, {0.35, 0.8, 0}, {-0.05, -0.75, -0.1}, {0.1, 0.05, 0.1}},
                                   {"arm-right", 3, {-0.35, 0.8, 0}, {-0.1, -0.75, -0.1}, {0.05, 0.05, 0.1}},
                                   {"head", 3, {0, 0.9, 0}, {-0.2, 0, -0.2}, {0.2, 0.4, 0.2}}};

/// A GLB file in which the blocks swing about x.
/// @param in_scene true: each box is the mesh of a node below its block, with vertices relative to the origin of the scene, at which these
///   nodes are; the last block has a node with an origin of its own
std::vector<std::byte> file_of_blocks(const std::vector<Block>& blocks = person, bool in_scene = false) {
  constexpr int frames = 31;
  formats::GlbChunk chunk;
  std::vector<float> times;
  for (int f = 0; f < frames; ++f) times.push_back(static_cast<float>(f / 30.0));
  const int time = chunk.floats(times, 1, "SCALAR");
  Json boxes = Json::array(), nodes = Json::array(), meshes = Json::array(), roots = Json::array(), channels = Json::array(),
       samplers = Json::array();
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const Block& b = blocks[i];
    Json node{{"name", b.name}, {"translation", {b.offset.x, b.offset.y, b.offset.z}}};
    Json children = Json::array();
    for (std::size_t k = 0; k < blocks.size(); ++k)
      if (blocks[k].parent == static_cast<int>(i)) children.push_back(k);
    Vec3 place;  // of the block in the scene, or of the last one relative to a point beside it
    for (int k = static_cast<int>(i); in_scene && k >= 0; k = blocks[static_cast<std::size_t>(k)].parent)
      place += blocks[static_cast<std::size_t>(k)].offset;
    if (in_scene && i + 1 == blocks.size()) place = {0.5, 0.25, 0.1};
    if (norm(b.high) > 0 && in_scene) children.push_back(blocks.size() + boxes.size());
    if (!children.empty()) node["children"] = children;
    if (norm(b.high) > 0) {
      std::vector<float> corners;
      for (const double x : {b.low.x, b.high.x})
        for (const double y : {b.low.y, b.high.y})
          for (const double z : {b.low.z, b.high.z})
            for (const double v : {x + place.x, y + place.y, z + place.z}) corners.push_back(static_cast<float>(v));
      if (in_scene)
        boxes.push_back({{"name", b.name}, {"translation", {-place.x, -place.y, -place.z}}, {"mesh", meshes.size()}});
      else
        node["mesh"] = meshes.size();
      meshes.push_back({{"primitives", {{{"attributes", {{"POSITION", chunk.floats(corners, 3, "VEC3")}}}}}}});
    }
    nodes.push_back(node);
    if (b.parent < 0) roots.push_back(i);
    std::vector<float> turns;
    for (int f = 0; f < frames; ++f) {
      const double angle = b.name == std::string("root") ? 0 : 0.3 * std::sin(0.4 * f + 1.3 * static_cast<double>(i));
      for (const double x : {std::sin(angle / 2), 0.0, 0.0, std::cos(angle / 2)}) turns.push_back(static_cast<float>(x));
    }
    channels.push_back({{"sampler", samplers.size()}, {"target", {{"node", i}, {"path", "rotation"}}}});
    samplers.push_back({{"input", time}, {"output", chunk.floats(turns, 4, "VEC4")}});
  }
  for (const Json& box : boxes) nodes.push_back(box);
  Json root = {{"asset", {{"version", "2.0"}}},
               {"scene", 0},
               {"scenes", {{{"nodes", roots}}}},
               {"nodes", nodes},
               {"meshes", meshes},
               {"animations", {{{"name", "walk"}, {"channels", channels}, {"samplers", samplers}}}}};
  return chunk.finish(std::move(root));
}

TEST(RigidMeshes, TheirFarEndsAreTheEndsOfGltfNodes) {
  const std::vector<std::byte> file = file_of_blocks();
  const auto m = formats::read_gltf(file, "person.glb", {.mesh_ends = true});
  ASSERT_TRUE(m) << m.error().text();
  for (const SkeletonJoint& j : m->front().skeleton.joints) {
    if (j.name != "leg-left" && j.name != "head") continue;
    ASSERT_EQ(j.end_sites.size(), 1u) << j.name;
    // The four corners of a leg's lower end, and of the top of the head, are farthest; z is up.
    EXPECT_LT(norm(j.end_sites[0] - Vec3{0, 0, j.name == "head" ? 0.4 : -1.0}), 1e-6) << j.name;
  }
}

TEST(RigidMeshes, MeshesOfParentsInTheFrameOfTheSceneAreNoJoints) {
  const std::vector<std::byte> whole = file_of_blocks(), divided = file_of_blocks(person, true);
  const auto a = formats::read_gltf(whole, "person.glb", {.mesh_ends = true}),
             b = formats::read_gltf(divided, "person.glb", {.mesh_ends = true});
  ASSERT_TRUE(a && b);
  const std::vector<SkeletonJoint>&expected = a->front().skeleton.joints, &joints = b->front().skeleton.joints;
  ASSERT_EQ(joints.size(), expected.size());
  for (std::size_t i = 0; i < joints.size(); ++i) {
    EXPECT_EQ(joints[i].name, expected[i].name);
    ASSERT_EQ(joints[i].end_sites.size(), expected[i].end_sites.size()) << joints[i].name;
    for (std::size_t k = 0; k < joints[i].end_sites.size(); ++k) EXPECT_LT(norm(joints[i].end_sites[k] - expected[i].end_sites[k]), 1e-6);
  }
  const Result<Intake> made = take_in({reinterpret_cast<const char*>(divided.data()), divided.size()}, "person.glb");
  ASSERT_TRUE(made) << made.error().text();
  EXPECT_TRUE(made->body->human);
}

TEST(RigidMeshes, ABlockyPersonOfOneNodeForEachLimbIsHuman) {
  const std::vector<std::byte> file = file_of_blocks();
  const Result<Intake> made = take_in({reinterpret_cast<const char*>(file.data()), file.size()}, "person.glb");
  ASSERT_TRUE(made) << made.error().text();
  EXPECT_TRUE(made->body->human);
  EXPECT_GT(made->body->height, 1.6);
  EXPECT_LT(made->body->height, 2.3);
}

TEST(RigidMeshes, PartsThatMoveAsWholesAreNoBody) {
  // A box and its lid are two trees. With a knob that turns on the lid, there is a joint.
  std::vector<Block> parts = {{"box", -1, {0, 0, 0}, {-0.5, 0, -0.5}, {0.5, 0.5, 0.5}},
                              {"lid", -1, {0, 0.5, 0}, {-0.5, 0, -0.5}, {0.5, 0.1, 0.5}}};
  for (const bool knob : {false, true}) {
    if (knob) parts.push_back({"knob", 1, {0, 0.1, 0}, {-0.05, 0, -0.05}, {0.05, 0.05, 0.05}});
    const std::vector<std::byte> file = file_of_blocks(parts);
    const Result<Intake> made = take_in({reinterpret_cast<const char*>(file.data()), file.size()}, "box.glb");
    ASSERT_TRUE(made) << made.error().text();
    EXPECT_EQ(made->mesh.has_value(), !knob);
    EXPECT_EQ(made->motion.has_value(), knob);
    EXPECT_EQ(std::ranges::any_of(made->report, [](const std::string& r) { return r.find("rigid parts") != std::string::npos; }), !knob);
    IntakeOptions keep;
    keep.motion_of_parts = true;
    const Result<Intake> moving = take_in({reinterpret_cast<const char*>(file.data()), file.size()}, "box.glb", nullptr, keep);
    ASSERT_TRUE(moving) << moving.error().text();
    EXPECT_TRUE(moving->motion && !moving->mesh);
  }
}

/// The person of blocks as a motion whose trunk is inclined by `pitch` rad.
MeasuredMotion posed(int frames, double pitch) {
  const std::vector<std::byte> file = file_of_blocks();
  MeasuredMotion m = formats::read_gltf(file, "person.glb", {.mesh_ends = true}).value().front();
  MeasuredMotion out = m;
  out.frames = frames;
  out.translations.clear();
  out.rotations.clear();
  const std::size_t n = m.skeleton.joints.size();
  for (int f = 0; f < frames; ++f)
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t from = static_cast<std::size_t>(f % m.frames) * n + i;
      out.translations.push_back(m.translations[from]);
      out.rotations.push_back(i == 0 ? axis_angle({0, 1, 0}, pitch) : m.rotations[from]);
    }
  return out;
}

TEST(RigidMeshes, APersonWhoLiesInTheLongestMotionIsHumanByTheOthers) {
  const auto plan_of = [](std::vector<MeasuredMotion> motions) {
    std::vector<std::string> report;
    return arrange(motions, report, nullptr, true).plan;
  };
  EXPECT_EQ(plan_of({posed(60, 1.6)}), body::BodyPlan::four_legs);
  EXPECT_EQ(plan_of({posed(60, 1.6), posed(20, 0), posed(25, 0), posed(20, 0)}), body::BodyPlan::human);
}

}  // namespace
}  // namespace ugoki::intake
