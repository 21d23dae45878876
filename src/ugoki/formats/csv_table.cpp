#include "ugoki/formats/csv_table.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace ugoki::formats {
namespace {

std::string_view trimmed(std::string_view s) {
  while (!s.empty() && (s.front() == ' ' || s.front() == '\t')) s.remove_prefix(1);
  while (!s.empty() && (s.back() == ' ' || s.back() == '\t')) s.remove_suffix(1);
  return s;
}

/// Splits the header line into its fields and removes quotes. Returns false if a closing quote is missing.
bool split_names(std::string_view line, char separator, std::vector<std::string>& out) {
  std::string field;
  bool quoted = false, was_quoted = false;
  for (std::size_t i = 0; i <= line.size(); ++i) {
    if (i == line.size() || (!quoted && line[i] == separator)) {
      if (quoted) return false;
      out.emplace_back(was_quoted ? std::string_view(field) : trimmed(field));
      field.clear();
      was_quoted = false;
    } else if (line[i] == '"') {
      if (quoted && i + 1 < line.size() && line[i + 1] == '"') {
        field += '"';
        ++i;
      } else {
        quoted = !quoted;
        was_quoted = true;
      }
    } else {
      field += line[i];
    }
  }
  return true;
}

/// Reads the values in the comments "# rate: N" and "# up: y"; ignores other comments.
void read_comment(std::string_view line, CsvTable& table) {
  line.remove_prefix(1);
  const std::size_t colon = line.find(':');
  if (colon == std::string_view::npos) return;
  const std::string_view key = trimmed(line.substr(0, colon)), value = trimmed(line.substr(colon + 1));
  if (equal_ignoring_case(key, "rate"))
    if (const auto x = measured_number(value); x && *x >= 1e-3 && *x <= 1e6) table.rate = *x;
  if (equal_ignoring_case(key, "up") && value.size() <= 2) table.up = std::string(value);
}

}  // namespace

std::string csv_name(std::string_view name) {
  if (name.find_first_of(",;\t\"\n\r#[") == std::string_view::npos && !name.empty() && name.front() != ' ' && name.back() != ' ')
    return std::string(name);
  std::string out = "\"";
  for (const char c : name) {
    if (c == '"') out += '"';
    out += c == '\n' || c == '\r' ? ' ' : c;
  }
  return out + "\"";
}

bool read_csv_table(std::string_view text, Problems& problems, CsvTable& table, bool rows) {
  const auto plain = plain_text(text, "CSV", problems);
  if (!plain) return false;
  text = *plain;
  char separator = 0;
  int number = 0;
  std::size_t width = 0;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find_first_of("\r\n", at), text.size());
    std::string_view line = text.substr(at, end - at);
    at = end + (text.substr(end).starts_with("\r\n") ? 2 : 1);
    ++number;
    if (trimmed(line).empty()) continue;
    if (trimmed(line).front() == '#') {
      read_comment(trimmed(line), table);
      continue;
    }
    if (separator == 0) {
      separator = line.find('\t') != std::string_view::npos ? '\t' : line.find(';') != std::string_view::npos ? ';' : ',';
      std::vector<std::string> names;
      if (!split_names(line, separator, names)) {
        problems.add(ErrorCode::syntax, number, "The quotes of a column name are not closed.", "Add the closing quote.");
        return false;
      }
      if (names.size() > 3 * max_joints + 2) {
        problems.add(ErrorCode::range, number, "The file has more than " + std::to_string(3 * max_joints) + " columns.",
                     "Check that it is motion data.");
        return false;
      }
      for (std::string& name : names) {
        CsvColumn column;
        if (const std::size_t open = name.rfind('['); open != std::string::npos && name.ends_with(']')) {
          column.unit = name.substr(open + 1, name.size() - open - 2);
          name = std::string(trimmed(std::string_view(name).substr(0, open)));
        }
        column.name = utf8(name);
        table.columns.push_back(std::move(column));
      }
      width = table.columns.size();
      if (!rows) return true;
      continue;
    }
    if (table.numbers.size() + width > max_numbers) {
      problems.add(ErrorCode::range, number, "The file has more than 400 million numbers.", "Split it into several files.");
      return false;
    }
    table.lines.push_back(number);
    std::size_t n = 0;
    for (bool more = true; more;) {
      const std::size_t stop = line.find(separator);
      more = stop != std::string_view::npos;
      std::string_view field = trimmed(line.substr(0, stop));
      if (field.size() >= 2 && field.front() == '"' && field.back() == '"') field = trimmed(field.substr(1, field.size() - 2));
      if (more) line.remove_prefix(stop + 1);
      if (!more && field.empty() && n == width) break;  // a separator at the end of the line does not begin another field
      double value = std::numeric_limits<double>::quiet_NaN();
      if (!field.empty() && !equal_ignoring_case(field, "nan")) {
        const auto x = measured_number(field);
        if (!x) {
          const NumberFault fault = number_fault(field);
          problems.add(fault.code, number, fault.message, fault.remedy);
          if (problems.full()) return false;
        }
        value = x.value_or(0);
      }
      if (++n <= width) table.numbers.push_back(value);
    }
    if (n != width) {
      problems.add(ErrorCode::structure, number,
                   "The row has " + std::to_string(n) + " fields, but the header line has " + std::to_string(width) + " columns.",
                   "Correct the row, or export the file again.");
      if (problems.full()) return false;
      table.numbers.resize(table.lines.size() * width, 0);
    }
  }
  if (separator == 0)
    problems.add(ErrorCode::truncated, std::max(number, 1), "The line with the column names is missing.",
                 "Write it before the first row of numbers.");
  else if (table.lines.empty())
    problems.add(ErrorCode::truncated, std::max(number, 1), "The file has no rows.", "Export it again.");
  return problems.empty();
}

}  // namespace ugoki::formats
