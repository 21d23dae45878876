#include "ugoki/intake/four_legs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "ugoki/body/joint_names.h"
#include "ugoki/body/limb_geometry.h"
#include "ugoki/intake/arrange.h"
#include "ugoki/intake/conversion_report.h"
#include "ugoki/intake/tree_edit.h"

namespace ugoki::intake {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Finds the limbs of one skeleton. Lengths are compared with the skeleton's extent.
class FourLegs {
 public:
  explicit FourLegs(std::span<MeasuredMotion> motions) : motions_(motions), s_(motions[0].skeleton), samples_(sample_poses(motions)) {
    std::vector<std::string> names;
    for (const SkeletonJoint& j : s_.joints) names.push_back(j.name);
    evidence_ = body::read_joint_names(names);
    children_.resize(s_.joints.size());
    for (std::size_t i = 0; i < s_.joints.size(); ++i)
      if (s_.joints[i].parent >= 0) children_[at(s_.joints[i].parent)].push_back(static_cast<int>(i));
  }

  /// Joint that has to become the root before anything else is changed; -1: none. Valid after run().
  [[nodiscard]] int new_root() const { return new_root_; }

  std::vector<std::string> run() {
    if (samples_.empty() || s_.joints.size() < 5) return {};
    for (const auto& X : samples_) extent_ = std::max(extent_, extent_of_trees(s_, X));
    find_feet();
    find_limbs(0.12);
    if (tops_.size() < 4) find_limbs(0.05);  // a fat animal
    if (tops_.size() < 4 || !find_pairs()) return {};
    find_joints();
    if (!front_named_ && chest_ >= 0 && hips_ != chest_ && is_below(s_, hips_, chest_)) {
      if (!has_branch_behind()) {  // the highest branch is the head, because the other end has none
        new_root_ = hips_;
        return {"The skeleton was re-rooted at joint " + s_.joints[at(hips_)].name + ", which carries the hind limbs."};
      }
      std::swap(fore_, hind_);  // the root is more likely at the hips
      find_joints();
    }
    if (hips_ >= 0 && chest_ >= 0 && !is_below(s_, chest_, hips_) && !is_below(s_, hips_, chest_))
      hips_ = chest_ = common(hips_, chest_);  // limbs on two branches of one joint; the chest gets a joint of its own below
    if (hips_ >= 0 && hips_ == chest_)
      if (const int spine = spine_joint(); spine >= 0) chest_ = spine;
    if (hips_ < 0 || chest_ < 0 || (chest_ != hips_ && !is_below(s_, chest_, hips_))) return {};
    std::vector<int> new_parent(s_.joints.size(), -1);
    std::vector<std::string> moved;
    for (const auto& [limbs, joint] : {std::pair{&fore_, chest_}, {&hind_, hips_}})
      for (const int top : *limbs) {
        if (parent(top) == joint) continue;
        if (!is_rigid(top, joint)) return {};
        new_parent[at(top)] = joint;
        moved.push_back(s_.joints[at(top)].name);
      }
    std::vector<std::string> report;
    if (!moved.empty())
      report.push_back("Limbs of one pair that are attached to different joints got the same joint: " + list_of(moved) + ".");
    const int count = motions_[0].joint_count();
    if (chest_ == hips_) add_chest(new_parent, report);
    if (!has_head(new_parent)) add_head(report);
    new_parent.resize(motions_[0].skeleton.joints.size(), -1);
    if (report.empty() || motions_[0].joint_count() < count) return {};
    reparent(motions_, new_parent);
    return report;
  }

