#pragma once
// Few loops on a tree: the ways of their multipliers from their own nodes to the base, one loop after another. Internal to dynamics/.
//
// All loops are then eliminated at the world, and the recursion of the open tree is run as it is; its cost for loops is
// O(loops depth + loops^2 common joints). Loops in series are better eliminated where they meet (closed_links.h); predicted
// costs decide.

#include "ugoki/dynamics/closed_structure.h"
#include "ugoki/dynamics/link_program.h"

namespace ugoki::dynamics {

struct LoopPaths {
  /// A node on the way, and the place of its first freedom among the loop's `freedoms`.
  struct Visit {
    int node;
    int place;
  };
  /// The visits [begin, fork_a) come from link a's node, [fork_a, fork_b) from link b's, and [fork_b, end) follow where both have met.
  struct Path {
    int entry;
    int rows;
    int begin, fork_a, fork_b, end;
    int present_a, present_b;  ///< where the columns at the ends are; -1: that end is fixed to the world
    int present_world;         ///< the columns at the world; -1: no end is there
    int place, freedoms;       ///< [place, place + freedoms) in `freedom`
  };
  /// Freedoms that the two loops of a block have in common: `count` from these places on.
  struct Run {
    int a, b, count;
  };
  struct Block {
    int block;
    int run, run_count;
  };

  LoopPaths() = default;
  /// @param at_world made with Meeting::world
  LoopPaths(const LinkProgram& program, const ClosedStructure& at_world);

  std::vector<Path> paths;
  std::vector<Visit> visits;
  std::vector<int> freedom;  ///< [places]
  std::vector<Block> blocks;
  std::vector<Run> runs;
};

/// Whether LoopPaths are predicted to be faster than the elimination of each loop where it meets.
[[nodiscard]] bool paths_are_faster(const LinkProgram& program, const ClosedStructure& at_meeting, const ClosedStructure& at_world);

}  // namespace ugoki::dynamics
