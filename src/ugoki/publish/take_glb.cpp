#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "ugoki/base/check.h"
#include "ugoki/formats/glb_chunk.h"
#include "ugoki/json/json.h"
#include "ugoki/publish/shape_surface.h"
#include "ugoki/publish/take.h"
#include "ugoki/spatial/rotation.h"

namespace ugoki::publish {
namespace {

using json::Json;

/// Converts a vector from our axes (Z up, X forward) to those of glTF (Y up, Z forward): a cyclic permutation.
Vec3 to_file(const Vec3& v) { return {v.y, v.z, v.x}; }
Quat to_file(const Quat& q) {
  const Vec3 v = to_file(q.vec());
  return {q.w, v.x, v.y, v.z};
}

void put(std::vector<float>& out, const Vec3& v) {
  for (int k = 0; k < 3; ++k) out.push_back(static_cast<float>(v[k]));
}
void put(std::vector<float>& out, const Quat& q) {
  const std::array<float, 4> x = formats::glb_rotation(q);
  out.insert(out.end(), x.begin(), x.end());
}
Json to_json(const Vec3& v) { return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)}; }
Json to_json(const Quat& q) {
  std::vector<float> x;
  put(x, q);
  return {x[0], x[1], x[2], x[3]};
}

Pose pose_of(const content::DisplayPose& x) { return {to_matrix(x.r), x.p}; }

/// Linear value, 0 ... 1, of two hexadecimal digits of an sRGB colour.
double linear(const std::string& color, std::size_t at) {
  const auto digit = [](char c) { return c >= 'a' ? c - 'a' + 10 : c >= 'A' ? c - 'A' + 10 : c - '0'; };
  if (color.size() < at + 2) return 0.8;
  const double s = (16 * digit(color[at]) + digit(color[at + 1])) / 255.0;
  return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
}

class Writer {
 public:
  explicit Writer(const Take& take) : take_(take) {}

  std::vector<std::byte> write() {
    root_ = {{"asset", {{"version", "2.0"}, {"generator", "Ugoki"}}}, {"scene", 0}};
    std::vector<float> times;
    for (int f = 0; f < take_.frames; ++f) times.push_back(static_cast<float>(f / take_.rate));
    times_ = chunk_.floats(times, 1, "SCALAR");
    chunk_.bound(times_, times, 1);
    for (const TakeCharacter& c : take_.characters)
      if (c.links() > 0) add_character(c);
    add_camera();
    root_["scenes"] = Json::array({{{"name", take_.name}, {"nodes", roots_}}});
    root_["nodes"] = nodes_;
    for (const auto& [key, list] :
         {std::pair{"meshes", &meshes_}, {"materials", &materials_}, {"skins", &skins_}, {"textures", &textures_}, {"images", &images_}})
      if (!list->empty()) root_[key] = *list;
    if (!channels_.empty()) root_["animations"] = Json::array({{{"name", take_.name}, {"channels", channels_}, {"samplers", samplers_}}});
    return chunk_.finish(std::move(root_));
  }

 private:
  void animate(std::size_t node, const char* path, int output) {
    samplers_.push_back({{"input", times_}, {"interpolation", "LINEAR"}, {"output", output}});
    channels_.push_back({{"sampler", samplers_.size() - 1}, {"target", {{"node", node}, {"path", path}}}});
  }

