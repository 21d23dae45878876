#pragma once
// Where the multipliers of closed loops go in the recursion over a tree: made anew when loops are closed or opened. Internal
// to dynamics/.

#include <span>
#include <vector>

#include "ugoki/mechanism/mechanism.h"

namespace ugoki::dynamics {

/// The tree that a recursion runs over: links, or the nodes of a LinkProgram. A parent's index is below its children's.
struct ClosedTree {
  std::vector<int> parent;           ///< [nodes] -1: the world
  std::vector<int> freedoms;         ///< [nodes]
  std::vector<int> node_of_link;     ///< [links] -1: fixed to the world
  std::vector<int> node_of_freedom;  ///< [nv]
};

struct ClosedStructure {
  /// A closed loop.
  struct Entry {
    int loop;
    int rows;                  ///< that take part, at most 6
    int position_rows;         ///< of them, first; the others are about rotations
    int first;                 ///< first of its multipliers
    int meeting;               ///< node where its branches meet
    int present_a, present_b;  ///< it at its own links; -1: gears
    int diagonal;              ///< its own block
  };
  /// A loop at a node. Loops that go on to the parent come first, in the order of entries.
  struct Present {
    int entry;
    int row;     ///< first of its rows among all rows that are present anywhere
    int parent;  ///< the same loop at the parent; -1: it is eliminated here
  };
  /// The block of two loops that pass a joint: Lambda(a, b) += d s_a s_b^T.
  struct Pair {
    int block;
    int a, b;  ///< places among the loops that pass
  };
  struct Neighbour {
    int entry;
    int block;        ///< of the eliminated loop and this one; rows are those of the smaller entry
    bool transposed;  ///< this one is the smaller entry
    int present;      ///< this one at the node
  };
  /// Lambda(a, b) -= Y_a^T Y_b
  struct Update {
    int block;
    int a, b;  ///< neighbours
  };
  struct Elimination {
    int entry;
    int present;
    int neighbours, neighbour_count;
    int updates, update_count;
  };
  /// A gear acts on the freedom itself.
  struct Gear {
    int freedom;
    int place;  ///< among the loops that pass
    int loop;
    bool second;  ///< the freedom is the loop's freedom b
  };
  struct Node {
    int present = 0, present_count = 0, passing_count = 0;
    int row = 0, passing_rows = 0;
    int pairs = 0, pair_count = 0;
    int eliminations = 0, elimination_count = 0;
    int gears = 0, gear_count = 0;
    int s_row = 0;   ///< first of passing_rows numbers of its first freedom; those of its next freedoms follow
    int s_slot = 0;  ///< the same, counted in loops
  };

  /// Where loops are eliminated: each where its branches meet, or all of them at the world.
  enum class Meeting : unsigned char { own_branches, world };

  /// @param closed [loops] @param use_row [rows of all loops] or empty: all @param first_row [loops + 1]
  ClosedStructure(const ClosedTree& tree, std::span<const Loop> loops, std::span<const char> closed, std::span<const int> first_row,
                  std::span<const char> use_row, Meeting meeting = Meeting::own_branches);

  std::vector<Entry> entries;
  std::vector<int> entry_of_loop;  ///< [loops] -1: open
  std::vector<int> row;            ///< [multipliers] among the rows of all loops
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
