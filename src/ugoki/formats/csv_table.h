#pragma once
// Tables of numbers as text; internal to formats.

#include <string>
#include <string_view>
#include <vector>

#include "ugoki/formats/text.h"

namespace ugoki::formats {

struct CsvColumn {
  std::string name;  ///< without unit
  std::string unit;  ///< in brackets in the head; empty: none
};

struct CsvTable {
  std::vector<CsvColumn> columns;
  std::vector<double> numbers;  ///< [rows][columns]; NaN where a place is empty or says nan
  std::vector<int> lines;       ///< [rows] of the file
  double rate = 0;              ///< of a line "# rate: 120"; 0: none
  std::string up;               ///< of a line "# up: z"; empty: none

  [[nodiscard]] std::size_t rows() const { return lines.size(); }
  [[nodiscard]] double at(std::size_t row, std::size_t column) const { return numbers[row * columns.size() + column]; }
};

/// Lines that begin with # are comments, of which "# rate: N" and "# up: y" are read; the first other line is the head. Names may stand in
/// quotes (RFC 4180). The separator is the one of tab, semicolon and comma that the head has, in this order. False: problems were added.
/// @param rows false: only the head
[[nodiscard]] bool read_csv_table(std::string_view text, Problems& problems, CsvTable& table, bool rows = true);

/// In quotes where it must be.
[[nodiscard]] std::string csv_name(std::string_view name);

}  // namespace ugoki::formats
