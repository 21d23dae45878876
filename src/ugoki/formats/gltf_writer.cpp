#include <array>
#include <utility>

#include "ugoki/formats/file_axes.h"
#include "ugoki/formats/glb_chunk.h"
#include "ugoki/formats/gltf.h"
#include "ugoki/json/json.h"

namespace ugoki::formats {
namespace {

using json::Json;

void put(std::vector<float>& out, const Vec3& v) {
  for (int k = 0; k < 3; ++k) out.push_back(static_cast<float>(v[k]));
}

/// Appends a rotation to `out` as x y z w, converted to file axes.
void put(std::vector<float>& out, const Quat& q, const FileAxes& axes) {
  const Vec3 v = axes.to_file({q.x, q.y, q.z});
  const std::array<float, 4> x = glb_rotation({q.w, v.x, v.y, v.z});
  out.insert(out.end(), x.begin(), x.end());
}

/// Mesh of the bones. Each bone is a flat-shaded double pyramid: a square at a fifth of its length, tips at both ends.
struct Bones {
  std::vector<float> positions, normals, weights;
  std::vector<std::uint16_t> joints;

  /// Adds a bone from a to b [m, file axes] that moves with `joint`. A bone shorter than 1e-6 m is omitted.
  void add(const Vec3& a, const Vec3& b, int joint) {
    const Vec3 d = b - a;
    const double length = norm(d);
    if (!(length > 1e-6)) return;
    const Vec3 z = d / length, x = any_perpendicular(z), y = cross(z, x);
    const double w = 0.12 * length;  // half the width of the square
    const Vec3 m = a + d * 0.2;
    const std::array<Vec3, 4> ring = {m + x * w, m + y * w, m - x * w, m - y * w};
    for (std::size_t k = 0; k < 4; ++k) {
      const Vec3 &p = ring[k], &q = ring[(k + 1) % 4];
      triangle(a, q, p, joint);
      triangle(b, p, q, joint);
    }
  }

