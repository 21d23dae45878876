#include "ugoki/dynamics/closed_structure.h"

#include <algorithm>
#include <map>
#include <set>

#include "ugoki/base/check.h"

namespace ugoki::dynamics {
namespace {

int int_of(std::size_t n) { return static_cast<int>(n); }
std::size_t at(int i) { return static_cast<std::size_t>(i); }

class Analysis {
 public:
  Analysis(const ClosedTree& tree, std::span<const Loop> loops, ClosedStructure::Meeting meeting, ClosedStructure& structure)
      : tree_(tree), loops_(loops), meeting_(meeting), c_(structure), world_(int_of(tree.parent.size())) {}

  void run(std::span<const char> closed, std::span<const int> first_row, std::span<const char> use_row) {
    make_entries(closed, first_row, use_row);
    fill_present();
    for (int e = 0; e < int_of(c_.entries.size()); ++e) c_.entries[at(e)].diagonal = block(e, e);
    for (int node = world_ - 1; node >= 0; --node) {
      order_eliminations(node);
      couple(node);
    }
    order_eliminations(world_);
    c_.blocks = int_of(blocks_.size());
  }

 private:
  int parent(int node) const { return tree_.parent[at(node)] < 0 ? world_ : tree_.parent[at(node)]; }
  int node_of(int link) const {
    const int node = link < 0 ? -1 : tree_.node_of_link[at(link)];
    return node < 0 ? world_ : node;
  }
  /// Node where a loop between nodes a and b is eliminated: their lowest common ancestor, or the world. A parent's index is below its
  /// children's.
  int meeting(int a, int b) const {
    if (meeting_ == ClosedStructure::Meeting::world) return world_;
    while (a != b) {
      if (a == world_ || b == world_) return world_;
      int& deeper = a > b ? a : b;
      deeper = parent(deeper);
    }
    return a;
  }

  void make_entries(std::span<const char> closed, std::span<const int> first_row, std::span<const char> use_row) {
    c_.entry_of_loop.assign(loops_.size(), -1);
    for (std::size_t i = 0; i < loops_.size(); ++i) {
      if (!closed[i]) continue;
      const Loop& loop = loops_[i];
      ClosedStructure::Entry e{};
      e.loop = int_of(i);
      e.first = int_of(c_.row.size());
      for (int k = first_row[i]; k < first_row[i + 1]; ++k)
        if (use_row.empty() || use_row[at(k)]) {
          c_.row.push_back(k);
          if (k < first_row[i] + position_row_count(loop.type)) ++e.position_rows;
        }
      e.rows = int_of(c_.row.size()) - e.first;
      if (e.rows == 0) continue;
      if (loop.type == LoopType::gear) {
        ends_.push_back({tree_.node_of_dof[at(loop.dof_a)], tree_.node_of_dof[at(loop.dof_b)]});
        e.meeting = meeting(parent(ends_.back().first), parent(ends_.back().second));
      } else {
        ends_.push_back({node_of(loop.link_a), node_of(loop.link_b)});
        e.meeting = meeting(ends_.back().first, ends_.back().second);
      }
      c_.entry_of_loop[i] = int_of(c_.entries.size());
      c_.entries.push_back(e);
    }
    neighbours_of_.resize(c_.entries.size());
  }

  /// Fills `present`: an entry for each loop at each node from the loop's two end nodes to its meeting node.
  void fill_present() {
    std::vector<std::vector<int>> passing(at(world_ + 1));
    ending_.resize(at(world_ + 1));
    for (int e = 0; e < int_of(c_.entries.size()); ++e) {
      const int top = c_.entries[at(e)].meeting;
      for (int end : {ends_[at(e)].first, ends_[at(e)].second})
        for (; end != top; end = parent(end))
          if (passing[at(end)].empty() || passing[at(end)].back() != e) passing[at(end)].push_back(e);
      ending_[at(top)].push_back(e);
    }
    c_.nodes.resize(at(world_ + 1));
    present_.resize(at(world_ + 1));
    for (int node = 0; node <= world_; ++node) {
      ClosedStructure::Node& n = c_.nodes[at(node)];
      n.present = int_of(c_.present.size());
      n.row = c_.present_rows;
      n.passing_count = int_of(passing[at(node)].size());
      for (const auto* list : {&passing[at(node)], &ending_[at(node)]})
        for (const int e : *list) {
          present_[at(node)][e] = int_of(c_.present.size());
          c_.present.push_back({e, c_.present_rows, -1});
          c_.present_rows += c_.entries[at(e)].rows;
          if (list == &passing[at(node)]) n.passing_rows = c_.present_rows - n.row;
        }
      n.present_count = int_of(c_.present.size()) - n.present;
    }
    for (int node = 0; node < world_; ++node) {
      ClosedStructure::Node& n = c_.nodes[at(node)];
      for (int i = n.present; i < n.present + n.passing_count; ++i)
        c_.present[at(i)].parent = present_[at(parent(node))].at(c_.present[at(i)].entry);
      n.s_row = c_.s_rows;
      n.s_slot = c_.s_slots;
      c_.s_rows += tree_.dofs[at(node)] * n.passing_rows;
      c_.s_slots += tree_.dofs[at(node)] * n.passing_count;
    }
    for (std::size_t e = 0; e < c_.entries.size(); ++e) {
      const bool gear = loops_[at(c_.entries[e].loop)].type == LoopType::gear;
      c_.entries[e].present_a = gear ? -1 : present_[at(ends_[e].first)].at(int_of(e));
      c_.entries[e].present_b = gear ? -1 : present_[at(ends_[e].second)].at(int_of(e));
    }
    fill_gears();
  }

