#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "ugoki/base/number.h"
#include "ugoki/formats/file_axes.h"
#include "ugoki/formats/gltf_document.h"
#include "ugoki/formats/gltf_meshes.h"
#include "ugoki/formats/gltf_skin.h"
#include "ugoki/formats/gltf_unpack.h"
#include "ugoki/formats/text.h"
#include "ugoki/spatial/elementary.h"

namespace ugoki::formats {
namespace {

/// Computes the value of a channel at time t [s]. Before the first key it is the first key's value, after the last key the last key's
/// value.
/// @param out [3 or 4]; a rotation as x y z w
void sample_channel(const GltfChannel& c, double t, double* out) {
  const std::size_t n = c.path == GltfPath::rotation ? 4 : 3;
  const bool cubic = c.interpolation == GltfInterpolation::cubic;
  const auto value = [&](std::size_t key, std::size_t part) { return c.values.data() + (cubic ? 3 * key + part : key) * n; };
  const auto copy = [&](std::size_t key) { std::copy_n(value(key, 1), n, out); };
  const auto after = static_cast<std::size_t>(std::upper_bound(c.times.begin(), c.times.end(), t) - c.times.begin());
  if (after == 0) return copy(0);
  if (after == c.times.size()) return copy(after - 1);
  const std::size_t a = after - 1;
  const double h = c.times[after] - c.times[a], s = h > 0 ? (t - c.times[a]) / h : 0;
  if (c.interpolation == GltfInterpolation::step) return copy(a);
  if (cubic) {
    const double s2 = s * s, s3 = s2 * s;
    const double *p0 = value(a, 1), *m0 = value(a, 2), *p1 = value(after, 1), *m1 = value(after, 0);
    for (std::size_t k = 0; k < n; ++k)
      out[k] = (2 * s3 - 3 * s2 + 1) * p0[k] + h * (s3 - 2 * s2 + s) * m0[k] + (3 * s2 - 2 * s3) * p1[k] + h * (s3 - s2) * m1[k];
    return;
  }
  const double *p0 = value(a, 0), *p1 = value(after, 0);
  if (n == 3) {
    for (std::size_t k = 0; k < 3; ++k) out[k] = p0[k] + s * (p1[k] - p0[k]);
    return;
  }
  const Quat q = slerp(normalized(Quat{p0[3], p0[0], p0[1], p0[2]}), normalized(Quat{p1[3], p1[0], p1[1], p1[2]}), s);
  out[0] = q.x, out[1] = q.y, out[2] = q.z, out[3] = q.w;
}

/// Returns the rotation in the linear part A, by Gram-Schmidt orthogonalisation of its columns x and y; drops scale, shear and mirroring.
Mat3 rotation_of(const Mat3& A) {
  const Vec3 x = normalized(A.column(0), {1, 0, 0});
  const Vec3 y = normalized(A.column(1) - x * dot(x, A.column(1)), any_perpendicular(x));
  return Mat3::columns(x, y, cross(x, y));
}

class Reader {
 public:
  Reader(GltfDocument document, std::string_view name, const GltfOptions& options, ReadNotes& notes)
      : doc_(std::move(document)), name_(name), options_(options), notes_(notes) {}

  Result<std::vector<MeasuredMotion>> read() {
    order_nodes();
    choose_joints();
    calc_globals(nullptr, 0);
    rest_ = globals_;
    apply_bind_poses();
    std::vector<MeasuredMotion> out;
    std::size_t numbers = 0;
    for (const GltfAnimation& a : doc_.animations) {
      if (std::none_of(a.channels.begin(), a.channels.end(), [&](const GltfChannel& c) { return moves_joint(c.node); })) continue;
      MeasuredMotion m = start(a.name);
      double first = 0, last = 0;
      const double densest = key_range(a, first, last);
      m.rate = options_.rate > 0 ? options_.rate : densest;
      m.frames = std::max(1, static_cast<int>(std::floor((last - first) * m.rate + 1e-3)) + 1);
      numbers += static_cast<std::size_t>(m.frames) * joints_.size();
      if (numbers > max_numbers / 8)
        return fail(ErrorCode::range, std::string(name_) + ":animations", "The animations have more than 50 million joint positions.",
                    "Choose a lower frame rate, or split the file.");
      fill(a, first, m);
      out.push_back(std::move(m));
    }
    if (out.empty()) {
      MeasuredMotion m = start("");
      m.frames = 1;
      m.rate = 30;
      fill({}, 0, m);
      out.push_back(std::move(m));
      notes_.remarks.push_back("The file does not animate any joint; the result is one frame at rest.");
    }
    finish_units(out);
    name_motions(out);
    const auto in_range = [](const Vec3& v) { return is_finite(v) && norm(v) <= max_magnitude; };
    for (const MeasuredMotion& m : out)
      if (!std::all_of(m.translations.begin(), m.translations.end(), in_range) ||
          !std::all_of(m.skeleton.joints.begin(), m.skeleton.joints.end(), [&](const SkeletonJoint& k) { return in_range(k.offset); }))
        return fail(ErrorCode::range, std::string(name_) + ":nodes", "A joint is farther than 1e9 m from the origin.",
                    "Correct the scales of the nodes.");
    return out;
  }

