#include "ugoki/formats/gltf_document.h"

#include <algorithm>
#include <cmath>

#include "ugoki/formats/gltf_data.h"
#include "ugoki/formats/mesh_end.h"
#include "ugoki/formats/text.h"

namespace ugoki::formats {
namespace {

using json::Json;

class Parser : private GltfData {
 public:
  using GltfData::GltfData;

  Result<GltfDocument> parse(std::span<const std::byte> bytes) {
    if (!split(bytes) || !check_asset() || !read_buffers() || !read_nodes() || !read_skins() || !read_animations())
      return fail(std::move(error_));
    read_mesh_ends();
    find_meshes_of_parents();
    read_rigid_mesh_ends();
    return std::move(out_);
  }

 private:
  bool read_nodes() {
    const Json& nodes = list("nodes");
    if (nodes.empty()) return refuse(ErrorCode::structure, "nodes", "The file has no nodes.");
    if (nodes.size() > max_joints)
      return refuse(ErrorCode::range, "nodes", "The file has more than " + std::to_string(max_joints) + " nodes.",
                    "Export only the skeleton and its meshes.");
    out_.nodes.resize(nodes.size());
    for (std::size_t i = 0; i < nodes.size(); ++i)
      if (!read_node(nodes[i], i)) return false;
    // Find cycles: the chain of parents of every node must end within max_depth steps.
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      std::size_t steps = 0;
      for (int n = static_cast<int>(i); n >= 0; n = out_.nodes[static_cast<std::size_t>(n)].parent)
        if (++steps > max_depth)
          return refuse(ErrorCode::structure, path("nodes", i), "The node is its own ancestor, or nested more than 1000 deep.");
    }
    return true;
  }

  bool read_node(const Json& json, std::size_t i) {
    GltfNode& node = out_.nodes[i];
    node.name = text(json, "name");
    std::array<double, 3> t{0, 0, 0}, s{1, 1, 1};
    std::array<double, 4> r{0, 0, 0, 1};
    std::array<double, 16> m{};
    if (!numbers(json, "translation", t) || !numbers(json, "scale", s) || !numbers(json, "rotation", r) || !numbers(json, "matrix", m))
      return refuse(ErrorCode::range, path("nodes", i),
                    "The transform has a wrong number of values, or a value that is not a number up to 1e9.");
    node.translation = {t[0], t[1], t[2]};
    node.scale = {s[0], s[1], s[2]};
    node.rotation = normalized(Quat{r[3], r[0], r[1], r[2]});
    if (member(json, "matrix") != nullptr)  // stored by columns
      node.matrix = Affine{Mat3::columns({m[0], m[1], m[2]}, {m[4], m[5], m[6]}, {m[8], m[9], m[10]}), {m[12], m[13], m[14]}};
    const auto skin = index(json, "skin", list("skins").size());
    if (!skin) return refuse(ErrorCode::structure, path("nodes", i) + "/skin", "The index of the skin is invalid.");
    node.skin = static_cast<int>(*skin);
    const Json* children = member(json, "children");
    if (children == nullptr) return true;
    if (!children->is_array()) return refuse(ErrorCode::structure, path("nodes", i) + "/children", "The value is not a list.");
    for (const Json& c : *children) {
      if (!c.is_number_unsigned() || c.get<std::uint64_t>() >= out_.nodes.size())
        return refuse(ErrorCode::structure, path("nodes", i) + "/children", "The index of a child is invalid.");
      GltfNode& child = out_.nodes[c.get<std::size_t>()];
      if (child.parent >= 0) return refuse(ErrorCode::structure, path("nodes", i) + "/children", "A node has two parents.");
      child.parent = static_cast<int>(i);
    }
    return true;
  }