  void fill_gears() {
    for (int node = 0; node < world_; ++node) {
      ClosedStructure::Node& n = c_.nodes[at(node)];
      n.gears = int_of(c_.gears.size());
      for (int i = 0; i < n.passing_count; ++i) {
        const int index = c_.entries[at(c_.present[at(n.present + i)].entry)].loop;
        const Loop& loop = loops_[at(index)];
        if (loop.type != LoopType::gear) continue;
        if (tree_.node_of_dof[at(loop.dof_a)] == node) c_.gears.push_back({loop.dof_a, i, index, false});
        if (tree_.node_of_dof[at(loop.dof_b)] == node) c_.gears.push_back({loop.dof_b, i, index, true});
      }
      n.gear_count = int_of(c_.gears.size()) - n.gears;
    }
  }

  /// Index of the block of Lambda for the entries a and b. Creates the block if it does not exist.
  int block(int a, int b) {
    if (a > b) std::swap(a, b);
    const auto [it, made] = blocks_.try_emplace({a, b}, int_of(blocks_.size()));
    if (made && a != b) {
      neighbours_of_[at(a)].insert(b);
      neighbours_of_[at(b)].insert(a);
    }
    return it->second;
  }

  /// Creates the blocks of Lambda between all loops that pass the node, because the node's joint couples these loops.
  void couple(int node) {
    ClosedStructure::Node& n = c_.nodes[at(node)];
    n.pairs = int_of(c_.pairs.size());
    if (tree_.dofs[at(node)] == 0) return;
    for (int i = 0; i < n.passing_count; ++i)
      for (int j = i; j < n.passing_count; ++j)
        c_.pairs.push_back({block(c_.present[at(n.present + i)].entry, c_.present[at(n.present + j)].entry), i, j});
    n.pair_count = int_of(c_.pairs.size()) - n.pairs;
  }

  /// Eliminates the loops that meet at the node, minimum degree first. An elimination couples the loop's neighbours with each other (fill).
  void order_eliminations(int node) {
    ClosedStructure::Node& n = c_.nodes[at(node)];
    n.eliminations = int_of(c_.eliminations.size());
    queue_.clear();
    for (const int e : ending_[at(node)]) queue_.insert({neighbours_of_[at(e)].size(), e});
    while (!queue_.empty()) {
      const int e = queue_.begin()->second;
      queue_.erase(queue_.begin());
      eliminate(node, e);
    }
    n.elimination_count = int_of(c_.eliminations.size()) - n.eliminations;
  }

  void eliminate(int node, int e) {
    const std::vector<int> around(neighbours_of_[at(e)].begin(), neighbours_of_[at(e)].end());
    ClosedStructure::Elimination x{};
    x.entry = e;
    x.present = present_[at(node)].at(e);
    x.neighbours = int_of(c_.neighbours.size());
    x.neighbour_count = int_of(around.size());
    for (const int o : around) {
      const auto here = present_[at(node)].find(o);
      UGOKI_CHECK(here != present_[at(node)].end());
      c_.neighbours.push_back({o, block(e, o), o < e, here->second});
      change_degree(o, [&] { neighbours_of_[at(o)].erase(e); });
    }
    x.updates = int_of(c_.updates.size());
    for (int i = 0; i < x.neighbour_count; ++i)
      for (int j = i; j < x.neighbour_count; ++j) {
        const int a = around[at(i)], b = around[at(j)];
        if (!blocks_.contains({a, b}))  // fill
          change_degree(a, [&] { change_degree(b, [&] { block(a, b); }); });
        c_.updates.push_back({block(a, b), x.neighbours + i, x.neighbours + j});
      }
    x.update_count = int_of(c_.updates.size()) - x.updates;
    c_.eliminations.push_back(x);
  }

  template <class F>
  void change_degree(int e, F&& change) {
    const bool waits = queue_.erase({neighbours_of_[at(e)].size(), e}) > 0;
    change();
    if (waits) queue_.insert({neighbours_of_[at(e)].size(), e});
  }

  const ClosedTree& tree_;
  std::span<const Loop> loops_;
  ClosedStructure::Meeting meeting_;
  ClosedStructure& c_;
  int world_;
  std::vector<std::pair<int, int>> ends_;        ///< [entries] end nodes a, b
  std::vector<std::map<int, int>> present_;      ///< [nodes + 1] entry -> index in c_.present
  std::vector<std::vector<int>> ending_;         ///< [nodes + 1] entries whose branches meet at the node
  std::vector<std::set<int>> neighbours_of_;     ///< [entries] neighbours that are not eliminated yet
  std::map<std::pair<int, int>, int> blocks_;    ///< (smaller entry, larger entry) -> block
  std::set<std::pair<std::size_t, int>> queue_;  ///< (degree, entry) of the entries to eliminate at the current node
};

}  // namespace

ClosedStructure::ClosedStructure(const ClosedTree& tree, std::span<const Loop> loops, std::span<const char> closed,
                                 std::span<const int> first_row, std::span<const char> use_row, Meeting meeting) {
  UGOKI_CHECK(closed.size() == loops.size() && first_row.size() == loops.size() + 1);
  Analysis(tree, loops, meeting, *this).run(closed, first_row, use_row);
}

}  // namespace ugoki::dynamics
