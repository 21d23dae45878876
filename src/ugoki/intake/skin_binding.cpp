#include "ugoki/intake/skin_binding.h"

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include "ugoki/base/number.h"
#include "ugoki/formats/gltf_skin.h"
#include "ugoki/intake/tree_edit.h"
#include "ugoki/scene_formats/meshopt.h"
#include "ugoki/scene_formats/scene_skin.h"

namespace ugoki::intake {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// The joints of motions that have the same skeleton.
SampledJoints sampled(std::span<const MeasuredMotion> motions) {
  SampledJoints out;
  for (const SkeletonJoint& j : motions[0].skeleton.joints) {
    out.names.push_back(j.name);
    out.parents.push_back(j.parent);
  }
  out.samples = sample_poses(motions);
  out.rest = rest_positions(motions[0].skeleton);
  return out;
}

/// The skin, or an empty one and a remark if it cannot be read.
formats::FileSkin shown_or_noted(Result<formats::FileSkin> skin, formats::ReadNotes& notes) {
  if (skin) return std::move(*skin);
  notes.remarks.push_back("The skin of the character is left out: " + skin.error().problems[0].message);
  return {};
}

}  // namespace

SkinBinding::SkinBinding(formats::FileSkin skin, std::span<const MeasuredMotion> motions)
    : file_(std::move(skin)), lost_(file_.bones.size(), 0) {
  if (exists()) joints_ = sampled(motions);
}

void SkinBinding::turn(const Mat3& R) {
  for (formats::FileBone& b : file_.bones) b.A = R * b.A, b.p = R * b.p;
  for (Vec3& p : joints_.rest) p = R * p;
  for (std::vector<Pose>& X : joints_.samples)
    for (Pose& x : X) x = {R * x.R * R.transposed(), R * x.p};
}

void SkinBinding::scale(double factor) {
  for (formats::FileBone& b : file_.bones) b.A = b.A * factor, b.p *= factor;
  for (Vec3& p : joints_.rest) p *= factor;
  for (std::vector<Pose>& X : joints_.samples)
    for (Pose& x : X) x.p *= factor;
}

void SkinBinding::reduce(std::span<const MeasuredMotion> motions) {
  if (!exists()) return;
  SampledJoints now = sampled(motions);
  if (now.samples.size() != joints_.samples.size()) return;
  const RigidJoints rigid_joints(std::move(joints_), now);
  std::map<std::string, std::optional<RigidJoint>, std::less<>> found;  // by the joint of the file
  for (std::size_t b = 0; b < file_.bones.size(); ++b) {
    formats::FileBone& bone = file_.bones[b];
    const auto [it, is_new] = found.try_emplace(bone.joint);
    if (is_new) it->second = rigid_joints.find(bone.joint);
    lost_[b] = it->second ? 0 : 1;
    if (!it->second) continue;
    const auto& [joint, X] = *it->second;
    bone.joint = now.names[joint];
    bone.A = X.R * bone.A;
    bone.p = X * bone.p;
  }
  joints_ = std::move(now);
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
  return shown_or_noted(std::move(skin), notes);
}

formats::FileSkin skin_of_scene(std::span<const std::byte> bytes, std::string_view file_name, const IntakeOptions& options,
                                formats::ReadNotes& notes) {
  return shown_or_noted(scene_formats::read_scene_skin(bytes, file_name, {.metres_per_unit = options.unit}, options.files, notes), notes);
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
