#pragma once
// Recognition of the character in one motion. Internal to body: recognise.cpp finds the limbs, recognise_parts.cpp names their parts, and
// recognise_correction.cpp applies corrections of the caller.

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <span>

#include "ugoki/base/number.h"
#include "ugoki/body/joint_names.h"
#include "ugoki/body/limb_geometry.h"
#include "ugoki/body/motion_shape.h"
#include "ugoki/body/recognise.h"
#include "ugoki/spatial/elementary.h"

namespace ugoki::body {

/// Finds limbs, parts and plan of a character. run() is called once.
class Recogniser {
 public:
  Recogniser(const MeasuredMotion& m, const AnatomyMapping* correction) : m_(m), correction_(correction), n_(m.joint_count()), shape_(m) {
    std::vector<std::string> names;
    for (const SkeletonJoint& j : m.skeleton.joints) names.push_back(j.name);
    names_ = read_joint_names(names);
  }

  Character run() {
    f_.parts.assign(at(n_), {});
    f_.helper.assign(at(n_), 0);
    for (int i = 0; i < n_; ++i) f_.free.push_back(shape_.is_free(i) ? 1 : 0);
    if (n_ == 0 || m_.frames == 0) {
      f_.why_not = "there are no joints or no frames.";
      return std::move(f_);
    }
    find_branches();
    choose_limbs();
    if (correction_ && !correction_->limbs.empty()) apply_correction();
    if (correction_ && !correction_->plan.empty()) apply_plan();
    return std::move(f_);
  }

 private:
  static std::size_t at(int i) { return static_cast<std::size_t>(i); }
  static double square(double x) { return x * x; }
  [[nodiscard]] int parent(int i) const { return m_.skeleton.joints[at(i)].parent; }
  [[nodiscard]] const NameEvidence& name(int i) const { return names_[at(i)]; }
  [[nodiscard]] bool is_below(int i, int ancestor) const {
    for (; i >= 0; i = parent(i))
      if (i == ancestor) return true;
    return false;
  }
  [[nodiscard]] int common_ancestor(int i, int j) const {
    for (; i >= 0; i = parent(i))
      if (is_below(j, i)) return i;
    return -1;
  }
  /// Joints from the descendant `to` up to `from` (excluded), in order from `from`.
  [[nodiscard]] std::vector<int> path_below(int from, int to) const {
    std::vector<int> path;
    for (int i = to; i >= 0 && i != from; i = parent(i)) path.push_back(i);
    std::reverse(path.begin(), path.end());
    return path;
  }

  /// Finds the longest path below each joint, and the branches that are long enough for a limb. Helper joints begin no branch.
  void find_branches() {
    const auto n = at(n_);
    find_driving_controls();
    find_ignored();
    down_.assign(n, 0);
    heir_.assign(n, -1);
    for (int i = n_ - 1; i >= 0; --i) {
      for (const Vec3& e : m_.skeleton.joints[at(i)].end_sites) down_[at(i)] = std::max(down_[at(i)], heir_[at(i)] < 0 ? norm(e) : 0.0);
      const int p = parent(i);
      if (p >= 0 && !shape_.is_free(i) && ignored(i) && name(i).end && heir_[at(p)] < 0)
        down_[at(p)] = std::max(down_[at(p)], shape_.bone_length(i));  // joint i is the end of its parent's bone
      if (p < 0 || shape_.is_free(i) || ignored(i)) continue;
      const double d = shape_.bone_length(i) + down_[at(i)];
      if (d > down_[at(p)] || heir_[at(p)] < 0) {
        down_[at(p)] = std::max(d, down_[at(p)]);
        heir_[at(p)] = i;
      }
    }
    for (int i = 0; i < n_; ++i) component_.push_back(parent(i) < 0 || shape_.is_free(i) ? i : component_[at(parent(i))]);
    size_ = 0;
    for (int i = 0; i < n_; ++i) {
      double first = 0, second = 0;
      for (const int c : shape_.children(i)) {
        if (shape_.is_free(c) || ignored(c)) continue;
        const double d = shape_.bone_length(c) + down_[at(c)];
        if (d > first) {
          second = first;
          first = d;
        } else {
          second = std::max(second, d);
        }
      }
      size_ = std::max(size_, first + second);
    }
    for (int i = 0; i < n_; ++i)
      for (const int c : shape_.children(i)) {
        if (shape_.is_free(c) || ignored(c)) continue;
        Branch b;
        b.from = i;
        b.first = c;
        b.length = shape_.bone_length(c) + down_[at(c)];
        const bool head = name(c).part == Part::head || name(c).part == Part::neck;
        if (b.length < (head ? 0.005 : 0.04) * size_) continue;
        for (int k = c; k >= 0; k = heir_[at(k)]) b.path.push_back(k);
        b.leaf = b.path.back();
        branches_.push_back(std::move(b));
      }
  }