  /// Adds a node for each link below an armature node, and the animation keys of each node.
  void add_character(const TakeCharacter& c) {
    const std::size_t armature = nodes_.size(), first = armature + 1;
    nodes_.push_back({{"name", c.name.empty() ? c.id : c.name}, {"children", Json::array()}});
    roots_.push_back(armature);
    for (std::size_t l = 0; l < c.links(); ++l) {
      const Link& link = c.mechanism->link(static_cast<int>(l));
      Json node{{"name", link.name}};
      std::vector<float> positions, rotations;
      Vec3 p0;
      Quat before, q0;
      bool still = true, straight = true;
      for (int f = 0; f < take_.frames; ++f) {
        Pose X = pose_of(c.pose(f, l));
        if (link.parent >= 0) X = pose_of(c.pose(f, static_cast<std::size_t>(link.parent))).inverse() * X;
        const Vec3 p = to_file(X.p);
        Quat q = to_file(to_quat(X.R));
        if (f > 0 && q.w * before.w + dot(q.vec(), before.vec()) < 0) q = {-q.w, -q.x, -q.y, -q.z};  // q and -q are the same rotation
        if (f == 0) {
          p0 = p;
          q0 = q;
        }
        still = still && norm(p - p0) < 1e-7;
        straight = straight && norm(q.vec() - q0.vec()) < 1e-8;
        before = q;
        put(positions, p);
        put(rotations, q);
      }
      node["translation"] = to_json(p0);
      node["rotation"] = to_json(q0);
      nodes_.push_back(std::move(node));
      Json& parent = nodes_[link.parent >= 0 ? first + static_cast<std::size_t>(link.parent) : armature];
      parent["children"].push_back(first + l);
      if (!still) animate(first + l, "translation", chunk_.floats(positions, 3, "VEC3"));
      if (!straight) animate(first + l, "rotation", chunk_.floats(rotations, 4, "VEC4"));
    }
    const bool skinned = c.mechanism->skin() && c.shown != "body";
    if (skinned) add_skin(c, first);
    if (!skinned || c.shown == "both") add_mesh(c, first);
  }

  /// Adds the skin of the mechanism. Its vertices keep their coordinates; the maps of the bones are the inverse bind matrices.
  void add_skin(const TakeCharacter& c, std::size_t first) {
    const Skin& skin = *c.mechanism->skin();
    std::vector<float> binds, normals, weights;
    Json joints = Json::array();
    std::vector<char> taken(c.links(), 0);
    for (const SkinBone& bone : c.mechanism->skin_bones()) {
      const auto link = static_cast<std::size_t>(c.mechanism->find_link(bone.link));
      std::size_t node = first + link;
      if (taken[link]++ != 0) {  // a glTF skin lists a node once; further bones of a link get nodes of their own
        nodes_.push_back({{"name", bone.link + " skin " + std::to_string(taken[link])}});
        nodes_[node]["children"].push_back(nodes_.size() - 1);
        node = nodes_.size() - 1;
      }
      joints.push_back(node);
      for (int axis = 0; axis < 3; ++axis) {
        put(binds, to_file(bone.A.column(axis)));
        binds.push_back(0);
      }
      put(binds, to_file(bone.p));
      binds.push_back(1);
    }
    for (std::size_t v = 0; v < skin.vertex_count(); ++v) {
      const float* n = skin.normals.data() + 3 * v;
      put(normals, unit_in_single(normalized(Vec3{n[0], n[1], n[2]}, {0, 0, 1})));
      for (std::size_t k = 4 * v; k < 4 * v + 4; ++k) weights.push_back(static_cast<float>(skin.weights[k]) / 65535);
    }
    const int position = chunk_.floats(skin.positions, 3, "VEC3", 34962);
    chunk_.bound(position, skin.positions, 3);
    Json attributes = {{"POSITION", position},
                       {"NORMAL", chunk_.floats(normals, 3, "VEC3", 34962)},
                       {"TEXCOORD_0", chunk_.floats(skin.uvs, 2, "VEC2", 34962)},
                       {"JOINTS_0", chunk_.add(skin.bones, 4, "VEC4", 5123, 34962)},
                       {"WEIGHTS_0", chunk_.floats(weights, 4, "VEC4", 34962)}};
    if (!skin.colors.empty()) attributes["COLOR_0"] = chunk_.floats(linear_colors(skin), 3, "VEC3", 34962);
    const std::size_t first_texture = textures_.size();
    for (const SkinTexture& t : skin.textures) {
      textures_.push_back({{"source", images_.size()}});
      images_.push_back({{"bufferView", chunk_.picture(t.data)}, {"mimeType", t.type}});
    }
    const std::string name = c.name.empty() ? c.id : c.name;
    Json primitives = Json::array();
    for (const SkinPart& part : skin.parts) {
      const std::vector<std::uint32_t> corners(skin.indices.begin() + part.first, skin.indices.begin() + part.first + part.count);
      primitives.push_back(
          {{"attributes", attributes}, {"indices", chunk_.add(corners, 1, "SCALAR", 5125, 34963)}, {"material", materials_.size()}});
      Json surface = {{"baseColorFactor", {linear(part.color, 1), linear(part.color, 3), linear(part.color, 5), 1}},
                      {"metallicFactor", 0},
                      {"roughnessFactor", 0.75}};
      if (part.texture >= 0) surface["baseColorTexture"] = {{"index", first_texture + static_cast<std::size_t>(part.texture)}};
      Json material = {{"name", name + " skin"}, {"pbrMetallicRoughness", std::move(surface)}};
      if (part.cutoff > 0) material["alphaMode"] = "MASK", material["alphaCutoff"] = part.cutoff;
      if (part.both_sides) material["doubleSided"] = true;
      materials_.push_back(std::move(material));
    }
    add_node(name + " skin", std::move(primitives), joints, binds);
  }

