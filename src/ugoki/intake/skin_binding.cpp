#include "ugoki/intake/skin_binding.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "ugoki/base/check.h"
#include "ugoki/base/number.h"
#include "ugoki/formats/gltf_skin.h"
#include "ugoki/intake/tree_edit.h"
#include "ugoki/scene_formats/meshopt.h"

namespace ugoki::intake {
namespace {

constexpr double rigid = 0.01;       // m; joints that move less relative to each other move together
constexpr double arm_of_turn = 0.1;  // m, at which a relative turn is measured

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Largest motion [m] of joint i of `inner` relative to joint k of `outer` over the sampled frames.
double relative_motion(const std::vector<std::vector<Pose>>& outer, std::size_t k, const std::vector<std::vector<Pose>>& inner,
                       std::size_t i) {
  const Pose first = outer[0][k].inverse() * inner[0][i];
  double largest = 0;
  for (std::size_t f = 1; f < outer.size(); ++f) {
    const Pose X = outer[f][k].inverse() * inner[f][i];
    double turn = 0;
    for (int c = 0; c < 3; ++c) turn = std::max(turn, norm(X.R.column(c) - first.R.column(c)));
    largest = std::max(largest, norm(X.p - first.p) + arm_of_turn * turn);
  }
  return largest;
}

}  // namespace

SkinBinding::SkinBinding(formats::FileSkin skin, std::span<const MeasuredMotion> motions)
    : file_(std::move(skin)), lost_(file_.bones.size(), 0) {
  if (!exists()) return;
  for (const SkeletonJoint& j : motions[0].skeleton.joints) {
    names_.push_back(j.name);
    parents_.push_back(j.parent);
  }
  rest_ = rest_positions(motions[0].skeleton);
  samples_ = sample_poses(motions);
}

void SkinBinding::turn(const Mat3& R) {
  for (formats::FileBone& b : file_.bones) b.A = R * b.A, b.p = R * b.p;
  for (Vec3& p : rest_) p = R * p;
  for (std::vector<Pose>& X : samples_)
    for (Pose& x : X) x = {R * x.R * R.transposed(), R * x.p};
}

void SkinBinding::scale(double factor) {
  for (formats::FileBone& b : file_.bones) b.A = b.A * factor, b.p *= factor;
  for (Vec3& p : rest_) p *= factor;
  for (std::vector<Pose>& X : samples_)
    for (Pose& x : X) x.p *= factor;
}

void SkinBinding::reduce(std::span<const MeasuredMotion> motions) {
  if (!exists()) return;
  const std::vector<std::vector<Pose>> now = sample_poses(motions);
  if (now.size() != samples_.size()) return;
  const std::vector<SkeletonJoint>& joints = motions[0].skeleton.joints;
  const std::vector<Vec3> rest = rest_positions(motions[0].skeleton);
  std::map<std::string, std::size_t, std::less<>> index_now, index_before;
  for (std::size_t k = 0; k < joints.size(); ++k) index_now.emplace(joints[k].name, k);
  for (std::size_t i = 0; i < names_.size(); ++i) index_before.emplace(names_[i], i);
  const auto remaining = [&](int i) {
    const auto it = index_now.find(names_[at(i)]);
    return it == index_now.end() ? -1 : static_cast<int>(it->second);
  };
  const auto carries_body = [&](int i) {  // an ancestor of a remaining joint
    for (const auto& [name, k] : index_now)
      if (const auto it = index_before.find(name); it != index_before.end())
        for (int up = static_cast<int>(it->second); up >= 0; up = parents_[at(up)])
          if (up == i) return true;
    return false;
  };
  std::map<std::size_t, std::pair<int, Pose>> found;  // by joint of the file: remaining joint and pose of the file's joint in it
  for (std::size_t b = 0; b < file_.bones.size(); ++b) {
    formats::FileBone& bone = file_.bones[b];
    const auto joint = index_before.find(bone.joint);
    UGOKI_CHECK(joint != index_before.end());
    const std::size_t i = joint->second;
    auto [it, is_new] = found.try_emplace(i, -1, Pose{});
    if (is_new) {
      int target = -1, up = static_cast<int>(i);
      while (up >= 0 && remaining(up) < 0) up = parents_[at(up)];
      if (up >= 0) target = remaining(up);
      if (target < 0 || relative_motion(now, at(target), samples_, i) > rigid) {
        double minimum = target < 0 ? 1e9 : relative_motion(now, at(target), samples_, i);
        for (std::size_t k = 0; (up >= 0 || carries_body(static_cast<int>(i))) && k < joints.size(); ++k)
          if (const double d = relative_motion(now, k, samples_, i); d < 0.5 * minimum || target < 0) {
            minimum = d;
            target = static_cast<int>(k);
          }
      }
      it->second.first = target;
      if (target >= 0)
        it->second.second = relative_motion(now, at(target), samples_, i) <= rigid ? now[0][at(target)].inverse() * samples_[0][i]
                                                                                   : Pose{Mat3::identity(), rest_[i] - rest[at(target)]};
    }
    const auto& [target, X] = it->second;
    lost_[b] = target < 0 ? 1 : 0;
    if (target < 0) continue;
    bone.joint = joints[at(target)].name;
    bone.A = X.R * bone.A;
    bone.p = X * bone.p;
  }
  // from now on, bones are those of the remaining joints
  names_.clear();
  parents_.clear();
  for (const SkeletonJoint& j : joints) names_.push_back(j.name), parents_.push_back(j.parent);
  rest_ = rest;
  samples_ = now;
}

void SkinBinding::drop_lost_triangles() {
  Skin& s = file_.skin;
  std::vector<char> gone(s.vertex_count(), 0);
  for (std::size_t v = 0; v < s.vertex_count(); ++v) {
    int lost = 0, heaviest = -1;
    for (std::size_t k = 4 * v; k < 4 * v + 4; ++k) {
      if (lost_[s.bones[k]] != 0)
        lost += s.weights[k];
      else if (heaviest < 0 || s.weights[k] > s.weights[at(heaviest)])
        heaviest = static_cast<int>(k);
    }
    gone[v] = lost > 32767 || heaviest < 0 ? 1 : 0;
    for (std::size_t k = 4 * v; k < 4 * v + 4 && heaviest >= 0; ++k)
      if (lost_[s.bones[k]] != 0) {
        s.weights[at(heaviest)] = static_cast<std::uint16_t>(s.weights[at(heaviest)] + s.weights[k]);
        s.weights[k] = 0;
        s.bones[k] = s.bones[at(heaviest)];
      }
  }
  std::vector<std::uint32_t> kept;
  for (SkinPart& part : s.parts) {
    const auto first = static_cast<std::uint32_t>(kept.size());
    for (std::uint32_t i = part.first; i < part.first + part.count; i += 3)
      if (gone[s.indices[i]] == 0 && gone[s.indices[i + 1]] == 0 && gone[s.indices[i + 2]] == 0)
        kept.insert(kept.end(), {s.indices[i], s.indices[i + 1], s.indices[i + 2]});
    part.first = first;
    part.count = static_cast<std::uint32_t>(kept.size()) - first;
  }
  s.indices = std::move(kept);
  std::erase_if(s.parts, [](const SkinPart& p) { return p.count == 0; });
  formats::remove_unused(file_);
}

void SkinBinding::attach(const body::Body& body, MechanismSpec& mechanism) {
  if (!exists()) return;
  drop_lost_triangles();
  if (file_.skin.indices.empty()) return;
  for (const formats::FileBone& bone : file_.bones) {
    const auto it = std::ranges::find(body.joint_names, bone.joint);
    const auto j = static_cast<std::size_t>(it - body.joint_names.begin());
    const std::size_t known = j < body.joint_names.size() ? j : 0;
    const Mat3 turn = body.rest.empty() ? Mat3::identity() : body.rest[known];
    mechanism.skin_bones.push_back({body.mechanism->link(body.link_of_joint[known]).name, turn * bone.A, turn * bone.p});
  }
  mechanism.skin = std::make_shared<Skin>(std::move(file_.skin));
}

formats::FileSkin skin_of_gltf(std::span<const std::byte> bytes, std::string_view file_name, const IntakeOptions& options,
                               formats::ReadNotes& notes) {
  Result<formats::FileSkin> skin = formats::read_gltf_skin(
      bytes, file_name, {.metres_per_unit = options.unit, .mesh_ends = true, .files = options.files}, scene_formats::unpack_meshopt, notes);
  if (skin) return std::move(*skin);
  notes.remarks.push_back("The skin of the character is left out: " + skin.error().problems[0].message);
  return {};
}

std::string describe(const Skin& skin) {
  const std::size_t pictures = skin.textures.size();
  std::size_t bytes = 0;
  for (const SkinTexture& t : skin.textures) bytes += t.data.size();
  return "A skin of " + std::to_string(skin.vertex_count()) + " vertices and " + std::to_string(skin.triangle_count()) + " triangles" +
         (pictures == 0 ? ", without textures."
                        : ", with " + std::to_string(pictures) + (pictures == 1 ? " texture of " : " textures of ") +
                              to_fixed(static_cast<double>(bytes) / (1 << 20), 1) + " MB.");
}

}  // namespace ugoki::intake
