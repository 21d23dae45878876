#include "ugoki/body/anatomy.h"

#include <algorithm>

#include "ugoki/spatial/elementary.h"

namespace ugoki::body {
namespace {

constexpr std::array<const char*, 16> part_names = {"",     "pelvis", "trunk",    "neck",      "head",    "hip",  "thigh",   "shank",
                                                    "foot", "toes",   "shoulder", "upper arm", "forearm", "hand", "fingers", "thumb"};

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// The name in lower case, without a namespace prefix ("mixamorig:") and without blanks.
std::string normalized_name(const std::string& name) {
  const std::size_t colon = name.rfind(':');
  std::string out;
  for (std::size_t i = colon == std::string::npos ? 0 : colon + 1; i < name.size(); ++i) {
    const char c = name[i];
    if (c == ' ') continue;
    out += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  }
  return out;
}
bool has(const std::string& text, const char* word) { return text.find(word) != std::string::npos; }

/// Name of the mirrored joint on the right side; empty if `left` does not name a joint on the left side.
std::string right_name(const std::string& left) {
  std::string out = left;
  if (const std::size_t i = left.find("left"); i != std::string::npos) return out.replace(i, 4, "right");
  if (left.size() > 2 && (left.ends_with("_l") || left.ends_with(".l") || left.ends_with("-l"))) {
    out.back() = 'r';
    return out;
  }
  if (left.size() > 1 && left[0] == 'l') {
    out[0] = 'r';
    return out;
  }
  return {};
}

/// Finds the anatomy of one skeleton; run() performs the steps in order.
class Finder {
 public:
  explicit Finder(const Skeleton& skeleton) : s_(skeleton), n_(static_cast<int>(skeleton.joints.size())) {}

  Anatomy run() {
    a_.p = rest_positions(s_);
    a_.children.resize(at(n_));
    a_.parts.resize(at(n_));
    a_.mirror.assign(at(n_), -1);
    a_.bone.resize(at(n_));
    for (int i = 0; i < n_; ++i) {
      names_.push_back(normalized_name(s_.joints[at(i)].name));
      if (const int parent = s_.joints[at(i)].parent; parent >= 0) a_.children[at(parent)].push_back(i);
    }
    turn_to_anatomical_axes();
    find_bones();
    a_.why_not = find_human();
    a_.human = a_.why_not.empty();
    if (!a_.human) {
      a_.parts.assign(at(n_), {});
      if (by_shape_) {  // without a human anatomy, a left side guessed from the shape is meaningless
        a_.R_WA = Mat3::identity();
        a_.p = rest_positions(s_);
        find_bones();
      }
      return std::move(a_);
    }
    find_mirror();
    return std::move(a_);
  }

 private:
  /// Sets R_WA: left is the mean direction from right-named to left-named joints, without such names left_by_shape().
  void turn_to_anatomical_axes() {
    Vec3 left{};
    for (int i = 0; i < n_; ++i) {
      const std::string partner = right_name(names_[at(i)]);
      if (partner.empty()) continue;
      const auto it = std::find(names_.begin(), names_.end(), partner);
      if (it == names_.end()) continue;
      const Vec3 d = a_.p[at(i)] - a_.p[static_cast<std::size_t>(it - names_.begin())];
      left += Vec3{d.x, d.y, 0};
    }
    by_shape_ = norm(left) <= 1e-6;
    if (by_shape_) left = left_by_shape();
    if (norm(left) > 1e-6) {
      left = normalized(left);
      if (left.y < (by_shape_ ? 0.98 : 0.85)) a_.R_WA = Mat3::columns(cross(left, Vec3{0, 0, 1}), left, {0, 0, 1});
    }
    for (Vec3& p : a_.p) p = transpose_times(a_.R_WA, p);
  }