  static std::vector<float> linear_colors(const Skin& skin) {
    std::vector<float> out;
    for (const std::uint16_t x : skin.colors) out.push_back(static_cast<float>(x) / 65535);
    return out;
  }

  /// Adds a mesh with its skin and the node that shows it.
  void add_node(const std::string& name, Json primitives, const Json& joints, const std::vector<float>& binds) {
    meshes_.push_back({{"name", name}, {"primitives", std::move(primitives)}});
    skins_.push_back({{"name", name}, {"joints", joints}, {"inverseBindMatrices", chunk_.floats(binds, 16, "MAT4")}});
    roots_.push_back(nodes_.size());
    nodes_.push_back({{"name", name}, {"mesh", meshes_.size() - 1}, {"skin", skins_.size() - 1}});
  }

  /// Adds mesh, materials and skin. Each vertex moves with one link; the mesh is bound in the pose of the first frame.
  void add_mesh(const TakeCharacter& c, std::size_t first) {
    std::vector<float> positions, normals, weights, binds;
    std::vector<std::uint16_t> owners;
    std::map<std::string, std::vector<std::uint32_t>> indices;  // by colour
    std::size_t shape = 0;
    Json joints = Json::array();
    for (std::size_t l = 0; l < c.links(); ++l) {
      joints.push_back(first + l);
      const Pose X = pose_of(c.pose(0, l)), inverse = X.inverse();
      // Columns of the inverse in the axes of the file. The axes x, y, z of the file are our axes y, z, x.
      for (const int axis : {1, 2, 0}) {
        const Vec3 column = to_file(inverse.R.column(axis));
        put(binds, column);
        binds.push_back(0);
      }
      put(binds, to_file(inverse.p));
      binds.push_back(1);
      for (const Shape& part : c.mechanism->link(static_cast<int>(l)).shapes) {
        if (!part.visible) continue;
        const std::string own = shape < c.shape_colors.size() ? c.shape_colors[shape] : std::string();
        ++shape;
        Surface surface;
        add_surface(part, surface);
        const auto base = static_cast<std::uint32_t>(positions.size() / 3);
        for (std::size_t i = 0; i < surface.points.size(); ++i) {
          put(positions, to_file(X.R * surface.points[i] + X.p));
          put(normals, unit_in_single(to_file(X.R * surface.normals[i])));
          owners.insert(owners.end(), {static_cast<std::uint16_t>(l), 0, 0, 0});
          weights.insert(weights.end(), {1, 0, 0, 0});
        }
        std::vector<std::uint32_t>& of_color = indices[own.empty() ? c.color : own];
        for (const auto& t : surface.triangles)
          for (const std::uint32_t i : t) of_color.push_back(base + i);
      }
    }
    std::erase_if(indices, [](const auto& entry) { return entry.second.empty(); });
    if (indices.empty()) return;
    const int position = chunk_.floats(positions, 3, "VEC3", 34962);
    chunk_.bound(position, positions, 3);
    const Json attributes = {{"POSITION", position},
                             {"NORMAL", chunk_.floats(normals, 3, "VEC3", 34962)},
                             {"JOINTS_0", chunk_.add(owners, 4, "VEC4", 5123, 34962)},
                             {"WEIGHTS_0", chunk_.floats(weights, 4, "VEC4", 34962)}};
    const std::string name = c.name.empty() ? c.id : c.name;
    Json primitives = Json::array();
    for (const auto& [color, list] : indices) {
      primitives.push_back(
          {{"attributes", attributes}, {"indices", chunk_.add(list, 1, "SCALAR", 5125, 34963)}, {"material", materials_.size()}});
      materials_.push_back({{"name", indices.size() == 1 ? name : name + " " + color},
                            {"pbrMetallicRoughness",
                             {{"baseColorFactor", {linear(color, 1), linear(color, 3), linear(color, 5), 1}},
                              {"metallicFactor", 0},
                              {"roughnessFactor", 0.58}}}});
    }
    meshes_.push_back({{"name", name}, {"primitives", std::move(primitives)}});
    skins_.push_back({{"name", name}, {"joints", joints}, {"inverseBindMatrices", chunk_.floats(binds, 16, "MAT4")}});
    roots_.push_back(nodes_.size());
    nodes_.push_back({{"name", name + " surface"}, {"mesh", meshes_.size() - 1}, {"skin", skins_.size() - 1}});
  }

