#include "ugoki/body/recogniser.h"

namespace ugoki::body {

void Recogniser::find_tail() {
  if (f_.corrected) {
    for (int i = tail_given_; i >= 0; i = heir_[at(i)]) f_.tail.push_back(i);
    return;
  }
  const Branch* tail = nullptr;
  for (const Branch& b : branches_) {
    if (b.from != f_.pelvis && !is_below(b.from, f_.pelvis)) continue;
    if (std::ranges::any_of(b.path, [&](int i) { return f_.parts[at(i)].part != Part::other; })) continue;
    if (f_.parts[at(b.from)].part != Part::pelvis && f_.parts[at(b.from)].part != Part::trunk) continue;
    const bool is_named = std::ranges::any_of(b.path, [&](int i) { return name(i).tail; });
    if (!is_named && (b.from != f_.pelvis || b.length < 0.08 * size_ || b.path.size() < 2)) continue;
    if (!tail || b.length > tail->length) tail = &b;
  }
  if (tail) f_.tail = tail->path;
}

int Recogniser::human_names() const {
  int count = 0;
  for (const std::array<Limb, 2>* limbs : {&f_.legs, &f_.arms})
    for (const Limb& l : *limbs)
      for (const int i : {l.proximal, l.distal, l.end})
        if (i >= 0 && name(i).part != Part::other && name(i).part == f_.parts[at(i)].part) ++count;
  return count;
}

bool Recogniser::stands_on_four() const {
  constexpr double level = 0.5, below = 0.6, near = 0.2, mostly = 0.7;  // sine; shares of the length of a leg; share of the frames
  int count = 0;
  for (int f = 0; f < shape_.frames(); ++f) {
    const auto end_of = [&](const Limb& l) { return shape_.tip(f, end_joint(l)).z; };
    const auto middle = [&](const std::array<Limb, 2>& l) { return (shape_.p(f, l[0].proximal) + shape_.p(f, l[1].proximal)) * 0.5; };
    bool stands = std::fabs(normalized(middle(f_.arms) - middle(f_.legs)).z) < level;
    for (std::size_t s = 0; s < 2; ++s) {
      stands = stands && shape_.p(f, f_.legs[s].proximal).z - end_of(f_.legs[s]) > below * f_.leg_length;
      stands = stands && std::fabs(end_of(f_.arms[s]) - end_of(f_.legs[s])) < near * f_.leg_length;
    }
    count += stands ? 1 : 0;
  }
  return count > mostly * shape_.frames();
}

int Recogniser::end_joint(const Limb& l) const {
  int i = l.tip >= 0 ? l.tip : l.end >= 0 ? l.end : l.distal;
  while (heir_[at(i)] >= 0) i = heir_[at(i)];
  return i;
}

bool Recogniser::comes_down(int joint) const {
  constexpr double near = 0.4, seldom = 0.05;  // share of the length of a leg; share of the frames
  int count = 0;
  for (int f = 0; f < shape_.frames(); ++f) {
    double ground = 1e300;
    for (const std::array<Limb, 2>* limbs : {&f_.legs, &f_.arms})
      for (const Limb& l : *limbs) ground = std::min(ground, shape_.tip(f, end_joint(l)).z);
    count += shape_.tip(f, joint).z < ground + near * f_.leg_length ? 1 : 0;
  }
  return count > seldom * shape_.frames();
}

int Recogniser::more_limbs() const {
  if (human_names() >= 5) return 0;
  const bool on_four = stands_on_four();
  int count = 0;
  std::vector<int> used;
  for (const Pair& p : pairs_) {
    const Branch &a = branches_[at(p.first)], &b = branches_[at(p.second)];
    const Part from = f_.parts[at(p.from)].part;
    if (f_.parts[at(a.first)].part != Part::other || f_.parts[at(b.first)].part != Part::other) continue;
    if ((from != Part::pelvis && from != Part::trunk && from != Part::other) || component_[at(p.from)] != component_[at(f_.pelvis)])
      continue;
    if (a.path.size() < 2 || std::min(a.length, b.length) < 0.55 * f_.leg_length) continue;
    // Two tails, and controls that carry the feet of the limbs, are no limbs.
    const auto is_limb = [&](const Branch& x) {
      return !name(x.first).control && std::ranges::none_of(x.path, [&](int i) { return name(i).tail; });
    };
    if (!is_limb(a) && !is_limb(b)) continue;
    // Bones of the fur and the trunk of an animal that stands on four limbs hang high above the ground, and are not named as limbs.
    const auto is_hanging = [&](const Branch& x) { return named(x, is_leg) + named(x, is_arm) == 0 && !comes_down(x.leaf); };
    if (on_four && is_hanging(a) && is_hanging(b)) continue;
    if (std::ranges::find(used, p.first) != used.end() || std::ranges::find(used, p.second) != used.end()) continue;
    used.insert(used.end(), {p.first, p.second});
    ++count;
  }
  return count;
}

void Recogniser::decide_plan() {
  double upright = 0, legs = 0, trunk = 0;
  for (int f = 0; f < shape_.frames(); ++f) {
    const auto middle = [&](const std::array<Limb, 2>& l) { return (shape_.p(f, l[0].proximal) + shape_.p(f, l[1].proximal)) * 0.5; };
    const Vec3 spine = middle(f_.arms) - middle(f_.legs);
    upright += normalized(spine).z;
    f_.up += normalized(spine) * (0.5 / shape_.frames());
    for (const Limb& l : f_.legs) f_.up += normalized(shape_.p(f, l.proximal) - shape_.p(f, l.end)) * (0.25 / shape_.frames());
    trunk += norm(spine);
  }
  upright /= shape_.frames();
  trunk /= shape_.frames();
  for (const Limb& l : f_.legs) legs += 0.5 * (shape_.distance(l.proximal, l.distal).mean + shape_.distance(l.distal, l.end).mean);
  f_.leg_length = legs;
  f_.trunk_length = trunk;
  if (const int pairs = more_limbs(); pairs > 0) {
    f_.plan = BodyPlan::other;
    f_.why_not = "it has " + std::to_string(4 + 2 * pairs) + " limbs.";
    f_.decisions.push_back("A creature with " + std::to_string(4 + 2 * pairs) + " limbs.");
    f_.confidence = 0.6;
    return;
  }
  const double ratio = legs / std::max(trunk, 1e-9);
  double animal_names = 0;
  for (int i = 0; i < n_; ++i) animal_names += name(i).paw || name(i).hind || name(i).fore ? 1 : 0;
  double animal = 0;
  animal += upright < 0.25 ? 1.3 : upright < 0.5 ? 1 : upright < 0.7 ? 0.4 : -1;
  animal += ratio < 0.95 ? 1 : ratio < 1.2 ? 0.4 : -1;
  double wings = 0;
  for (const Limb& l : f_.arms)
    for (const int i : {l.proximal, l.distal, l.end}) wings += i >= 0 && name(i).wing ? 1 : 0;
  if (wings >= 2) {
    f_.winged = true;
    f_.plan = BodyPlan::other;
    f_.why_not = "it has wings.";
    f_.decisions.push_back("A winged animal, by the joints' names.");
    f_.confidence = 0.6;
    return;
  }
  animal += f_.tail.empty() ? 0 : 0.8;
  animal += animal_names >= 2 ? 1 : 0;
  // Names of front and rear limbs on both sides; a named tail on a character that stands on four limbs.
  int fore = 0, hind = 0;
  for (std::size_t s = 0; s < 2; ++s) {
    const auto states = [&](const Limb& l, bool NameEvidence::* end) {
      return std::ranges::any_of(std::array{l.proximal, l.distal, l.end, l.tip}, [&](int i) { return i >= 0 && name(i).*end; });
    };
    fore += states(f_.arms[s], &NameEvidence::fore) ? 1 : 0;
    hind += states(f_.legs[s], &NameEvidence::hind) ? 1 : 0;
  }
  animal += fore == 2 && hind == 2 && trunk > 0.1 * legs ? 1 : 0;
  // Rigs of Rigify name the hind limbs as legs of a person, but no arm is called a leg in front ("front_thigh.L").
  animal += fore == 2 && hind < 2 && trunk > 0.1 * legs && upright < 0.5 ? 1 : 0;
  const bool named_tail = std::ranges::any_of(f_.tail, [&](int i) { return name(i).tail; });
  animal += (human_names() < 5 || named_tail) && stands_on_four() ? 1.2 : 0;
  // Animals whose joints have human names seldom have fingers. 3ds Max Biped names the toes of fore limbs fingers, but adds a tail.
  int fingers = 0;
  for (const NameEvidence& e : names_) fingers += !e.helper && (e.part == Part::fingers || e.part == Part::thumb) ? 1 : 0;
  animal -= fingers < 4 ? 0 : f_.tail.empty() ? 1.2 : 0.8;
  f_.plan = animal > 1 ? BodyPlan::four_legs : BodyPlan::human;
  const std::string characters = "trunk " + to_fixed(ugoki::acos(std::clamp(upright, -1.0, 1.0)) * 180 / pi, 0) +
                                 " degrees from upright, legs " + to_fixed(ratio, 2) + " trunk lengths" +
                                 (f_.tail.empty() ? "" : ", a tail");
  f_.decisions.push_back((f_.plan == BodyPlan::human ? "A human: " : "A four-legged animal: ") + characters + ".");
  f_.confidence = std::clamp(0.55 + 0.2 * std::fabs(animal - 1) - doubt_, 0.05, 0.99);
}

void Recogniser::mark_rest() {
  for (int i = 0; i < n_; ++i) {
    SidedPart& own = f_.parts[at(i)];
    if (own.part != Part::other) continue;
    const int p = parent(i);
    if (p < 0 || !is_below(i, f_.pelvis)) continue;
    own = f_.parts[at(p)];
    // A branch at the hand or the forearm is a finger.
    if (own.part == Part::hand || own.part == Part::forearm) own.part = Part::fingers;
    if (own.part == Part::foot) own.part = Part::toes;
  }
  for (int side = 0; side < 2; ++side) find_thumb(side);
  for (int i = 0; i < n_; ++i) {
    SidedPart& own = f_.parts[at(i)];
    if (own.part == Part::fingers && name(i).part == Part::thumb) own.part = Part::thumb;
    const int p = parent(i);
    if (own.part == Part::fingers && p >= 0 && f_.parts[at(p)].part == Part::thumb) own.part = Part::thumb;
  }
}

void Recogniser::find_thumb(int side) {
  const int sign = side == 0 ? 1 : -1, wrist = f_.arms[at(side)].end;
  if (wrist < 0) return;
  std::vector<int> fingers, tips;
  for (int i = 0; i < n_; ++i) {
    const SidedPart own = f_.parts[at(i)];
    if (own.side != sign || own.part != Part::fingers || ignored(i)) continue;
    if (name(i).part == Part::thumb) return;
    const int p = parent(i);
    const bool begins = f_.parts[at(p)].part == Part::hand || f_.parts[at(p)].part == Part::forearm;
    if (!begins) continue;
    int tip = i;
    while (heir_[at(tip)] >= 0) tip = heir_[at(tip)];
    fingers.push_back(i);
    tips.push_back(tip);
  }
  if (fingers.size() < 2) return;
  const std::size_t thumb = find_thumb_among(shape_, f_.arms[at(side)], tips);
  for (int i = 0; i < n_; ++i)
    if (is_below(i, fingers[thumb]) && f_.parts[at(i)].part == Part::fingers) f_.parts[at(i)].part = Part::thumb;
}

void Recogniser::find_helpers() {
  for (int i = 0; i < n_; ++i)
    if (is_below(i, f_.pelvis) && ignored(i)) f_.helper[at(i)] = 1;
}

void Recogniser::find_head() {
  for (const int i : f_.neck) f_.parts[at(i)] = {Part::neck, 0};
  int head = head_given_;
  for (const int i : f_.neck)
    if (head < 0 && name(i).part == Part::head && !name(i).helper) {
      head = i;
      break;
    }
  if (head < 0) {
    // Without a name, the head is the last joint that carries a bone. An end without a bone is the top of the head.
    const bool end = m_.skeleton.joints[at(f_.neck.back())].end_sites.empty() && f_.neck.size() > 1;
    head = end ? f_.neck[f_.neck.size() - 2] : f_.neck.back();
  }
  while (f_.neck.back() != head) {
    f_.parts[at(f_.neck.back())] = {Part::head, 0};
    f_.neck.pop_back();
  }
  f_.head = head;
  f_.parts[at(head)] = {Part::head, 0};
}

void Recogniser::choose_sides(Branch (&legs)[2], Branch (&arms)[2], Sections (&leg_parts)[2], Sections (&arm_parts)[2]) {
  double names = 0;
  for (int s = 0; s < 2; ++s) names += (s == 0 ? 1 : -1) * (named_side(legs[s]) + named_side(arms[s]));
  // Arms and legs get the same order: the first arm is on the side of the first leg.
  double same = 0;
  for (int f = 0; f < shape_.frames(); ++f) {
    const Vec3 hips = shape_.p(f, legs[0].path[at(leg_parts[0].upper)]) - shape_.p(f, legs[1].path[at(leg_parts[1].upper)]);
    const Vec3 shoulders = shape_.p(f, arms[0].path[at(arm_parts[0].upper)]) - shape_.p(f, arms[1].path[at(arm_parts[1].upper)]);
    same += dot(normalized(hips), normalized(shoulders));
  }
  const double arm_names = named_side(arms[0]) - named_side(arms[1]), leg_names = named_side(legs[0]) - named_side(legs[1]);
  const bool cross_arms = arm_names != 0 && leg_names != 0 ? arm_names * leg_names < 0 : same < 0;
  if (cross_arms) {
    std::swap(arms[0], arms[1]);
    std::swap(arm_parts[0], arm_parts[1]);
    names = 0;
    for (int s = 0; s < 2; ++s) names += (s == 0 ? 1 : -1) * (named_side(legs[s]) + named_side(arms[s]));
  }
  // By the shape, left is up x forward; forward is the direction in which feet point and knees bend.
  const double shape = facing_of(shape_, legs, leg_parts, size_);
  if (std::fabs(names) > 0.5) {
    if (names < 0) swap_sides(legs, arms, leg_parts, arm_parts);
    const double agrees = names < 0 ? -shape : shape;
    if (agrees < -0.8) {
      f_.decisions.push_back("The names of left and right contradict the direction of feet and knees; the names were followed.");
      doubt_ += 0.2;
    }
    side_confidence_ = agrees < -0.8 ? 0.7 : 0.99;
    f_.decisions.push_back("Left and right: by the joints' names.");
  } else {
    if (shape < 0) swap_sides(legs, arms, leg_parts, arm_parts);
    f_.decisions.push_back("Left and right: by the direction of feet and knees, because the names do not state them.");
    doubt_ += std::fabs(shape) < 0.3 ? 0.3 : 0.1;
    side_confidence_ = 0.5 + 0.48 * std::min(1.0, std::fabs(shape));
  }
}

}  // namespace ugoki::body