 private:
  /// Finds the joints that carry both limbs of a pair.
  void find_joints() {
    hips_ = common(parent(hind_[0]), parent(hind_[1]));
    chest_ = common(parent(fore_[0]), parent(fore_[1]));
  }
  /// The foremost joint of the trunk that moves with both fore limbs, although these hang on the joint of the hind limbs; -1: none.
  [[nodiscard]] int spine_joint() const {
    constexpr double min_share = 0.25, max_share = 1.1;  // shares of the way from the hind to the fore limbs
    constexpr double rigid = 0.02;  // share of the extent; otherwise a joint for the chest moves exactly as the limbs do
    const auto middle = [&](const std::array<int, 2>& limbs) { return (mean_in(hips_, limbs[0]) + mean_in(hips_, limbs[1])) * 0.5; };
    const Vec3 back = middle(hind_), along = middle(fore_) - back;
    int found = -1;
    double foremost = min_share;
    for (int i = 0; i < motions_[0].joint_count(); ++i) {
      if (i == hips_ || !is_below(s_, i, hips_) || children_[at(i)].empty() || is_no_limb(i)) continue;
      if (std::ranges::any_of(tops_, [&](int t) { return is_below(s_, i, t); })) continue;
      const double share = dot(mean_in(hips_, i) - back, along) / dot(along, along);
      if (share < foremost || share > max_share || !is_rigid(fore_[0], i, rigid) || !is_rigid(fore_[1], i, rigid)) continue;
      found = i;
      foremost = share;
    }
    return found;
  }
  [[nodiscard]] int parent(int i) const { return s_.joints[at(i)].parent; }
  [[nodiscard]] int common(int i, int j) const {
    for (; i >= 0; i = parent(i))
      if (is_below(s_, j, i)) return i;
    return -1;
  }
  [[nodiscard]] Vec3 tip(const std::vector<Pose>& X, int i) const {
    Vec3 end;
    const std::vector<Vec3>& sites = s_.joints[at(i)].end_sites;
    for (const Vec3& e : sites) end += e / static_cast<double>(sites.size());
    return X[at(i)] * end;
  }
  /// Mean position of all joints and the ends of a limb in a sample.
  [[nodiscard]] Vec3 middle_of(const std::vector<Pose>& X, int top) const {
    Vec3 sum;
    double count = 0;
    for (std::size_t i = at(top); i < children_.size(); ++i) {
      if (!is_below(s_, static_cast<int>(i), top)) continue;
      sum += children_[i].empty() ? tip(X, static_cast<int>(i)) : X[i].p;
      count += 1;
    }
    return sum / count;
  }
  /// Mean position of a point in the frame of joint a. @param point function of the poses of a sample
  template <class Point>
  [[nodiscard]] Vec3 mean_in(int a, const Point& point) const {
    Vec3 sum;
    for (const auto& X : samples_) sum += X[at(a)].inverse() * point(X) / static_cast<double>(samples_.size());
    return sum;
  }
  [[nodiscard]] Vec3 mean_in(int a, int joint) const {
    return mean_in(a, [&](const std::vector<Pose>& X) { return X[at(joint)].p; });
  }
  /// True if a joint stays at one place relative to another in most frames.
  /// @param rigid share of the extent; the body holds the joint at its mean place
  [[nodiscard]] bool is_rigid(int joint, int other, double rigid = 0.06) const {
    constexpr double mostly = 0.8;  // share of the frames
    return quantile(deviations(samples_, at(joint), at(other)), mostly) < rigid * extent_;
  }
  /// True if joint i or a joint above it is part of a tail, wing, head or neck, or a control or face joint.
  [[nodiscard]] bool is_no_limb(int i) const {
    for (int k = i; k >= 0; k = parent(k)) {
      const body::NameEvidence& e = evidence_[at(k)];
      if (e.tail || e.wing || e.part == body::Part::head || e.part == body::Part::neck) return true;
      if (e.helper && !e.end && !is_end_control(k)) return true;
    }
    return false;
  }
  /// True if joint i is a control of inverse kinematics at the end of a limb of its side, as a hoof whose mesh hangs on "LegFTarget.L".
  [[nodiscard]] bool is_end_control(int i) const {
    if (!evidence_[at(i)].control || evidence_[at(i)].side == 0 || !children_[at(i)].empty() || parent(i) < 0) return false;
    const body::NameEvidence& limb = evidence_[at(parent(i))];
    return !limb.helper && limb.side == evidence_[at(i)].side && children_[at(parent(i))].size() == 1;
  }

