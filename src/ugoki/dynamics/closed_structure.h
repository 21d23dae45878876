#pragma once
// Structure of the elimination of closed loops in a recursion over a tree: which loops' multipliers are present at which node, which blocks
// of the condensed matrix Lambda (closed_links.h) exist, and in which order loops are eliminated. Rebuilt when loops are closed or opened.
// Internal to dynamics/.
//
// A loop is present at every node from its two end nodes up to the node where its two branches meet; the loop is eliminated at that node.
// At all nodes before it the loop is a passing loop: it is also present at the parent node. The world counts as a node, the last one.

#include <span>
#include <vector>

#include "ugoki/mechanism/mechanism.h"

namespace ugoki::dynamics {

/// The tree that a recursion runs over: links, or the nodes of a LinkProgram. A parent's index is below its children's.
struct ClosedTree {
  std::vector<int> parent;        ///< [nodes] -1: the world
  std::vector<int> dofs;          ///< [nodes] number of DOFs
  std::vector<int> node_of_link;  ///< [links] -1: fixed to the world
  std::vector<int> node_of_dof;   ///< [nv] node of each DOF
};

struct ClosedStructure {
  /// A closed loop. Its multipliers are consecutive, in the order of its rows.
  struct Entry {
    int loop;                  ///< index of the loop
    int rows;                  ///< number of rows in use, at most 6
    int position_rows;         ///< number of position rows; position rows come first, rotation rows follow
    int first;                 ///< index of the loop's first multiplier
    int meeting;               ///< node where the loop's two branches meet; the loop is eliminated there
    int present_a, present_b;  ///< index in `present` for the nodes of the loop's links a and b; -1: gear
    int diagonal;              ///< index of the loop's diagonal block of Lambda
  };
  /// One loop at one node. The list of each node begins with its passing loops, in the order of `entries`. The loops that are eliminated
  /// at the node follow.
  struct Present {
    int entry;   ///< index in `entries`
    int row;     ///< index of the loop's first row at this node, in arrays of size present_rows
    int parent;  ///< index in `present` of the same loop at the parent node; -1: the loop is eliminated at this node
  };
  /// Two passing loops of the same node. Both cross the node's joint, so Lambda has a block for the pair:
  /// Lambda(a, b) += d s_a s_b^T (symbols: kernel_loops.h).
  struct Pair {
    int block;
    int a, b;  ///< indices among the passing loops of the node
  };
  /// A loop that shares a block of Lambda with a loop that is being eliminated.
  struct Neighbour {
    int entry;        ///< index in `entries`
    int block;        ///< block of Lambda for the eliminated loop and this neighbour; block rows: the loop that is first in `entries`
    bool transposed;  ///< true: this neighbour is first in `entries`, so the rows of the block are its multipliers
    int present;      ///< index in `present` of this neighbour at the node where the other loop is eliminated
  };
  /// Update of a block between two neighbours of an eliminated loop: Lambda(a, b) -= Y_a^T Y_b.
  /// Y: see ClosedArguments.
  struct Update {
    int block;
    int a, b;  ///< indices in `neighbours`
  };
  /// Elimination of one loop at a node, with its ranges of `neighbours` and `updates`.
  struct Elimination {
    int entry;    ///< index in `entries`
    int present;  ///< index in `present`
    int neighbours, neighbour_count;
    int updates, update_count;
  };
  /// One of the two DOFs that a gear couples. A gear's row acts on the DOFs directly and has no wrench.
  struct Gear {
    int dof;      ///< velocity index
    int passing;  ///< index of the gear among the passing loops of the node
    int loop;     ///< index of the loop
    bool second;  ///< true: the DOF is the loop's dof_b; false: dof_a
  };
  /// Ranges of one node in the arrays below: first index and count. Passing loops are the first passing_count of `present`.
  struct Node {
    int present = 0, present_count = 0, passing_count = 0;
    int row = 0, passing_rows = 0;
    int pairs = 0, pair_count = 0;
    int eliminations = 0, elimination_count = 0;
    int gears = 0, gear_count = 0;
    int s_row = 0;   ///< index of the node's first value s = S . P; there are passing_rows values per DOF, DOF after DOF
    int s_slot = 0;  ///< index of the node's first slot; there are passing_count slots per DOF, one for each passing loop
  };

  /// Node where a loop is eliminated. own_branches: the node where the loop's two branches meet; world: the world, for all loops.
  enum class Meeting : unsigned char { own_branches, world };

  /// @param closed [loops] 1 if closed @param first_row [loops + 1] first row of each loop @param use_row [rows of all loops] 0 for rows to
  /// leave out; empty: use all
  ClosedStructure(const ClosedTree& tree, std::span<const Loop> loops, std::span<const char> closed, std::span<const int> first_row,
                  std::span<const char> use_row, Meeting meeting = Meeting::own_branches);

  std::vector<Entry> entries;
  std::vector<int> entry_of_loop;  ///< [loops] -1: open
  std::vector<int> row;            ///< [multipliers] index among the rows of all loops
  std::vector<Node> nodes;         ///< [nodes + 1], the last one is the world
  std::vector<Present> present;
  std::vector<Pair> pairs;
  std::vector<Elimination> eliminations;
  std::vector<Neighbour> neighbours;
  std::vector<Update> updates;
  std::vector<Gear> gears;
  int present_rows = 0, s_rows = 0, s_slots = 0, blocks = 0;

  [[nodiscard]] int world() const { return static_cast<int>(nodes.size()) - 1; }
  [[nodiscard]] int multipliers() const { return static_cast<int>(row.size()); }
};

}  // namespace ugoki::dynamics
