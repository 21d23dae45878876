#pragma once
// The table of results of `ugoki bake`: an SQLite file, or a table in the PostgreSQL database of a shared library.

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "sweep.h"
#include "ugoki/base/result.h"
#include "ugoki/json/json.h"
#include "ugoki/store/connection.h"
#include "ugoki/sweep/results.h"

namespace ugoki::cli {

/// The runs that have a row but no result.
struct SweepFailures {
  std::uint64_t count = 0;
  std::string first;  ///< status and message of the first one
};

/// A table of results with a row for each finished run.
class SweepTable {
 public:
  /// Creates the table, or opens an existing table that has the same plan.
  /// Errors: the table has another plan; another `ugoki bake` uses the SQLite file; the server cannot be reached.
  [[nodiscard]] static Result<SweepTable> open(const sweep::TableAddress& address, const SweepPlan& plan);
  /// Numbers of the runs that have a row, ascending.
  [[nodiscard]] Result<std::vector<std::uint64_t>> finished();
  /// The runs of a part (index, index + parts, ...) whose status is not `done`.
  [[nodiscard]] Result<SweepFailures> failures(std::uint64_t index, std::uint64_t parts);
  /// Adds the row of a run, unless the table has a row with the same number. The row is on the disk when this function returns.
  /// @param row JSON object: status, message, steps, processor_s, state_hash, measures
  [[nodiscard]] Result<void> add(std::uint64_t number, const std::string& target, const std::vector<std::string>& values,
                                 const json::Json& row);
  /// Copies the rows that this table lacks from the SQLite file `path`, which must have the same plan. @return number of rows copied
  [[nodiscard]] Result<std::int64_t> merge(const std::string& path);
  /// Returns the table as CSV, ordered by run number.
  [[nodiscard]] Result<std::string> csv();

  SweepTable(SweepTable&& other) noexcept
      : connection_(std::move(other.connection_)),
        lock_(std::exchange(other.lock_, -1)),
        table_(std::move(other.table_)),
        plan_(std::move(other.plan_)),
        columns_(std::move(other.columns_)) {}
  SweepTable& operator=(SweepTable&&) = delete;
  ~SweepTable();

 private:
  SweepTable(std::unique_ptr<store::Connection> connection, int lock) : connection_(std::move(connection)), lock_(lock) {}
  [[nodiscard]] Result<void> prepare(const sweep::TableAddress& address, const SweepPlan& plan);
  [[nodiscard]] Result<bool> insert(const std::vector<store::Value>& cells);

  std::unique_ptr<store::Connection> connection_;
  int lock_ = -1;                     // file descriptor of the lock file, which is locked; -1 for PostgreSQL
  std::string table_;                 // quoted name of the table of runs
  std::string plan_;                  // SweepPlan::text()
  std::vector<std::string> columns_;  // all columns of the table of runs
};

}  // namespace ugoki::cli
