#pragma once
// The table that ./bench circuit, collision, dynamics, motion, step and wasm print: rows of our time and a peer's time, measured in the
// same run.
//
// A file of rows defines a function that measures and calls Table::add(), and registers the function with a static RowRegistration. The
// function first compares the results of both sides and throws if they differ; the program then fails.

#include <functional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace ugoki::benchmarks {

/// One line: nanoseconds of one call (or of one instance of a batch).
struct Row {
  std::string row;
  double ours_ns = 0;
  std::string peer;  ///< name of the compared library; empty: none
  double peer_ns = 0;
  double per = 0;                                          ///< divisor for the column "ns each", for example the number of joints; 0: none
  std::vector<std::pair<std::string, double>> extra = {};  ///< additional fields of the JSON file
  std::string note = {};                                   ///< printed at the end of the line
};

class Table {
 public:
  void add(const Row& row);
  [[nodiscard]] const std::vector<Row>& rows() const { return rows_; }

 private:
  std::vector<Row> rows_;
};

/// True if the option --rows PATTERN (a part of the row's name, with * and ?) selects this row, or if there is no such option.
[[nodiscard]] bool is_selected(const std::string& row);

using RowMaker = void (*)(Table&);
struct RowRegistration {
  /// @param order position in the table, unique. Dynamics: humanoid 100, chains 200, batches 300, closed links 400. Collision: convex pairs
  /// 100, mesh pairs 200, characters and many bodies 300. The option --orders LOW-HIGH selects a range.
  RowRegistration(int order, RowMaker maker);
};

/// Returns for each function the minimum time of one call, in ns. The functions alternate in batches of at least 0.1 ms, for about
/// `seconds` each.
[[nodiscard]] std::vector<double> measure(const std::vector<std::function<void()>>& functions, double seconds = 0.4);

/// Throws if two results differ by more than `relative` times their maximum magnitude (at least 1).
void require_same(const std::vector<double>& a, const std::vector<double>& b, double relative, const std::string& what);

}  // namespace ugoki::benchmarks
