#pragma once
// Queries of the superior tree: the closest pair of two groups, all pairs closer than a margin, or all pairs whose boxes are closer
// than a margin. A PairFilter excludes pairs.
//
// Each query keeps a front: pairs of nodes that together cover all pairs of bodies, each with a lower bound of the distance between its
// nodes. A step subtracts from each bound the motion of both nodes since the bound was computed. It examines only the pairs that the bound
// does not rule out: first by the nodes' boxes, then by splitting a node into its children, last (for two bodies) by the true distance,
// which becomes the new bound. In coherent motion a step examines only a few pairs, independent of the number of bodies.

#include <cstdint>
#include <limits>
#include <vector>

#include "ugoki/collision/pair_distance.h"
#include "ugoki/collision/superior_tree.h"

namespace ugoki::collision {

/// Computes the distance between two bodies at the poses of the tree's last update. Implemented by the caller of a query.
class PairFunction {
 public:
  virtual ~PairFunction() = default;
  /// Distance between bodies a and b.
  /// @param cutoff m: for a larger distance the result may be exact = false with `lower` above the cutoff
  /// @param cache [in, out] warm start of this pair in this query; empty at the first call for the pair
  [[nodiscard]] virtual PairDistance distance(int a, int b, double cutoff, PairCache& cache) = 0;
};

/// Indices of two bodies of the tree.
struct BodyPair {
  int a = -1, b = -1;
  friend auto operator<=>(const BodyPair&, const BodyPair&) = default;
};

/// Two bodies and their distance: the result of a query.
struct NearPair {
  BodyPair bodies;
  PairDistance near;
};

/// Selects the pairs of bodies that a query considers.
class PairFilter {
 public:
  bool between_groups = true;  ///< pairs of bodies of different groups are considered
  /// [groups] not 0: pairs of bodies inside this group are considered. Missing entries: 0.
  std::vector<std::uint8_t> inside_group;
  /// Excludes pairs of bodies, given in either order.
  void exclude(std::vector<BodyPair> pairs);

  [[nodiscard]] bool inside(int group) const {
    const auto g = static_cast<std::size_t>(group);
    return group >= 0 && g < inside_group.size() && inside_group[g] != 0;
  }
  [[nodiscard]] bool excluded(int a, int b) const;

 private:
  std::vector<BodyPair> excluded_;  // excluded pairs with a < b, sorted by (a, b)
};

/// Work of the last find() of a query, for tuning.
struct QueryCounts {
  int front = 0;       ///< number of pairs of nodes in the front
  int candidates = 0;  ///< number of pairs of the front that their distance bounds did not rule out
  int distances = 0;   ///< number of calls of PairFunction::distance
};

/// Common base of the queries: holds the front, a list of pairs of nodes.
class PairFront {
 public:
  /// A pair of nodes of the tree.
  struct Entry {
    double key;          ///< m: lower bound of the distance, plus SuperiorTree::travel() of both nodes when this bound was computed
    std::int32_t a, b;   ///< nodes of the tree
    std::int32_t cache;  ///< index of the pair's PairCache; -1: none yet
  };

  explicit PairFront(PairFilter filter) : filter_(std::move(filter)) {}

 protected:
  /// True while the front fits the tree; if false, make() must rebuild the front.
  [[nodiscard]] bool is_valid(const SuperiorTree& tree) const { return made_ && epoch_ == tree.epoch() && topology_ == tree.topology(); }
  /// True when the front has doubled since make() and should be rebuilt. The constant 64 lets small fronts grow further.
  [[nodiscard]] bool has_grown() const { return entries_.size() > 2 * size_when_made_ + 64; }
  /// Rebuilds the front from the pair of nodes (a, b), which is split until each entry is a pair of bodies or is farther apart than `limit`
  /// [m]. Bounds and caches of pairs of bodies are kept if they are still valid.
  void make(SuperiorTree& tree, int a, int b, double limit);
  /// Fills candidates_ with the indices of the entries whose distance may be `limit` [m] or less, in ascending order.
  void scan(const SuperiorTree& tree, double limit);
  /// Recomputes the bound of an entry from the boxes of its nodes. If the boxes are not farther apart than `limit` [m] and a node can be
  /// split, finer entries are appended, each of two bodies or farther apart than `limit`. The key of the old entry becomes infinite, which
  /// rules this entry out permanently.
  void refine(SuperiorTree& tree, std::size_t index, double limit);
  /// Computes the distance between the two bodies of an entry, and stores PairDistance::lower as the entry's new bound.
  PairDistance measure(SuperiorTree& tree, std::size_t index, double cutoff, PairFunction& distance);
  /// Lower bound [m] of the entry's distance at the present poses.
  [[nodiscard]] double bound(const SuperiorTree& tree, const Entry& e) const {
    const double* travel = tree.travel();
    return e.key - travel[e.a] - travel[e.b];
  }
  [[nodiscard]] bool may_be_within(const SuperiorTree& tree, const Entry& e, double limit) const {
    const double lower = bound(tree, e);
    return lower <= limit + tree.slack() && lower < std::numeric_limits<double>::infinity();
  }
  [[nodiscard]] bool leaf(const SuperiorTree& tree, const Entry& e) const { return tree.is_body(e.a) && tree.is_body(e.b); }
  /// Entry of two nodes whose boxes are `apart` [m] from each other.
  [[nodiscard]] Entry make_entry(const SuperiorTree& tree, int a, int b, double apart) const;
  /// Calls visit(index, list) for every entry of two bodies whose boxes may be within `margin` [m]; visit appends its results to the list.
  /// On return `out` contains all results in the order of (a, b).
  /// @param late scratch: results of entries that are not yet in sorted order
  template <class Found, class Visit>
  void visit_within(SuperiorTree& tree, double margin, std::vector<Found>& out, std::vector<Found>& late, const Visit& visit);
  /// Reserves caches for measure(); called after make().
  void reserve_caches();
  /// Merges the entries from index sorted_ on into the sorted entries before them. Removes split entries that have no cache.
  void sort_new();