  /// Counts controls of inverse kinematics that are part of a limb as joints of it: the control stays at the end of its parent's bone, has
  /// a bone of its own, and the parent has no other child. (Rigs of games have a paw "IKBackLeg.L" with the toes, or with the mesh of the
  /// hoof, and no other joint there.)
  void find_driving_controls() {
    // Shares of the bone's length, of the frames, and of the length of the parent's bone. In animations of games a limb does not reach the
    // control in up to a fifth of the frames.
    constexpr double rigid = 0.03, reached = 0.75, shortest = 0.1;
    for (int i = 0; i < n_; ++i) {
      const int p = parent(i);
      const bool carries = !shape_.children(i).empty() || !m_.skeleton.joints[at(i)].end_sites.empty();
      if (!name(i).control || p < 0 || !carries || shape_.children(p).size() != 1) continue;
      const double length = shape_.bone_length(i);
      if (length < shortest * shape_.bone_length(p)) continue;
      int near = 0;
      for (int f = 0; f < shape_.frames(); ++f) near += std::fabs(norm(shape_.p(f, i) - shape_.p(f, p)) - length) < rigid * length ? 1 : 0;
      if (near < reached * shape_.frames()) continue;
      names_[at(i)].helper = names_[at(i)].control = false;
      names_[at(i)].part = Part::other;
    }
  }

  /// True if joint i has the name of a helper joint (twist, end, hair, face) and no descendant has the name of a body part.
  [[nodiscard]] bool ignored(int i) const { return ignored_[at(i)] != 0; }
  void find_ignored() {
    std::vector<char> named_below(at(n_), 0);  // 1: a descendant has the name of a body part
    ignored_.assign(at(n_), 0);
    for (int i = n_ - 1; i >= 0; --i) {
      ignored_[at(i)] = name(i).helper && named_below[at(i)] == 0 ? 1 : 0;
      const bool part = !name(i).helper && name(i).part != Part::other;
      if (parent(i) >= 0 && (part || named_below[at(i)] != 0)) named_below[at(parent(i))] = 1;
    }
  }

  /// Number of joints of a branch whose named part passes `test`; a helper counts 0.3; at most 3.
  template <class Test>
  [[nodiscard]] double named(const Branch& b, const Test& test) const {
    double sum = 0;
    for (const int i : b.path)
      if (test(name(i).part)) sum += name(i).helper ? 0.3 : 1;
    return std::min(3.0, sum);
  }
  /// Number of joints of a branch with the name of a hind limb, less those with the name of a fore limb; at most 3.
  [[nodiscard]] double hind(const Branch& b) const {
    double sum = 0;
    for (const int i : b.path) sum += (name(i).hind ? 1 : 0) - (name(i).fore ? 1 : 0);
    return std::clamp(sum, -3.0, 3.0);
  }
  [[nodiscard]] double named_side(const Branch& b) const {
    double sum = 0;
    for (const int i : b.path) sum += name(i).side;
    return std::clamp(sum, -2.0, 2.0);
  }

