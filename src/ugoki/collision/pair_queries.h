#pragma once
// Questions to the superior tree: the nearest pair of two groups, all pairs closer than a margin, or only those whose boxes are; with
// pairs left out.
//
// Each question keeps a front: pairs of nodes that together cover all pairs of bodies, with a lower bound for each. A step looks at
// the bounds, less what the nodes have moved since, and goes into only those pairs whose bound does not rule them out: by the
// nodes' boxes, then by their children, at last by the true distance, which is the pair's new bound. In coherent motion that is a
// few pairs a step, however many there are.

#include <cstdint>
#include <limits>
#include <vector>

#include "ugoki/collision/pair_distance.h"
#include "ugoki/collision/superior_tree.h"

namespace ugoki::collision {

/// What measures two bodies, at the poses of the tree's last update.
class PairFunction {
 public:
  virtual ~PairFunction() = default;
  /// @param enough m: where the distance is greater, a `lower` above it is answer enough (exact = false)
  /// @param cache of this pair and this question alone; new at the pair's first call
  [[nodiscard]] virtual PairDistance distance(int a, int b, double enough, PairCache& cache) = 0;
};

struct BodyPair {
  int a = -1, b = -1;
  friend auto operator<=>(const BodyPair&, const BodyPair&) = default;
};

struct NearPair {
  BodyPair bodies;
  PairDistance near;
};

/// Which pairs of bodies do not count.
class PairFilter {
 public:
  bool between_groups = true;
  /// In each group: do its bodies count among each other? Missing: no.
  std::vector<std::uint8_t> inside_group;
  /// Leaves out pairs of bodies, in either order.
  void exclude(std::vector<BodyPair> pairs);

  [[nodiscard]] bool inside(int group) const {
    const auto g = static_cast<std::size_t>(group);
    return group >= 0 && g < inside_group.size() && inside_group[g] != 0;
  }
  [[nodiscard]] bool excluded(int a, int b) const;

 private:
  std::vector<BodyPair> excluded_;  // sorted, a < b
};

/// What a question went into in its last step, for those who tune.
struct QueryCounts {
  int front = 0;      ///< pairs of nodes in the front
  int touched = 0;    ///< of these not ruled out by their bounds
  int distances = 0;  ///< true distances asked for
};

/// The front that both questions share.
class PairFront {
 public:
  struct Entry {
    double key;  ///< m: lower bound of the distance plus the travel of both nodes at that time
    std::int32_t a, b;
    std::int32_t cache;  ///< index, -1: none yet
  };

  explicit PairFront(PairFilter filter) : filter_(std::move(filter)) {}

 protected:
  [[nodiscard]] bool holds(const SuperiorTree& tree) const { return made_ && epoch_ == tree.epoch() && topology_ == tree.topology(); }
  [[nodiscard]] bool grown() const { return entries_.size() > 2 * size_when_made_ + 64; }
  /// Begins anew from the pair (a, b), as fine as `limit` needs; bounds and caches of bodies are kept where they still hold.
  void make(SuperiorTree& tree, int a, int b, double limit);
  /// Indices of the entries that may be nearer than `limit`, ascending, in touched_.
  void scan(const SuperiorTree& tree, double limit);
  /// Bounds an entry by its boxes; where they are not farther than `limit`, splits it: it is ruled out for ever, and finer ones,
  /// each of two bodies or farther than `limit`, come last.
  void refine(SuperiorTree& tree, std::size_t index, double limit);
  /// Asks for the distance of an entry of two bodies and keeps the bound.
  PairDistance measure(SuperiorTree& tree, std::size_t index, double enough, PairFunction& distance);
  [[nodiscard]] double bound(const SuperiorTree& tree, const Entry& e) const {
    const double* travel = tree.travel();
    return e.key - travel[e.a] - travel[e.b];
  }
  [[nodiscard]] bool may_be_within(const SuperiorTree& tree, const Entry& e, double limit) const {
    const double lower = bound(tree, e);
    return lower <= limit + tree.slack() && lower < std::numeric_limits<double>::infinity();
  }
  [[nodiscard]] bool leaf(const SuperiorTree& tree, const Entry& e) const { return tree.is_body(e.a) && tree.is_body(e.b); }
  /// Entry of two nodes whose boxes are `apart`.
  [[nodiscard]] Entry make_entry(const SuperiorTree& tree, int a, int b, double apart) const;
  /// Calls ask(index, list) for every entry of two bodies that may be within `margin`, which appends to the list what it finds; `out`
  /// is then in the order of (a, b).
  template <class Found, class Ask>
  void ask_within(SuperiorTree& tree, double margin, std::vector<Found>& out, std::vector<Found>& late, const Ask& ask);
  /// For make(): also of what measure() needs.
  void reserve_caches();
  /// Brings the entries from sorted_ on into the order of the others, and drops what was split.
  void sort_new();

  PairFilter filter_;
  std::vector<Entry> entries_;
  std::vector<std::uint32_t> touched_;
  QueryCounts counts_;
  std::size_t sorted_ = 0;  // entries before this are in the order of (a, b)

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
  bool symmetric_ = false;  // begun from one node: entries have a < b
};

/// The nearest pair of two groups, or inside one (a group with itself).
class NearestPair : private PairFront {
 public:
  NearestPair(int group_a, int group_b, PairFilter filter = {});
  /// The same as measuring all pairs and taking the least distance (where several are equal, the first in the order of the
  /// bodies' numbers). Body a is of group a. No pair: bodies -1, distance infinite.
  /// Call it after each update of the tree, or after several: any number of steps may lie between.
  [[nodiscard]] const NearPair& find(SuperiorTree& tree, PairFunction& distance);
  [[nodiscard]] const QueryCounts& counts() const { return counts_; }

 private:
  [[nodiscard]] BodyPair first_guess(SuperiorTree& tree) const;
  bool consider(const Entry& e, const PairDistance& d);
  void begin(SuperiorTree& tree, const BodyPair& guess, double limit);
  void look_into(SuperiorTree& tree, std::size_t index, PairFunction& distance);

  int group_a_, group_b_;
  NearPair best_;
  std::size_t best_entry_ = 0;
};

/// All pairs closer than a margin.
class PairsWithin : private PairFront {
 public:
  explicit PairsWithin(PairFilter filter) : PairFront(std::move(filter)) {}
  /// @param out cleared, then all pairs with a distance not above `margin`, in the order of (a, b), a < b; keeps its memory
  void find(SuperiorTree& tree, double margin, PairFunction& distance, std::vector<NearPair>& out);
  [[nodiscard]] const QueryCounts& counts() const { return counts_; }

 private:
  std::vector<NearPair> late_;
};

/// All pairs whose boxes are closer than a margin: candidates for those who measure in their own way.
class BoxesWithin : private PairFront {
 public:
  explicit BoxesWithin(PairFilter filter) : PairFront(std::move(filter)) {}
  /// @param out cleared, then all pairs with a box_distance() not above `margin`, in the order of (a, b), a < b; keeps its memory.
  ///   Bodies that turn: as far as their motion has not ruled out before that they are that near
  void find(SuperiorTree& tree, double margin, std::vector<BodyPair>& out);
  [[nodiscard]] const QueryCounts& counts() const { return counts_; }

 private:
  std::vector<BodyPair> late_;
};

}  // namespace ugoki::collision