  /// The skin of the joints that read() gives. @param notes receives remarks about it
  Result<FileSkin> skin(GltfMeshes meshes, ReadNotes& notes) {
    order_nodes();
    choose_joints();
    calc_globals(nullptr, 0);
    rest_ = globals_;
    apply_bind_poses();
    std::vector<MeasuredMotion> first(1, start(""));
    first[0].frames = 1;
    const auto moving = std::ranges::find_if(doc_.animations, [&](const GltfAnimation& a) {
      return std::ranges::any_of(a.channels, [&](const GltfChannel& c) { return moves_joint(c.node); });
    });
    double begin = 0, end = 0;
    if (moving != doc_.animations.end()) (void)key_range(*moving, begin, end);
    fill(moving != doc_.animations.end() ? *moving : GltfAnimation{}, begin, first[0]);
    finish_units(first);
    first[0].calc_joint_poses(0, joint_poses_);
    names_.clear();
    for (const SkeletonJoint& j : first[0].skeleton.joints) names_.push_back(j.name);
    FileSkin out;
    out.skin.textures = std::move(meshes.textures);
    std::size_t scenery = 0;
    for (const GltfSurface& surface : meshes.surfaces)
      if (!add_surface(surface, first[0].skeleton.unit, out)) ++scenery;
    if (scenery > 0) notes.remarks.push_back("Meshes that follow no joint of the character are left out.");
    if (out.bones.size() > max_skin_bones || out.skin.parts.size() > max_skin_parts)
      return fail(
          ErrorCode::range, std::string(name_) + ":skins",
          "The character has more than " + std::to_string(max_skin_bones) + " bones or " + std::to_string(max_skin_parts) + " parts.",
          "Join its meshes in a modelling program.");
    remove_unused(out);
    return out;
  }

 private:
  /// Adds a surface, with its own bones. @param metres m per file unit @return false: it follows no joint
  bool add_surface(const GltfSurface& from, double metres, FileSkin& out) {
    const std::size_t base = out.skin.vertex_count(), first_index = out.skin.indices.size();
    const int s = doc_.nodes[from.node].skin;
    const bool skinned = s >= 0 && from.sets > 0;
    const auto [known, is_new] = first_bones_.try_emplace(skinned ? -1 - s : static_cast<int>(from.node), out.bones.size());
    const std::size_t first_bone = known->second;
    if (skinned && is_new) {
      const GltfSkin& skin = doc_.skins[static_cast<std::size_t>(s)];
      for (std::size_t j = 0; j < skin.joints.size(); ++j) {
        const auto node = static_cast<std::size_t>(skin.joints[j]);
        const Affine bind = skin.inverse_binds.empty() ? Affine{} : skin.inverse_binds[j];
        out.bones.push_back(bone_of(static_cast<std::size_t>(joint_of_node_[node]), globals_[node] * bind, metres));
      }
    } else if (!skinned) {
      int node = static_cast<int>(from.node);
      while (node >= 0 && joint_of_node_[static_cast<std::size_t>(node)] < 0) node = doc_.nodes[static_cast<std::size_t>(node)].parent;
      if (node < 0) return false;
      if (is_new)
        out.bones.push_back(bone_of(static_cast<std::size_t>(joint_of_node_[static_cast<std::size_t>(node)]), globals_[from.node], metres));
    }
    Skin& skin = out.skin;
    skin.positions.insert(skin.positions.end(), from.positions.begin(), from.positions.end());
    skin.uvs.insert(skin.uvs.end(), from.uvs.begin(), from.uvs.end());
    add_colors(skin, base, from.colors);
    std::vector<std::pair<std::uint16_t, double>> shares;
    for (std::size_t v = 0; v < from.positions.size() / 3; ++v) {
      shares.clear();
      for (std::size_t k = 0; skinned && k < from.sets; ++k) {
        const std::size_t joint = from.joints[from.sets * v + k], bone = first_bone + joint;
        if (joint < doc_.skins[static_cast<std::size_t>(s)].joints.size())
          shares.emplace_back(static_cast<std::uint16_t>(bone), from.weights[from.sets * v + k]);
      }
      if (shares.empty()) shares.emplace_back(static_cast<std::uint16_t>(first_bone), 1);
      add_weights(skin, shares);
    }
    for (const std::uint32_t c : from.corners) skin.indices.push_back(static_cast<std::uint32_t>(base) + c);
    if (from.normals.empty())
      add_normals(skin, base, first_index);
    else
      skin.normals.insert(skin.normals.end(), from.normals.begin(), from.normals.end());
    skin.parts.push_back(from.part);
    skin.parts.back().first = static_cast<std::uint32_t>(first_index);
    skin.parts.back().count = static_cast<std::uint32_t>(from.corners.size());
    return true;
  }

