#include "ugoki/dynamics/loop_paths.h"

#include <algorithm>
#include <utility>

namespace ugoki::dynamics {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }
int int_of(std::size_t n) { return static_cast<int>(n); }

/// Nodes that carry links a and b of a loop; -1: the world.
std::pair<int, int> end_nodes(const ClosedStructure& x, const ClosedStructure::Entry& e) {
  const auto node_of = [&](int present) {
    for (int node = 0; node < x.world(); ++node) {
      const ClosedStructure::Node& n = x.nodes[at(node)];
      if (present >= n.present && present < n.present + n.present_count) return node;
    }
    return -1;
  };
  return {node_of(e.present_a), node_of(e.present_b)};
}

}  // namespace

LoopPaths::LoopPaths(const LinkProgram& program, const ClosedStructure& x) {
  const auto parent = [&](int node) { return program.order[at(node)].parent; };
  std::vector<std::vector<int>> index_of(x.entries.size(), std::vector<int>(at(program.nv), -1));
  for (std::size_t i = 0; i < x.entries.size(); ++i) {
    const ClosedStructure::Entry& e = x.entries[i];
    auto [a, b] = end_nodes(x, e);
    Path p{.entry = int_of(i),
           .rows = e.rows,
           .begin = int_of(visits.size()),
           .fork_a = 0,
           .fork_b = 0,
           .end = 0,
           .present_a = e.present_a,
           .present_b = e.present_b,
           .present_world = -1,
           .dof_begin = int_of(dof.size()),
           .dof_count = 0};
    if (a < 0) p.present_world = std::exchange(p.present_a, -1);
    if (b < 0) p.present_world = std::exchange(p.present_b, -1);
    if (a == b) p.present_a = -1;  // both ends have the same columns: add them once
    const auto visit = [&](int& node) {
      visits.push_back({node, int_of(dof.size())});
      const NodeOrder& o = program.order[at(node)];
      const int count = dofs_of(o.kind);
      for (int k = 0; k < count; ++k) {
        index_of[i][at(o.v + k)] = int_of(dof.size());
        dof.push_back(o.v + k);
      }
      node = parent(node);
    };
    const auto meeting = [&] {
      int m = a, n = b;
      while (m != n) (m > n ? m : n) = parent(m > n ? m : n);
      return m;
    }();
    while (a != meeting) visit(a);
    p.fork_a = int_of(visits.size());
    while (b != meeting) visit(b);
    p.fork_b = int_of(visits.size());
    while (a >= 0) visit(a);
    p.end = int_of(visits.size());
    p.dof_count = int_of(dof.size()) - p.dof_begin;
    paths.push_back(p);
  }
  // Find the block of Lambda for each pair of loops that have DOFs in common. The rows of a block belong to the first loop.
  std::vector<std::vector<int>> block_of(x.entries.size(), std::vector<int>(x.entries.size(), -1));
  for (const ClosedStructure::Node& n : x.nodes)
    for (int k = n.pairs; k < n.pairs + n.pair_count; ++k) {
      const ClosedStructure::Pair& pair = x.pairs[at(k)];
      block_of[at(x.present[at(n.present + pair.a)].entry)][at(x.present[at(n.present + pair.b)].entry)] = pair.block;
    }
  for (std::size_t i = 0; i < paths.size(); ++i)
    for (std::size_t j = i; j < paths.size(); ++j) {
      if (block_of[i][j] < 0) continue;
      Block block{block_of[i][j], int_of(runs.size()), 0};
      for (int k = paths[i].dof_begin; k < paths[i].dof_begin + paths[i].dof_count; ++k) {
        const int other = index_of[j][at(dof[at(k)])];
        if (other < 0) continue;
        if (block.run_count > 0 && runs.back().a + runs.back().count == k && runs.back().b + runs.back().count == other)
          ++runs.back().count;
        else
          runs.push_back({k, other, 1}), ++block.run_count;
      }
      blocks.push_back(block);
    }
}

bool paths_are_faster(const LinkProgram& program, const ClosedStructure& at_meeting, const ClosedStructure& at_world) {
  // Estimated costs. Unit: cost of transforming one loop's columns across one joint of a path. `on_tree`: elimination at the meeting node
  constexpr double column_on_tree = 2, pair_on_tree = 0.7, pair_on_paths = 0.3, elimination = 4;
  const auto cost = [](const ClosedStructure& x, double passing, double pair) {
    double sum = elimination * (static_cast<double>(x.eliminations.size()) + static_cast<double>(x.neighbours.size()));
    for (const ClosedStructure::Node& n : x.nodes) sum += passing * n.passing_count + pair * n.pair_count;
    return sum;
  };
  if (!at_world.gears.empty()) return false;  // a gear acts on two DOFs directly and has no path
  for (int i = 0; i < program.nodes(); ++i)   // a massless body may need the stiffness of loops that are eliminated before it
    if (program.order[at(i)].massless && at_world.nodes[at(i)].passing_count > 0) return false;
  return cost(at_world, 1, pair_on_paths) < cost(at_meeting, column_on_tree, pair_on_tree);
}

}  // namespace ugoki::dynamics