  /// Finds the pairs of similar branches of one joint. For joints with very many branches (stars, hair) only the longest branches and the
  /// best pairs are kept, so that the cost of choose_limbs() is bounded.
  void find_pairs() {
    constexpr std::size_t max_branches = 64, max_pairs = 200;  // of one joint; pelvis and chest of public rigs have at most 30 branches
    for (std::size_t begin = 0, end = 0; begin < branches_.size(); begin = end) {  // the branches of a joint follow each other
      while (end < branches_.size() && branches_[end].from == branches_[begin].from) ++end;
      std::vector<std::size_t> of_joint(end - begin);
      std::iota(of_joint.begin(), of_joint.end(), begin);
      const auto longer = [&](std::size_t a, std::size_t b) {
        return branches_[a].length != branches_[b].length ? branches_[a].length > branches_[b].length : a < b;
      };
      if (of_joint.size() > max_branches) {
        std::ranges::sort(of_joint, longer);
        of_joint.resize(max_branches);
        std::ranges::sort(of_joint);
      }
      const std::size_t first = pairs_.size();
      find_pairs_of(of_joint);
      keep_best_pairs(first, max_pairs);
    }
    keep_best_pairs(0, static_cast<std::size_t>(std::sqrt(3e7 / static_cast<double>(branches_.size() + 1))));
  }
  /// Keeps at most `count` of the pairs with index `first` and above: those with the best scores, in the same order.
  void keep_best_pairs(std::size_t first, std::size_t count) {
    if (pairs_.size() - first <= count) return;
    std::vector<double> scores;
    for (std::size_t i = first; i < pairs_.size(); ++i) scores.push_back(pairs_[i].score);
    std::ranges::nth_element(scores, scores.begin() + static_cast<std::ptrdiff_t>(count), std::greater());
    const double limit = scores[count];
    std::size_t better = count;  // number of pairs at the limit that are kept
    for (std::size_t i = first; i < pairs_.size(); ++i) better -= pairs_[i].score > limit ? 1 : 0;
    const auto tail = std::remove_if(pairs_.begin() + static_cast<std::ptrdiff_t>(first), pairs_.end(), [&](const Pair& p) {
      if (p.score > limit) return false;
      return p.score < limit || better == 0 || (--better, false);
    });
    pairs_.erase(tail, pairs_.end());
  }
  void find_pairs_of(std::span<const std::size_t> of_joint) {
    for (const std::size_t k : of_joint)
      for (const std::size_t l : of_joint) {
        if (l <= k) continue;
        const Branch &a = branches_[k], &b = branches_[l];
        const double unlike = std::fabs(a.length - b.length) / (a.length + b.length);
        const double sides = named_side(a) * named_side(b);  // below 0: one left, one right
        if (unlike > (sides < 0 ? 0.15 : 0.06)) continue;
        const auto middle = [&](const Branch& x) {
          return std::ranges::any_of(x.path, [&](int i) { return (is_middle(name(i).part) && !name(i).helper) || name(i).tail; });
        };
        double score = 2 - 20 * unlike - 0.1 * std::fabs(static_cast<double>(a.path.size()) - static_cast<double>(b.path.size()));
        score += sides < 0 ? 2 : sides > 0 ? -3 : 0;
        if (middle(a) || middle(b)) score -= 3;
        pairs_.push_back({a.from, static_cast<int>(k), static_cast<int>(l), score});
      }
  }

  /// Mean height [m] of a joint over the sampled frames.
  [[nodiscard]] double mean_height(int i) const {
    double sum = 0;
    for (int f = 0; f < shape_.frames(); ++f) sum += shape_.p(f, i).z;
    return sum / shape_.frames();
  }