  bool read_skins() {
    const Json& skins = list("skins");
    for (std::size_t i = 0; i < skins.size(); ++i) {
      GltfSkin skin;
      const Json* joints = member(skins[i], "joints");
      if (joints == nullptr || !joints->is_array() || joints->empty())
        return refuse(ErrorCode::structure, path("skins", i), "The skin has no joints.");
      for (const Json& j : *joints) {
        if (!j.is_number_unsigned() || j.get<std::uint64_t>() >= out_.nodes.size())
          return refuse(ErrorCode::structure, path("skins", i) + "/joints", "The index of a joint is invalid.");
        skin.joints.push_back(j.get<int>());
      }
      const auto binds = index(skins[i], "inverseBindMatrices", list("accessors").size());
      if (!binds) return refuse(ErrorCode::structure, path("skins", i) + "/inverseBindMatrices", "The index of the accessor is invalid.");
      if (*binds >= 0) {
        std::vector<double> m;
        if (!accessor(*binds, 16, path("skins", i) + "/inverseBindMatrices", m)) return false;
        if (m.size() < 16 * skin.joints.size())
          return refuse(ErrorCode::structure, path("skins", i) + "/inverseBindMatrices", "There are fewer matrices than joints.");
        for (std::size_t j = 0; j < skin.joints.size(); ++j) {
          const double* v = m.data() + 16 * j;
          skin.inverse_binds.push_back({Mat3::columns({v[0], v[1], v[2]}, {v[4], v[5], v[6]}, {v[8], v[9], v[10]}), {v[12], v[13], v[14]}});
        }
      }
      out_.skins.push_back(std::move(skin));
    }
    return true;
  }

  /// World transform of a node in the pose of the file.
  [[nodiscard]] Affine world_of(std::size_t node) const {
    Affine X = local_of(out_.nodes[node]);
    for (int n = out_.nodes[node].parent; n >= 0; n = out_.nodes[static_cast<std::size_t>(n)].parent)
      X = local_of(out_.nodes[static_cast<std::size_t>(n)]) * X;
    return X;
  }

  /// Sets GltfNode::mesh_of_parent. (Editors of blocky characters export one node for each group of boxes, and below it one for each box.
  /// Vertices of most boxes are relative to the origin of the scene.)
  void find_meshes_of_parents() {
    constexpr std::size_t fewest = 3;            // such nodes: two can be at one place by chance
    constexpr double same = 1e-4, apart = 1e-2;  // shares of the extent of all nodes
    if (!out_.skins.empty()) return;
    std::vector<char> is_leaf(out_.nodes.size(), 1);
    for (const GltfNode& n : out_.nodes)
      if (n.parent >= 0) is_leaf[static_cast<std::size_t>(n.parent)] = 0;
    for (const GltfAnimation& a : out_.animations)
      for (const GltfChannel& c : a.channels) is_leaf[static_cast<std::size_t>(c.node)] = 0;
    std::vector<std::size_t> leaves;
    std::vector<Vec3> places;
    const auto parent_of = [&](std::size_t i) { return static_cast<std::size_t>(out_.nodes[i].parent); };
    double extent = 0;
    for (std::size_t i = 0; i < out_.nodes.size(); ++i) {
      places.push_back(world_of(i).p);
      extent = std::max(extent, norm(places[i] - places[0]));
      if (is_leaf[i] != 0 && out_.nodes[i].parent >= 0 && member(list("nodes")[i], "mesh") != nullptr) leaves.push_back(i);
    }
    bool found = false;
    for (const std::size_t first : leaves) {
      std::vector<std::size_t> together;
      for (const std::size_t i : leaves)
        if (norm(places[i] - places[first]) <= same * extent && norm(places[parent_of(i)] - places[first]) > apart * extent)
          together.push_back(i);
      const bool of_one = std::ranges::all_of(together, [&](std::size_t i) { return parent_of(i) == parent_of(together[0]); });
      found = found || (together.size() >= fewest && !of_one);
    }
    if (!found) return;
    for (const std::size_t i : leaves) out_.nodes[i].mesh_of_parent = member(list("nodes")[parent_of(i)], "mesh") == nullptr;
  }

  static constexpr std::size_t max_numbers_of_meshes = 12'000'000;  // numbers of all meshes that are read for their ends

