// Fuzz targets of the glTF readers.
#include <algorithm>
#include <cmath>
#include <span>

#include "fuzz_targets.h"
#include "ugoki/base/check.h"
#include "ugoki/formats/gltf.h"
#include "ugoki/formats/gltf_skin.h"
#include "ugoki/scene_formats/meshopt.h"

namespace ugoki {

void fuzz_gltf(const std::uint8_t* data, std::size_t size) {
  const auto motions = formats::read_gltf({reinterpret_cast<const std::byte*>(data), size}, "fuzz.glb");
  if (!motions) {
    UGOKI_CHECK(!motions.error().problems.empty());
    for (const Problem& p : motions.error().problems) UGOKI_CHECK(!p.location.empty() && p.message.ends_with('.'));
    return;
  }
  UGOKI_CHECK(!motions->empty());
  for (const MeasuredMotion& m : *motions) {
    const std::size_t count = static_cast<std::size_t>(m.frames) * m.skeleton.joints.size();
    UGOKI_CHECK(m.frames > 0 && m.rate > 0 && std::isfinite(m.rate) && m.joint_count() > 0);
    UGOKI_CHECK(m.translations.size() == count && m.rotations.size() == count);
    for (std::size_t j = 0; j < m.skeleton.joints.size(); ++j) UGOKI_CHECK(m.skeleton.joints[j].parent < static_cast<int>(j));
    for (const Vec3& t : m.translations) UGOKI_CHECK(is_finite(t));
    for (const Quat& q : m.rotations) UGOKI_CHECK(std::fabs(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z - 1) < 1e-9);
  }
  const MeasuredMotion& m = motions->front();
  if (m.translations.size() > 5'000) return;
  const auto back = formats::read_gltf(formats::write_glb(m), "again.glb", {.rate = m.rate, .metres_per_unit = m.skeleton.unit});
  UGOKI_CHECK(back.has_value() && back->front().joint_count() == m.joint_count());
}

/// The skin of a file, and the ends of bones that its meshes show, as they are imported.
void fuzz_gltf_skin(const std::uint8_t* data, std::size_t size) {
  const std::span bytes(reinterpret_cast<const std::byte*>(data), size);
  const formats::GltfOptions options{.mesh_ends = true};
  formats::ReadNotes notes;
  const auto motions = formats::read_gltf(bytes, "fuzz.glb", options, scene_formats::unpack_meshopt, &notes);
  const auto skin = formats::read_gltf_skin(bytes, "fuzz.glb", options, scene_formats::unpack_meshopt, notes);
  if (!skin) {
    for (const Problem& p : skin.error().problems) UGOKI_CHECK(!p.location.empty() && p.message.ends_with('.'));
    return;
  }
  if (motions)
    for (const SkeletonJoint& j : motions->front().skeleton.joints)
      for (const Vec3& e : j.end_sites) UGOKI_CHECK(is_finite(e));
  if (skin->bones.empty() || !motions) return;  // a file without a motion is refused
  Error problems;
  check_skin(skin->skin, skin->bones.size(), "fuzz.glb", problems);
  UGOKI_CHECK(problems.empty());
  for (const formats::FileBone& b : skin->bones) {
    UGOKI_CHECK(is_finite(b.p) && is_finite(b.A.column(0)) && is_finite(b.A.column(1)) && is_finite(b.A.column(2)));
    UGOKI_CHECK(std::ranges::any_of(motions->front().skeleton.joints, [&](const SkeletonJoint& j) { return j.name == b.joint; }));
  }
}

}  // namespace ugoki
