#include "ugoki/collision/pair_queries.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace ugoki::collision {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

BodyPair ordered(int a, int b) { return a < b ? BodyPair{a, b} : BodyPair{b, a}; }

bool before(const PairFront::Entry& x, const PairFront::Entry& y) { return x.a != y.a ? x.a < y.a : x.b < y.b; }

template <class Found>
const BodyPair& bodies_of(const Found& found) {
  if constexpr (requires { found.bodies; })
    return found.bodies;
  else
    return found;
}

double size_of(const SuperiorTree::Box& b) {
  const Vec3 d = b.high - b.low;
  return d.x + d.y + d.z;
}

/// Margin [m] added to the limit of a distance query. The resulting bound then rules the pair out for about the next eight steps at the
/// present speed, or permanently if no body moves.
double bound_margin(const SuperiorTree& tree, const PairFront::Entry& e) {
  return 8 * (tree.last_travel(e.a) + tree.last_travel(e.b)) + 4 * tree.slack();
}

}  // namespace

void PairFilter::exclude(std::vector<BodyPair> pairs) {
  for (const BodyPair& p : pairs) excluded_.push_back(ordered(p.a, p.b));
  std::ranges::sort(excluded_);
}

bool PairFilter::excluded(int a, int b) const { return !excluded_.empty() && std::ranges::binary_search(excluded_, ordered(a, b)); }

/// Calls store(a, b, box distance) for the coarsest pairs of nodes below (a, b) that are farther apart than `limit`, and for the
/// remaining pairs of two bodies. Pairs that the filter excludes are skipped.
template <class Store>
void PairFront::expand(SuperiorTree& tree, int a, int b, double limit, const Store& store) {
  stack_.clear();
  stack_.push_back({a, b});
  while (!stack_.empty()) {
    const BodyPair p = stack_.back();
    stack_.pop_back();
    const int ga = tree.group_of_node(p.a), gb = tree.group_of_node(p.b);
    if (ga >= 0 && ga == gb && !filter_.inside(ga)) continue;
    if (ga >= 0 && gb >= 0 && ga != gb && !filter_.between_groups) continue;
    if (p.a == p.b) {
      if (tree.is_body(p.a)) continue;
      const int l = tree.left(p.a), r = tree.right(p.a);
      stack_.push_back({r, r});
      stack_.push_back({l, r});
      stack_.push_back({l, l});
      continue;
    }
    const bool body_a = tree.is_body(p.a), body_b = tree.is_body(p.b);
    if (body_a && body_b && filter_.excluded(p.a, p.b)) continue;
    const double apart = box_distance(tree.box(p.a), tree.box(p.b));
    if ((body_a && body_b) || apart > limit) {
      store(p.a, p.b, apart);
    } else if (body_b || (!body_a && size_of(tree.box(p.a)) >= size_of(tree.box(p.b)))) {
      stack_.push_back({tree.right(p.a), p.b});
      stack_.push_back({tree.left(p.a), p.b});
    } else {
      stack_.push_back({p.a, tree.right(p.b)});
      stack_.push_back({p.a, tree.left(p.b)});
    }
  }
}

/// Copies the entries of two bodies to old_, sorted by (a, b). If the epoch has changed, their bounds are dropped, and entries without a
/// cache are not copied.
void PairFront::keep_old_bounds(const SuperiorTree& tree) {
  old_.clear();
  const bool bounds_valid = made_ && epoch_ == tree.epoch();
  for (Entry e : entries_) {
    if (!leaf(tree, e) || (e.cache < 0 && !bounds_valid)) continue;
    if (!bounds_valid) e.key = -infinity;
    old_.push_back(e);
  }
  std::ranges::sort(old_, before);
}

PairFront::Entry PairFront::make_entry(const SuperiorTree& tree, int a, int b, double apart) const {
  const double* travel = tree.travel();
  if (symmetric_ && a > b) std::swap(a, b);
  return {apart + travel[a] + travel[b], a, b, -1};
}

void PairFront::make(SuperiorTree& tree, int a, int b, double limit) {
  keep_old_bounds(tree);
  entries_.clear();
  symmetric_ = a == b;
  expand(tree, a, b, limit, [&](int node_a, int node_b, double apart) {
    Entry e = make_entry(tree, node_a, node_b, apart);
    const auto old = leaf(tree, e) ? std::ranges::lower_bound(old_, e, before) : old_.end();
    if (old != old_.end() && old->a == e.a && old->b == e.b) {
      e.key = std::max(e.key, old->key);
      e.cache = std::exchange(old->cache, -1);
    }
    entries_.push_back(e);
  });
  for (const Entry& e : old_)
    if (e.cache >= 0) free_caches_.push_back(e.cache);
  std::ranges::sort(entries_, before);
  reserve(static_cast<std::size_t>(tree.bodies()));
  size_when_made_ = sorted_ = entries_.size();
  epoch_ = tree.epoch();
  topology_ = tree.topology();
  made_ = true;
}