  /// Unit horizontal vector to the left: the normal of the mirror plane of legs and arms, signed so that the toes point forward.
  /// Zero if the skeleton has no mirrored limbs.
  [[nodiscard]] Vec3 left_by_shape() const {
    std::vector<double> length(at(n_));  // [joints] m, total bone length below a joint
    std::vector<int> count(at(n_));      // [joints] number of joints below
    for (int i = n_ - 1; i >= 0; --i)
      for (const int c : a_.children[at(i)]) {
        length[at(i)] += length[at(c)] + norm(s_.joints[at(c)].offset);
        count[at(i)] += 1 + count[at(c)];
      }
    double xx = 0, xy = 0, yy = 0;
    for (const std::vector<int>& siblings : a_.children)
      for (std::size_t k = 0; k < siblings.size(); ++k)
        for (std::size_t l = 0; l < k; ++l) {
          const int i = siblings[k], j = siblings[l];
          const double weight = length[at(i)] + length[at(j)];
          if (count[at(i)] != count[at(j)] || std::fabs(length[at(i)] - length[at(j)]) > 0.02 * weight) continue;
          const Vec3 d = a_.p[at(i)] - a_.p[at(j)];
          xx += weight * d.x * d.x;
          xy += weight * d.x * d.y;
          yy += weight * d.y * d.y;
        }
    if (!(xx + yy > 0)) return {};
    const double angle = 0.5 * ugoki::atan2(2 * xy, xx - yy);
    const SinCos turn = sin_cos(angle);
    Vec3 left{turn.cos, turn.sin, 0};
    if (left.y < 0) left = -left;
    const double forward = dot(toe_direction(), cross(left, Vec3{0, 0, 1}));
    return forward < 0 ? -left : left;
  }

  /// Sum [m] of the horizontal directions of the lowest end bones; bones that point steeply down (horizontal share below 0.35) are skipped.
  [[nodiscard]] Vec3 toe_direction() const {
    double low = 1e300, high = -1e300;
    for (const Vec3& p : a_.p) {
      low = std::min(low, p.z);
      high = std::max(high, p.z);
    }
    Vec3 sum{};
    for (int i = 0; i < n_; ++i) {
      const int parent = s_.joints[at(i)].parent;
      if (!a_.children[at(i)].empty() || parent < 0 || a_.p[at(i)].z > low + 0.1 * (high - low)) continue;
      Vec3 end = a_.p[at(i)] - a_.p[at(parent)];
      for (const Vec3& e : s_.joints[at(i)].end_sites) end += e;
      const Vec3 flat{end.x, end.y, 0};
      if (norm(flat) > 0.35 * norm(end)) sum += flat;
    }
    return sum;
  }

  /// Sets the bone of every joint: the vector to its farthest child or end site.
  void find_bones() {
    for (int i = 0; i < n_; ++i) {
      Vec3 best{};
      for (const Vec3& e : s_.joints[at(i)].end_sites)
        if (norm(e) > norm(best)) best = transpose_times(a_.R_WA, e);
      for (const int c : a_.children[at(i)])
        if (norm(a_.p[at(c)] - a_.p[at(i)]) > norm(best)) best = a_.p[at(c)] - a_.p[at(i)];
      a_.bone[at(i)] = best;
    }
  }