  /// Chooses legs, arms and head: the combination of two pairs and a single branch with the best evidence.
  void choose_limbs() {
    find_pairs();
    double best = -1e9;
    int best_legs = -1, best_arms = -1, best_head = -1;
    for (std::size_t l = 0; l < pairs_.size(); ++l)
      for (std::size_t a = 0; a < pairs_.size(); ++a) {
        const Pair &legs = pairs_[l], &arms = pairs_[a];
        if (legs.from == arms.from || l == a || component_[at(legs.from)] != component_[at(arms.from)]) continue;
        const Branch &leg = branches_[at(legs.first)], &arm = branches_[at(arms.first)];
        const Branch &leg2 = branches_[at(legs.second)], &arm2 = branches_[at(arms.second)];
        // A limb must not carry the other pair.
        if (is_below(arms.from, leg.first) || is_below(arms.from, leg2.first)) continue;
        if (is_below(legs.from, arm.first) || is_below(legs.from, arm2.first)) continue;
        double score = legs.score + arms.score;
        score += 1.2 * (named(leg, is_leg) + named(leg2, is_leg) - named(leg, is_arm) - named(leg2, is_arm));
        score += 1.2 * (named(arm, is_arm) + named(arm2, is_arm) - named(arm, is_leg) - named(arm2, is_leg));
        score += 0.6 * (hind(leg) + hind(leg2) - hind(arm) - hind(arm2));
        const double ratio = leg.length / arm.length;
        score -= 3 * square(ugoki::log(ratio / 1.15) / ugoki::log(2.0));
        score += 6 * std::min(0.5, (leg.length + arm.length) / size_);
        score += is_below(arms.from, legs.from) ? 1.4 : 0;
        const double height =
            (mean_height(arm.leaf) + mean_height(arm2.leaf) - mean_height(leg.leaf) - mean_height(leg2.leaf)) / (leg.length + leg2.length);
        score += 2 * std::clamp(2 * height, -1.0, 1.0);
        int head = -1;
        double head_score = -1e9;
        for (std::size_t h = 0; h < branches_.size(); ++h) {
          const double s = score_head(static_cast<int>(h), legs, arms);
          if (s > head_score) {
            head_score = s;
            head = static_cast<int>(h);
          }
        }
        if (head_score < -3) head = -1;
        score += head < 0 ? -6 : head_score;
        choices_.push_back({static_cast<int>(l), static_cast<int>(a), head, score});
        if (score > best) {
          best = score;
          best_legs = static_cast<int>(l);
          best_arms = static_cast<int>(a);
          best_head = head;
        }
      }
    if (best_legs < 0) {
      f_.why_not = pairs_.empty() ? "it has no pair of similar limbs." : "it has no two pairs of similar limbs that can be legs and arms.";
      return;
    }
    const Pair legs = pairs_[at(best_legs)], arms = pairs_[at(best_arms)];
    f_.pelvis = legs.from;
    if (best_head < 0) {
      f_.why_not = "no head was found above two arms.";
      return;
    }
    const Branch& head = branches_[at(best_head)];
    if (!is_below(arms.from, f_.pelvis)) {
      f_.chest = arms.from;
      f_.why_not = "the legs are not attached below the arms.";
      return;
    }
    f_.chest = common_ancestor(arms.from, head.leaf);
    if (f_.chest < 0 || !is_below(f_.chest, f_.pelvis) || f_.chest == f_.pelvis) {
      f_.why_not = "head and arms are not on a common spine.";
      return;
    }
    chosen_ = {best_legs, best_arms, best_head, best};
    build(legs, arms, head);
  }

  /// Probability that the right choice passes `test`, if the scores of the choices are log-likelihoods.
  template <class Test>
  [[nodiscard]] double share_of_choices(const Test& test) const {
    double with = 0, all = 0;
    for (const Choice& c : choices_) {
      const double p = ugoki::exp(c.score - chosen_.score);
      all += p;
      with += test(c) ? p : 0;
    }
    return all > 0 ? with / all : 0;
  }

  /// Score of branch h as neck and head; higher is better.
  [[nodiscard]] double score_head(int h, const Pair& legs, const Pair& arms) const {
    const Branch& b = branches_[at(h)];
    if (h == legs.first || h == legs.second || h == arms.first || h == arms.second) return -1e9;
    if (component_[at(b.from)] != component_[at(legs.from)]) return -1e9;
    if (is_below(arms.from, b.first) || is_below(legs.from, b.first)) return -1e9;
    for (const int limb : {legs.first, legs.second, arms.first, arms.second})
      if (is_below(b.first, branches_[at(limb)].first)) return -1e9;
    double score = 0;
    for (const int i : b.path)
      if (name(i).part == Part::head || name(i).part == Part::neck) score = 3;
    for (const int i : b.path)
      if (name(i).tail || is_leg(name(i).part) || is_arm(name(i).part) || name(i).wing) score = -3;
    // The head is close to the arms along the spine.
    const int common = common_ancestor(b.from, arms.from);
    double to_arms = 0;
    for (int i = arms.from; i >= 0 && i != common; i = parent(i)) to_arms += shape_.bone_length(i);
    for (int i = b.from; i >= 0 && i != common; i = parent(i)) to_arms += shape_.bone_length(i);
    const double arm = branches_[at(arms.first)].length;
    score -= 4 * to_arms / arm;
    score -= b.from == legs.from && legs.from != arms.from ? 4 : 0;
    score -= square(ugoki::log(b.length / (0.5 * arm)) / ugoki::log(2.5));
    // The head has no similar branch beside it.
    for (const Branch& other : branches_)
      if (other.from == b.from && other.first != b.first && std::fabs(other.length - b.length) < 0.03 * b.length &&
          other.path.size() == b.path.size())
        score -= 3;
    if (std::fabs(named_side(b)) >= 1) score -= 1.5;
    return score;
  }