  /// Bone that places vertices in `joint` as `X` places them in the file's world, in the pose of joint_poses_.
  [[nodiscard]] FileBone bone_of(std::size_t joint, const Affine& X, double metres) const {
    const FileAxes axes;
    const Pose inverse = joint_poses_[joint].inverse();
    FileBone bone;
    bone.joint = names_[joint];
    const auto ours = [&](const Vec3& v) { return inverse.R * (axes.from_file(v) * metres); };
    bone.A = Mat3::columns(ours(X.A.column(0)), ours(X.A.column(1)), ours(X.A.column(2)));
    bone.p = ours(X.p) + inverse.p;
    return bone;
  }

  /// Fills order_: parents before their children, otherwise in file order.
  void order_nodes() {
    std::vector<char> done(doc_.nodes.size());
    std::vector<std::size_t> ancestors;
    for (std::size_t i = 0; i < doc_.nodes.size(); ++i) {
      for (int n = static_cast<int>(i); n >= 0 && done[static_cast<std::size_t>(n)] == 0;
           n = doc_.nodes[static_cast<std::size_t>(n)].parent)
        ancestors.push_back(static_cast<std::size_t>(n));
      for (; !ancestors.empty(); ancestors.pop_back()) {
        done[ancestors.back()] = 1;
        order_.push_back(ancestors.back());
      }
    }
  }

  /// Fills joints_ with the nodes that become joints of the skeleton.
  void choose_joints() {
    std::vector<char> joint(doc_.nodes.size());  // 1: joint of a skin, 2: needed ancestor
    for (const GltfSkin& skin : doc_.skins)
      for (const int j : skin.joints) joint[static_cast<std::size_t>(j)] = 1;
    if (doc_.skins.empty()) joint.assign(joint.size(), 1);
    std::vector<char> moved(doc_.nodes.size()), turned(doc_.nodes.size());
    for (const GltfAnimation& a : doc_.animations)
      for (const GltfChannel& c : a.channels) {
        moved[static_cast<std::size_t>(c.node)] = 1;
        if (c.path == GltfPath::rotation && doc_.nodes[static_cast<std::size_t>(c.node)].skin < 0)
          turned[static_cast<std::size_t>(c.node)] = 1;
      }
    // If the animations turn more nodes outside the skins than in them, the file contains the mesh of a part only (often the head), and
    // all turning nodes belong to the skeleton.
    std::ptrdiff_t inside = 0, outside = 0;
    for (std::size_t i = 0; i < joint.size(); ++i) (joint[i] == 1 ? inside : outside) += turned[i];
    for (std::size_t i = 0; i < joint.size() && outside > inside; ++i)
      if (turned[i] != 0) joint[i] = 1;
    // An ancestor of a joint becomes a joint if it is animated, or if it is a descendant of a joint or of an animated node.
    for (std::size_t i = 0; i < joint.size(); ++i) {
      if (joint[i] != 1) continue;
      bool needed = false;
      std::vector<int> ancestors;
      for (int n = doc_.nodes[i].parent; n >= 0; n = doc_.nodes[static_cast<std::size_t>(n)].parent) ancestors.push_back(n);
      for (auto it = ancestors.rbegin(); it != ancestors.rend(); ++it) {
        const auto n = static_cast<std::size_t>(*it);
        needed = needed || joint[n] == 1 || moved[n] != 0;
        if (needed && joint[n] == 0) joint[n] = 2;
      }
    }
    joint_of_node_.assign(doc_.nodes.size(), -1);
    for (const std::size_t n : order_) {
      if (joint[n] == 0 || doc_.nodes[n].mesh_of_parent) continue;
      joint_of_node_[n] = static_cast<int>(joints_.size());
      joints_.push_back(n);
    }
  }

