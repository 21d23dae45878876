#pragma once
// A CSV file as a table of numbers. Internal to formats.

#include <string>
#include <string_view>
#include <vector>

#include "ugoki/formats/text.h"

namespace ugoki::formats {

struct CsvColumn {
  std::string name;  ///< without the unit
  std::string unit;  ///< the text in brackets after the name, as in "time[s]"; empty: none
};

struct CsvTable {
  std::vector<CsvColumn> columns;
  std::vector<double> numbers;  ///< [rows][columns]; NaN where the field is empty or "nan"
  std::vector<int> lines;       ///< [rows] line number in the file
  double rate = 0;              ///< frames per second from a comment "# rate: 120"; 0: none
  std::string up;               ///< up axis from a comment "# up: z"; empty: none

  [[nodiscard]] std::size_t rows() const { return lines.size(); }
  [[nodiscard]] double at(std::size_t row, std::size_t column) const { return numbers[row * columns.size() + column]; }
};

/// Reads a table. Lines that begin with # are comments; only "# rate: N" and "# up: y" are used. The first other line that is not blank is
/// the header line with the column names, which may be quoted (RFC 4180). The separator is the first of tab, semicolon and comma that
/// occurs in the header line. Returns false if problems were added.
/// @param rows false: read only the header line
[[nodiscard]] bool read_csv_table(std::string_view text, Problems& problems, CsvTable& table, bool rows = true);

/// Returns `name` as a CSV field: quoted if it contains a separator, quote, line end, '#' or '[', or begins or ends with a blank.
[[nodiscard]] std::string csv_name(std::string_view name);

}  // namespace ugoki::formats