  /// Length [m] of the farthest end site of a branch's last joint.
  [[nodiscard]] double tip_length(const Branch& b) const {
    double length = 0;
    for (const Vec3& e : m_.skeleton.joints[at(b.leaf)].end_sites) length = std::max(length, norm(e));
    for (const int c : shape_.children(b.leaf))
      if (name(c).end) length = std::max(length, shape_.bone_length(c));
    return length;
  }
  /// Score of the agreement between a joint's name and the wanted part; higher is better.
  [[nodiscard]] double fits(int joint, Part wanted) const {
    const NameEvidence& e = name(joint);
    if (e.helper) return -4;
    if (e.part == Part::other) return 0;
    if (e.part == wanted) return e.weak ? 2.4 : 3;
    return e.second == wanted ? 1.2 : -2;
  }

  /// Cost of dividing a limb at the joints u, l, e of its path. The cost depends on the lengths of the bones, their constancy in the
  /// motion, the joints' names, and usual proportions. If e is the size of the path, the limb ends at the tip of its last bone.
  [[nodiscard]] double division_cost(const Branch& b, bool leg, int u, int l, int e) const {
    const int count = static_cast<int>(b.path.size());
    const auto path = [&](int k) { return b.path[at(k)]; };
    const double tip = tip_length(b);
    const bool ends = e == count;
    const double upper = shape_.distance(path(u), path(l)).mean;
    const double lower = ends ? tip + shape_.distance(path(l), b.leaf).mean : shape_.distance(path(l), path(e)).mean;
    const double both = upper + lower;
    if (upper < 0.02 * size_ || lower < 0.02 * size_) return 1e9;
    double rest = ends ? 0 : tip;
    for (int k = e + 1; k < count; ++k) rest += shape_.bone_length(path(k));
    double stub = 0;
    for (int k = 0; k <= u; ++k) stub += shape_.bone_length(path(k));
    double cost = square(ugoki::log(upper / lower / (leg ? 1.0 : 1.2)) / 0.25);
    cost += 0.5 * square((rest / both - (leg ? 0.27 : 0.33)) / 0.2);
    cost += 0.5 * square((stub / both - (leg ? 0.2 : 0.35)) / 0.25);
    if (ends) cost += 3;
    cost -= fits(path(u), leg ? Part::thigh : Part::upper_arm) + fits(path(l), leg ? Part::shank : Part::forearm);
    if (!ends) cost -= fits(path(e), leg ? Part::foot : Part::hand);
    // The distance between the two ends of a section is constant in the motion; a chain that bends or stretches is more than one section.
    cost += 60 * shape_.distance(path(u), path(l)).spread / upper;
    if (!ends) cost += 60 * shape_.distance(path(l), path(e)).spread / lower;
    return cost;
  }

  /// Divides limbs into their sections. Two limbs with equal numbers of joints are divided at the same joints.
  [[nodiscard]] Sections divide(std::span<const Branch* const> limbs, bool leg) const {
    const int count = static_cast<int>(limbs[0]->path.size());
    Sections best;
    std::vector<double> costs;
    for (int u = 0; u < count; ++u)
      for (int l = u + 1; l < count; ++l)
        for (int e = l + 1; e <= (leg ? count - 1 : count); ++e) {
          double cost = 0;
          for (const Branch* b : limbs) cost += division_cost(*b, leg, u, l, e);
          costs.push_back(cost);
          if (cost < best.cost) best = {u, l, e == count ? -1 : e, -1, cost};
        }
    // Costs are squared deviations in units of their standard deviations, so half of a cost is a negative log-likelihood.
    double sum = 0;
    for (const double c : costs) sum += ugoki::exp(0.5 * (best.cost - c) / static_cast<double>(limbs.size()));
    best.confidence = sum > 0 ? 1 / sum : 0;
    return best;
  }
  void divide_both(const Branch (&limbs)[2], bool leg, Sections (&out)[2]) const {
    const Branch* both[2] = {&limbs[0], &limbs[1]};
    if (limbs[0].path.size() == limbs[1].path.size()) {
      out[0] = out[1] = divide(both, leg);
    } else {
      for (int s = 0; s < 2; ++s) out[s] = divide(std::span(both).subspan(at(s), 1), leg);
    }
    for (int s = 0; s < 2; ++s)
      for (int k = out[s].end + 1; out[s].end >= 0 && k < static_cast<int>(limbs[s].path.size()); ++k)
        if (shape_.distance(limbs[s].path[at(out[s].end)], limbs[s].path[at(k)]).mean > 0.008 * size_) {
          out[s].tip = k;
          break;
        }
  }

