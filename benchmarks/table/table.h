#pragma once
// The table that ./bench dynamics and ./bench collision print: rows of our time against a peer's, measured in one run.
//
// A row is added by a file of its own: it defines a function that measures and calls Table::add(), and registers it with a static
// RowRegistration. Before anything is timed, the results are compared; a row whose results differ throws, and the program fails.

#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

namespace ugoki::benchmarks {

/// One line: nanoseconds of one call (or of one instance of a batch).
struct Row {
  std::string row;
  double ours_ns = 0;
  std::string peer;  ///< empty: nothing to compare with
  double peer_ns = 0;
  double per = 0;  ///< not 0: the number of joints, or the like, for the column "ns each"
};

class Table {
 public:
  void add(const Row& row);
  [[nodiscard]] const std::vector<Row>& rows() const { return rows_; }

 private:
  std::vector<Row> rows_;
};

using RowMaker = void (*)(Table&);
struct RowRegistration {
  /// @param order where in the table, different for each. Dynamics: humanoid 100, chains 200, batches 300, closed links 400.
  /// Collision: convex pairs 100, mesh pairs 200, figures and many bodies 300. The program's --orders LOW-HIGH measures only some.
  RowRegistration(int order, RowMaker maker);
};

/// Least time of one call of each function in ns: they take turns in batches of at least 0.1 ms, for about `seconds` each.
[[nodiscard]] std::vector<double> measure(const std::vector<std::function<void()>>& functions, double seconds = 0.4);

/// Throws where two results differ by more than `relative` of the greatest magnitude (at least 1).
void require_same(const std::vector<double>& a, const std::vector<double>& b, double relative, const std::string& what);

}  // namespace ugoki::benchmarks