  /// Sets GltfNode::mesh_end: nodes can carry rigid meshes instead of a skin. A mesh that cannot be read is left out.
  void read_rigid_mesh_ends() {
    std::size_t numbers = 0;
    const Json &nodes = list("nodes"), &meshes = list("meshes"), &accessors = list("accessors");
    std::vector<std::vector<Vec3>> points(nodes.size());
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const auto mesh = index(nodes[i], "mesh", meshes.size());
      if (out_.nodes[i].skin >= 0 || !mesh || *mesh < 0) continue;
      const Json* primitives = member(meshes[static_cast<std::size_t>(*mesh)], "primitives");
      if (primitives == nullptr || !primitives->is_array()) continue;
      const GltfNode& node = out_.nodes[i];
      std::vector<Vec3>& own = points[node.mesh_of_parent ? static_cast<std::size_t>(node.parent) : i];
      const Affine X = node.mesh_of_parent ? local_of(node) : Affine{};
      for (const Json& p : *primitives) {
        const Json* attributes = member(p, "attributes");
        if (attributes == nullptr || member(p, "extensions") != nullptr) continue;
        const auto position = index(*attributes, "POSITION", accessors.size());
        if (!position || *position < 0) continue;
        const auto count = index(accessors[static_cast<std::size_t>(*position)], "count", max_numbers_of_meshes);
        if (!count || *count < 1 || (numbers += 3 * static_cast<std::size_t>(*count)) > max_numbers_of_meshes) continue;
        std::vector<double> x;
        const bool read = accessor(*position, 3, "meshes", x);
        error_ = {};
        for (std::size_t v = 0; read && 3 * v + 2 < x.size(); ++v) own.push_back(X.A * Vec3{x[3 * v], x[3 * v + 1], x[3 * v + 2]} + X.p);
      }
    }
    for (std::size_t i = 0; i < nodes.size(); ++i) out_.nodes[i].mesh_end = far_end(points[i]);
  }