  /// Sets the parts of a limb's joints.
  Limb mark(const Branch& b, const Sections& s, bool leg, int side) {
    Limb limb;
    for (int k = 0; k < static_cast<int>(b.path.size()); ++k) {
      const int i = b.path[at(k)];
      Part part = leg ? Part::hip : Part::shoulder;
      if (k >= s.upper) part = leg ? Part::thigh : Part::upper_arm;
      if (k >= s.lower) part = leg ? Part::shank : Part::forearm;
      if (s.end >= 0 && k >= s.end) part = leg ? Part::foot : Part::hand;
      if (s.end >= 0 && k > s.end) part = leg ? Part::toes : Part::fingers;
      f_.parts[at(i)] = {part, side};
      if (k == s.upper) limb.proximal = i;
      if (k == s.lower) limb.distal = i;
      if (k == s.end) limb.end = i;
      if (k == (leg ? s.tip : s.end >= 0 && s.end + 1 < static_cast<int>(b.path.size()) ? s.end + 1 : -1)) limb.tip = i;
    }
    if (leg && limb.tip < 0 && s.end >= 0 && s.end + 1 < static_cast<int>(b.path.size())) limb.tip = b.path[at(s.end + 1)];
    return limb;
  }

  void build(const Pair& leg_pair, const Pair& arm_pair, const Branch& head) {
    // Limbs reach to the joint that carries head and arms.
    const auto from_chest = [&](const Branch& b) {
      Branch out = b;
      out.path = path_below(f_.chest, b.leaf);
      out.from = f_.chest;
      return out;
    };
    Branch legs[2] = {branches_[at(leg_pair.first)], branches_[at(leg_pair.second)]};
    Branch arms[2] = {from_chest(branches_[at(arm_pair.first)]), from_chest(branches_[at(arm_pair.second)])};
    Sections leg_parts[2], arm_parts[2];
    divide_both(legs, true, leg_parts);
    divide_both(arms, false, arm_parts);
    if (leg_parts[0].upper < 0 || leg_parts[1].upper < 0) {
      f_.why_not = "a leg has no thigh, shank and foot.";
      return;
    }
    if (arm_parts[0].upper < 0 || arm_parts[1].upper < 0) {
      f_.why_not = "an arm has no upper arm and forearm.";
      return;
    }
    choose_sides(legs, arms, leg_parts, arm_parts);
    const double pair_of_legs = share_of_choices([&](const Choice& c) { return c.legs == chosen_.legs; });
    const double pair_of_arms = share_of_choices([&](const Choice& c) { return c.arms == chosen_.arms; });
    for (int s = 0; s < 2; ++s) {
      f_.leg_confidence[at(s)] = pair_of_legs * leg_parts[s].confidence * side_confidence_;
      f_.arm_confidence[at(s)] = pair_of_arms * arm_parts[s].confidence * side_confidence_;
    }
    f_.head_confidence = share_of_choices([&](const Choice& c) { return c.head == chosen_.head; });
    assemble(legs, arms, leg_parts, arm_parts, head);
  }

