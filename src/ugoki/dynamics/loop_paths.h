#pragma once
// Paths of loops through a tree that has few loops: for each loop, the nodes from its two ends to the base. Internal to dynamics/.
//
// The kernel that uses the paths (kernel_paths.h) runs the recursion of the open tree unchanged, carries the columns of each loop's
// multipliers along its path, and eliminates all loops at the world. The loops cost O(loops depth + loops^2 common joints). For
// loops in series it is cheaper to eliminate each loop where its two branches meet (closed_links.h). paths_are_faster() predicts
// which method costs less.

#include "ugoki/dynamics/closed_structure.h"
#include "ugoki/dynamics/link_program.h"

namespace ugoki::dynamics {

struct LoopPaths {
  /// A node on a path, and the index in LoopPaths::dof of the node's first DOF.
  struct Visit {
    int node;
    int dof_begin;
  };
  /// The path of one loop as ranges of `visits`: [begin, fork_a) leads from link a's node to the node where the branches meet,
  /// [fork_a, fork_b) from link b's node to it, and [fork_b, end) from the meeting node to the base.
  struct Path {
    int entry;  ///< index into ClosedStructure::entries
    int rows;   ///< number of the loop's rows
    int begin, fork_a, fork_b, end;
    int present_a, present_b;  ///< index in ClosedStructure::present of the columns at link a, b; -1: that end is fixed to the world
    int present_world;         ///< index in ClosedStructure::present of the columns at the end that is fixed to the world; -1: none
    int dof_begin, dof_count;  ///< the path's DOFs are [dof_begin, dof_begin + dof_count) in `dof`
  };
  /// A run of DOFs that the two loops of a block have in common: `count` entries of `dof` from index a (first loop) and b (second loop).
  struct Run {
    int a, b, count;
  };
  /// Two loops with common DOFs, or one loop twice, and the block of the condensed matrix Lambda that couples them.
  struct Block {
    int block;           ///< index of the block of Lambda in ClosedStructure
    int run, run_count;  ///< range [run, run + run_count) in `runs`
  };

  LoopPaths() = default;
  /// @param at_world structure that was constructed with ClosedStructure::Meeting::world
  LoopPaths(const LinkProgram& program, const ClosedStructure& at_world);

  std::vector<Path> paths;  ///< [entries] one path for each closed loop
  std::vector<Visit> visits;
  std::vector<int> dof;  ///< DOFs of the nodes of all paths, path after path
  std::vector<Block> blocks;
  std::vector<Run> runs;
};

/// True if LoopPaths are predicted to be faster than the elimination of each loop where its two branches meet.
[[nodiscard]] bool paths_are_faster(const LinkProgram& program, const ClosedStructure& at_meeting, const ClosedStructure& at_world);

}  // namespace ugoki::dynamics