  static Vec3 unit_in_single(const Vec3& v) {
    const Vec3 s = {static_cast<double>(static_cast<float>(v.x)), static_cast<double>(static_cast<float>(v.y)),
                    static_cast<double>(static_cast<float>(v.z))};
    return normalized(s);
  }

  void add_camera() {
    const std::size_t node = nodes_.size();
    std::vector<float> positions;
    bool still = true;
    TakeView first;
    for (int f = 0; f < take_.frames; ++f) {
      const TakeView view = view_at(take_, f);
      if (f == 0) first = view;
      still = still && norm(view.position - first.position) < 1e-7;
      put(positions, to_file(view.position));
    }
    // A glTF camera looks along -z with y up. Its axes x, y, z point right, up and back.
    const Vec3 x = to_file(first.right), y = to_file(first.up), z = to_file(first.back);
    const Mat3 R = {x.x, y.x, z.x, x.y, y.y, z.y, x.z, y.z, z.z};
    nodes_.push_back(
        {{"name", "camera"}, {"camera", 0}, {"translation", to_json(to_file(first.position))}, {"rotation", to_json(to_quat(R))}});
    roots_.push_back(node);
    root_["cameras"] = Json::array(
        {{{"name", "camera"}, {"type", "perspective"}, {"perspective", {{"yfov", take_field_of_view}, {"znear", 0.05}, {"zfar", 1000}}}}});
    if (!still) animate(node, "translation", chunk_.floats(positions, 3, "VEC3"));
  }

  const Take& take_;
  formats::GlbChunk chunk_;
  Json root_, nodes_ = Json::array(), roots_ = Json::array(), meshes_ = Json::array(), materials_ = Json::array(), skins_ = Json::array();
  Json textures_ = Json::array(), images_ = Json::array();
  Json channels_ = Json::array(), samplers_ = Json::array();
  int times_ = -1;
};

}  // namespace

std::vector<std::byte> write_take_glb(const Take& take) {
  UGOKI_CHECK(take.frames > 0);
  return Writer(take).write();
}

}  // namespace ugoki::publish
