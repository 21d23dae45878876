#include "ugoki/retarget/anatomy.h"

#include <algorithm>
#include <cmath>

#include "ugoki/mechanism/state.h"
#include "ugoki/motion/contact_labels.h"

namespace ugoki::retarget {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Returns the name in lower case, without a namespace prefix ("mixamorig:") and without blanks.
std::string normalized_name(const std::string& name) {
  const std::size_t colon = name.rfind(':');
  std::string out;
  for (std::size_t i = colon == std::string::npos ? 0 : colon + 1; i < name.size(); ++i) {
    const char c = name[i];
    if (c != ' ') out += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  }
  return out;
}

/// Returns the name of the mirrored link on the right side; empty if `left` is not the name of a link on the left side.
std::string right_name(const std::string& left) {
  std::string out = left;
  if (const std::size_t i = left.find("left"); i != std::string::npos) return out.replace(i, 4, "right");
  for (const char* mark : {"_l", ".l", "-l", "_l_", ".l."})
    if (const std::size_t i = left.find(mark); i != std::string::npos && (i + 2 == left.size() || std::string_view(mark).size() == 3)) {
      out[i + 1] = 'r';
      return out;
    }
  if (left.size() > 1 && left[0] == 'l') {
    out[0] = 'r';
    return out;
  }
  return {};
}

/// Returns the index of the limb section (Slot) that a link label names; -1: none.
int slot_of_label(const std::string& label) {
  constexpr struct {
    const char* word;
    Slot slot;
  } words[] = {{"hip", Slot::girdle},      {"shoulder", Slot::girdle}, {"scapula", Slot::girdle}, {"thigh", Slot::upper},
               {"upper arm", Slot::upper}, {"shank", Slot::lower},     {"forearm", Slot::lower},  {"foot", Slot::end},
               {"hock", Slot::end},        {"carpus", Slot::end},      {"hand", Slot::end},       {"toes", Slot::tip},
               {"paw", Slot::tip},         {"fingers", Slot::tip},     {"thumb", Slot::tip}};
  for (const auto& w : words)
    if (label.starts_with(w.word)) return static_cast<int>(w.slot);
  return -1;
}

/// Subtree that is attached to the trunk on one side of the body: a candidate for a limb.
struct Branch {
  int root = -1;      ///< first link of the branch
  int attach = -1;    ///< parent of the root
  int leaf = -1;      ///< the leaf link whose distance from the root along the bones is largest
  int side = 0;       ///< 1 left, -1 right
  double length = 0;  ///< m, from root to leaf along the bones
  Vec3 base, tip;     ///< m, positions of root and leaf in anatomical axes
  double low = 0;     ///< m, height of the lowest point of the leaf in the neutral position
};

/// Finds the anatomy of one mechanism; run() performs the steps in order.
class Finder {
 public:
  Finder(const Mechanism& m, const AnatomyNames& names) : m_(m), n_(m.link_count()), names_(names) {}

  Result<Anatomy> run() {
    anatomy_.X_WB.resize(at(n_));
    calc_poses(m_, m_.neutral(), anatomy_.X_WB);
    turn_to_anatomical_axes();
    measure();
    find_branches();
    if (Error wrong = choose_limbs(); !wrong.empty()) return fail(std::move(wrong));
    if (Error wrong = find_trunk(); !wrong.empty()) return fail(std::move(wrong));
    find_tail();
    for (int k = 0; k < limb_count; ++k)
      if (Error wrong = divide(k); !wrong.empty()) return fail(std::move(wrong));
    return std::move(anatomy_);
  }

 private:
  [[nodiscard]] const Link& link(int i) const { return m_.link(i); }

