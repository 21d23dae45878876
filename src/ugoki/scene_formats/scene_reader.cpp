// Converts assimp's scene of a file to measured motions.

#include <assimp/config.h>
#include <assimp/scene.h>

#include <algorithm>
#include <array>
#include <assimp/Importer.hpp>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <string>

#include "ugoki/base/number.h"
#include "ugoki/formats/text.h"
#include "ugoki/scene_formats/collada_core.h"
#include "ugoki/scene_formats/fbx_core.h"
#include "ugoki/scene_formats/scene_file.h"
#include "ugoki/scene_formats/scene_joints.h"
#include "ugoki/scene_formats/scene_metadata.h"

namespace ugoki::scene_formats {
namespace {

Vec3 vec_of(const aiVector3D& v) { return {static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z)}; }
Quat quat_of(const aiQuaternion& q) {
  return normalized(Quat{static_cast<double>(q.w), static_cast<double>(q.x), static_cast<double>(q.y), static_cast<double>(q.z)});
}
Affine affine_of(const aiMatrix4x4& m) {
  const auto d = [](ai_real x) { return static_cast<double>(x); };
  return {{d(m.a1), d(m.a2), d(m.a3), d(m.b1), d(m.b2), d(m.b3), d(m.c1), d(m.c2), d(m.c3)}, {d(m.a4), d(m.b4), d(m.c4)}};
}

/// A node of assimp's scene.
struct Node {
  const aiNode* node;
  int parent;                                         ///< index in nodes_; -1: the root
  int joint = -1;                                     ///< index of the skeleton joint; -1: none
  bool bone = false, animated = false, keep = false;  ///< keep: the node becomes a joint
  Affine rest;                                        ///< world transform in the rest pose, in the file's axes and units
};

/// Chooses the joints and samples the animations of a scene.
class SceneReader {
 public:
  /// @param collada_up up axis of a COLLADA file: 0 x, 1 y, 2 z
  /// @param mesh_ends by the name of the node: far end of the bone's mesh in the node's frame, file units
  SceneReader(const aiScene& scene, std::string_view file_name, const SceneOptions& options, formats::ReadNotes& notes, int collada_up,
              const std::map<std::string, Vec3>& mesh_ends)
      : scene_(scene), file_name_(file_name), options_(options), notes_(notes), collada_up_(collada_up), mesh_ends_(mesh_ends) {}

  Result<std::vector<MeasuredMotion>> read() {
    if (!collect_nodes()) return fail(std::move(error_));
    choose_joints();
    if (joints_.empty())
      return fail(ErrorCode::structure, std::string(file_name_),
                  "The file has no skeleton: neither a skin with bones nor an animated node.", "Export the skeleton with its motion.");
    find_axes();
    make_skeleton();
    std::vector<MeasuredMotion> out;
    for (unsigned i = 0; i < scene_.mNumAnimations; ++i) {
      MeasuredMotion motion;
      if (!sample(*scene_.mAnimations[i], i, motion)) {
        if (!error_.empty()) return fail(std::move(error_));
        continue;
      }
      out.push_back(std::move(motion));
    }
    if (out.empty()) {
      MeasuredMotion rest = empty_motion(formats::stem_of(file_name_));
      rest.frames = 1;
      rest.rate = 30;
      add_frame(rest, rest_locals_);
      notes_.remarks.push_back("The file has no animations; the result is one frame in the rest pose.");
      out.push_back(std::move(rest));
    }
    return out;
  }

  /// Places of all nodes at or below joints in the first frame of `first`, the first motion of read().
  [[nodiscard]] NodePlaces places(const MeasuredMotion& first) const {
    NodePlaces out;
    std::vector<Pose> joints;
    first.calc_joint_poses(0, joints);
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      const int j = nodes_[i].joint >= 0 ? nodes_[i].joint : parent_joint(i);
      if (j < 0) continue;
      const Pose inverse = joints[static_cast<std::size_t>(j)].inverse();
      const Mat3 to_joint = inverse.R * R_ * metres_;
      out.emplace(nodes_[i].node->mName.C_Str(), NodePlace{frames_.skeleton().joints[static_cast<std::size_t>(j)].name,
                                                           to_joint * first_world_[i].M, to_joint * first_world_[i].p + inverse.p});
    }
    return out;
  }