  /// Far end of a leaf's bone, m.
  [[nodiscard]] Vec3 tip(int leaf) const { return a_.p[at(leaf)] + a_.bone[at(leaf)]; }
  [[nodiscard]] std::vector<int> path_from_root(int i) const {
    std::vector<int> path;
    for (; i >= 0; i = s_.joints[at(i)].parent) path.push_back(i);
    std::reverse(path.begin(), path.end());
    return path;
  }
  [[nodiscard]] int common_ancestor(int i, int j) const {
    const std::vector<int> a = path_from_root(i), b = path_from_root(j);
    int last = -1;
    for (std::size_t k = 0; k < std::min(a.size(), b.size()) && a[k] == b[k]; ++k) last = a[k];
    return last;
  }
  /// Joints on the path from `from` (excluded) to its descendant `leaf`.
  [[nodiscard]] std::vector<int> path_below(int from, int leaf) const {
    std::vector<int> path = path_from_root(leaf);
    const auto it = std::find(path.begin(), path.end(), from);
    path.erase(path.begin(), it == path.end() ? path.begin() : it + 1);
    return path;
  }
  /// Length [m] of the bones from `from` to the tip of `leaf`.
  [[nodiscard]] double path_length(int from, int leaf) const {
    double length = norm(a_.bone[at(leaf)]);
    int last = from;
    for (const int i : path_below(from, leaf)) {
      length += norm(a_.p[at(i)] - a_.p[at(last)]);
      last = i;
    }
    return length;
  }
  void mark(int joint, Part part, int side) { a_.parts[at(joint)] = {part, side}; }
  /// Joints without a part get the part of their parent; below hand and foot they are fingers, thumb or toes.
  void mark_rest() {
    for (int i = 0; i < n_; ++i) {
      if (a_.parts[at(i)].part != Part::other) continue;
      const int parent = s_.joints[at(i)].parent;
      if (parent < 0) continue;
      SidedPart sided = a_.parts[at(parent)];
      if (sided.part == Part::hand) sided.part = Part::fingers;
      if (sided.part == Part::foot) sided.part = Part::toes;
      if (sided.side != 0 && has(names_[at(i)], "thumb")) sided.part = Part::thumb;
      a_.parts[at(i)] = sided;
    }
  }

  /// Finds all parts. Lengths are compared with the skeleton's height. @return why the skeleton is not human; empty if it is
  std::string find_human() {
    std::vector<int> leaves;
    for (int i = 0; i < n_; ++i)
      if (a_.children[at(i)].empty()) leaves.push_back(i);
    double low = 1e300, high = -1e300;
    for (const int l : leaves) {
      low = std::min(low, tip(l).z);
      high = std::max(high, tip(l).z);
    }
    const double extent = high - low;
    if (leaves.size() < 5 || !(extent > 0)) return "the skeleton has fewer than five end joints (head, hands, feet).";
    int leg_leaf[2] = {-1, -1};
    int head_leaf = -1;
    for (const int l : leaves) {
      const Vec3 t = tip(l);
      const int side = t.y > 0 ? 0 : 1;
      if (std::fabs(t.y) > 0.01 * extent && (leg_leaf[side] < 0 || t.z < tip(leg_leaf[side]).z)) leg_leaf[side] = l;
      if (std::fabs(t.y) < 0.06 * extent && (head_leaf < 0 || t.z > tip(head_leaf).z)) head_leaf = l;
    }
    if (leg_leaf[0] < 0 || leg_leaf[1] < 0 || head_leaf < 0) return "no two feet and a head were found.";
    const int pelvis = common_ancestor(leg_leaf[0], leg_leaf[1]);
    if (pelvis < 0) return "the legs have no common root.";
    if (common_ancestor(pelvis, head_leaf) < 0) return "the head is not connected to the pelvis.";
    int arm_leaf[2] = {-1, -1};
    double arm_length[2] = {0, 0};
    for (const int l : leaves) {
      const int from = common_ancestor(l, head_leaf);
      const int leg = std::max(common_ancestor(l, leg_leaf[0]), common_ancestor(l, leg_leaf[1]));
      if (l == head_leaf || from < 0 || leg > pelvis || from == pelvis || has(names_[at(l)], "thumb")) continue;
      const double y = tip(l).y;
      const int side = y > 0 ? 0 : 1;
      const double length = path_length(from, l);
      if (std::fabs(y) > 0.02 * extent && length > arm_length[side]) {
        arm_leaf[side] = l;
        arm_length[side] = length;
      }
    }
    if (arm_leaf[0] < 0 || arm_leaf[1] < 0) return "no two arms were found.";
    const int chest = std::min(common_ancestor(arm_leaf[0], head_leaf), common_ancestor(arm_leaf[1], head_leaf));
    if (chest == pelvis) return "the arms are attached to the pelvis.";
    if (common_ancestor(chest, pelvis) != pelvis) return "the legs are attached above the arms.";
    for (int side = 0; side < 2; ++side) {
      if (tip(arm_leaf[side]).z < low + 0.15 * extent) return "the skeleton has four legs.";
      if (const std::string why = find_leg(pelvis, leg_leaf[side], side, extent); !why.empty()) return why;
    }
    for (const int i : path_from_root(pelvis)) {
      mark(i, Part::pelvis, 0);
      if (i != pelvis) a_.trunk.push_back(i);
    }
    a_.trunk.push_back(pelvis);
    for (const int i : path_below(pelvis, chest)) {
      mark(i, Part::trunk, 0);
      a_.trunk.push_back(i);
    }
    if (a_.trunk.back() != chest) return "the arms are not attached to the spine.";
    for (const int i : path_below(chest, head_leaf)) {
      mark(i, Part::neck, 0);
      a_.neck.push_back(i);
    }
    if (a_.neck.empty()) return "no head was found above the arms.";
    // The head is the first neck joint named "head", otherwise the last one.
    int head = a_.neck.back();
    for (const int i : a_.neck)
      if (has(names_[at(i)], "head")) {
        head = i;
        break;
      }
    while (a_.neck.back() != head) {
      mark(a_.neck.back(), Part::head, 0);
      a_.neck.pop_back();
    }
    mark(head, Part::head, 0);
    for (int side = 0; side < 2; ++side)
      if (const std::string why = find_arm(chest, arm_leaf[side], side, extent); !why.empty()) return why;
    mark_rest();
    const auto leg_length = [&](int side) {
      return norm(a_.p[at(a_.legs[at(side)].end)] - a_.p[at(a_.legs[at(side)].distal)]) +
             norm(a_.p[at(a_.legs[at(side)].distal)] - a_.p[at(a_.legs[at(side)].proximal)]);
    };
    if (std::fabs(leg_length(0) - leg_length(1)) > 0.15 * (leg_length(0) + leg_length(1)))
      return "the legs differ in length by more than a third.";
    if (leg_length(0) < 0.25 * extent) return "the legs are shorter than a quarter of the height.";
    return {};
  }