  /// Sets the parts of a body whose pelvis, chest, limbs and sides are known.
  void assemble(const Branch (&legs)[2], const Branch (&arms)[2], const Sections (&leg_parts)[2], const Sections (&arm_parts)[2],
                const Branch& head) {
    f_.trunk.push_back(f_.pelvis);
    for (const int i : path_below(f_.pelvis, f_.chest)) f_.trunk.push_back(i);
    for (int i = parent(f_.pelvis); i >= 0; i = parent(i)) f_.root_path.push_back(i);
    std::reverse(f_.root_path.begin(), f_.root_path.end());
    for (const int i : f_.trunk) f_.parts[at(i)] = {i == f_.pelvis ? Part::pelvis : Part::trunk, 0};
    f_.neck = path_below(f_.chest, head.leaf);
    find_head();
    for (int s = 0; s < 2; ++s) {
      f_.legs[at(s)] = mark(legs[s], leg_parts[s], true, s == 0 ? 1 : -1);
      f_.arms[at(s)] = mark(arms[s], arm_parts[s], false, s == 0 ? 1 : -1);
    }
    find_tail();
    decide_plan();
    mark_rest();
    find_helpers();
  }

  [[nodiscard]] int joint_named(const std::string& wanted) const;

  /// The recognised joints of a limb, with the joints that the correction names in place of the recognised ones.
  [[nodiscard]] Limb corrected(Limb limb, const std::string& limb_name, bool leg) const;

  /// Rebuilds the character with the sections that the caller names.
  void apply_correction();

  /// Replaces the character by one with the given limbs. Sets Character::why_not if the limbs form no body.
  void rebuild(const std::array<Limb, 2>& legs, const std::array<Limb, 2>& arms, int head);

  void apply_plan();

  /// Finds the head: the joint of the correction, else the first neck joint that is named a head, else the last one that carries a bone.
  void find_head();

  /// Puts the left limb of each pair first. Names decide unless the character's shape and movement clearly contradict them.
  void choose_sides(Branch (&legs)[2], Branch (&arms)[2], Sections (&leg_parts)[2], Sections (&arm_parts)[2]);
  /// Finds the tail: the longest branch at the pelvis that is neither leg nor spine, or joints that are named tail.
  void find_tail();

  /// Number of further pairs of limbs: similar branches of the trunk, besides legs and arms, that are as long as limbs. 0 if the names are
  /// those of a human.
  [[nodiscard]] int more_limbs() const;

  /// Number of joints of legs and arms whose names state the recognised part.
  [[nodiscard]] int human_names() const;

  /// True if the character stands on four limbs in most frames: the trunk is level, the legs are straight below the hips, and the ends of
  /// the arms are as low as the ends of the legs. A crawling person has bent legs, and a person who bends over does so for a part of the
  /// motion.
  [[nodiscard]] bool stands_on_four() const;
  /// The last joint of a limb.
  [[nodiscard]] int end_joint(const Limb& l) const;
  /// True if the end of a joint's bone comes down to the lowest end of the four limbs, as a leg does.
  [[nodiscard]] bool comes_down(int joint) const;

  /// Chooses the body plan from the number of limbs, the inclination of the trunk, the proportions and the names.
  void decide_plan();

  /// Gives joints without a part the part of their parent. Joints below hand and foot become fingers, thumb or toes.
  void mark_rest();

  /// Finds the thumb if no joint is named thumb: of several fingers of a hand, the one that points away from the others.
  void find_thumb(int side);

  /// Marks the helper joints of the body: joints below the pelvis for which ignored() is true.
  void find_helpers();

  /// A combination of legs and arms (indices of pairs) and head (index of a branch) with its score.
  struct Choice {
    int legs = -1, arms = -1, head = -1;
    double score = 0;
  };

  const MeasuredMotion& m_;
  const AnatomyMapping* correction_;
  int n_;
  MotionShape shape_;
  std::vector<Choice> choices_;
  Choice chosen_;
  double side_confidence_ = 0;
  int head_given_ = -1, tail_given_ = -1;  // joints of head and tail that the correction names
  std::vector<NameEvidence> names_;
  std::vector<double> down_;    // [joints] m, length of the longest path below the joint
  std::vector<char> ignored_;   // [joints] 1: see ignored()
  std::vector<int> heir_;       // [joints] child on the longest path below the joint
  std::vector<int> component_;  // [joints] closest of the joint and its ancestors that is a root or free
  double size_ = 0;             // m, length of the longest path between two leaf joints
  double doubt_ = 0;
  std::vector<Branch> branches_;
  std::vector<Pair> pairs_;
  Character f_;
};

}  // namespace ugoki::body