  /// True if the name of joint i or of a joint above it states a side and a fore or hind limb.
  [[nodiscard]] bool is_named_limb(int i) const {
    for (int k = i; k >= 0; k = parent(k))
      if (evidence_[at(k)].side != 0 && (evidence_[at(k)].fore || evidence_[at(k)].hind)) return true;
    return false;
  }

  /// Side that the name of joint i or of the closest joint above it states: 1 left, -1 right, 0 none.
  [[nodiscard]] int side_of(int i) const {
    while (i >= 0 && evidence_[at(i)].side == 0) i = parent(i);
    return i < 0 ? 0 : evidence_[at(i)].side;
  }

  /// Finds the ends of limbs: leaf joints with the name of a limb, or whose tip is near the lowest points of the character in a fifth of
  /// the frames.
  void find_feet() {
    constexpr double near = 0.1, often = 0.2;
    std::vector<std::vector<double>> heights(s_.joints.size());
    std::vector<double> lowest;
    for (const auto& X : samples_) {
      double low = 1e300;
      for (std::size_t i = 0; i < s_.joints.size(); ++i) {
        if (!children_[i].empty() || is_no_limb(static_cast<int>(i))) continue;
        heights[i].push_back(tip(X, static_cast<int>(i)).z);
        low = std::min(low, heights[i].back());
      }
      lowest.push_back(low);
    }
    std::ranges::sort(lowest);
    const double floor = quantile(lowest, often);
    for (std::size_t i = 0; i < s_.joints.size(); ++i) {
      if (heights[i].empty()) continue;
      std::ranges::sort(heights[i]);
      if (is_named_limb(static_cast<int>(i)) || quantile(heights[i], often) < floor + near * extent_) feet_.push_back(static_cast<int>(i));
    }
  }

  /// Finds the first joint of the limb of each foot: the highest joint above it that carries nothing else of size.
  /// @param shortest share of the extent; shorter limbs are left out
  void find_limbs(double shortest) {
    tops_.clear();
    constexpr double same_foot = 0.08, small = 0.1;
    // A foot can have two joints at one place (a control and a bone), of which one has no end.
    const auto is_same_foot = [&](int other, int foot, const Vec3& own) {
      const bool at_one_place = norm(samples_[0][at(other)].p - samples_[0][at(foot)].p) < 0.25 * same_foot * extent_;
      return side_of(other) * side_of(foot) >= 0 && (at_one_place || norm(tip(samples_[0], other) - own) <= same_foot * extent_);
    };
    const auto alone = [&](int joint, int foot) {
      const Vec3 own = tip(samples_[0], foot);
      for (const int other : feet_)
        if (is_below(s_, other, joint) && !is_same_foot(other, foot, own)) return false;
      for (int k = 0; k < motions_[0].joint_count(); ++k) {
        if (!is_below(s_, k, joint) || evidence_[at(k)].helper) continue;
        // Distance of the joint from the path to the foot.
        int on = k;
        while (on != joint && !is_below(s_, foot, on)) on = parent(on);
        if (on != k && norm(samples_[0][at(k)].p - samples_[0][at(on)].p) > small * extent_ && !is_same_foot(k, foot, own)) return false;
      }
      return true;
    };
    std::vector<std::array<int, 2>> found;  // first joint and foot, the longest limb first
    for (const int foot : feet_) {
      int top = foot;
      if (!alone(top, foot)) continue;
      while (parent(top) >= 0 && parent(parent(top)) >= 0 && alone(parent(top), foot)) top = parent(top);
      if (std::ranges::any_of(found, [&](const auto& f) { return f[0] == top; })) continue;
      if (norm(tip(samples_[0], foot) - samples_[0][at(top)].p) > shortest * extent_) found.push_back({top, foot});
    }
    const auto length = [&](const std::array<int, 2>& limb) { return norm(tip(samples_[0], limb[1]) - samples_[0][at(limb[0])].p); };
    std::ranges::sort(found, [&](const auto& a, const auto& b) { return length(a) != length(b) ? length(a) > length(b) : a < b; });
    // A trunk or tail that hangs down to the floor has no side.
    const auto has_side = [&](const std::array<int, 2>& limb) { return side_of(limb[1]) != 0; };
    if (std::ranges::count_if(found, has_side) >= 4) std::erase_if(found, [&](const auto& limb) { return !has_side(limb); });
    if (found.size() > 4) found.resize(4);
    shorten(found);
    leave_common_place(found);
    for (const auto& limb : found) tops_.push_back(limb[0]);
  }