  /// True if `node` is a joint or an ancestor of one.
  [[nodiscard]] bool moves_joint(int node) const {
    for (const std::size_t j : joints_)
      for (int n = static_cast<int>(j); n >= 0; n = doc_.nodes[static_cast<std::size_t>(n)].parent)
        if (n == node) return true;
    return false;
  }

  /// Returns the closest ancestor that is a joint; -1: none.
  [[nodiscard]] int parent_joint(std::size_t joint) const {
    for (int n = doc_.nodes[joints_[joint]].parent; n >= 0; n = doc_.nodes[static_cast<std::size_t>(n)].parent)
      if (joint_of_node_[static_cast<std::size_t>(n)] >= 0) return joint_of_node_[static_cast<std::size_t>(n)];
    return -1;
  }

  /// Computes globals_, the world transforms of all nodes, at time t [s] of the animation. If `animation` is null: the pose in the file.
  void calc_globals(const GltfAnimation* animation, double t) {
    std::vector<GltfNode>& posed = posed_;
    posed = doc_.nodes;
    if (animation != nullptr) {
      for (const GltfChannel& c : animation->channels) {
        GltfNode& n = posed[static_cast<std::size_t>(c.node)];
        double v[4] = {0, 0, 0, 0};
        sample_channel(c, t, v);
        n.matrix.reset();
        if (c.path == GltfPath::translation) n.translation = {v[0], v[1], v[2]};
        if (c.path == GltfPath::scale) n.scale = {v[0], v[1], v[2]};
        if (c.path == GltfPath::rotation) n.rotation = normalized(Quat{v[3], v[0], v[1], v[2]});
      }
    }
    globals_.resize(posed.size());
    for (const std::size_t i : order_) {
      const Affine local = local_of(posed[i]);
      globals_[i] = posed[i].parent < 0 ? local : globals_[static_cast<std::size_t>(posed[i].parent)] * local;
    }
  }

  /// Sets the rest pose of the skins' joints to their bind pose: a transform of the skin times the inverse of the joint's matrix in
  /// GltfSkin::inverse_binds. The transform is that of the node with the skinned mesh. Some exporters write the matrices in the space of
  /// the scene; then the bones have their lengths without this transform. If neither gives the lengths of the bones, the bind pose is
  /// scaled.
  void apply_bind_poses() {
    for (std::size_t s = 0; s < doc_.skins.size(); ++s) {
      const GltfSkin& skin = doc_.skins[s];
      const auto mesh =
          std::find_if(doc_.nodes.begin(), doc_.nodes.end(), [&](const GltfNode& n) { return n.skin == static_cast<int>(s); });
      if (mesh == doc_.nodes.end() || skin.inverse_binds.empty()) continue;
      const Affine mesh_transform = globals_[static_cast<std::size_t>(mesh - doc_.nodes.begin())];
      Affine transform = mesh_transform;
      const double with = bind_scale(skin, mesh_transform), without = bind_scale(skin, {});
      constexpr double same = 0.2;  // bones of bind pose and scene differ by a few percent where the animation stretches them
      if (std::fabs(with) > same)
        transform = std::fabs(without) <= same ? Affine{} : Affine{mesh_transform.A * ugoki::exp(-with), mesh_transform.p};
      for (std::size_t j = 0; j < skin.joints.size(); ++j)
        if (const std::optional<Affine> bind = bind_pose(skin, j, transform)) rest_[static_cast<std::size_t>(skin.joints[j])] = *bind;
    }
  }