  /// Marks the joints of a leg. @return what is missing; empty if complete
  std::string find_leg(int pelvis, int leaf, int side, double extent) {
    const int sign = side == 0 ? 1 : -1;
    Limb& leg = a_.legs[at(side)];
    for (const int i : path_below(pelvis, leaf)) {
      if (leg.proximal < 0) {
        const bool stub = std::fabs(a_.p[at(i)].y) < 0.03 * extent;
        mark(i, stub ? Part::hip : Part::thigh, sign);
        if (!stub) leg.proximal = i;
      } else if (leg.distal < 0) {
        const bool knee = norm(a_.p[at(i)] - a_.p[at(leg.proximal)]) > 0.12 * extent;
        mark(i, knee ? Part::shank : Part::thigh, sign);
        if (knee) leg.distal = i;
      } else if (leg.end < 0) {
        const bool ankle = norm(a_.p[at(i)] - a_.p[at(leg.distal)]) > 0.12 * extent;
        mark(i, ankle ? Part::foot : Part::shank, sign);
        if (ankle) leg.end = i;
      } else {
        mark(i, Part::toes, sign);
        if (leg.tip < 0) leg.tip = i;
      }
    }
    return leg.end < 0 ? "a leg has no thigh, shank and foot." : "";
  }

  /// Marks the joints of an arm. @return what is missing; empty if complete
  std::string find_arm(int chest, int leaf, int side, double extent) {
    const int sign = side == 0 ? 1 : -1;
    Limb& arm = a_.arms[at(side)];
    const std::vector<int> path = path_below(chest, leaf);
    for (std::size_t k = 0; k < path.size(); ++k) {
      const int i = path[k];
      const std::string& name = names_[at(i)];
      const double bone = k + 1 < path.size() ? norm(a_.p[at(path[k + 1])] - a_.p[at(i)]) : norm(a_.bone[at(i)]);
      if (arm.proximal < 0) {
        const bool stub = std::fabs(a_.p[at(i)].y) < 0.035 * extent || has(name, "clav") || has(name, "collar");
        mark(i, stub ? Part::shoulder : Part::upper_arm, sign);
        if (!stub) arm.proximal = i;
      } else if (arm.distal < 0) {
        const bool elbow = norm(a_.p[at(i)] - a_.p[at(arm.proximal)]) > 0.09 * extent;
        mark(i, elbow ? Part::forearm : Part::upper_arm, sign);
        if (elbow) arm.distal = i;
      } else if (arm.end < 0) {
        const bool far = norm(a_.p[at(i)] - a_.p[at(arm.distal)]) > 0.07 * extent;
        // A joint between elbow and hand that only twists the forearm belongs to the forearm.
        const bool turns = has(name, "roll") || has(name, "twist") || (has(name, "wrist") && bone > 0.035 * extent && k + 1 < path.size());
        mark(i, far && !turns ? Part::hand : Part::forearm, sign);
        if (far && !turns) arm.end = i;
      } else {
        mark(i, Part::fingers, sign);
        if (arm.tip < 0) arm.tip = i;
      }
    }
    return arm.distal < 0 ? "an arm has no upper arm and forearm." : "";
  }