  /// Lets the limbs begin at their second joints if the first joints of all are at one place (transforms without a bone).
  /// @param limbs first joint and foot of each
  void leave_common_place(std::vector<std::array<int, 2>>& limbs) const {
    constexpr double same_place = 0.02;
    const auto& X = samples_[0];
    if (limbs.size() != 4 || std::ranges::any_of(limbs, [&](const auto& limb) {
          return limb[0] == limb[1] || norm(X[at(limb[0])].p - X[at(limbs[0][0])].p) > same_place * extent_;
        }))
      return;
    for (auto& [top, foot] : limbs) {
      int next = foot;
      while (parent(next) != top) next = parent(next);
      top = next;
    }
  }

  /// Takes the last joint of the spine from a limb that is its only branch: a limb with more joints than two others begins further down.
  /// @param limbs first joint and foot of each
  void shorten(std::vector<std::array<int, 2>>& limbs) const {
    std::vector<int> counts;
    for (const auto& [top, foot] : limbs) {
      counts.push_back(1);
      for (int i = foot; i != top; i = parent(i)) ++counts.back();
    }
    std::vector<int> sorted = counts;
    std::ranges::sort(sorted);
    for (std::size_t k = 0; k < limbs.size(); ++k)
      for (int extra = counts[k] - sorted[sorted.size() / 2]; extra > 0; --extra) {
        int next = limbs[k][1];
        while (parent(next) != limbs[k][0]) next = parent(next);
        limbs[k][0] = next;
      }
  }

  /// 1: a name in the limb states a fore limb, -1: a hind limb, 0: none.
  [[nodiscard]] int named_end(int top) const {
    int sum = 0, arms = 0;
    for (int k = top; k < motions_[0].joint_count(); ++k) {
      if (!is_below(s_, k, top)) continue;
      sum += (evidence_[at(k)].fore ? 1 : 0) - (evidence_[at(k)].hind ? 1 : 0);
      arms += body::is_arm(evidence_[at(k)].part) ? 1 : 0;
    }
    return sum != 0 ? (sum > 0 ? 1 : -1) : arms > 0 ? 1 : 0;
  }

