// Which loops are open at which link, which of their multipliers meet in a block of the condensed matrix, and in what order
// they are eliminated.

#include <algorithm>
#include <map>
#include <set>

#include "ugoki/base/check.h"
#include "ugoki/dynamics/closed_links.h"

namespace ugoki::dynamics {
namespace {

int int_of(std::size_t n) { return static_cast<int>(n); }
std::size_t at(int i) { return static_cast<std::size_t>(i); }

std::vector<char> closed_at_start(const Mechanism& m) {
  std::vector<char> closed;
  for (const Loop& loop : m.loops()) closed.push_back(loop.closed);
  return closed;
}

}  // namespace

class ClosedAnalysis {
 public:
  ClosedAnalysis(const Mechanism& m, ClosedLinks& c) : m_(m), c_(c), world_(m.link_count()) {}

  void run(std::span<const char> closed, std::span<const char> rows) {
    make_entries(closed, rows);
    place_rows();
    for (int node = world_ - 1; node >= 0; --node) {
      order_eliminations(node);
      couple(node);
    }
    order_eliminations(world_);
    c_.Lambda_.resize(at(lambda_size_));
    c_.reduced_.resize(c_.row_.size());
    c_.Y_.resize(at(Y_size_));
    share_inertias();
    c_.I_.resize(m_.links().size());
    for (std::vector<double>* x : {&c_.g_, &c_.z_, &c_.lambda_}) x->resize(c_.row_.size());
    c_.pivots_.resize(c_.row_.size());
    c_.Z_.resize(c_.row_.size());
    c_.multipliers_.resize(at(c_.rows_.count()));
    c_.independent_.resize(at(c_.rows_.count()));
  }

 private:
  int parent(int node) const { return m_.link(node).parent < 0 ? world_ : m_.link(node).parent; }
  int node_of(int link) const { return link < 0 ? world_ : link; }
  /// Parents have smaller indices; the world is above all.
  int meeting(int a, int b) const {
    while (a != b) {
      if (a == world_ || b == world_) return world_;
      int& deeper = a > b ? a : b;
      deeper = parent(deeper);
    }
    return a;
  }

  void make_entries(std::span<const char> closed, std::span<const char> rows) {
    int factor_size = 0;
    c_.entry_of_loop_.assign(c_.loops_.size(), -1);
    for (std::size_t i = 0; i < c_.loops_.size(); ++i) {
      if (!closed[i]) continue;
      const Loop& loop = c_.loops_[i];
      ClosedLinks::Entry e{};
      e.loop = int_of(i);
      e.first = int_of(c_.row_.size());
      for (int k = c_.rows_.first[i]; k < c_.rows_.first[i + 1]; ++k)
        if (rows.empty() || rows[at(k)]) c_.row_.push_back(k);
      e.rows = int_of(c_.row_.size()) - e.first;
      if (e.rows == 0) continue;
      e.C = factor_size;
      factor_size += e.rows * e.rows;
      e.P_a = e.P_b = -1;
      if (loop.type == LoopType::gear) {
        ends_.push_back({m_.link_of_freedom(loop.freedom_a), m_.link_of_freedom(loop.freedom_b)});
        e.meeting = meeting(parent(ends_.back().first), parent(ends_.back().second));
      } else {
        ends_.push_back({node_of(loop.link_a), node_of(loop.link_b)});
        e.meeting = meeting(ends_.back().first, ends_.back().second);
      }
      c_.entry_of_loop_[i] = int_of(c_.entries_.size());
      c_.entries_.push_back(e);
    }
    c_.C_.resize(at(factor_size));
    neighbours_of_.resize(c_.entries_.size());
  }