  /// Pairs the joints of each part by their order on both sides.
  void find_mirror() {
    for (int i = 0; i < n_; ++i) {
      const SidedPart sided = a_.parts[at(i)];
      if (sided.side <= 0) continue;
      int rank = 0;
      for (int k = 0; k < i; ++k) rank += a_.parts[at(k)].part == sided.part && a_.parts[at(k)].side == sided.side ? 1 : 0;
      for (int k = 0; k < n_; ++k) {
        if (a_.parts[at(k)].part != sided.part || a_.parts[at(k)].side != -1) continue;
        if (rank-- == 0) {
          a_.mirror[at(i)] = k;
          a_.mirror[at(k)] = i;
        }
      }
    }
  }

  const Skeleton& s_;
  int n_;
  std::vector<std::string> names_;
  bool by_shape_ = false;  // left was guessed from the shape, because no joint names give it
  Anatomy a_;
};

}  // namespace

Vec3 Anatomy::symmetric_bone(int i) const {
  const int other = mirror[at(i)];
  if (other < 0) return bone[at(i)];
  const Vec3 b = bone[at(other)];
  // The sum has the same order for both sides, so that the results are bitwise equal.
  const Vec3 l = parts[at(i)].side > 0 ? bone[at(i)] : b, r = parts[at(i)].side > 0 ? b : bone[at(i)];
  const Vec3 mean = {0.5 * (l.x + r.x), 0.5 * (l.y - r.y), 0.5 * (l.z + r.z)};
  return parts[at(i)].side > 0 ? mean : Vec3{mean.x, -mean.y, mean.z};
}

Anatomy find_anatomy(const Skeleton& skeleton) { return Finder(skeleton).run(); }

std::string label_of(const Anatomy& anatomy, int joint) {
  const SidedPart sided = anatomy.parts[at(joint)];
  if (sided.part == Part::other) return {};
  std::string text = part_names[static_cast<std::size_t>(sided.part)];
  if (sided.part == Part::trunk) {
    const auto& t = anatomy.trunk;
    const auto it = std::find(t.begin(), t.end(), joint);
    if (it == t.end()) return {};
    // The first two trunk joints belong to the abdomen; the last one is the chest.
    const auto first = std::find_if(t.begin(), t.end(), [&](int i) { return anatomy.parts[at(i)].part == Part::trunk; });
    text = it + 1 == t.end() ? "chest" : it == first ? "abdomen" : it == first + 1 ? "abdomen upper" : "back";
  }
  int rank = 0;
  for (int i = 0; i < joint; ++i)
    rank += anatomy.parts[at(i)].part == sided.part && anatomy.parts[at(i)].side == sided.side && sided.part != Part::trunk ? 1 : 0;
  if (sided.part == Part::neck && rank > 0)
    text = "neck upper";
  else if (rank > 0)
    text += " " + std::to_string(rank + 1);
  if (sided.side != 0) text += sided.side > 0 ? " left" : " right";
  return text;
}

}  // namespace ugoki::body
