#include "ugoki/body/mapping.h"

#include <algorithm>

#include "ugoki/body/joint_names.h"
#include "ugoki/body/recognise.h"

namespace ugoki::body {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

struct SectionPart {
  const char* section;
  Part part;
};
constexpr SectionPart leg_sections[] = {{"thigh", Part::thigh}, {"shank", Part::shank}, {"foot", Part::foot}, {"toes", Part::toes}};
constexpr SectionPart arm_sections[] = {
    {"upper arm", Part::upper_arm}, {"forearm", Part::forearm}, {"hand", Part::hand}, {"fingers", Part::fingers}};

/// Sentence about the evidence of a limb: how many of its sections the joints' names state.
std::string evidence_of(int named, int contradicted, int sections, bool corrected) {
  if (corrected) return "Given by the mapping.";
  std::string out = named == sections ? "All sections by name."
                    : named > 0 ? std::to_string(named) + " of " + std::to_string(sections) + " sections by name, the others by shape."
                    : contradicted > 0 ? "By lengths and movement of the bones, against the joints' names."
                                       : "By lengths and movement of the bones, because the names state nothing.";
  return out;
}

/// The limb with its sections and all joints on its side with one of its parts.
LimbMapping limb_of(const Character& c, const Skeleton& skeleton, std::span<const NameEvidence> names, const Limb& limb, bool leg,
                    int side) {
  LimbMapping out;
  out.name = std::string(side > 0 ? "left " : "right ") + (leg ? "leg" : "arm");
  out.confidence = (leg ? c.leg_confidence : c.arm_confidence)[side > 0 ? 0 : 1];
  const int joints[] = {limb.proximal, limb.distal, limb.end, limb.tip};
  int named = 0, contradicted = 0, present = 0;
  for (std::size_t k = 0; k < 4; ++k) {
    const SectionPart& s = leg ? leg_sections[k] : arm_sections[k];
    const int joint = joints[k];
    out.sections.push_back({s.section, joint >= 0 ? skeleton.joints[at(joint)].name : ""});
    if (joint < 0) continue;
    ++present;
    const NameEvidence& name = names[at(joint)];
    if (name.part == s.part || name.second == s.part)
      ++named;
    else if (name.part != Part::other)
      ++contradicted;
  }
  out.evidence = evidence_of(named, contradicted, present, c.corrected && out.confidence == 1);
  for (std::size_t i = 0; i < c.parts.size(); ++i) {
    const SidedPart& own = c.parts[i];
    const bool of_leg =
        own.part == Part::hip || own.part == Part::thigh || own.part == Part::shank || own.part == Part::foot || own.part == Part::toes;
    const bool of_arm = own.part == Part::shoulder || own.part == Part::upper_arm || own.part == Part::forearm || own.part == Part::hand ||
                        own.part == Part::fingers || own.part == Part::thumb;
    if (own.side == side && (leg ? of_leg : of_arm)) out.joints.push_back(static_cast<int>(i));
  }
  return out;
}

}  // namespace

AnatomyMapping mapping_of(const Character& c, const Skeleton& skeleton) {
  AnatomyMapping out;
  out.plan = c.plan == BodyPlan::human ? "human" : c.plan == BodyPlan::four_legs ? "four legs" : "other";
  out.confidence = c.confidence;
  if (c.pelvis < 0 || c.head < 0 || c.parts.size() != skeleton.joints.size() || c.legs[0].proximal < 0) return out;
  std::vector<std::string> joint_names;
  for (const SkeletonJoint& j : skeleton.joints) joint_names.push_back(j.name);
  const std::vector<NameEvidence> names = read_joint_names(joint_names);
  for (const int side : {1, -1}) {
    out.limbs.push_back(limb_of(c, skeleton, names, c.legs[side > 0 ? 0 : 1], true, side));
    out.limbs.push_back(limb_of(c, skeleton, names, c.arms[side > 0 ? 0 : 1], false, side));
  }
  LimbMapping head;
  head.name = "head";
  head.confidence = c.head_confidence;
  head.sections = {{"head", skeleton.joints[at(c.head)].name}};
  head.evidence = evidence_of(names[at(c.head)].part == Part::head ? 1 : 0, 0, 1, c.corrected && c.head_confidence == 1);
  for (std::size_t i = 0; i < c.parts.size(); ++i)
    if (c.parts[i].part == Part::head || c.parts[i].part == Part::neck) head.joints.push_back(static_cast<int>(i));
  out.limbs.push_back(std::move(head));
  if (!c.tail.empty()) {
    LimbMapping tail;
    tail.name = "tail";
    tail.sections = {{"tail", skeleton.joints[at(c.tail.front())].name}};
    const bool named = names[at(c.tail.front())].tail;
    tail.confidence = named ? 0.98 : 0.6;
    tail.evidence = named ? "By name." : "The longest branch at the pelvis that is neither leg nor spine.";
    tail.joints = c.tail;
    out.limbs.push_back(std::move(tail));
  }
  return out;
}

Error check_mapping(const AnatomyMapping& mapping, const Skeleton& skeleton, const std::string& location) {
  Error errors;
  if (!mapping.plan.empty() && mapping.plan != "human" && mapping.plan != "four legs" && mapping.plan != "other")
    errors.add(ErrorCode::unknown, location + "/plan", "There is no body plan '" + mapping.plan + "'.", "Use human, four legs or other.");
  for (const LimbMapping& l : mapping.limbs) {
    const bool leg = l.name == "left leg" || l.name == "right leg", arm = l.name == "left arm" || l.name == "right arm";
    if (!leg && !arm && l.name != "head" && l.name != "tail") {
      errors.add(ErrorCode::unknown, location + "/limbs", "There is no limb '" + l.name + "'.",
                 "Use left leg, right leg, left arm, right arm, head or tail.");
      continue;
    }
    for (const SectionJoint& s : l.sections) {
      const auto has = [&](const auto& list) {
        return std::ranges::any_of(list, [&](const SectionPart& p) { return s.section == p.section; });
      };
      if (leg ? !has(leg_sections) : arm ? !has(arm_sections) : s.section != l.name)
        errors.add(ErrorCode::unknown, location + "/limbs/" + l.name, "The limb has no section '" + s.section + "'.",
                   leg   ? "Use thigh, shank, foot and toes."
                   : arm ? "Use upper arm, forearm, hand and fingers."
                         : "Use " + l.name + ".");
      else if (!s.joint.empty() && std::ranges::none_of(skeleton.joints, [&](const SkeletonJoint& j) { return j.name == s.joint; }))
        errors.add(ErrorCode::unknown, location + "/limbs/" + l.name + "/" + s.section, "The skeleton has no joint '" + s.joint + "'.",
                   "List its joints with `ugoki info FILE`.");
    }
  }
  return errors;
}

}  // namespace ugoki::body