  /// Divides the four limbs into fore and hind limbs. @return false if they form no two pairs
  bool find_pairs() {
    std::vector<int> named_fore, others;
    for (const int t : tops_) (named_end(t) > 0 ? named_fore : others).push_back(t);
    if (named_fore.size() == 2) {
      fore_ = {named_fore[0], named_fore[1]};
      hind_ = {others[0], others[1]};
      front_named_ = true;
      return true;
    }
    const int frame = common(common(parent(tops_[0]), parent(tops_[1])), common(parent(tops_[2]), parent(tops_[3])));
    if (frame < 0) return false;
    std::array<Vec3, 4> middles, begins;
    for (std::size_t k = 0; k < 4; ++k) {
      middles[k] = mean_in(frame, [&](const std::vector<Pose>& X) { return middle_of(X, tops_[k]); });
      begins[k] = mean_in(frame, begin_of(tops_[k]));
    }
    // A short motion can show the limbs of one side in front, but not their beginnings.
    std::optional<std::array<std::size_t, 4>> order = symmetric_order(middles);
    const std::array<Vec3, 4>& p = order ? middles : begins;
    if (!order) order = symmetric_order(begins);
    if (!order) return false;
    const std::array<std::size_t, 4>& o = *order;
    fore_ = {tops_[o[0]], tops_[o[1]]};
    hind_ = {tops_[o[2]], tops_[o[3]]};
    if (const std::optional<Vec3> front = front_point(frame); front) {
      const Vec3 first = (p[o[0]] + p[o[1]]) * 0.5, second = (p[o[2]] + p[o[3]]) * 0.5;
      if (dot(*front - (first + second) * 0.5, first - second) < 0) std::swap(fore_, hind_);
    }
    return true;
  }

  /// The joint at which a limb leaves the trunk: its second joint, if another limb begins at the place of the first.
  [[nodiscard]] int begin_of(int top) const {
    constexpr double same_place = 0.05;
    const auto shared = [&](int other) { return other != top && norm(mean_in(top, other)) < same_place * extent_; };
    if (std::ranges::none_of(tops_, shared)) return top;
    int next = -1;
    double longest = 0;
    for (const int c : children_[at(top)])
      if (const double length = norm(mean_in(top, [&](const std::vector<Pose>& X) { return middle_of(X, c); })); length > longest) {
        longest = length;
        next = c;
      }
    return next < 0 ? top : next;
  }

  /// Order of four points in which the first two and the last two are symmetric pairs: the vectors between the points of the pairs are
  /// equal, and at right angles to the vector between the pairs. std::nullopt: they form no such pairs
  [[nodiscard]] static std::optional<std::array<std::size_t, 4>> symmetric_order(const std::array<Vec3, 4>& p) {
    double best = 0.5;  // sum of the cosines and of the difference of lengths; 0: symmetric
    std::optional<std::array<std::size_t, 4>> order;
    for (const std::array<std::size_t, 4>& o : {std::array<std::size_t, 4>{0, 1, 2, 3}, {0, 2, 1, 3}, {0, 3, 1, 2}}) {
      const Vec3 a = p[o[0]] - p[o[1]], b = p[o[2]] - p[o[3]], along = (p[o[0]] + p[o[1]] - p[o[2]] - p[o[3]]) * 0.5;
      if (norm(a) < 1e-9 || norm(b) < 1e-9 || norm(along) < 1e-9) continue;
      const double cost = std::fabs(dot(normalized(a), normalized(along))) + std::fabs(dot(normalized(b), normalized(along))) + 1 -
                          std::fabs(dot(normalized(a), normalized(b))) + std::fabs(norm(a) - norm(b)) / (norm(a) + norm(b)) +
                          0.1 * norm(a) / norm(along);  // a trunk is longer than wide
      if (cost < best) {
        best = cost;
        order = o;
      }
    }
    return order;
  }

  /// A point in front of the animal, in the frame of joint a: its head by name, else opposite to its tail, else the highest joint that is
  /// no limb. std::nullopt if there is none.
  [[nodiscard]] std::optional<Vec3> front_point(int a) {
    std::optional<Vec3> tail, high;
    double height = -1e300;
    Vec3 middle;
    for (const int t : tops_) middle += mean_in(a, t) * 0.25;
    for (int i = 0; i < motions_[0].joint_count(); ++i) {
      const body::NameEvidence& e = evidence_[at(i)];
      if (e.part == body::Part::head) {
        front_named_ = true;
        return mean_in(a, i);
      }
      if (e.tail) tail = mean_in(a, i);
      if (std::ranges::any_of(tops_, [&](int t) { return is_below(s_, i, t); }) || !is_below(s_, i, a) || e.tail) continue;
      double z = 0;
      for (const auto& X : samples_) z += tip(X, i).z;
      if (z <= height) continue;
      height = z;
      high = mean_in(a, [&](const std::vector<Pose>& X) { return tip(X, i); });
    }
    front_named_ = tail.has_value();
    return tail ? middle * 2 - *tail : high;
  }