 private:
  void triangle(const Vec3& a, const Vec3& b, const Vec3& c, int joint) {
    const Vec3 n = normalized(cross(b - a, c - a));
    for (const Vec3& v : {a, b, c}) {
      put(positions, v);
      put(normals, n);
      joints.insert(joints.end(), {static_cast<std::uint16_t>(joint), 0, 0, 0});
      weights.insert(weights.end(), {1, 0, 0, 0});
    }
  }
};

/// Adds the mesh, its material and the skin to `root`; returns the node with mesh and skin.
Json skin_and_mesh(const MeasuredMotion& m, const FileAxes& axes, GlbChunk& chunk, Json& root) {
  const std::vector<Vec3> rest = rest_positions(m.skeleton);
  const std::size_t n = rest.size();
  Bones bones;
  std::vector<float> binds;
  Json joints = Json::array();
  for (std::size_t j = 0; j < n; ++j) {
    const Vec3 p = axes.to_file(rest[j]);
    for (const double v : {1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, -p.x, -p.y, -p.z, 1.0})
      binds.push_back(static_cast<float>(v));
    joints.push_back(j);
    for (const Vec3& e : m.skeleton.joints[j].end_sites) bones.add(p, p + axes.to_file(e), static_cast<int>(j));
    const int parent = m.skeleton.joints[j].parent;
    if (parent >= 0) bones.add(axes.to_file(rest[static_cast<std::size_t>(parent)]), p, parent);
  }
  if (bones.positions.empty()) bones.add({0, 0, 0}, {0, 0.1, 0}, 0);
  const int positions = chunk.floats(bones.positions, 3, "VEC3", 34962);
  chunk.bound(positions, bones.positions, 3);
  const int normals = chunk.floats(bones.normals, 3, "VEC3", 34962);
  const int weights = chunk.floats(bones.weights, 4, "VEC4", 34962);
  const int owners = chunk.add(bones.joints, 4, "VEC4", 5123, 34962);
  root["meshes"] = Json::array(
      {{{"name", "bones"},
        {"primitives",
         Json::array({{{"attributes", {{"POSITION", positions}, {"NORMAL", normals}, {"JOINTS_0", owners}, {"WEIGHTS_0", weights}}},
                       {"material", 0}}})}}});
  root["materials"] = Json::array(
      {{{"name", "bones"},
        {"pbrMetallicRoughness", {{"baseColorFactor", {0.72, 0.74, 0.78, 1}}, {"metallicFactor", 0}, {"roughnessFactor", 0.7}}}}});
  root["skins"] = Json::array({{{"joints", joints}, {"inverseBindMatrices", chunk.floats(binds, 16, "MAT4")}}});
  return {{"name", m.skeleton.name.empty() ? "character" : m.skeleton.name}, {"mesh", 0}, {"skin", 0}};
}

/// Adds the animation to `root`. Joints that do not translate have no translation channel.
void animate(const MeasuredMotion& m, const FileAxes& axes, GlbChunk& chunk, Json& root) {
  std::vector<float> times;
  for (int f = 0; f < m.frames; ++f) times.push_back(static_cast<float>(f / m.rate));
  const int input = chunk.floats(times, 1, "SCALAR");
  chunk.bound(input, times, 1);
  Json channels = Json::array(), samplers = Json::array();
  const auto add = [&](std::size_t joint, const char* path, int output) {
    samplers.push_back({{"input", input}, {"interpolation", "LINEAR"}, {"output", output}});
    channels.push_back({{"sampler", samplers.size() - 1}, {"target", {{"node", joint}, {"path", path}}}});
  };
  const std::size_t n = m.skeleton.joints.size();
  for (std::size_t j = 0; j < n; ++j) {
    std::vector<float> positions, rotations;
    bool still = true;
    for (std::size_t f = 0; f < static_cast<std::size_t>(m.frames); ++f) {
      const std::size_t at = f * n + j;
      put(positions, axes.to_file(m.translations[at]));
      Quat q = m.rotations[at];
      if (f > 0) {
        const Quat& before = m.rotations[at - n];  // q and -q are the same rotation: choose the sign closer to `before`
        if (q.w * before.w + dot(q.vec(), before.vec()) < 0) q = {-q.w, -q.x, -q.y, -q.z};
      }
      put(rotations, q, axes);
      still = still && norm(m.translations[at] - m.skeleton.joints[j].offset) < 1e-9;
    }
    if (!still) add(j, "translation", chunk.floats(positions, 3, "VEC3"));
    add(j, "rotation", chunk.floats(rotations, 4, "VEC4"));
  }
  root["animations"] = Json::array({{{"name", m.name.empty() ? "motion" : m.name}, {"channels", channels}, {"samplers", samplers}}});
}

}  // namespace

std::vector<std::byte> write_glb(const MeasuredMotion& m) {
  const FileAxes axes;
  GlbChunk chunk;
  Json root{{"asset", {{"version", "2.0"}, {"generator", "Ugoki"}}}, {"scene", 0}};
  Json nodes = Json::array(), joint_roots = Json::array();
  for (std::size_t j = 0; j < m.skeleton.joints.size(); ++j) {
    const SkeletonJoint& joint = m.skeleton.joints[j];
    const Vec3 p = axes.to_file(joint.offset);
    Json node{{"name", joint.name}, {"translation", {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)}}};
    nodes.push_back(std::move(node));
    if (joint.parent < 0) {
      joint_roots.push_back(j);
      continue;
    }
    nodes[static_cast<std::size_t>(joint.parent)]["children"].push_back(j);
  }
  if (m.frames > 0) animate(m, axes, chunk, root);
  if (joint_roots.size() > 1) {  // glTF requires a common root for the joints of a skin
    nodes.push_back({{"name", "roots"}, {"children", joint_roots}});
    joint_roots = Json::array({nodes.size() - 1});
  }
  Json roots = std::move(joint_roots);
  nodes.push_back(skin_and_mesh(m, axes, chunk, root));
  roots.push_back(nodes.size() - 1);
  root["scenes"] = Json::array({{{"nodes", roots}}});
  root["nodes"] = std::move(nodes);
  return chunk.finish(std::move(root));
}

}  // namespace ugoki::formats
