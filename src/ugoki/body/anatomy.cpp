#include "ugoki/body/anatomy.h"

#include <algorithm>

#include "ugoki/spatial/elementary.h"

namespace ugoki::body {
namespace {

constexpr std::array<const char*, 16> part_names = {"",     "pelvis", "trunk",    "neck",      "head",    "hip",  "thigh",   "shank",
                                                    "foot", "toes",   "shoulder", "upper arm", "forearm", "hand", "fingers", "thumb"};

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Lower case, without a name space ("mixamorig:") and without blanks.
std::string plain(const std::string& name) {
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

/// The name that the partner on the right would have; empty if the name does not say left.
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

class Finder {
 public:
  explicit Finder(const Skeleton& skeleton) : s_(skeleton), n_(static_cast<int>(skeleton.joints.size())) {}

  Anatomy run() {
    a_.p = rest_positions(s_);
    a_.children.resize(at(n_));
    a_.places.resize(at(n_));
    a_.mirror.assign(at(n_), -1);
    a_.bone.resize(at(n_));
    for (int i = 0; i < n_; ++i) {
      names_.push_back(plain(s_.joints[at(i)].name));
      if (const int parent = s_.joints[at(i)].parent; parent >= 0) a_.children[at(parent)].push_back(i);
    }
    turn_to_anatomical_axes();
    find_bones();
    a_.why_not = find_human();
    a_.human = a_.why_not.empty();
    if (!a_.human) {
      a_.places.assign(at(n_), {});
      if (by_shape_) {  // what is no figure has no left
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
  /// Left is where joints named left lie; without such names the shape tells it.
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

  /// Horizontal, across the plane that legs and arms are mirrored in; the toes point forward. Zero: nothing is mirrored.
  [[nodiscard]] Vec3 left_by_shape() const {
    std::vector<double> length(at(n_));  // of all that hangs on a joint
    std::vector<int> count(at(n_));
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
    const double forward = dot(toes_point(), cross(left, Vec3{0, 0, 1}));
    return forward < 0 ? -left : left;
  }

  /// Sum over the lowest ends of their horizontal way from the joint before, where they point more than steeply down.
  [[nodiscard]] Vec3 toes_point() const {
    double low = 1e300, high = -1e300;
    for (const Vec3& p : a_.p) {
      low = std::min(low, p.z);
      high = std::max(high, p.z);
    }
    Vec3 sum{};
    for (int i = 0; i < n_; ++i) {
      const int parent = s_.joints[at(i)].parent;
      if (!a_.children[at(i)].empty() || parent < 0 || a_.p[at(i)].z > low + 0.1 * (high - low)) continue;
      Vec3 way = a_.p[at(i)] - a_.p[at(parent)];
      for (const Vec3& e : s_.joints[at(i)].end_sites) way += e;
      const Vec3 flat{way.x, way.y, 0};
      if (norm(flat) > 0.35 * norm(way)) sum += flat;
    }
    return sum;
  }

  /// Farthest point of the bone that starts at joint i: child or end site.
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
  /// Joints below `from` on the way to `leaf`.
  [[nodiscard]] std::vector<int> path_below(int from, int leaf) const {
    std::vector<int> path = path_from_root(leaf);
    const auto it = std::find(path.begin(), path.end(), from);
    path.erase(path.begin(), it == path.end() ? path.begin() : it + 1);
    return path;
  }
  [[nodiscard]] double path_length(int from, int leaf) const {
    double length = norm(a_.bone[at(leaf)]);
    int last = from;
    for (const int i : path_below(from, leaf)) {
      length += norm(a_.p[at(i)] - a_.p[at(last)]);
      last = i;
    }
    return length;
  }
  void mark(int joint, Part part, int side) { a_.places[at(joint)] = {part, side}; }
  /// Joints that nothing has claimed belong to the part of their parent.
  void mark_rest() {
    for (int i = 0; i < n_; ++i) {
      if (a_.places[at(i)].part != Part::other) continue;
      const int parent = s_.joints[at(i)].parent;
      if (parent < 0) continue;
      Place place = a_.places[at(parent)];
      if (place.part == Part::hand) place.part = Part::fingers;
      if (place.part == Part::foot) place.part = Part::toes;
      if (place.side != 0 && has(names_[at(i)], "thumb")) place.part = Part::thumb;
      a_.places[at(i)] = place;
    }
  }

  /// @return why this is no human; empty if it is one
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
    if (leaves.size() < 5 || !(extent > 0)) return "it has fewer than five ends (head, hands, feet).";
    int leg_leaf[2] = {-1, -1};
    int head_leaf = -1;
    for (const int l : leaves) {
      const Vec3 t = tip(l);
      const int side = t.y > 0 ? 0 : 1;
      if (std::fabs(t.y) > 0.01 * extent && (leg_leaf[side] < 0 || t.z < tip(leg_leaf[side]).z)) leg_leaf[side] = l;
      if (std::fabs(t.y) < 0.06 * extent && (head_leaf < 0 || t.z > tip(head_leaf).z)) head_leaf = l;
    }
    if (leg_leaf[0] < 0 || leg_leaf[1] < 0 || head_leaf < 0) return "it has no two feet and a head.";
    const int pelvis = common_ancestor(leg_leaf[0], leg_leaf[1]);
    if (pelvis < 0) return "its legs have no common root.";
    // From the pelvis up to the head.
    if (common_ancestor(pelvis, head_leaf) < 0) return "its head does not hang on its pelvis.";
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
    if (arm_leaf[0] < 0 || arm_leaf[1] < 0) return "it has no two arms.";
    const int chest = std::min(common_ancestor(arm_leaf[0], head_leaf), common_ancestor(arm_leaf[1], head_leaf));
    if (chest == pelvis) return "its arms hang on its pelvis.";
    if (common_ancestor(chest, pelvis) != pelvis) return "its legs hang above its arms.";
    for (int side = 0; side < 2; ++side) {
      if (tip(arm_leaf[side]).z < low + 0.15 * extent) return "it stands on four legs.";
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
    if (a_.trunk.back() != chest) return "its arms do not hang on its spine.";
    for (const int i : path_below(chest, head_leaf)) {
      mark(i, Part::neck, 0);
      a_.neck.push_back(i);
    }
    if (a_.neck.empty()) return "it has no head above its arms.";
    // The head is the last joint named so, or the last one.
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
      return "its legs differ in length by more than a third.";
    if (leg_length(0) < 0.25 * extent) return "its legs are too short.";
    return {};
  }

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
        // A bone between elbow and hand that only turns the forearm.
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

  void find_mirror() {
    for (int i = 0; i < n_; ++i) {
      const Place place = a_.places[at(i)];
      if (place.side <= 0) continue;
      int rank = 0;
      for (int k = 0; k < i; ++k) rank += a_.places[at(k)].part == place.part && a_.places[at(k)].side == place.side ? 1 : 0;
      for (int k = 0; k < n_; ++k) {
        if (a_.places[at(k)].part != place.part || a_.places[at(k)].side != -1) continue;
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
  bool by_shape_ = false;  // no names tell left from right
  Anatomy a_;
};

}  // namespace

Vec3 Anatomy::symmetric_bone(int i) const {
  const int other = mirror[at(i)];
  if (other < 0) return bone[at(i)];
  const Vec3 b = bone[at(other)];
  // Added in the same order on both sides, so that both get the same bits.
  const Vec3 l = places[at(i)].side > 0 ? bone[at(i)] : b, r = places[at(i)].side > 0 ? b : bone[at(i)];
  const Vec3 mean = {0.5 * (l.x + r.x), 0.5 * (l.y - r.y), 0.5 * (l.z + r.z)};
  return places[at(i)].side > 0 ? mean : Vec3{mean.x, -mean.y, mean.z};
}

Anatomy find_anatomy(const Skeleton& skeleton) { return Finder(skeleton).run(); }

std::string label_of(const Anatomy& anatomy, int joint) {
  const Place place = anatomy.places[at(joint)];
  if (place.part == Part::other) return {};
  std::string text = part_names[static_cast<std::size_t>(place.part)];
  if (place.part == Part::trunk) {
    const auto& t = anatomy.trunk;
    const auto it = std::find(t.begin(), t.end(), joint);
    if (it == t.end()) return {};
    // The first trunk joints belong to the abdomen, the last one is the chest.
    const auto first = std::find_if(t.begin(), t.end(), [&](int i) { return anatomy.places[at(i)].part == Part::trunk; });
    text = it + 1 == t.end() ? "chest" : it == first ? "abdomen" : it == first + 1 ? "abdomen upper" : "back";
  }
  int rank = 0;
  for (int i = 0; i < joint; ++i)
    rank += anatomy.places[at(i)].part == place.part && anatomy.places[at(i)].side == place.side && place.part != Part::trunk ? 1 : 0;
  if (place.part == Part::neck && rank > 0)
    text = "neck upper";
  else if (rank > 0)
    text += " " + std::to_string(rank + 1);
  if (place.side != 0) text += place.side > 0 ? " left" : " right";
  return text;
}

}  // namespace ugoki::body
