#include "ugoki/intake/join_branches.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "ugoki/intake/tree_edit.h"

namespace ugoki::intake {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Tree of joints whose parents change one after the other.
class Branches {
 public:
  explicit Branches(std::span<const MeasuredMotion> motions)
      : s_(motions[0].skeleton), samples_(sample_poses(motions)), parents_(s_.joints.size()) {
    for (std::size_t i = 0; i < s_.joints.size(); ++i) parents_[i] = s_.joints[i].parent;
  }

  /// New parent of each joint; -1: it keeps its parent.
  [[nodiscard]] std::vector<int> join() {
    const std::size_t n = s_.joints.size();
    std::vector<int> new_parent(n, -1), below(n, 0), order(n);
    if (samples_.size() < 10) return new_parent;
    extent_ = extent_of_trees(s_, samples_[0]);
    for (const auto& X : samples_) extent_ = std::max(extent_, extent_of_trees(s_, X));
    for (std::size_t i = 0; i < n; ++i)
      for (int a = parents_[i]; a >= 0; a = parents_[at(a)]) ++below[at(a)];
    std::iota(order.begin(), order.end(), 0);
    std::ranges::sort(order, {}, [&](int i) { return std::pair(below[at(i)], i); });
    for (const int i : order)
      if (const int a = moves(i) ? nearest_rigid(i) : -1; a >= 0) new_parent[at(i)] = parents_[at(i)] = a;
    return new_parent;
  }

 private:
  [[nodiscard]] bool is_below(int i, int ancestor) const {
    for (; i >= 0; i = parents_[at(i)])
      if (i == ancestor) return true;
    return false;
  }
  /// True if a joint has no parent, or often moves relative to it.
  [[nodiscard]] bool moves(int i) const {
    constexpr double min_shift = 0.01, mostly = 0.8;  // shares of the extent and of the frames
    return parents_[at(i)] < 0 || quantile(deviations(samples_, at(i), at(parents_[at(i)])), mostly) > min_shift * extent_;
  }
  /// The nearest joint that is neither below nor above joint i and to which it is rigid; -1: none.
  [[nodiscard]] int nearest_rigid(int i) const {
    // Shares of the extent and of the frames. Jumps and poses without size in some frames of a file do not separate a body.
    constexpr double rigid = 0.005, mostly = 0.8, loose = 0.1, nearly_always = 0.95;
    int best = -1;
    double distance = 1e300;
    for (int a = 0; a < static_cast<int>(parents_.size()); ++a) {
      if (is_below(a, i) || is_below(i, a)) continue;
      const double d = norm(samples_[0][at(a)].p - samples_[0][at(i)].p);
      if (d >= distance) continue;
      const std::vector<double> shifts = deviations(samples_, at(i), at(a));
      if (quantile(shifts, mostly) > rigid * extent_ || quantile(shifts, nearly_always) > loose * extent_) continue;
      best = a;
      distance = d;
    }
    return best;
  }

  const Skeleton& s_;
  std::vector<std::vector<Pose>> samples_;
  std::vector<int> parents_;  ///< [joints]
  double extent_ = 0;         ///< m
};

}  // namespace

std::vector<std::string> join_rigid_branches(std::span<MeasuredMotion> motions) {
  const std::vector<int> new_parent = Branches(motions).join();
  std::vector<std::string> names;
  for (std::size_t i = 0; i < new_parent.size(); ++i)
    if (new_parent[i] >= 0) names.push_back(motions[0].skeleton.joints[i].name);
  if (!names.empty()) reparent(motions, new_parent);
  return names;
}

}  // namespace ugoki::intake
