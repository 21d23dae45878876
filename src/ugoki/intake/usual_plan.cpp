#include "ugoki/intake/usual_plan.h"

#include <algorithm>
#include <cmath>

#include "ugoki/body/joint_names.h"
#include "ugoki/body/limb_geometry.h"
#include "ugoki/intake/joined_motion.h"
#include "ugoki/intake/tree_edit.h"

namespace ugoki::intake {
namespace {

/// True if names state arms and legs on both sides, and no part of an animal.
bool has_names_of_person(const Skeleton& s) {
  std::vector<std::string> names;
  for (const SkeletonJoint& j : s.joints) names.push_back(j.name);
  bool left_arm = false, right_arm = false, left_leg = false, right_leg = false;
  for (const body::NameEvidence& e : body::read_joint_names(names)) {
    if (e.tail || e.wing || e.paw || e.fore || e.hind) return false;
    left_arm = left_arm || (body::is_arm(e.part) && e.side > 0);
    right_arm = right_arm || (body::is_arm(e.part) && e.side < 0);
    left_leg = left_leg || (body::is_leg(e.part) && e.side > 0);
    right_leg = right_leg || (body::is_leg(e.part) && e.side < 0);
  }
  return left_arm && right_arm && left_leg && right_leg;
}

}  // namespace

std::optional<body::Character> human_in_most(std::span<const MeasuredMotion> motions) {
  if (motions.size() < 3 || !has_names_of_person(motions[0].skeleton)) return std::nullopt;
  constexpr int shortest = 6;              // frames; shorter motions are poses
  constexpr std::size_t max_motions = 40;  // bounds the time
  std::size_t count = 0, humans = 0;
  int longest = 0;
  std::optional<body::Character> human;
  for (const MeasuredMotion& m : motions) {
    if (m.frames < shortest) continue;
    if (++count > max_motions) break;
    body::Character own = body::recognise_character(m);
    if (own.plan != body::BodyPlan::human) continue;
    ++humans;
    if (m.frames <= longest) continue;
    longest = m.frames;
    human = std::move(own);
  }
  count = std::min(count, max_motions);
  return count >= 3 && 3 * humans >= 2 * count ? std::move(human) : std::nullopt;
}

std::optional<body::Character> animal_of_species(std::span<const MeasuredMotion> motions, const body::Character& human) {
  constexpr double level = 0.5, mostly = 0.7;  // sine of the inclination of the trunk; share of the frames
  if (motions.size() > 1)
    if (body::Character all = body::recognise_character(joined({motions.begin(), motions.end()})); all.plan == body::BodyPlan::four_legs)
      return all;
  std::size_t count = 0;
  const std::vector<std::vector<Pose>> samples = sample_poses(motions);
  for (const std::vector<Pose>& X : samples) {
    const auto middle = [&](const std::array<body::Limb, 2>& l) {
      return (X[static_cast<std::size_t>(l[0].proximal)].p + X[static_cast<std::size_t>(l[1].proximal)].p) * 0.5;
    };
    count += std::fabs(normalized(middle(human.arms) - middle(human.legs)).z) < level ? 1 : 0;
  }
  if (static_cast<double>(count) <= mostly * static_cast<double>(samples.size())) return std::nullopt;
  body::AnatomyMapping mapping = body::mapping_of(human, motions[0].skeleton);
  mapping.plan = "four legs";
  body::Character animal = body::recognise_character(*std::ranges::max_element(motions, {}, &MeasuredMotion::frames), &mapping);
  animal.corrected = false;
  return animal.plan == body::BodyPlan::four_legs ? std::optional(std::move(animal)) : std::nullopt;
}

}  // namespace ugoki::intake