  /// Places of every loop's columns at every node on its way.
  void place_rows() {
    std::vector<std::vector<int>> passing(at(world_ + 1)), ending(at(world_ + 1));
    for (int e = 0; e < int_of(c_.entries_.size()); ++e) {
      const int top = c_.entries_[at(e)].meeting;
      for (int end : {ends_[at(e)].first, ends_[at(e)].second})
        for (; end != top; end = parent(end))
          if (passing[at(end)].empty() || passing[at(end)].back() != e) passing[at(end)].push_back(e);
      ending[at(top)].push_back(e);
    }
    c_.nodes_.resize(at(world_ + 1));
    std::vector<std::map<int, int>> place(at(world_ + 1));  // entry -> row in P_
    for (int node = 0; node <= world_; ++node) {
      ClosedLinks::Node& n = c_.nodes_[at(node)];
      n.P = P_size_;
      for (const auto* list : {&passing[at(node)], &ending[at(node)]})
        for (const int e : *list) {
          place[at(node)][e] = P_size_;
          P_size_ += c_.entries_[at(e)].rows;
          if (list == &passing[at(node)]) n.passing_rows = P_size_ - n.P;
        }
      n.P_rows = P_size_ - n.P;
    }
    c_.P_.resize(at(P_size_));
    for (std::size_t e = 0; e < c_.entries_.size(); ++e) {
      if (c_.loops_[at(c_.entries_[e].loop)].type == LoopType::gear) continue;
      c_.entries_[e].P_a = place[at(ends_[e].first)].at(int_of(e));
      c_.entries_[e].P_b = place[at(ends_[e].second)].at(int_of(e));
    }
    c_.s_start_.assign(at(m_.nv()), 0);
    int s_size = 0;
    for (int node = 0; node <= world_; ++node) {
      ClosedLinks::Node& n = c_.nodes_[at(node)];
      n.present = int_of(c_.present_.size());
      for (const int e : passing[at(node)]) c_.present_.push_back({e, place[at(node)][e], place[at(parent(node))].at(e)});
      n.passing_count = int_of(c_.present_.size()) - n.present;
      for (const int e : ending[at(node)]) c_.present_.push_back({e, place[at(node)][e], -1});
      n.present_count = int_of(c_.present_.size()) - n.present;
      if (node == world_) break;
      const Link& link = m_.link(node);
      n.gears = int_of(c_.gears_.size());
      for (int f = link.v_index; f < link.v_index + link.joint.nv(); ++f) {
        c_.s_start_[at(f)] = s_size;
        for (const int e : passing[at(node)]) {
          const Loop& loop = c_.loops_[at(c_.entries_[at(e)].loop)];
          if (loop.type != LoopType::gear) continue;
          const int s = s_size + place[at(node)][e] - n.P;
          if (loop.freedom_a == f) c_.gears_.push_back({f, s, c_.entries_[at(e)].loop, false});
          if (loop.freedom_b == f) c_.gears_.push_back({f, s, c_.entries_[at(e)].loop, true});
        }
        s_size += n.passing_rows;
      }
      n.gear_count = int_of(c_.gears_.size()) - n.gears;
    }
    c_.s_.resize(at(s_size));
    place_ = std::move(place);
    ending_ = std::move(ending);
    for (int e = 0; e < int_of(c_.entries_.size()); ++e) c_.entries_[at(e)].diagonal = block(e, e);
  }

  /// Block of Lambda_ for two entries, made where it is missing.
  int block(int a, int b) {
    if (a > b) std::swap(a, b);
    const auto [it, made] = blocks_.try_emplace({a, b}, lambda_size_);
    if (made) {
      lambda_size_ += c_.entries_[at(a)].rows * c_.entries_[at(b)].rows;
      if (a != b) {
        neighbours_of_[at(a)].insert(b);
        neighbours_of_[at(b)].insert(a);
      }
    }
    return it->second;
  }

  /// The joint of a link couples all loops that pass it.
  void couple(int node) {
    ClosedLinks::Node& n = c_.nodes_[at(node)];
    n.pairs = int_of(c_.pairs_.size());
    if (m_.link(node).joint.nv() == 0) return;
    for (int i = 0; i < n.passing_count; ++i)
      for (int j = i; j < n.passing_count; ++j) {
        const ClosedLinks::Present &a = c_.present_[at(n.present + i)], &b = c_.present_[at(n.present + j)];
        c_.pairs_.push_back({block(a.entry, b.entry), a.P - n.P, b.P - n.P, c_.entries_[at(a.entry)].rows, c_.entries_[at(b.entry)].rows});
      }
    n.pair_count = int_of(c_.pairs_.size()) - n.pairs;
  }