  /// Sets GltfSkin::mesh_ends. A mesh that cannot be read is left out.
  void read_mesh_ends() {
    std::size_t numbers = 0;
    const Json &nodes = list("nodes"), &meshes = list("meshes"), &accessors = list("accessors");
    std::vector<std::vector<std::vector<Vec3>>> points(out_.skins.size());  // [skins][joints]
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const auto mesh = index(nodes[i], "mesh", meshes.size());
      if (out_.nodes[i].skin < 0 || !mesh || *mesh < 0) continue;
      const auto s = static_cast<std::size_t>(out_.nodes[i].skin);
      const GltfSkin& skin = out_.skins[s];
      const Json* primitives = member(meshes[static_cast<std::size_t>(*mesh)], "primitives");
      if (skin.inverse_binds.empty() || primitives == nullptr || !primitives->is_array()) continue;
      points[s].resize(skin.joints.size());
      for (const Json& p : *primitives) {
        const Json* attributes = member(p, "attributes");
        if (attributes == nullptr || member(p, "extensions") != nullptr) continue;
        const auto position = index(*attributes, "POSITION", accessors.size()), joints = index(*attributes, "JOINTS_0", accessors.size()),
                   weights = index(*attributes, "WEIGHTS_0", accessors.size());
        if (!position || *position < 0 || !joints || *joints < 0 || !weights || *weights < 0) continue;
        const auto count = index(accessors[static_cast<std::size_t>(*position)], "count", max_numbers_of_meshes);
        if (!count || *count < 1 || (numbers += 11 * static_cast<std::size_t>(*count)) > max_numbers_of_meshes) continue;
        std::vector<double> x, j, w;
        const bool read = accessor(*position, 3, "meshes", x) && accessor(*joints, 4, "meshes", j) && accessor(*weights, 4, "meshes", w);
        error_ = {};
        if (!read || j.size() != w.size() || 4 * x.size() != 3 * j.size()) continue;
        for (std::size_t v = 0; 3 * v < x.size(); ++v) {
          const auto heaviest = static_cast<std::size_t>(std::max_element(&w[4 * v], &w[4 * v] + 4) - &w[4 * v]);
          const double joint = j[4 * v + heaviest];
          if (!(joint >= 0) || joint >= static_cast<double>(skin.joints.size())) continue;
          const auto k = static_cast<std::size_t>(joint);
          const Affine& bind = skin.inverse_binds[k];
          points[s][k].push_back(bind.A * Vec3{x[3 * v], x[3 * v + 1], x[3 * v + 2]} + bind.p);
        }
      }
    }
    for (std::size_t s = 0; s < points.size(); ++s) {
      out_.skins[s].mesh_ends.resize(points[s].size());
      for (std::size_t k = 0; k < points[s].size(); ++k) out_.skins[s].mesh_ends[k] = far_end(points[s][k]);
    }
  }

  bool read_animations() {
    const Json& animations = list("animations");
    if (animations.size() > 1000)
      return refuse(ErrorCode::range, "animations", "The file has more than 1000 animations.", "Split it into several files.");
    for (std::size_t i = 0; i < animations.size(); ++i) {
      GltfAnimation animation;
      animation.name = text(animations[i], "name");
      const Json *channels = member(animations[i], "channels"), *samplers = member(animations[i], "samplers");
      if (channels == nullptr || !channels->is_array() || samplers == nullptr || !samplers->is_array())
        return refuse(ErrorCode::structure, path("animations", i), "The animation has no channels or no samplers.");
      for (std::size_t c = 0; c < channels->size(); ++c)
        if (!read_channel((*channels)[c], *samplers, path("animations", i) + "/channels/" + std::to_string(c), animation)) return false;
      out_.animations.push_back(std::move(animation));
    }
    return true;
  }

  bool read_channel(const Json& json, const Json& samplers, const std::string& location, GltfAnimation& animation) {
    const Json* target = member(json, "target");
    const auto which = index(json, "sampler", samplers.size());
    if (target == nullptr || !which || *which < 0)
      return refuse(ErrorCode::structure, location, "The channel has no target or no valid sampler.");
    const auto node = index(*target, "node", out_.nodes.size());
    if (!node) return refuse(ErrorCode::structure, location + "/target/node", "The index of the node is invalid.");
    GltfChannel channel;
    const std::string path = text(*target, "path");
    if (*node < 0 || (path != "translation" && path != "rotation" && path != "scale"))
      return true;  // morph weights and paths of extensions are not read
    channel.node = static_cast<int>(*node);
    channel.path = path == "rotation" ? GltfPath::rotation : path == "scale" ? GltfPath::scale : GltfPath::translation;
    const Json& sampler = samplers[static_cast<std::size_t>(*which)];
    const auto input = index(sampler, "input", list("accessors").size()), output = index(sampler, "output", list("accessors").size());
    if (!input || *input < 0 || !output || *output < 0)
      return refuse(ErrorCode::structure, location + "/sampler", "The sampler has no valid input or output.");
    const std::string interpolation = text(sampler, "interpolation");
    channel.interpolation = interpolation == "STEP"          ? GltfInterpolation::step
                            : interpolation == "CUBICSPLINE" ? GltfInterpolation::cubic
                                                             : GltfInterpolation::linear;
    const std::size_t components = channel.path == GltfPath::rotation ? 4 : 3;
    if (!accessor(*input, 1, location, channel.times) || !accessor(*output, components, location, channel.values)) return false;
    const std::size_t rows = channel.times.size() * (channel.interpolation == GltfInterpolation::cubic ? 3 : 1);
    if (channel.values.size() < rows * components) return refuse(ErrorCode::structure, location, "There are fewer values than times.");
    for (std::size_t k = 0; k < channel.times.size(); ++k)
      if (!(channel.times[k] >= 0 && channel.times[k] < 1e6) || (k > 0 && channel.times[k] < channel.times[k - 1]))
        return refuse(ErrorCode::range, location, "The times of the keys are negative, decreasing, or 1e6 s or more.");
    for (const double v : channel.values)
      if (!(std::fabs(v) <= max_magnitude))
        return refuse(ErrorCode::range, location, "A value is not finite or its magnitude is above 1e9.");
    animation.channels.push_back(std::move(channel));
    return true;
  }

  GltfDocument out_;
};

}  // namespace

Affine local_of(const GltfNode& n) {
  if (n.matrix) return *n.matrix;
  return {to_matrix(n.rotation) * Mat3::diagonal(n.scale.x, n.scale.y, n.scale.z), n.translation};
}

Result<GltfDocument> read_gltf_document(std::span<const std::byte> bytes, std::string_view file_name, const GltfFiles& files,
                                        const GltfUnpack& unpack, ReadNotes& notes) {
  return Parser(file_name, files, unpack, notes).parse(bytes);
}

}  // namespace ugoki::formats