/// Reserves memory so that later queries do not allocate. A front never has more than bodies^2 entries: one for each pair of bodies, and
/// at most as many entries that were split. Large fronts get memory for four times their present number of entries, plus 4096.
void PairFront::reserve(std::size_t bodies) {
  const std::size_t capacity = std::min(bodies * bodies, 4 * entries_.size() + 4096);
  if (capacity <= entries_.capacity()) return;
  entries_.reserve(capacity);
  candidates_.reserve(capacity);
  spare_.reserve(capacity);
  old_.reserve(capacity);
  stack_.reserve(256);
}

void PairFront::reserve_caches() {
  caches_.reserve(entries_.capacity());
  free_caches_.reserve(entries_.capacity());
}

void PairFront::scan(const SuperiorTree& tree, double limit) {
  const double* travel = tree.travel();
  limit = std::min(limit + tree.slack(), std::numeric_limits<double>::max());  // finite, so that entries with infinite bounds never qualify
  candidates_.clear();
  const std::size_t count = entries_.size();
  candidates_.resize(count);
  // Branch-free: only a few entries qualify, at unpredictable positions.
  std::size_t found = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Entry& e = entries_[i];
    candidates_[found] = static_cast<std::uint32_t>(i);
    found += e.key - travel[e.a] - travel[e.b] <= limit ? 1 : 0;
  }
  candidates_.resize(found);
  counts_ = {static_cast<int>(count), static_cast<int>(found), 0};
}

void PairFront::refine(SuperiorTree& tree, std::size_t index, double limit) {
  const Entry old = entries_[index];
  entries_[index].key = infinity;  // stays infinite if the entry is split, so that the entry is ruled out
  expand(tree, old.a, old.b, limit, [&](int a, int b, double apart) {
    const Entry e = make_entry(tree, a, b, apart);
    if (e.a == old.a && e.b == old.b)
      entries_[index].key = std::max(e.key, old.key);
    else
      entries_.push_back(e);
  });
}

PairDistance PairFront::measure(SuperiorTree& tree, std::size_t index, double cutoff, PairFunction& distance) {
  Entry& e = entries_[index];
  if (e.cache < 0) {
    if (free_caches_.empty()) {
      e.cache = static_cast<std::int32_t>(caches_.size());
      caches_.emplace_back();
    } else {
      e.cache = free_caches_.back();
      free_caches_.pop_back();
      caches_[static_cast<std::size_t>(e.cache)] = {};
    }
  }
  ++counts_.distances;
  const PairDistance d = distance.distance(e.a, e.b, cutoff, caches_[static_cast<std::size_t>(e.cache)]);
  e.key = d.lower + tree.travel()[e.a] + tree.travel()[e.b];
  return d;
}

void PairFront::sort_new() {
  const auto middle = entries_.begin() + static_cast<std::ptrdiff_t>(sorted_);
  std::sort(middle, entries_.end(), before);
  spare_.clear();
  std::merge(entries_.begin(), middle, middle, entries_.end(), std::back_inserter(spare_), before);
  std::erase_if(spare_, [&](const Entry& e) { return e.key == infinity && e.cache < 0; });
  entries_.swap(spare_);
  sorted_ = entries_.size();
}

ClosestPair::ClosestPair(int group_a, int group_b, PairFilter filter) : PairFront(std::move(filter)), group_a_(group_a), group_b_(group_b) {
  filter_.between_groups = true;
  if (group_a != group_b) return;
  const auto g = static_cast<std::size_t>(group_a);
  if (filter_.inside_group.size() <= g) filter_.inside_group.resize(g + 1);
  filter_.inside_group[g] = 1;
}

/// Makes the bodies of e, at distance d, the best pair if they are closer than the best pair so far, or equally close and earlier
/// in the order of body indices.
/// @return true if the best pair was replaced
bool ClosestPair::consider(const Entry& e, const PairDistance& d) {
  const BodyPair bodies{e.a, e.b};
  if (!d.exact || d.distance > best_.near.distance || (d.distance == best_.near.distance && bodies > best_.bodies)) return false;
  best_ = {bodies, d};
  return true;
}

/// Guesses a close pair of bodies by greedy descent to the closer child node. Returns bodies -1 if the descent ends at an excluded pair.
BodyPair ClosestPair::first_guess(SuperiorTree& tree) const {
  int a = tree.group_root(group_a_), b = tree.group_root(group_b_);
  if (group_a_ == group_b_) {
    if (tree.is_body(a)) return {};
    b = tree.right(a);
    a = tree.left(a);
  }
  const auto nearer = [&](int node, int other) {
    const int l = tree.left(node), r = tree.right(node);
    return box_distance(tree.box(l), tree.box(other)) <= box_distance(tree.box(r), tree.box(other)) ? l : r;
  };
  while (!tree.is_body(a) || !tree.is_body(b)) {
    if (tree.is_body(b) || (!tree.is_body(a) && size_of(tree.box(a)) >= size_of(tree.box(b))))
      a = nearer(a, b);
    else
      b = nearer(b, a);
  }
  return filter_.excluded(a, b) ? BodyPair{} : BodyPair{a, b};
}

