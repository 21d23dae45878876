#include "ugoki/body/recogniser.h"

namespace ugoki::body {

void Recogniser::apply_correction() {
  std::array<Limb, 2> legs, arms;
  for (std::size_t s = 0; s < 2; ++s) {
    const std::string side = s == 0 ? "left " : "right ";
    legs[s] = corrected(f_.legs[s], side + "leg", true);
    arms[s] = corrected(f_.arms[s], side + "arm", false);
  }
  int head = f_.head, tail = f_.tail.empty() ? -1 : f_.tail.front();
  for (const auto& [name, joint] : {std::pair<const char*, int*>{"head", &head}, {"tail", &tail}})
    if (const LimbMapping* given = correction_->find(name); given && !given->sections.empty())
      *joint = joint_named(given->sections.front().joint);
  const Character recognised = f_;
  f_ = {};
  f_.parts.assign(at(n_), {});
  f_.helper.assign(at(n_), 0);
  f_.free = recognised.free;
  f_.corrected = true;
  tail_given_ = tail;
  rebuild(legs, arms, head);
  f_.decisions.push_back("The limbs are those of the mapping.");
  f_.leg_confidence = recognised.leg_confidence;
  f_.arm_confidence = recognised.arm_confidence;
  f_.head_confidence = recognised.head_confidence;
  for (const LimbMapping& l : correction_->limbs) {
    const std::size_t s = l.name.starts_with("right") ? 1 : 0;
    if (l.name.ends_with("leg")) f_.leg_confidence[s] = 1;
    if (l.name.ends_with("arm")) f_.arm_confidence[s] = 1;
    if (l.name == "head") f_.head_confidence = 1;
  }
}

int Recogniser::joint_named(const std::string& wanted) const {
  for (int i = 0; i < n_ && !wanted.empty(); ++i)
    if (m_.skeleton.joints[at(i)].name == wanted) return i;
  return -1;
}

Limb Recogniser::corrected(Limb limb, const std::string& limb_name, bool leg) const {
  const LimbMapping* given = correction_->find(limb_name);
  if (given == nullptr) return limb;
  for (const SectionJoint& s : given->sections) {
    const auto set = [&](const char* section, int& joint) {
      if (s.section == section) joint = joint_named(s.joint);
    };
    set(leg ? "thigh" : "upper arm", limb.proximal);
    set(leg ? "shank" : "forearm", limb.distal);
    set(leg ? "foot" : "hand", limb.end);
    set(leg ? "toes" : "fingers", limb.tip);
  }
  return limb;
}

void Recogniser::rebuild(const std::array<Limb, 2>& legs, const std::array<Limb, 2>& arms, int head) {
  for (const Limb& l : legs)
    if (l.proximal < 0 || l.distal < 0 || l.end < 0) {
      f_.why_not = "the mapping leaves a leg without thigh, shank or foot.";
      return;
    }
  for (const Limb& l : arms)
    if (l.proximal < 0 || l.distal < 0) {
      f_.why_not = "the mapping leaves an arm without upper arm or forearm.";
      return;
    }
  if (head < 0) {
    f_.why_not = "the mapping leaves the body without a head.";
    return;
  }
  f_.pelvis = common_ancestor(parent(legs[0].proximal), parent(legs[1].proximal));
  f_.chest = common_ancestor(common_ancestor(parent(arms[0].proximal), parent(arms[1].proximal)), parent(head));
  if (f_.pelvis < 0 || f_.chest < 0 || f_.chest == f_.pelvis || !is_below(f_.chest, f_.pelvis)) {
    f_.why_not = "legs, arms and head of the mapping are not on a common spine with the pelvis at its lower end.";
    f_.pelvis = f_.chest = -1;
    return;
  }
  Branch branches[4];
  Sections sections[4];
  for (std::size_t k = 0; k < 4; ++k) {
    const Limb& l = k < 2 ? legs[k] : arms[k - 2];
    Branch& b = branches[k];
    b.from = k < 2 ? f_.pelvis : f_.chest;
    b.leaf = l.tip >= 0 ? l.tip : l.end >= 0 ? l.end : l.distal;
    while (heir_[at(b.leaf)] >= 0) b.leaf = heir_[at(b.leaf)];
    b.path = path_below(b.from, b.leaf);
    b.first = b.path.empty() ? -1 : b.path.front();
    const auto place = [&](int joint) {
      const auto found = std::ranges::find(b.path, joint);
      return joint < 0 || found == b.path.end() ? -1 : static_cast<int>(found - b.path.begin());
    };
    Sections& s = sections[k];
    s = {place(l.proximal), place(l.distal), place(l.end), place(l.tip), 0};
    if (!(s.upper >= 0 && s.lower > s.upper && (l.end < 0 || s.end > s.lower) && (l.tip < 0 || s.tip > s.end))) {
      f_.why_not = "the sections of a limb in the mapping do not follow each other from the trunk outwards.";
      f_.pelvis = f_.chest = -1;
      return;
    }
  }
  Branch skull;
  skull.leaf = head;
  while (heir_[at(skull.leaf)] >= 0) skull.leaf = heir_[at(skull.leaf)];
  head_given_ = head;
  assemble({branches[0], branches[1]}, {branches[2], branches[3]}, {sections[0], sections[1]}, {sections[2], sections[3]}, skull);
}

void Recogniser::apply_plan() {
  const std::string& plan = correction_->plan;
  const bool limbs = f_.pelvis >= 0 && f_.head >= 0;
  if (plan == "other") {
    f_.plan = BodyPlan::other;
    f_.why_not = "the mapping states another body plan.";
  } else if (limbs && f_.leg_length > 0) {
    f_.plan = plan == "human" ? BodyPlan::human : BodyPlan::four_legs;
    f_.why_not.clear();
    f_.winged = false;
  } else {
    return;
  }
  f_.corrected = true;
  f_.confidence = 1;
  f_.decisions.push_back("The body plan is that of the mapping.");
}

}  // namespace ugoki::body
