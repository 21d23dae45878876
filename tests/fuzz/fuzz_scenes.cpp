// Fuzz targets of the FBX and COLLADA readers. They run in this process, without the guard of read_scene, which turns crashes of the assimp
// library into errors. scripts/fuzz separates faults of assimp from ours by their call stack.
#include <cmath>
#include <span>

#include "fuzz_targets.h"
#include "ugoki/base/check.h"
#include "ugoki/formats/read_notes.h"
#include "ugoki/scene_formats/scene_file.h"

namespace ugoki {
namespace {

void fuzz_scene(const std::uint8_t* data, std::size_t size, std::string_view name) {
  formats::ReadNotes notes;
  const auto motions = scene_formats::read_scene_unguarded({reinterpret_cast<const std::byte*>(data), size}, name, {.mesh_ends = size % 2 == 1}, notes);
  if (!motions) {
    UGOKI_CHECK(!motions.error().problems.empty());
    for (const Problem& p : motions.error().problems) UGOKI_CHECK(!p.location.empty() && p.message.ends_with('.') && !p.remedy.empty());
    return;
  }
  UGOKI_CHECK(!motions->empty());
  for (const MeasuredMotion& m : *motions) {
    const std::size_t count = static_cast<std::size_t>(m.frames) * m.skeleton.joints.size();
    UGOKI_CHECK(m.frames > 0 && m.rate > 0 && std::isfinite(m.rate) && m.joint_count() > 0);
    UGOKI_CHECK(m.translations.size() == count && m.rotations.size() == count);
    for (std::size_t j = 0; j < m.skeleton.joints.size(); ++j) {
      UGOKI_CHECK(m.skeleton.joints[j].parent < static_cast<int>(j) && !m.skeleton.joints[j].name.empty());
      UGOKI_CHECK(is_finite(m.skeleton.joints[j].offset));
    }
    for (const Vec3& t : m.translations) UGOKI_CHECK(is_finite(t));
    for (const Quat& q : m.rotations) UGOKI_CHECK(std::fabs(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z - 1) < 1e-9);
  }
}

}  // namespace

void fuzz_fbx(const std::uint8_t* data, std::size_t size) { fuzz_scene(data, size, "fuzz.fbx"); }
void fuzz_collada(const std::uint8_t* data, std::size_t size) { fuzz_scene(data, size, "fuzz.dae"); }

}  // namespace ugoki