 private:
  bool refuse(ErrorCode code, std::string message, std::string remedy) {
    error_.add(code, std::string(file_name_), std::move(message), std::move(remedy));
    return false;
  }

  /// Fills nodes_, parents before children; without recursion, so that no depth exhausts the stack.
  bool collect_nodes() {
    if (!scene_.mRootNode) return refuse(ErrorCode::structure, "The file has no nodes.", "Export it again.");
    std::map<std::string, bool, std::less<>> bones;
    for (unsigned m = 0; m < scene_.mNumMeshes; ++m)
      for (unsigned b = 0; b < scene_.mMeshes[m]->mNumBones; ++b) bones[scene_.mMeshes[m]->mBones[b]->mName.C_Str()] = true;
    std::map<std::string, bool, std::less<>> animated;
    for (unsigned a = 0; a < scene_.mNumAnimations; ++a)
      for (unsigned c = 0; c < scene_.mAnimations[a]->mNumChannels; ++c)
        animated[scene_.mAnimations[a]->mChannels[c]->mNodeName.C_Str()] = true;
    nodes_.push_back({scene_.mRootNode, -1, -1, false, false, false, affine_of(scene_.mRootNode->mTransformation)});
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      const aiNode* node = nodes_[i].node;
      nodes_[i].bone = bones.contains(std::string_view(node->mName.C_Str()));
      nodes_[i].animated = animated.contains(std::string_view(node->mName.C_Str()));
      index_.emplace(node->mName.C_Str(), static_cast<int>(i));
      for (unsigned c = 0; c < node->mNumChildren; ++c) {
        if (nodes_.size() > 20 * formats::max_joints)
          return refuse(ErrorCode::range, "The file has more than " + std::to_string(20 * formats::max_joints) + " nodes.",
                        "Export the skeleton only.");
        nodes_.push_back({node->mChildren[c], static_cast<int>(i), -1, false, false, false,
                          nodes_[i].rest * affine_of(node->mChildren[c]->mTransformation)});
      }
    }
    for (const Node& n : nodes_)
      if (!is_finite(n.rest))
        return refuse(ErrorCode::range, "The transformation of the node " + formats::in_quotes(n.node->mName.C_Str()) + " is not finite.",
                      "Export it again.");
    return true;
  }

  /// True if an animation turns the node by more than 1 degree.
  [[nodiscard]] bool turns(const aiNode& node) const {
    constexpr double still = 0.99996;  // cosine of half a degree, of the real part of quaternions
    for (unsigned a = 0; a < scene_.mNumAnimations; ++a)
      for (unsigned c = 0; c < scene_.mAnimations[a]->mNumChannels; ++c) {
        const aiNodeAnim& channel = *scene_.mAnimations[a]->mChannels[c];
        if (channel.mNodeName != node.mName) continue;
        for (unsigned k = 1; k < channel.mNumRotationKeys; ++k) {
          const Quat p = quat_of(channel.mRotationKeys[0].mValue), q = quat_of(channel.mRotationKeys[k].mValue);
          if (std::fabs(p.w * q.w + p.x * q.x + p.y * q.y + p.z * q.z) < still) return true;
        }
      }
    return false;
  }

  /// Selects the nodes that become joints. With skins: the bones, the nodes between them, animated nodes above them, and animated
  /// nodes without meshes below them that turn or carry such nodes (a skin can weight the half of a body only). Without skins: the animated
  /// nodes and their descendants without meshes.
  void choose_joints() {
    const bool skinned = std::any_of(nodes_.begin(), nodes_.end(), [](const Node& n) { return n.bone; });
    std::vector<char> below_bone(nodes_.size(), 0), carries(nodes_.size(), 0);
    for (const Node& n : nodes_)
      if (n.parent >= 0 && n.animated && n.node->mNumMeshes == 0) carries[static_cast<std::size_t>(n.parent)] = 1;
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      Node& n = nodes_[i];
      const auto above = static_cast<std::size_t>(std::max(n.parent, 0));
      below_bone[i] = n.parent >= 0 && (nodes_[above].bone || below_bone[above] != 0) ? 1 : 0;
      const bool on_chosen = n.parent >= 0 && nodes_[static_cast<std::size_t>(n.parent)].keep;
      n.keep = skinned ? n.bone || (below_bone[i] != 0 && n.animated && n.node->mNumMeshes == 0 && (carries[i] != 0 || turns(*n.node)))
                       : (n.animated || (on_chosen && n.node->mNumMeshes == 0));
    }
    for (std::size_t i = nodes_.size(); i-- > 1;) {  // all nodes up to the highest animated or kept ancestor become joints
      if (!nodes_[i].keep) continue;
      std::size_t top = i;
      for (int k = nodes_[i].parent; k >= 0; k = nodes_[static_cast<std::size_t>(k)].parent)
        if (nodes_[static_cast<std::size_t>(k)].keep || nodes_[static_cast<std::size_t>(k)].animated) top = static_cast<std::size_t>(k);
      for (int k = nodes_[i].parent; top != i && k >= 0; k = nodes_[static_cast<std::size_t>(k)].parent) {
        nodes_[static_cast<std::size_t>(k)].keep = true;
        if (static_cast<std::size_t>(k) == top) break;
      }
    }
    if (std::none_of(nodes_.begin(), nodes_.end(), [](const Node& n) { return n.keep; }) && scene_.mNumAnimations == 0 &&
        scene_.mNumMeshes == 0)
      for (std::size_t i = 1; i < nodes_.size(); ++i) nodes_[i].keep = true;  // a file with a skeleton only gives its rest pose
    for (std::size_t i = 0; i < nodes_.size() && joints_.size() < formats::max_joints; ++i) {
      if (!nodes_[i].keep) continue;
      nodes_[i].joint = static_cast<int>(joints_.size());
      joints_.push_back(i);
    }
  }

  /// Determines up axis and unit. FBX files state the up axis and the unit in cm. COLLADA files were converted to metres by assimp.
  void find_axes() {
    const bool fbx = metadata_number(scene_, "UnitScaleFactor").has_value() || metadata_number(scene_, "UpAxis").has_value();
    const int up = fbx ? static_cast<int>(metadata_number(scene_, "UpAxis").value_or(1)) : collada_up_;
    const double sign = fbx && metadata_number(scene_, "UpAxisSign").value_or(1) < 0 ? -1 : 1;
    R_ = axes_with_up(up);
    if (sign < 0) R_ = Mat3::diagonal(1, -1, -1) * R_;
    notes_.z_up = up == 2;
    const double scale = metadata_number(scene_, "UnitScaleFactor").value_or(1);
    double metres = fbx ? 0.01 * (std::isfinite(scale) && scale > 0 ? scale : 1) : 1;
    if (options_.metres_per_unit > 0) {
      metres = options_.metres_per_unit;
    } else {
      Vec3 low{INFINITY, INFINITY, INFINITY}, high{-INFINITY, -INFINITY, -INFINITY};
      for (const std::size_t i : joints_)
        for (int k = 0; k < 3; ++k) {
          low[k] = std::min(low[k], nodes_[i].rest.p[k]);
          high[k] = std::max(high[k], nodes_[i].rest.p[k]);
        }
      metres = plausible_unit(std::max({high.x - low.x, high.y - low.y, high.z - low.z}), metres, notes_);
    }
    metres_ = metres;
    notes_.metres_per_unit = metres;
  }

  void make_skeleton() {
    frames_ = SceneJoints(R_, metres_);
    for (const std::size_t i : joints_) frames_.add(formats::utf8(nodes_[i].node->mName.C_Str()), parent_joint(i), nodes_[i].rest);
    frames_.skeleton().name = formats::stem_of(file_name_);
    add_mesh_ends();
    for (const Node& n : nodes_) rest_locals_.push_back(affine_of(n.node->mTransformation));
  }

  /// Gives joints without children the far ends of their meshes as end sites.
  void add_mesh_ends() {
    std::vector<SkeletonJoint>& joints = frames_.skeleton().joints;
    std::vector<char> carries(joints.size(), 0);
    for (const SkeletonJoint& j : joints)
      if (j.parent >= 0) carries[static_cast<std::size_t>(j.parent)] = 1;
    for (std::size_t j = 0; j < joints.size(); ++j) {
      const Node& node = nodes_[joints_[j]];
      const auto end = mesh_ends_.find(node.node->mName.C_Str());
      if (carries[j] != 0 || end == mesh_ends_.end()) continue;
      const Vec3 site = R_ * (node.rest.M * end->second) * metres_;
      if (is_finite(site) && norm(site) < formats::max_magnitude) joints[j].end_sites.push_back(site);
    }
  }

  /// Returns the index of the closest ancestor joint; -1: none.
  [[nodiscard]] int parent_joint(std::size_t node) const {
    for (int k = nodes_[node].parent; k >= 0; k = nodes_[static_cast<std::size_t>(k)].parent)
      if (nodes_[static_cast<std::size_t>(k)].joint >= 0) return nodes_[static_cast<std::size_t>(k)].joint;
    return -1;
  }

  MeasuredMotion empty_motion(std::string name) const {
    MeasuredMotion m;
    m.name = std::move(name);
    m.source = std::string(file_name_);
    m.skeleton = frames_.skeleton();
    return m;
  }

  /// Appends one frame to the motion. @param locals [nodes] transformation of each node relative to its parent
  void add_frame(MeasuredMotion& motion, const std::vector<Affine>& locals) {
    world_.resize(nodes_.size());
    for (std::size_t i = 0; i < nodes_.size(); ++i)
      world_[i] = nodes_[i].parent < 0 ? locals[i] : world_[static_cast<std::size_t>(nodes_[i].parent)] * locals[i];
    if (first_world_.empty()) first_world_ = world_;
    joint_world_.clear();
    for (const std::size_t i : joints_) joint_world_.push_back(world_[i]);
    frames_.append_frame(motion, joint_world_);
  }

  /// Value at time t [ticks], linearly interpolated between the keys.
  /// @param cursor [in and out] index of the last key used; t must not decrease from call to call
  template <class Key, class Value, class Mix>
  static Value at(const Key* keys, unsigned count, double t, unsigned& cursor, Value (*value)(const Key&), Mix mix) {
    while (cursor + 1 < count && keys[cursor + 1].mTime <= t) ++cursor;
    if (cursor + 1 >= count || t <= keys[cursor].mTime) return value(keys[cursor]);
    const double s = (t - keys[cursor].mTime) / (keys[cursor + 1].mTime - keys[cursor].mTime);
    return mix(value(keys[cursor]), value(keys[cursor + 1]), s);
  }

  /// Index of the last key used in each track of a channel.
  struct Cursor {
    unsigned position = 0, rotation = 0, scale = 0;
  };
  static Vec3 vector_of(const aiVectorKey& k) { return vec_of(k.mValue); }
  static Quat rotation_of(const aiQuatKey& k) { return quat_of(k.mValue); }

  /// Returns the transformation of a node at time t [ticks]. Tracks without keys use the value of the rest pose.
  Affine local_of(const aiNodeAnim& channel, double t, Cursor& cursor, const Affine& rest) const {
    const auto linear = [](const Vec3& a, const Vec3& b, double s) { return a + (b - a) * s; };
    Vec3 p = rest.p, scale{norm(rest.M.column(0)), norm(rest.M.column(1)), norm(rest.M.column(2))};
    Mat3 R = Mat3::identity();
    if (channel.mNumPositionKeys > 0) p = at(channel.mPositionKeys, channel.mNumPositionKeys, t, cursor.position, vector_of, linear);
    if (channel.mNumScalingKeys > 0) scale = at(channel.mScalingKeys, channel.mNumScalingKeys, t, cursor.scale, vector_of, linear);
    if (channel.mNumRotationKeys > 0)
      R = to_matrix(at(channel.mRotationKeys, channel.mNumRotationKeys, t, cursor.rotation, rotation_of,
                       [](const Quat& a, const Quat& b, double s) { return slerp(a, b, s); }));
    else if (const auto own = nearest_rotation(rest.M))
      R = *own;
    return {R * Mat3::diagonal(scale.x, scale.y, scale.z), p};
  }

  /// Samples one animation. Returns false if it has no keys or cannot be used; if it cannot be used, sets error_.
  bool sample(const aiAnimation& animation, unsigned number, MeasuredMotion& motion) {
    const double ticks = animation.mTicksPerSecond > 0 && std::isfinite(animation.mTicksPerSecond) ? animation.mTicksPerSecond : 25;
    double first = INFINITY, last = -INFINITY, closest = INFINITY;
    std::vector<double> gaps;
    std::vector<const aiNodeAnim*> channel_of(nodes_.size(), nullptr);
    const auto scan_keys = [&](const auto* keys, unsigned count) {
      for (unsigned k = 0; k < count; ++k) {
        const double t = keys[k].mTime;
        if (!std::isfinite(t) || std::fabs(t) > 1e12) return false;
        if (k > 0 && t < keys[k - 1].mTime) return false;
        if (k > 0 && t > keys[k - 1].mTime) gaps.push_back(t - keys[k - 1].mTime);
        first = std::min(first, t);
        last = std::max(last, t);
      }
      // The median gap is used, because rounding in an exporter can turn one key into two keys at almost equal times.
      if (!gaps.empty()) {
        std::nth_element(gaps.begin(), gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2), gaps.end());
        closest = std::min(closest, gaps[gaps.size() / 2]);
        gaps.clear();
      }
      return true;
    };
    for (unsigned c = 0; c < animation.mNumChannels; ++c) {
      const aiNodeAnim& channel = *animation.mChannels[c];
      const auto it = index_.find(std::string_view(channel.mNodeName.C_Str()));
      if (it == index_.end()) continue;
      if (!scan_keys(channel.mPositionKeys, channel.mNumPositionKeys) || !scan_keys(channel.mRotationKeys, channel.mNumRotationKeys) ||
          !scan_keys(channel.mScalingKeys, channel.mNumScalingKeys))
        return refuse(ErrorCode::structure,
                      "The key times of " + formats::in_quotes(channel.mNodeName.C_Str()) + " decrease or are not finite.",
                      "Export it again.");
      channel_of[static_cast<std::size_t>(it->second)] = &channel;
    }
    if (!(last >= first)) return false;
    double rate = options_.rate;
    if (!(rate > 0)) rate = rate_of_gap(closest / ticks);
    const double span = (last - first) / ticks;
    const double frames = std::floor(span * rate + 1.5);
    if (!(frames * static_cast<double>(joints_.size()) <= 2e7))
      return refuse(ErrorCode::range,
                    "An animation of " + to_fixed(span, 1) + " s at " + to_fixed(rate, 1) +
                        " frames per second has more than 20 million joint poses.",
                    "Sample it at a lower rate (--rate).");
    const std::string own = formats::utf8(animation.mName.C_Str());
    motion = empty_motion(scene_.mNumAnimations == 1 || own.empty()
                              ? formats::stem_of(file_name_) + (scene_.mNumAnimations == 1 ? "" : " " + std::to_string(number + 1))
                              : own);
    motion.rate = rate;
    motion.frames = static_cast<int>(frames);
    for (std::size_t j = 0; j < joints_.size(); ++j) {
      const aiNodeAnim* channel = channel_of[joints_[j]];
      motion.skeleton.joints[j].translates = moves(channel);
    }
    std::vector<Cursor> cursors(nodes_.size());
    std::vector<Affine> locals = rest_locals_;
    for (int f = 0; f < motion.frames; ++f) {
      const double t = std::min(first + f / rate * ticks, last);
      for (std::size_t i = 0; i < nodes_.size(); ++i)
        if (channel_of[i]) locals[i] = local_of(*channel_of[i], t, cursors[i], rest_locals_[i]);
      add_frame(motion, locals);
    }
    for (const Vec3& p : motion.translations)
      if (!is_finite(p) || norm(p) > formats::max_magnitude)
        return refuse(ErrorCode::range, "A position is not finite or more than 1e9 m from the origin.", "Export it again.");
    if (const long flat = frames_.take_flat(); flat > 0)
      notes_.remarks.push_back("Some joints are scaled to nothing or mirrored in " + std::to_string(flat) +
                               " joint poses; these poses use the rotation of their parents.");
    notes_.frame_time = 1 / rate;
    return true;
  }

  /// True if the position keys of a channel differ from each other.
  static bool moves(const aiNodeAnim* channel) {
    if (!channel || channel->mNumPositionKeys < 2) return false;
    for (unsigned k = 1; k < channel->mNumPositionKeys; ++k) {
      const Vec3 d = vec_of(channel->mPositionKeys[k].mValue) - vec_of(channel->mPositionKeys[0].mValue);
      if (norm(d) > 1e-5 * (1 + norm(vec_of(channel->mPositionKeys[0].mValue)))) return true;
    }
    return false;
  }

  const aiScene& scene_;
  std::string_view file_name_;
  const SceneOptions& options_;
  formats::ReadNotes& notes_;
  int collada_up_;
  const std::map<std::string, Vec3>& mesh_ends_;
  Error error_;
  std::vector<Node> nodes_;
  std::map<std::string, int, std::less<>> index_;
  std::vector<std::size_t> joints_;  ///< [joints] index in nodes_
  Mat3 R_ = Mat3::identity();        ///< from the file's axes to ours
  double metres_ = 1;                ///< m per file unit
  SceneJoints frames_;
  std::vector<Affine> rest_locals_;  ///< [nodes] transformation relative to the parent in the rest pose
  std::vector<Affine> world_;        ///< [nodes] world transform in the frame that add_frame() computes
  std::vector<Affine> joint_world_;  ///< [joints] the same of the joints
  std::vector<Affine> first_world_;  ///< [nodes] world_ of the first frame
};

}  // namespace

