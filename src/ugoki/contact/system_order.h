#pragma once
// Order of the systems of an island in a sparse matrix, so that systems that touch are close to each other: breadth-first, from the system
// that a first search reaches last. Source: Cuthill, McKee (1969), Reducing the bandwidth of sparse symmetric matrices.

#include <span>
#include <utility>
#include <vector>

namespace ugoki::contact {

class SystemOrder {
 public:
  /// Reserves memory. @param systems number of systems of the scene @param pairs expected number of pairs
  void reserve(std::size_t systems, std::size_t pairs);

  // To find an order: clear(), add() for each pair of systems that touch, then find().
  void clear() { pairs_.clear(); }
  void add(int system_a, int system_b) { pairs_.emplace_back(system_a, system_b); }
  /// Returns the members in their new order, valid until the next call. O(members + pairs)
  /// @param members all systems of the island; they contain the systems of all pairs. They need not be connected
  std::span<const int> find(std::span<const int> members);

 private:
  std::size_t search(int from, std::size_t head);

  std::vector<std::pair<int, int>> pairs_;
  std::vector<int> first_, end_;  // [systems] the system's neighbours: a range of neighbours_
  std::vector<int> neighbours_;
  std::vector<char> found_;  // [systems] 1: the system is in queue_
  std::vector<int> queue_;   // [members]
};

}  // namespace ugoki::contact