  /// Sets R_WA, whose y axis (left) is the mean horizontal direction from right links to their left partners, found by name. Fills p_.
  void turn_to_anatomical_axes() {
    std::vector<std::string> names;
    for (int i = 0; i < n_; ++i) names.push_back(normalized_name(link(i).name));
    Vec3 left{};
    for (int i = 0; i < n_; ++i) {
      const std::string partner = right_name(names[at(i)]);
      if (partner.empty()) continue;
      const auto it = std::find(names.begin(), names.end(), partner);
      if (it == names.end()) continue;
      const Vec3 d = anatomy_.X_WB[at(i)].p - anatomy_.X_WB[static_cast<std::size_t>(it - names.begin())].p;
      left += Vec3{d.x, d.y, 0};
    }
    if (norm(left) > 1e-6) {
      left = normalized(left);
      if (left.y < 0.999) anatomy_.R_WA = Mat3::columns(cross(left, Vec3{0, 0, 1}), left, {0, 0, 1});
    }
    for (int i = 0; i < n_; ++i) p_.push_back(transpose_times(anatomy_.R_WA, anatomy_.X_WB[at(i)].p));
  }

  /// Height [m] of a link's lowest point in the neutral position.
  [[nodiscard]] double low_of(int i) const {
    double low = p_[at(i)].z;
    for (const SupportPoint& s : support_points(link(i))) low = std::min(low, (anatomy_.X_WB[at(i)] * s.p).z - s.radius);
    return low;
  }

  /// Sets anatomy_.extent, low_ and size_ (m), measured in the neutral position.
  void measure() {
    double low = 1e300, high = -1e300;
    Vec3 box_low{1e300, 1e300, 1e300}, box_high = box_low * -1.0;
    for (int i = 0; i < n_; ++i) {
      low = std::min(low, low_of(i));
      high = std::max(high, p_[at(i)].z);
      for (int k = 0; k < 3; ++k) {
        box_low[k] = std::min(box_low[k], p_[at(i)][k]);
        box_high[k] = std::max(box_high[k], p_[at(i)][k]);
      }
    }
    anatomy_.extent = high - low;
    low_ = low;
    size_ = std::max(anatomy_.extent, norm(box_high - box_low) * 0.7);
  }

  [[nodiscard]] bool movable_below(int root) const {
    for (int i = root; i < n_; ++i)
      if (link(i).joint.nv() > 0 && (i == root || is_below(i, root))) return true;
    return false;
  }
  [[nodiscard]] bool is_below(int i, int ancestor) const {
    for (; i >= 0; i = link(i).parent)
      if (i == ancestor) return true;
    return false;
  }

  /// Collects maximal subtrees whose leaves are all on one side.
  void find_branches() {
    // Bit mask of the sides of the leaf links among each link's descendants: 1 left, 2 right, 4 middle.
    sides_.assign(at(n_), 0);
    for (int i = n_; i-- > 0;) {
      if (link(i).child < 0) sides_[at(i)] = p_[at(i)].y > 0.012 * size_ ? 1 : p_[at(i)].y < -0.012 * size_ ? 2 : 4;
      if (const int parent = link(i).parent; parent >= 0) sides_[at(parent)] |= sides_[at(i)];
    }
    for (int i = 0; i < n_; ++i) {
      const int parent = link(i).parent;
      const bool one_side = sides_[at(i)] == 1 || sides_[at(i)] == 2;
      if (!one_side || parent < 0 || sides_[at(parent)] == sides_[at(i)] || link(i).real >= 0) continue;
      Branch b;
      b.root = i;
      b.attach = parent;
      b.side = sides_[at(i)] == 1 ? 1 : -1;
      b.base = p_[at(i)];
      for (int leaf = i; leaf < n_; ++leaf) {
        if (link(leaf).child >= 0 || !is_below(leaf, i)) continue;
        double length = 0;
        for (int k = leaf; k != i; k = link(k).parent) length += norm(p_[at(k)] - p_[at(link(k).parent)]);
        if (b.leaf >= 0 && length <= b.length) continue;
        b.leaf = leaf;
        b.length = length;
        b.tip = p_[at(leaf)];
        b.low = low_of(leaf);
      }
      if (b.length > 0.1 * size_ && movable_below(i)) branches_.push_back(b);
    }
  }