void set_importer(Assimp::Importer& importer) {
  importer.SetPropertyBool(AI_CONFIG_IMPORT_FBX_PRESERVE_PIVOTS, false);
  importer.SetPropertyBool(AI_CONFIG_IMPORT_FBX_READ_CAMERAS, false);
  importer.SetPropertyBool(AI_CONFIG_IMPORT_FBX_READ_LIGHTS, false);
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);  // find_axes() converts the up axis, for all formats
}

void keep_repeated_bones(Assimp::Importer& importer) {
  const aiScene* scene = importer.GetScene();
  for (unsigned int i = 0; scene && i < scene->mNumMeshes; ++i) {
    const aiMesh& mesh = *scene->mMeshes[i];
    std::set<const aiBone*> bones(mesh.mBones, mesh.mBones + mesh.mNumBones);
    if (bones.size() == mesh.mNumBones) continue;
    (void)importer.GetOrphanedScene();
    return;
  }
}

Result<std::vector<MeasuredMotion>> read_scene_unguarded(std::span<const std::byte> bytes, std::string_view file_name,
                                                         const SceneOptions& options, formats::ReadNotes& notes, NodePlaces* places) {
  const std::string location(file_name);
  const std::size_t dot = file_name.rfind('.');
  const std::string_view ending = dot == std::string_view::npos ? std::string_view() : file_name.substr(dot + 1);
  const bool fbx = formats::equal_ignoring_case(ending, "fbx"), dae = formats::equal_ignoring_case(ending, "dae");
  if (!fbx && !dae) return fail(ErrorCode::unsupported, location, "The file is neither FBX nor COLLADA.", "Give a .fbx or .dae file.");
  if (bytes.empty()) return fail(ErrorCode::truncated, location, "The file is empty.", "Export it again.");
  Assimp::Importer importer;
  set_importer(importer);
  importer.SetPropertyBool(AI_CONFIG_IMPORT_FBX_READ_MATERIALS, false);
  importer.SetPropertyBool(AI_CONFIG_IMPORT_FBX_READ_TEXTURES, false);
  std::map<std::string, Vec3> mesh_ends;
  const Result<std::string> core =
      fbx ? fbx_core(bytes, location, options.mesh_ends ? &mesh_ends : nullptr) : collada_core(bytes, location);
  if (!core) return fail(core.error());
  const aiScene* scene = importer.ReadFileFromMemory(core->data(), core->size(), 0, fbx ? "fbx" : "dae");
  if (!scene)
    return fail(
        ErrorCode::syntax, location,
        "The file cannot be read as " + std::string(fbx ? "FBX" : "COLLADA") + ": " + formats::utf8(importer.GetErrorString()) + ".",
        "Export it again, in another version of the format or as glTF or BVH.");
  const int up = dae ? collada_up_axis({reinterpret_cast<const char*>(bytes.data()), bytes.size()}) : 1;
  SceneReader reader(*scene, file_name, options, notes, up, mesh_ends);
  Result<std::vector<MeasuredMotion>> motions = reader.read();
  if (motions && places) *places = reader.places(motions->front());
  keep_repeated_bones(importer);
  return motions;
}

}  // namespace ugoki::scene_formats