  /// Bind pose of joint j of a skin; std::nullopt if its matrix is not invertible.
  static std::optional<Affine> bind_pose(const GltfSkin& skin, std::size_t j, const Affine& transform) {
    const Affine& inv = skin.inverse_binds[j];
    const double determinant = dot(inv.A.column(0), cross(inv.A.column(1), inv.A.column(2)));
    if (!(std::fabs(determinant) > 1e-12)) return std::nullopt;
    const Mat3 A = inverse(inv.A);
    const Affine bind = transform * Affine{A, -(A * inv.p)};
    if (!is_finite(bind.p)) return std::nullopt;
    return bind;
  }

  /// Median logarithm of the ratio of a bone's length in the bind pose to its length in the scene. 0 if the skin has no bones.
  [[nodiscard]] double bind_scale(const GltfSkin& skin, const Affine& transform) const {
    std::vector<int> slot(doc_.nodes.size(), -1);
    for (std::size_t j = 0; j < skin.joints.size(); ++j) slot[static_cast<std::size_t>(skin.joints[j])] = static_cast<int>(j);
    std::vector<double> ratios;
    for (std::size_t j = 0; j < skin.joints.size(); ++j) {
      const auto node = static_cast<std::size_t>(skin.joints[j]);
      const int parent = doc_.nodes[node].parent;
      if (parent < 0 || slot[static_cast<std::size_t>(parent)] < 0) continue;
      const auto up = static_cast<std::size_t>(parent);
      const auto a = bind_pose(skin, j, transform), b = bind_pose(skin, static_cast<std::size_t>(slot[up]), transform);
      if (!a || !b) continue;
      const double in_bind = norm(a->p - b->p), in_scene = norm(globals_[node].p - globals_[up].p);
      if (in_bind > 0 && in_scene > 0 && std::isfinite(in_bind) && std::isfinite(in_scene))
        ratios.push_back(ugoki::log(in_bind / in_scene));
    }
    if (ratios.empty()) return 0;
    const auto middle = ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2);
    std::nth_element(ratios.begin(), middle, ratios.end());
    return *middle;
  }

  /// Returns the frames per second that match the most closely spaced keys. @param first, last [out] s, time range of all keys
  double key_range(const GltfAnimation& a, double& first, double& last) const {
    double gap = 0;
    bool any = false;
    for (const GltfChannel& c : a.channels) {
      first = any ? std::min(first, c.times.front()) : c.times.front();
      last = any ? std::max(last, c.times.back()) : c.times.back();
      any = true;
      for (std::size_t k = 1; k < c.times.size(); ++k) {
        const double d = c.times[k] - c.times[k - 1];
        if (d > 1e-3 && (gap == 0 || d < gap)) gap = d;
      }
    }
    if (gap == 0) return 30;
    const double rate = std::round(1 / gap);
    // Times have single precision (1/24 s is 0.0416667), so a rate within 0.2 % of an integer is rounded to this integer. A rate below 10
    // is multiplied by an integer to reach at least 30, so that the curve between sparse keys is kept. The rate is at most 1000.
    const double near = std::fabs(rate * gap - 1) < 2e-3 ? rate : 1 / gap;
    return near < 10 ? near * std::ceil(30 / near - 1e-9) : std::min(near, 1000.0);
  }

  /// Returns the skeleton at rest as a motion without frames. @param animation name of the motion
  MeasuredMotion start(const std::string& animation) const {
    MeasuredMotion m;
    m.name = animation;
    m.source = std::string(name_);
    m.skeleton.name = stem_of(name_);
    const FileAxes axes;
    for (std::size_t j = 0; j < joints_.size(); ++j) {
      SkeletonJoint joint;
      const std::string& name = doc_.nodes[joints_[j]].name;
      joint.name = name.empty() ? "node_" + std::to_string(joints_[j]) : utf8(name);
      joint.parent = parent_joint(j);
      const Vec3 p = rest_[joints_[j]].p;
      joint.offset = axes.from_file(joint.parent < 0 ? p : p - rest_[joints_[static_cast<std::size_t>(joint.parent)]].p);
      joint.dofs = {{{0, 0, 1}}, {{0, 1, 0}}, {{1, 0, 0}}};
      joint.translates = joint.parent < 0;
      m.skeleton.joints.push_back(std::move(joint));
    }
    if (options_.mesh_ends) add_mesh_ends(m.skeleton, axes);
    // A repeated name is made unique by an appended number.
    std::vector<std::string> names;
    for (SkeletonJoint& j : m.skeleton.joints) {
      std::string unique = j.name;
      for (int k = 2; std::find(names.begin(), names.end(), unique) != names.end(); ++k) unique = j.name + "_" + std::to_string(k);
      j.name = unique;
      names.push_back(unique);
    }
    return m;
  }