  /// Returns the branch on the other side that is closest to the mirror image of branch `i`; -1: none within 0.35 of the character's size.
  [[nodiscard]] int partner_of(int i) const {
    const Branch& a = branches_[at(i)];
    int best = -1;
    double minimum = 0.35 * size_;
    for (int k = 0; k < static_cast<int>(branches_.size()); ++k) {
      const Branch& b = branches_[at(k)];
      if (b.side == a.side) continue;
      const double off = norm(a.base - Vec3{b.base.x, -b.base.y, b.base.z}) + norm(a.tip - Vec3{b.tip.x, -b.tip.y, b.tip.z});
      if (off < minimum) {
        minimum = off;
        best = k;
      }
    }
    return best;
  }

  [[nodiscard]] int named(const std::string& name, const char* what, Error& wrong) const {
    if (name.empty()) return -1;
    const int i = m_.find_link(name);
    if (i < 0)
      wrong.add(ErrorCode::unknown, what, "'" + m_.name() + "' has no link '" + name + "'.", "Correct the name in the mapping file.");
    return i;
  }

  void set_limb(int k, int root, int leaf) {
    std::vector<int>& links = anatomy_.limbs[at(k)].links;
    links.clear();
    for (int i = leaf; i >= 0; i = link(i).parent) {
      links.insert(links.begin(), i);
      if (i == root) break;
    }
  }