  /// Least degree first: what is eliminated couples its neighbours with each other.
  void order_eliminations(int node) {
    ClosedLinks::Node& n = c_.nodes_[at(node)];
    n.eliminations = int_of(c_.eliminations_.size());
    std::set<std::pair<std::size_t, int>> queue;
    for (const int e : ending_[at(node)]) queue.insert({neighbours_of_[at(e)].size(), e});
    while (!queue.empty()) {
      const int e = queue.begin()->second;
      queue.erase(queue.begin());
      const std::vector<int> around(neighbours_of_[at(e)].begin(), neighbours_of_[at(e)].end());
      const auto requeue = [&](auto&& change) {
        for (const int o : around) {
          const bool waits = queue.erase({neighbours_of_[at(o)].size(), o}) > 0;
          change(o);
          if (waits) queue.insert({neighbours_of_[at(o)].size(), o});
        }
      };
      ClosedLinks::Elimination x{};
      x.entry = e;
      x.P = place_[at(node)].at(e);
      x.neighbours = int_of(c_.neighbours_.size());
      x.neighbour_count = int_of(around.size());
      for (const int o : around) {
        const auto here = place_[at(node)].find(o);
        UGOKI_CHECK(here != place_[at(node)].end());
        c_.neighbours_.push_back({o, block(e, o), Y_size_, here->second, o < e});
        Y_size_ += c_.entries_[at(e)].rows * c_.entries_[at(o)].rows;
      }
      requeue([&](int o) { neighbours_of_[at(o)].erase(e); });
      x.updates = int_of(c_.updates_.size());
      for (int i = 0; i < x.neighbour_count; ++i)
        for (int j = i; j < x.neighbour_count; ++j) {
          const int a = around[at(i)], b = around[at(j)];
          if (!blocks_.contains({a, b})) {  // fill
            const bool a_waits = queue.erase({neighbours_of_[at(a)].size(), a}) > 0;
            const bool b_waits = queue.erase({neighbours_of_[at(b)].size(), b}) > 0;
            block(a, b);
            if (a_waits) queue.insert({neighbours_of_[at(a)].size(), a});
            if (b_waits) queue.insert({neighbours_of_[at(b)].size(), b});
          }
          c_.updates_.push_back({block(a, b), i, j});
        }
      x.update_count = int_of(c_.updates_.size()) - x.updates;
      c_.eliminations_.push_back(x);
    }
    n.elimination_count = int_of(c_.eliminations_.size()) - n.eliminations;
  }

  /// A virtual link is a second body of its real link: where it has no inertia of its own, the two share the real one's. The
  /// closed system stays the same, and no joint of the cut tree is without inertia.
  void share_inertias() {
    std::map<int, std::vector<int>> second_bodies;
    for (const ClosedLinks::Entry& e : c_.entries_) {
      const Loop& loop = c_.loops_[at(e.loop)];
      if (!loop.of_virtual_link) continue;
      const Inertia& own = m_.link(loop.link_b).inertia;
      if (own.mass == 0 && own.I == Sym3{}) second_bodies[loop.link_a].push_back(loop.link_b);
    }
    for (const auto& [real, bodies] : second_bodies) {
      const double part = 1.0 / static_cast<double>(bodies.size() + 1);
      for (const int body : bodies) c_.shares_.push_back({body, real, part});
      c_.shares_.push_back({real, real, part});
    }
  }

  const Mechanism& m_;
  ClosedLinks& c_;
  int world_;
  std::vector<std::pair<int, int>> ends_;  ///< [entries] nodes
  std::vector<std::map<int, int>> place_;
  std::vector<std::vector<int>> ending_;
  std::vector<std::set<int>> neighbours_of_;
  std::map<std::pair<int, int>, int> blocks_;
  int P_size_ = 0, Y_size_ = 0, lambda_size_ = 0;
};

ClosedLinks::ClosedLinks(const Mechanism& m) : ClosedLinks(m, {m.loops().begin(), m.loops().end()}, closed_at_start(m)) {}

ClosedLinks::ClosedLinks(const Mechanism& m, std::vector<Loop> loops, std::span<const char> closed, std::span<const char> rows)
    : loops_(std::move(loops)), rows_(loops_) {
  UGOKI_CHECK(closed.size() == loops_.size());
  ClosedAnalysis(m, *this).run(closed, rows);
}

}  // namespace ugoki::dynamics
