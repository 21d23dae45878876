#include "ugoki/intake/hip_root.h"

#include <vector>

#include "ugoki/base/number.h"
#include "ugoki/intake/tree_edit.h"
#include "ugoki/spatial/rotation.h"

namespace ugoki::intake {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Moves the origin of the root joint by a vector in its own frame.
void move_root(MeasuredMotion& m, const Vec3& shift) {
  const std::size_t n = m.skeleton.joints.size();
  m.skeleton.joints[0].offset += shift;
  for (Vec3& e : m.skeleton.joints[0].end_sites) e -= shift;
  for (std::size_t f = 0; f < at(m.frames); ++f) {
    const std::size_t root = f * n;
    m.translations[root] += rotate(m.rotations[root], shift);
    for (std::size_t i = 1; i < n; ++i)
      if (m.skeleton.joints[i].parent == 0) m.translations[root + i] -= shift;
  }
  for (std::size_t i = 1; i < n; ++i)
    if (m.skeleton.joints[i].parent == 0) m.skeleton.joints[i].offset -= shift;
}

}  // namespace

std::string move_root_to_hips(std::span<MeasuredMotion> motions, const body::Character& character) {
  constexpr double far = 0.6;  // trunk lengths; roots in the middle of the trunk stay
  if (character.pelvis != 0) return {};
  const std::vector<std::vector<Pose>> samples = sample_poses(motions);
  if (samples.empty()) return {};
  Vec3 middle;  // of the hips, in the frame of the root
  for (const auto& X : samples)
    for (const body::Limb& leg : character.legs)
      middle += X[0].inverse() * X[at(leg.proximal)].p / (2 * static_cast<double>(samples.size()));
  if (norm(middle) < far * character.trunk_length) return {};
  for (MeasuredMotion& m : motions) move_root(m, middle);
  return "The root joint " + motions[0].skeleton.joints[0].name + " is " + to_fixed(norm(middle) / character.trunk_length, 1) +
         " trunk lengths away from the hips; its place in the body is between them.";
}

}  // namespace ugoki::intake
