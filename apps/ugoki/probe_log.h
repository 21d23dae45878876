#pragma once
// Log of the probed (sampled) pin values of a run, in memory that the guarded process shares with its parent, so that it survives a crash.

#include <cstddef>
#include <cstdint>
#include <span>

#include "ugoki/base/result.h"

namespace ugoki::cli {

/// A ring buffer of rows: a tick and the numbers of all probed pins. Open it before the fork; the child calls begin and add, and both
/// processes read.
class ProbeLog {
 public:
  static constexpr std::size_t max_rows = 100'000;  ///< number of rows that are kept; older rows are overwritten

  ProbeLog() = default;
  ProbeLog(const ProbeLog&) = delete;
  ProbeLog& operator=(const ProbeLog&) = delete;
  ~ProbeLog();

  /// Creates the shared memory. Error: the system could not create it.
  [[nodiscard]] Result<void> open();
  /// Empties the log. @param width count of numbers in a row. Error: there is not enough memory.
  [[nodiscard]] Result<void> begin(std::size_t width);
  void add(std::uint64_t tick, std::span<const double> numbers);

  /// Reads what another process has written. Call it after that process has ended. False: begin was never called.
  [[nodiscard]] bool attach();
  [[nodiscard]] std::size_t width() const { return header_ ? header_->width : 0; }  ///< number of values in a row; 0: before begin()
  [[nodiscard]] std::size_t size() const;                                           ///< number of stored rows
  [[nodiscard]] std::uint64_t tick(std::size_t row) const;                          ///< tick of a row; row 0 is the oldest
  [[nodiscard]] std::span<const double> numbers(std::size_t row) const;             ///< [width] values of the row

 private:
  struct Header {
    std::uint64_t width, rows, written;  // rows: capacity; written: rows so far, including overwritten ones
  };
  [[nodiscard]] std::byte* row_at(std::uint64_t index) const;
  [[nodiscard]] bool map(std::size_t bytes);
  void unmap();

  int file_ = -1;
  Header* header_ = nullptr;  // begin of the shared memory; the rows follow the header
  std::size_t bytes_ = 0;     // size of the shared memory, bytes
};

}  // namespace ugoki::cli