void ClosestPair::begin(SuperiorTree& tree, const BodyPair& guess, double limit) {
  make(tree, tree.group_root(group_a_), tree.group_root(group_b_), limit);
  reserve_caches();
  const auto found = std::ranges::find_if(entries_, [&](const Entry& e) { return BodyPair{e.a, e.b} == guess; });
  best_entry_ = static_cast<std::size_t>(found - entries_.begin());
}

void ClosestPair::examine(SuperiorTree& tree, std::size_t index, PairFunction& distance) {
  const std::size_t before = entries_.size();
  refine(tree, index, best_.near.distance + tree.slack());
  for (std::size_t i = index; i < entries_.size(); i = i == index ? before : i + 1) {
    const Entry e = entries_[i];
    const double limit = best_.near.distance;
    if (!leaf(tree, e) || !may_be_within(tree, e, limit)) continue;
    if (consider(e, measure(tree, i, limit + bound_margin(tree, e), distance))) best_entry_ = i;
  }
}

const NearPair& ClosestPair::find(SuperiorTree& tree, PairFunction& distance) {
  const BodyPair last = best_.bodies;
  best_ = {};
  best_.near.distance = best_.near.lower = infinity;
  counts_ = {};
  const auto empty = [&](int group) { return group >= tree.groups() || tree.group_root(group) < 0; };
  if (empty(group_a_) || empty(group_b_)) return best_;
  if (!is_valid(tree)) {
    const BodyPair guess = last.a >= 0 ? last : first_guess(tree);
    PairCache cache;
    begin(tree, guess, guess.a < 0 ? infinity : distance.distance(guess.a, guess.b, infinity, cache).distance);
  }
  const std::size_t known = best_entry_;
  if (known < entries_.size()) (void)consider(entries_[known], measure(tree, known, infinity, distance));
  scan(tree, best_.near.distance);
  for (const std::uint32_t i : candidates_)
    if (i != known && may_be_within(tree, entries_[i], best_.near.distance)) examine(tree, i, distance);
  if (has_grown()) begin(tree, best_.bodies, best_.near.distance);
  return best_;
}

template <class Found, class Visit>
void PairFront::visit_within(SuperiorTree& tree, double margin, std::vector<Found>& out, std::vector<Found>& late, const Visit& visit) {
  scan(tree, margin);
  const double limit = margin + tree.slack();
  const std::size_t before_splits = entries_.size();
  for (const std::uint32_t i : candidates_) {
    if (!leaf(tree, entries_[i])) {
      refine(tree, i, limit);
      continue;
    }
    const double apart = box_distance(tree.box(entries_[i].a), tree.box(entries_[i].b));
    if (apart > limit)
      entries_[i].key = make_entry(tree, entries_[i].a, entries_[i].b, apart).key;
    else
      visit(i, i < sorted_ ? out : late);
  }
  for (std::size_t i = before_splits; i < entries_.size(); ++i)
    if (leaf(tree, entries_[i]) && may_be_within(tree, entries_[i], margin)) visit(i, late);
  if (entries_.size() - sorted_ > sorted_ / 8 + 64) sort_new();
  // Both lists are in the order of (a, b): merge `late` into `out` from the ends, in place.
  std::ranges::sort(late, {}, bodies_of<Found>);
  std::size_t i = out.size(), j = late.size(), k = i + j;
  out.resize(k);
  while (j > 0) {
    if (i > 0 && bodies_of(out[i - 1]) > bodies_of(late[j - 1]))
      out[--k] = out[--i];
    else
      out[--k] = late[--j];
  }
}

void PairsWithin::find(SuperiorTree& tree, double margin, PairFunction& distance, std::vector<NearPair>& out) {
  out.clear();
  late_.clear();
  counts_ = {};
  if (tree.root() < 0) return;
  if (!is_valid(tree) || has_grown()) {
    make(tree, tree.root(), tree.root(), margin);
    reserve_caches();
    late_.reserve(std::min<std::size_t>(entries_.capacity(), 4096));
  }
  visit_within(tree, margin, out, late_, [&](std::size_t i, std::vector<NearPair>& found) {
    const Entry& e = entries_[i];
    const PairDistance d = measure(tree, i, margin + bound_margin(tree, e), distance);
    if (d.exact && d.distance <= margin) found.push_back({{e.a, e.b}, d});
  });
}

void BoxesWithin::find(SuperiorTree& tree, double margin, std::vector<BodyPair>& out) {
  out.clear();
  late_.clear();
  counts_ = {};
  if (tree.root() < 0) return;
  if (!is_valid(tree) || has_grown()) {
    make(tree, tree.root(), tree.root(), margin);
    late_.reserve(std::min<std::size_t>(entries_.capacity(), 4096));
    out.reserve(late_.capacity());
  }
  visit_within(tree, margin, out, late_,
               [&](std::size_t i, std::vector<BodyPair>& found) { found.push_back({entries_[i].a, entries_[i].b}); });
}

}  // namespace ugoki::collision