  Error choose_limbs() {
    struct Pair {
      int left, right;
      double low, length, x;
    };
    std::vector<Pair> pairs;
    for (int i = 0; i < static_cast<int>(branches_.size()); ++i) {
      const Branch& b = branches_[at(i)];
      const int k = partner_of(i);
      if (b.side < 0 || k < 0 || partner_of(k) != i) continue;
      pairs.push_back({i, k, std::min(b.low, branches_[at(k)].low), b.length, b.base.x});
    }
    std::sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) { return a.low != b.low ? a.low < b.low : a.left < b.left; });
    Error wrong = named_limbs();
    const bool legs_named = !names_.limbs[0][1].empty() && !names_.limbs[1][1].empty();
    if (pairs.empty() && !legs_named)
      wrong.add(ErrorCode::structure, m_.name(), "No pair of legs was found in this mechanism.",
                "Name its limbs in a mapping file (docs/retarget.md).");
    if (!wrong.empty()) return wrong;
    int legs = pairs.empty() ? -1 : 0, arms = -1;
    for (int i = 1; i < static_cast<int>(pairs.size()); ++i)
      if (arms < 0 || pairs[at(i)].length > 1.3 * pairs[at(arms)].length) arms = i;
    anatomy_.four_legs = arms >= 0 && pairs[at(arms)].low < low_ + 0.15 * anatomy_.extent;
    for (int i = 0; i < n_; ++i)
      if (link(i).label.starts_with("paw fore")) anatomy_.four_legs = true;
    if (names_.four_legs >= 0) anatomy_.four_legs = names_.four_legs == 1;
    if (anatomy_.four_legs && arms >= 0 && pairs[at(arms)].x < pairs[at(legs)].x) std::swap(legs, arms);
    for (const auto& [pair, first] : {std::pair{legs, 0}, std::pair{arms, 2}}) {
      if (pair < 0) continue;
      for (const int side : {0, 1}) {
        const Branch& b = branches_[at(side == 0 ? pairs[at(pair)].left : pairs[at(pair)].right)];
        if (anatomy_.limbs[at(first + side)].links.empty()) set_limb(first + side, b.root, b.leaf);
      }
    }
    return {};
  }

  /// Sets the limbs that the mapping names: from the first named link to the farthest leaf link below the last named link.
  Error named_limbs() {
    Error wrong;
    for (int k = 0; k < limb_count; ++k) {
      int first = -1, last = -1;
      for (const std::string& name : names_.limbs[at(k)]) {
        const int i = named(name, "mapping", wrong);
        if (i < 0) continue;
        if (first < 0) first = i;
        if (last >= 0 && !is_below(i, last))
          wrong.add(ErrorCode::structure, "mapping", "'" + name + "' is not a descendant of '" + link(last).name + "'.",
                    "Name the sections of a limb from the trunk outwards.");
        last = i;
      }
      if (first < 0 || !wrong.empty()) continue;
      int leaf = last;
      double longest = -1;
      for (int i = last; i < n_; ++i) {
        if (link(i).child >= 0 || !is_below(i, last)) continue;
        const double length = norm(p_[at(i)] - p_[at(last)]);
        if (length > longest) {
          longest = length;
          leaf = i;
        }
      }
      set_limb(k, first, leaf);
    }
    return wrong;
  }

  /// Returns the links on the path through the tree from a to b, without a. Empty if a and b have no common ancestor.
  [[nodiscard]] std::vector<int> path_between(int a, int b) const {
    std::vector<int> up, down;
    int i = a, k = b;
    while (i != k) {
      if (i > k) {
        up.push_back(i);
        i = link(i).parent;
      } else {
        down.push_back(k);
        k = link(k).parent;
      }
      if (i < 0 || k < 0) return {};
    }
    up.push_back(i);
    std::reverse(down.begin(), down.end());
    up.insert(up.end(), down.begin(), down.end());
    up.erase(up.begin());
    return up;
  }
  [[nodiscard]] int common_ancestor(int i, int k) const {
    while (i != k) (i > k ? i : k) = link(std::max(i, k)).parent;
    return i;
  }

  Error find_trunk() {
    Error wrong;
    const int pelvis = named(names_.pelvis, "mapping/pelvis", wrong), chest = named(names_.chest, "mapping/chest", wrong),
              head = named(names_.head, "mapping/head", wrong);
    if (!wrong.empty()) return wrong;
    const auto base = [&](int k) { return link(anatomy_.limbs[at(k)].links.front()).parent; };
    anatomy_.pelvis = pelvis >= 0 ? pelvis : common_ancestor(base(0), base(1));
    const bool arms = !anatomy_.limbs[2].links.empty() && !anatomy_.limbs[3].links.empty();
    int top = chest >= 0 ? chest : arms ? common_ancestor(base(2), base(3)) : -1;
    int head_link = head;
    for (int i = 0; i < n_ && head_link < 0; ++i)
      if (link(i).label == "head") head_link = i;
    if (head_link < 0) {
      double best = -1e300;
      for (int i = 0; i < n_; ++i) {
        if (link(i).child >= 0 || sides_[at(i)] != 4) continue;
        const double height = p_[at(i)].z + (anatomy_.four_legs ? p_[at(i)].x : 0);
        if (height > best && (top < 0 || height > p_[at(top)].z + (anatomy_.four_legs ? p_[at(top)].x : 0) + 0.02 * size_)) {
          best = height;
          head_link = i;
        }
      }
    }
    if (top < 0 && head_link >= 0) top = link(head_link).parent >= 0 ? link(head_link).parent : head_link;
    if (top >= 0) anatomy_.spine = path_between(anatomy_.pelvis, top);
    if (head_link >= 0 && head_link != anatomy_.chest()) {
      anatomy_.neck = path_between(anatomy_.chest(), head_link);
      for (const int i : anatomy_.neck)
        if (i == anatomy_.pelvis || std::find(anatomy_.spine.begin(), anatomy_.spine.end(), i) != anatomy_.spine.end()) {
          anatomy_.neck.clear();
          break;
        }
      // Links beyond the head (jaw, nose) are not part of the neck.
      for (std::size_t k = 0; k < anatomy_.neck.size() && head < 0; ++k)
        if (normalized_name(link(anatomy_.neck[k]).name).find("head") != std::string::npos || link(anatomy_.neck[k]).label == "head")
          anatomy_.neck.resize(k + 1);
    }
    return {};
  }

  void find_tail() {
    if (!names_.tail.empty()) {
      const int first = m_.find_link(names_.tail.front()), last = m_.find_link(names_.tail.back());
      if (first < 0 || last < 0) return;
      if (first != last) anatomy_.tail = path_between(first, last);
      anatomy_.tail.insert(anatomy_.tail.begin(), first);
      return;
    }
    int end = -1;
    for (int i = 0; i < n_; ++i) {
      if (link(i).child >= 0 || sides_[at(i)] != 4 || i == anatomy_.head() || !is_below(i, anatomy_.pelvis)) continue;
      const bool in_trunk = std::find(anatomy_.neck.begin(), anatomy_.neck.end(), i) != anatomy_.neck.end() ||
                            std::find(anatomy_.spine.begin(), anatomy_.spine.end(), i) != anatomy_.spine.end();
      if (in_trunk ||
          (!anatomy_.spine.empty() && is_below(i, anatomy_.spine.front()) && link(anatomy_.spine.front()).parent == anatomy_.pelvis))
        continue;
      if (p_[at(i)].x < p_[at(anatomy_.pelvis)].x - 0.03 * size_ && (end < 0 || p_[at(i)].x < p_[at(end)].x)) end = i;
    }
    if (end >= 0) anatomy_.tail = path_between(anatomy_.pelvis, end);
  }

  /// Divides a limb into its sections.
  Error divide(int k) {
    Limb& limb = anatomy_.limbs[at(k)];
    const std::vector<int>& links = limb.links;
    const int n = static_cast<int>(links.size());
    limb.begin.fill(n);
    limb.begin[0] = 0;
    if (n == 0) return {};
    // Sections are taken from the mapping; otherwise from labels; otherwise from bone lengths.
    std::vector<int> slots(at(n), -1);
    bool from_names = false, upper = false, lower = false;
    for (int i = 0; i < n; ++i) {
      slots[at(i)] = slot_of_label(link(links[at(i)]).label);
      upper = upper || slots[at(i)] == 1;
      lower = lower || slots[at(i)] == 2;
    }
    for (int s = 0; s < slot_count; ++s)
      if (!names_.limbs[at(k)][at(s)].empty()) from_names = true;
    if (from_names) {
      std::fill(slots.begin(), slots.end(), -1);
      for (int s = 0; s < slot_count; ++s)
        for (int i = 0; i < n; ++i)
          if (link(links[at(i)]).name == names_.limbs[at(k)][at(s)]) slots[at(i)] = s;
    } else if (!upper || !lower) {
      slots = slots_of_lengths(links);
    }
    int slot = 0;
    for (int i = 0; i < n; ++i) {
      const int next = std::max(slot, slots[at(i)]);
      for (; slot < next; ++slot) limb.begin[at(slot) + 1] = i;
    }
    for (; slot < slot_count; ++slot) limb.begin[at(slot) + 1] = n;
    if (!limb.has(Slot::upper) || !limb.has(Slot::lower)) {
      if (k >= 2 && !anatomy_.four_legs) {  // an arm with a single bone cannot follow another arm
        limb = {};
        return {};
      }
      return Error(ErrorCode::structure, m_.name(), "Its " + std::string(name_of(static_cast<LimbName>(k))) + " has fewer than two bones.",
                   "Name its sections in a mapping file (docs/retarget.md).");
    }
    return {};
  }

  /// True if the joints at the position of links[first] only twist the preceding bone about its own axis, so that they belong to that bone.
  /// @param bone m, vector along the preceding bone
  [[nodiscard]] bool only_twists(const std::vector<int>& links, int first, const Vec3& bone) const {
    for (std::size_t i = at(first); i < links.size() && norm(p_[at(links[i])] - p_[at(links[at(first)])]) < 1e-3 * norm(bone); ++i) {
      const Joint& joint = link(links[i]).joint;
      if (joint.type == JointType::fixed) continue;
      if (joint.type != JointType::revolute) return false;
      const Vec3 axis = transpose_times(anatomy_.R_WA, anatomy_.X_WB[at(links[i])].R * joint.axis);
      if (std::fabs(dot(axis, bone)) < 0.9 * norm(bone)) return false;
    }
    return at(first) + 1 < links.size();
  }

  /// Assigns sections by bone lengths: the two consecutive bones with the largest sum are the upper and the lower section. Joints at the
  /// same position count as one joint.
  [[nodiscard]] std::vector<int> slots_of_lengths(const std::vector<int>& links) const {
    const int n = static_cast<int>(links.size());
    std::vector<int> node_begin = {0};
    double total = 0;
    for (int i = 1; i < n; ++i) total += norm(p_[at(links[at(i)])] - p_[at(links[at(i - 1)])]);
    for (int i = 1; i < n; ++i) {
      const Vec3 bone = p_[at(links[at(i)])] - p_[at(links[at(node_begin.back())])];
      if (norm(bone) > 0.04 * total && !only_twists(links, i, bone)) node_begin.push_back(i);
    }
    const int nodes = static_cast<int>(node_begin.size());
    std::vector<double> bone(at(nodes), 0.0);
    for (int i = 0; i < nodes; ++i) {
      const int own = links[at(node_begin[at(i)])];
      if (i + 1 < nodes) {
        bone[at(i)] = norm(p_[at(links[at(node_begin[at(i + 1)])])] - p_[at(own)]);
      } else {  // the last bone ends at the farthest point of its shapes
        for (const SupportPoint& s : support_points(link(own))) bone[at(i)] = std::max(bone[at(i)], norm(s.p) + s.radius);
        bone[at(i)] = std::min(bone[at(i)], 0.35 * total);
      }
    }
    int best = -1;
    for (int i = 0; i + 1 < nodes; ++i)
      if (best < 0 || bone[at(i)] + bone[at(i + 1)] > 1.02 * (bone[at(best)] + bone[at(best + 1)])) best = i;
    std::vector<int> slots(at(n), -1);
    if (best < 0) return slots;
    for (int i = best, slot = 1; i < nodes && slot < slot_count; ++i, ++slot) slots[at(node_begin[at(i)])] = slot;
    return slots;
  }

  const Mechanism& m_;
  int n_;
  const AnatomyNames& names_;
  Anatomy anatomy_;
  std::vector<Vec3> p_;     // [links] m, positions of the links' origins in the neutral position, in anatomical axes
  std::vector<int> sides_;  // [links] bit mask, see find_branches
  std::vector<Branch> branches_;
  double low_ = 0, size_ = 0;  // m, height of the lowest point; size of the character, by which thresholds are scaled
};

}  // namespace

std::string_view name_of(Slot slot) {
  constexpr std::array<std::string_view, slot_count> names = {"girdle", "upper", "lower", "end", "tip"};
  return names[static_cast<std::size_t>(slot)];
}
std::string_view name_of(LimbName limb) {
  constexpr std::array<std::string_view, limb_count> names = {"left leg", "right leg", "left arm", "right arm"};
  return names[static_cast<std::size_t>(limb)];
}

int Limb::first(Slot s) const { return has(s) ? links[at(begin[static_cast<std::size_t>(s)])] : -1; }
int Limb::last(Slot s) const { return has(s) ? links[at(begin[static_cast<std::size_t>(s) + 1] - 1)] : -1; }
Slot Limb::slot_of(int link) const {
  const int i = static_cast<int>(std::find(links.begin(), links.end(), link) - links.begin());
  int s = 0;
  while (s + 1 < slot_count && i >= begin[at(s + 1)]) ++s;
  return static_cast<Slot>(s);
}

Result<Anatomy> find_anatomy(const Mechanism& mechanism, const AnatomyNames& names) { return Finder(mechanism, names).run(); }

}  // namespace ugoki::retarget
