#include "ugoki/intake/headless.h"

#include <array>
#include <optional>

#include "ugoki/body/joint_names.h"
#include "ugoki/body/limb_geometry.h"
#include "ugoki/intake/tree_edit.h"

namespace ugoki::intake {
namespace {

/// The first joints of the limbs: of a left and a right arm and of a left and a right leg.
struct Limbs {
  std::array<int, 2> arms = {-1, -1}, legs = {-1, -1};
};

/// Finds the limbs by names; none if a limb has no name of a side, or if a joint is named as neck, head or part of an animal.
std::optional<Limbs> named_limbs(const Skeleton& s) {
  std::vector<std::string> names;
  for (const SkeletonJoint& j : s.joints) names.push_back(j.name);
  Limbs out;
  const std::vector<body::NameEvidence> evidence = body::read_joint_names(names);
  for (std::size_t i = 0; i < evidence.size(); ++i) {
    const body::NameEvidence& e = evidence[i];
    if (e.part == body::Part::head || e.part == body::Part::neck || e.tail || e.wing || e.paw || e.fore || e.hind) return std::nullopt;
    if (e.helper || e.side == 0 || (!body::is_arm(e.part) && !body::is_leg(e.part))) continue;
    int& first = (body::is_arm(e.part) ? out.arms : out.legs)[e.side > 0 ? 0 : 1];
    if (first < 0) first = static_cast<int>(i);  // parents precede their children
  }
  const bool all = out.arms[0] >= 0 && out.arms[1] >= 0 && out.legs[0] >= 0 && out.legs[1] >= 0;
  return all ? std::optional(out) : std::nullopt;
}

}  // namespace

std::string add_head(std::span<MeasuredMotion> motions) {
  // Shares of the distance between hips and shoulders: usual proportions of a person (anthropometry: 0.29 of the height).
  constexpr double neck = 0.15, head = 0.35, top = 0.4, beside = 0.1;
  const Skeleton& s = motions[0].skeleton;
  const std::optional<Limbs> limbs = named_limbs(s);
  if (!limbs) return {};
  const auto joint = [&](int i) -> const SkeletonJoint& { return s.joints[static_cast<std::size_t>(i)]; };
  const int chest = joint(limbs->arms[0]).parent;
  if (chest < 0 || joint(limbs->arms[1]).parent != chest || joint(limbs->legs[0]).parent == chest) return {};
  const std::vector<std::vector<Pose>> samples = sample_poses(motions);
  if (samples.empty()) return {};
  Vec3 shoulders, trunk;  // m, mean in the axes of the chest's joint
  for (const std::vector<Pose>& X : samples) {
    const auto p = [&](int i) { return X[static_cast<std::size_t>(i)].p; };
    const Pose& C = X[static_cast<std::size_t>(chest)];
    const Vec3 above = (p(limbs->arms[0]) + p(limbs->arms[1])) * 0.5, below = (p(limbs->legs[0]) + p(limbs->legs[1])) * 0.5;
    shoulders += transpose_times(C.R, above - C.p) / static_cast<double>(samples.size());
    trunk += transpose_times(C.R, above - below) / static_cast<double>(samples.size());
  }
  if (norm(trunk) < 1e-6) return {};
  // A joint above the shoulders that belongs to no limb is the head, whatever its name is.
  const Vec3 up = normalized(trunk);
  for (int i = chest + 1; i < static_cast<int>(s.joints.size()); ++i) {
    if (is_below(s, i, limbs->arms[0]) || is_below(s, i, limbs->arms[1]) || !is_below(s, i, chest)) continue;
    double height = 0;  // m, above the shoulders
    for (const std::vector<Pose>& X : samples) {
      const Pose& C = X[static_cast<std::size_t>(chest)];
      const Vec3 p = transpose_times(C.R, X[static_cast<std::size_t>(i)].p - C.p);
      height += dot(p - shoulders, up) / static_cast<double>(samples.size());
    }
    if (height > beside * norm(trunk)) return {};
  }
  std::string name = joint(chest).name;
  for (MeasuredMotion& m : motions) {
    append_rigid(m, "neck", chest, shoulders + trunk * neck, {});
    append_rigid(m, "head", m.joint_count() - 1, trunk * (head - neck), {trunk * top});
  }
  return name;
}

}  // namespace ugoki::intake