  /// True if something that is no limb reaches beyond the hind limbs.
  [[nodiscard]] bool has_branch_behind() const {
    constexpr double min_reach = 0.05;  // share of the extent
    const int frame = common(hips_, chest_);
    const auto middle = [&](const std::array<int, 2>& limbs) { return (mean_in(frame, limbs[0]) + mean_in(frame, limbs[1])) * 0.5; };
    const Vec3 back = middle(hind_), behind = normalized(back - middle(fore_));
    for (int i = 0; i < motions_[0].joint_count(); ++i) {
      if (std::ranges::any_of(tops_, [&](int t) { return is_below(s_, i, t); }) || !is_below(s_, i, frame) || evidence_[at(i)].helper)
        continue;
      if (dot(mean_in(frame, [&](const std::vector<Pose>& X) { return tip(X, i); }) - back, behind) > min_reach * extent_) return true;
    }
    return false;
  }

  /// True if joint i or a joint below it is named a neck or head.
  [[nodiscard]] bool carries_head(int i) const {
    for (std::size_t k = at(i); k < evidence_.size(); ++k)
      if ((evidence_[k].part == body::Part::head || evidence_[k].part == body::Part::neck) && is_below(s_, static_cast<int>(k), i))
        return true;
    return false;
  }

  /// True if a branch carries fore limbs and no hind limbs.
  [[nodiscard]] bool carries_only_fore_limbs(int i) const {
    const auto carried = [&](int limb) { return limb != i && is_below(s_, limb, i); };
    return std::ranges::any_of(fore_, carried) && std::ranges::none_of(hind_, carried);
  }

  /// True if joint i is part of a limb, or carries one.
  [[nodiscard]] bool carries_limb(int i) const {
    return std::ranges::any_of(tops_, [&](int t) { return is_below(s_, i, t) || is_below(s_, t, i); });
  }

  /// Adds a joint between the fore limbs, which carries them and the branches in front of them.
  void add_chest(std::vector<int>& new_parent, std::vector<std::string>& report) {
    const int place = motions_[0].joint_count();
    const auto middle = [&](const std::array<int, 2>& limbs) { return (mean_in(hips_, limbs[0]) + mean_in(hips_, limbs[1])) * 0.5; };
    const Vec3 front = middle(fore_), back = middle(hind_), along = front - back;
    std::vector<std::string> names;
    bool in_front_found = false;
    for (const int c : children_[at(hips_)]) {
      const bool limb = c == fore_[0] || c == fore_[1];
      const bool in_front = c != hind_[0] && c != hind_[1] && !evidence_[at(c)].tail &&
                            (carries_head(c) || carries_only_fore_limbs(c) ||
                             dot(mean_in(hips_, c) - (front + back) * 0.5, along) > 0.25 * dot(along, along));
      if (!limb && !in_front) continue;
      in_front_found = in_front_found || (in_front && !limb);
      new_parent[at(c)] = place;
      names.push_back(s_.joints[at(c)].name);
    }
    if (!in_front_found) {              // of a spine that begins between the limbs, the first joint at the fore limbs continues the chest
      constexpr double nearest = 0.75;  // share of the way from the hind to the fore limbs
      for (int i = hips_ + 1; i < static_cast<int>(children_.size()); ++i) {
        if (!is_below(s_, i, hips_) || children_[at(i)].empty() || is_no_limb(i) || carries_limb(i)) continue;
        if (dot(mean_in(hips_, i) - back, along) < nearest * dot(along, along)) continue;
        new_parent[at(i)] = place;
        names.push_back(s_.joints[at(i)].name);
        break;
      }
    }
    const std::string name = s_.joints[at(hips_)].name + "_chest";
    for (MeasuredMotion& m : motions_) append_rigid(m, name, hips_, front, {});
    chest_ = place;
    new_parent.push_back(-1);
    for (const int limb : fore_)
      if (new_parent[at(limb)] != place) {
        new_parent[at(limb)] = place;
        names.push_back(s_.joints[at(limb)].name);
      }
    samples_ = sample_poses(motions_);
    report.push_back("All limbs have one common joint; a joint for the chest was added, which carries " + list_of(names) + ".");
  }