  /// Gives joints without children the ends of their meshes as end sites.
  void add_mesh_ends(Skeleton& skeleton, const FileAxes& axes) const {
    std::vector<char> carries(joints_.size(), 0);
    for (const SkeletonJoint& j : skeleton.joints)
      if (j.parent >= 0) carries[static_cast<std::size_t>(j.parent)] = 1;
    const auto add = [&](std::size_t node, const std::optional<Vec3>& mesh_end) {
      const int j = joint_of_node_[node];
      if (j < 0 || carries[static_cast<std::size_t>(j)] != 0 || !mesh_end) return;
      const Vec3 end = axes.from_file(rest_[node].A * *mesh_end);
      if (!is_finite(end) || norm(end) > max_magnitude || !skeleton.joints[static_cast<std::size_t>(j)].end_sites.empty()) return;
      skeleton.joints[static_cast<std::size_t>(j)].end_sites.push_back(end);
    };
    for (const GltfSkin& skin : doc_.skins)
      for (std::size_t k = 0; k < skin.mesh_ends.size(); ++k) add(static_cast<std::size_t>(skin.joints[k]), skin.mesh_ends[k]);
    for (std::size_t node = 0; node < doc_.nodes.size(); ++node) add(node, doc_.nodes[node].mesh_end);
  }

  /// Computes all frames. The rotation of a joint from rest is computed in world axes, then made relative to the parent's rotation. The
  /// position of a joint is relative to the parent, in the parent's axes. @param first s, time of the first frame
  void fill(const GltfAnimation& a, double first, MeasuredMotion& m) {
    const FileAxes axes;
    const std::size_t n = joints_.size();
    std::vector<Mat3> rest(n), turn(n);
    std::vector<Vec3> position(n);
    for (std::size_t j = 0; j < n; ++j) rest[j] = rotation_of(rest_[joints_[j]].A).transposed();
    const auto ours = [&](const Mat3& R) {  // P R P^T, where P converts file axes to Ugoki's axes
      const auto turned = [&](const Vec3& e) { return axes.from_file(R * axes.to_file(e)); };
      return Mat3::columns(turned({1, 0, 0}), turned({0, 1, 0}), turned({0, 0, 1}));
    };
    for (int f = 0; f < m.frames; ++f) {
      calc_globals(&a, first + f / m.rate);
      for (std::size_t j = 0; j < n; ++j) {
        turn[j] = ours(rotation_of(globals_[joints_[j]].A) * rest[j]);
        position[j] = axes.from_file(globals_[joints_[j]].p);
        const int p = m.skeleton.joints[j].parent;
        if (p < 0) {
          m.rotations.push_back(to_quat(turn[j]));
          m.translations.push_back(position[j]);
          continue;
        }
        const auto parent = static_cast<std::size_t>(p);
        m.rotations.push_back(to_quat(turn[parent].transposed() * turn[j]));
        const Vec3 local = transpose_times(turn[parent], position[j] - position[parent]);
        if (norm(local - m.skeleton.joints[j].offset) > 1e-5 * (1 + norm(local))) m.skeleton.joints[j].translates = true;
        m.translations.push_back(local);
      }
    }
    // A joint counts as not translating if its translation differs from its offset by at most 1e-5 (relative): such differences are
    // rounding errors of the file's single-precision numbers.
    for (std::size_t i = 0; i < m.translations.size(); ++i)
      if (const SkeletonJoint& joint = m.skeleton.joints[i % n]; !joint.translates) m.translations[i] = joint.offset;
  }