  PairFilter filter_;
  std::vector<Entry> entries_;
  std::vector<std::uint32_t> candidates_;  // indices of entries, ascending; result of scan()
  QueryCounts counts_;
  std::size_t sorted_ = 0;  // entries before this index are in the order of (a, b)

 private:
  template <class Store>
  void expand(SuperiorTree& tree, int a, int b, double limit, const Store& store);
  void keep_old_bounds(const SuperiorTree& tree);
  void reserve(std::size_t bodies);

  std::vector<PairCache> caches_;
  std::vector<std::int32_t> free_caches_;
  std::vector<Entry> old_, spare_;
  std::vector<BodyPair> stack_;
  std::size_t size_when_made_ = 0;
  std::uint32_t epoch_ = 0, topology_ = 0;
  bool made_ = false;
  bool symmetric_ = false;  // the front was built from a node paired with itself: entries have a < b
};

/// Query: the closest pair of bodies of two groups, or inside one group (group_a == group_b).
class ClosestPair : private PairFront {
 public:
  ClosestPair(int group_a, int group_b, PairFilter filter = {});
  /// Closest pair at the poses of the tree's last update. The result equals that of measuring all pairs and taking the minimum distance;
  /// among equal distances the first in the order of the body indices wins. Body a belongs to group_a. No pair: bodies -1, distance
  /// infinite. The tree may have been updated any number of times since the last call. The reference is valid until the next call.
  [[nodiscard]] const NearPair& find(SuperiorTree& tree, PairFunction& distance);
  [[nodiscard]] const QueryCounts& counts() const { return counts_; }

 private:
  [[nodiscard]] BodyPair first_guess(SuperiorTree& tree) const;
  bool consider(const Entry& e, const PairDistance& d);
  void begin(SuperiorTree& tree, const BodyPair& guess, double limit);
  void examine(SuperiorTree& tree, std::size_t index, PairFunction& distance);

  int group_a_, group_b_;
  NearPair best_;
  std::size_t best_entry_ = 0;
};

/// Query: all pairs of bodies closer than a margin.
class PairsWithin : private PairFront {
 public:
  explicit PairsWithin(PairFilter filter) : PairFront(std::move(filter)) {}
  /// Finds all pairs with a distance <= `margin` [m] at the poses of the tree's last update.
  /// @param out cleared, then filled in the order of (a, b), with a < b; keeps its memory
  void find(SuperiorTree& tree, double margin, PairFunction& distance, std::vector<NearPair>& out);
  [[nodiscard]] const QueryCounts& counts() const { return counts_; }

 private:
  std::vector<NearPair> late_;
};

/// Query: all pairs of bodies whose boxes are closer than a margin: candidates for a caller that computes distances itself.
class BoxesWithin : private PairFront {
 public:
  explicit BoxesWithin(PairFilter filter) : PairFront(std::move(filter)) {}
  /// Finds all pairs with a box_distance() <= `margin` [m] at the poses of the tree's last update. A pair may be missing if a rotation
  /// enlarged the box of one of its bodies. The motion bound then proves that the bodies themselves are farther apart than `margin`.
  /// @param out cleared, then filled in the order of (a, b), with a < b; keeps its memory
  void find(SuperiorTree& tree, double margin, std::vector<BodyPair>& out);
  [[nodiscard]] const QueryCounts& counts() const { return counts_; }

 private:
  std::vector<BodyPair> late_;
};

}  // namespace ugoki::collision