  /// True if the chest carries a branch that is neither limb nor tail. @param new_parent changes of the tree that are not yet made
  [[nodiscard]] bool has_head(const std::vector<int>& new_parent) const {
    constexpr double shortest = 0.05;
    const auto now = [&](int i) { return at(i) < new_parent.size() && new_parent[at(i)] >= 0 ? new_parent[at(i)] : parent(i); };
    for (int i = 0; i < motions_[0].joint_count(); ++i) {
      if (i == chest_ || evidence_of(i).helper || evidence_of(i).tail) continue;
      bool limb = false, below = false;
      for (int k = i; k >= 0 && !below; k = now(k)) {
        limb = limb || k == fore_[0] || k == fore_[1];
        below = k == chest_;
      }
      if (below && !limb && norm(tip(samples_[0], i) - samples_[0][at(chest_)].p) > shortest * extent_) return true;
    }
    return false;
  }
  [[nodiscard]] body::NameEvidence evidence_of(int i) const { return at(i) < evidence_.size() ? evidence_[at(i)] : body::NameEvidence{}; }

  /// Adds a neck and a head in front of the fore limbs, with the usual proportions of a dog.
  void add_head(std::vector<std::string>& report) {
    const auto middle = [&](const std::array<int, 2>& limbs) { return (mean_in(chest_, limbs[0]) + mean_in(chest_, limbs[1])) * 0.5; };
    const Vec3 front = middle(fore_), along = front - middle(hind_);
    const Vec3 up = mean_in(chest_, [&](const std::vector<Pose>& X) { return X[at(chest_)].p + Vec3{0, 0, norm(along)}; });
    const std::string name = s_.joints[at(chest_)].name;
    const int place = motions_[0].joint_count();
    for (MeasuredMotion& m : motions_) {
      append_rigid(m, name + "_neck", chest_, front + along * 0.15 + up * 0.15, {});
      append_rigid(m, name + "_head", place, along * 0.2 + up * 0.1, {along * 0.25});
    }
    report.push_back("No head was found in front of the fore limbs; a neck and a head that do not turn were added to joint " + name + ".");
  }

  std::span<MeasuredMotion> motions_;
  const Skeleton& s_;  ///< of the first motion; joints are only appended to it
  std::vector<std::vector<Pose>> samples_;
  std::vector<body::NameEvidence> evidence_;  ///< [joints of the file]
  std::vector<std::vector<int>> children_;    ///< [joints of the file]
  double extent_ = 0;                         ///< m
  std::vector<int> feet_, tops_;
  std::array<int, 2> fore_{-1, -1}, hind_{-1, -1};  ///< first joints of the limbs
  int hips_ = -1, chest_ = -1, new_root_ = -1;
  bool front_named_ = false;  ///< names of limbs, head or tail state which limbs are in front
};

}  // namespace

std::vector<std::string> complete_four_legs(std::span<MeasuredMotion> motions) {
  FourLegs limbs(motions);
  std::vector<std::string> report = limbs.run();
  if (limbs.new_root() < 0) return report;
  for (MeasuredMotion& m : motions) make_root(m, limbs.new_root());
  const std::vector<std::string> changes = FourLegs(motions).run();
  report.insert(report.end(), changes.begin(), changes.end());
  return report;
}

}  // namespace ugoki::intake