  void finish_units(std::vector<MeasuredMotion>& motions) {
    double metres = options_.metres_per_unit;
    if (!(metres > 0) || !std::isfinite(metres)) {
      metres = 1;
      const double extent = rest_extent(motions[0].skeleton);
      if (extent > 20 || (extent > 0 && extent < 0.01)) {
        const UnitGuess guess = guess_unit(extent);
        metres = guess.metres;
        notes_.unit_guessed = true;
        notes_.remarks.push_back("The glTF unit of length is the metre, but the skeleton would be " + to_fixed(extent, 2) +
                                 " m large; lengths are assumed to be in " + guess.name + ".");
      }
    }
    notes_.metres_per_unit = metres;
    for (MeasuredMotion& m : motions) {
      m.skeleton.unit = metres;
      for (SkeletonJoint& j : m.skeleton.joints) {
        j.offset *= metres;
        for (Vec3& e : j.end_sites) e *= metres;
      }
      for (Vec3& t : m.translations) t *= metres;
    }
  }

  void name_motions(std::vector<MeasuredMotion>& motions) const {
    const std::string stem = stem_of(name_);
    for (std::size_t i = 0; i < motions.size(); ++i) {
      std::string& name = motions[i].name;
      if (name.empty()) name = motions.size() == 1 ? stem : stem + " " + std::to_string(i + 1);
      name = utf8(name);
    }
  }

  GltfDocument doc_;
  std::string_view name_;
  const GltfOptions& options_;
  ReadNotes& notes_;
  std::vector<std::size_t> order_;          // indices of all nodes, parents first
  std::vector<std::size_t> joints_;         // indices of the nodes that become joints, parents first
  std::vector<int> joint_of_node_;          // [nodes] index in joints_, or -1
  std::vector<Pose> joint_poses_;           // [joints] of the frame for which the skin's bones are computed
  std::map<int, std::size_t> first_bones_;  // of a skin (-1 - index), of a node with a mesh that is fixed to a joint (index)
  std::vector<std::string> names_;          // [joints] of the measured motion
  std::vector<GltfNode> posed_;             // nodes with the animation applied
  std::vector<Affine> globals_, rest_;      // [nodes] world transforms (current pose, rest pose), file axes and units
};

}  // namespace

Result<std::vector<MeasuredMotion>> read_gltf(std::span<const std::byte> bytes, std::string_view file_name, const GltfOptions& options,
                                              const GltfUnpack& unpack, ReadNotes* notes) {
  ReadNotes own;
  ReadNotes& collected = notes != nullptr ? *notes : own;
  auto document = read_gltf_document(bytes, file_name, options.files, unpack, collected);
  if (!document) return fail(std::move(document.error()));
  return Reader(std::move(*document), file_name, options, collected).read();
}

Result<std::vector<MeasuredMotion>> read_gltf(std::span<const std::byte> bytes, std::string_view file_name, const GltfOptions& options,
                                              ReadNotes* notes) {
  return read_gltf(bytes, file_name, options, {}, notes);
}

Result<FileSkin> read_gltf_skin(std::span<const std::byte> bytes, std::string_view file_name, const GltfOptions& options,
                                const GltfUnpack& unpack, ReadNotes& notes) {
  ReadNotes ignored;  // of read_gltf()
  auto document = read_gltf_document(bytes, file_name, options.files, unpack, ignored);
  if (!document) return fail(std::move(document.error()));
  auto meshes = read_gltf_meshes(bytes, file_name, options.files, unpack, notes);
  if (!meshes) return fail(std::move(meshes.error()));
  Result<FileSkin> skin = Reader(std::move(*document), file_name, options, ignored).skin(std::move(*meshes), notes);
  if (!skin || skin->bones.empty()) return skin;
  // A damaged file can have values that a body would refuse with its whole character.
  Error problems;
  check_skin(skin->skin, skin->bones.size(), file_name, problems);
  if (!problems.empty()) return fail(std::move(problems));
  const auto is_usable = [](const FileBone& b) {
    return is_finite(b.p) && is_finite(b.A.column(0)) && is_finite(b.A.column(1)) && is_finite(b.A.column(2));
  };
  if (!std::ranges::all_of(skin->bones, is_usable))
    return fail(ErrorCode::range, std::string(file_name), "The bones of the skin have places that are not finite.",
                "Export the file again with its bind pose.");
  return skin;
}

}  // namespace ugoki::formats
