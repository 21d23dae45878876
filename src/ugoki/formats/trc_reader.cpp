#include <algorithm>
#include <cmath>
#include <optional>

#include "ugoki/base/number.h"
#include "ugoki/formats/file_axes.h"
#include "ugoki/formats/marker_axes.h"
#include "ugoki/formats/text.h"
#include "ugoki/formats/trc.h"

namespace ugoki::formats {
namespace {

/// Lines of a text, and the columns of a line. Lines end with LF, CR LF or CR.
class Lines {
 public:
  explicit Lines(std::string_view text) : text_(text) {}

  bool next(std::string_view& line) {
    if (at_ >= text_.size()) return false;
    const std::size_t end = std::min(text_.find_first_of("\r\n", at_), text_.size());
    line = text_.substr(at_, end - at_);
    at_ = end + (text_.substr(end).starts_with("\r\n") ? 2 : 1);
    ++number_;
    return true;
  }
  [[nodiscard]] int number() const { return number_; }
  [[nodiscard]] std::size_t remaining() const { return text_.size() - std::min(at_, text_.size()); }

 private:
  std::string_view text_;
  std::size_t at_ = 0;
  int number_ = 0;
};

std::string_view trimmed(std::string_view s) {
  while (!s.empty() && (s.front() == ' ' || s.front() == '"')) s.remove_prefix(1);
  while (!s.empty() && (s.back() == ' ' || s.back() == '"')) s.remove_suffix(1);
  return s;
}

/// The next column of `rest`, which loses it; nothing at the line's end.
std::optional<std::string_view> next_column(std::string_view& rest, char separator, bool& ended) {
  if (ended) return std::nullopt;
  const std::size_t end = rest.find(separator);
  const std::string_view column = trimmed(rest.substr(0, end));
  ended = end == std::string_view::npos;
  if (!ended) rest.remove_prefix(end + 1);
  return column;
}

std::vector<std::string_view> columns_of(std::string_view line, char separator) {
  std::vector<std::string_view> out;
  bool ended = false;
  while (const auto column = next_column(line, separator, ended)) out.push_back(*column);
  return out;
}

class Reader {
 public:
  Reader(std::string_view text, std::string_view name, Problems& problems, ReadNotes& notes)
      : lines_(text), name_(name), problems_(problems), notes_(notes) {}

  bool read(MarkerMotion& motion, double& metres) {
    return read_head(motion, metres) && read_labels(motion) && read_rows(motion) && finish(motion);
  }

 private:
  bool refuse(ErrorCode code, const std::string& message, const std::string& remedy) {
    problems_.add(code, std::max(lines_.number(), 1), message, remedy);
    return false;
  }

  /// The next line that holds anything.
  bool next_line(std::string_view& line) {
    while (lines_.next(line))
      if (!trimmed(line).empty() && line.find_first_not_of("\t, ") != std::string_view::npos) return true;
    return false;
  }

  bool read_head(MarkerMotion& motion, double& metres) {
    std::string_view line;
    if (!next_line(line)) return refuse(ErrorCode::truncated, "the file is empty.", "Export it again.");
    separator_ = line.find('\t') != std::string_view::npos ? '\t' : ',';
    if (!columns_of(line, separator_)[0].starts_with("PathFileType"))
      return refuse(ErrorCode::syntax, "a TRC file begins with 'PathFileType'.", "Check the file's type.");
    std::string_view names, values;
    if (!next_line(names) || !next_line(values)) return refuse(ErrorCode::truncated, "the file ends within its head.", "Export it again.");
    const auto keys = columns_of(names, separator_), given = columns_of(values, separator_);
    const auto value = [&](std::string_view key) -> std::string_view {
      for (std::size_t i = 0; i < keys.size() && i < given.size(); ++i)
        if (equal_ignoring_case(keys[i], key)) return given[i];
      return {};
    };
    const auto rate = measured_number(value("DataRate"));
    if (!rate || *rate < 1e-3 || *rate > 1e6)
      return refuse(ErrorCode::range, "DataRate is " + in_quotes(value("DataRate")) + " instead of frames a second.",
                    "Write the rate under 'DataRate'.");
    motion.rate = *rate;
    if (const auto count = parse_long(value("NumFrames"))) promised_frames_ = *count;
    if (const auto count = parse_long(value("NumMarkers"))) promised_markers_ = *count;
    if (const auto first = parse_long(value("OrigDataStartFrame")); first && *first >= 0 && *first < 1'000'000'000)
      motion.first_frame = static_cast<int>(*first);
    const std::string_view unit = value("Units");
    if (const auto known = metres_of(unit))
      metres = *known;
    else if (!unit.empty())
      notes_.remarks.push_back("The unit of length " + in_quotes(unit) + " is not known.");
    return true;
  }

  /// "Frame#  Time  LASI    RASI ...", each name over three columns, then the line "X1 Y1 Z1 ...".
  bool read_labels(MarkerMotion& motion) {
    std::string_view line;
    if (!next_line(line)) return refuse(ErrorCode::truncated, "the line of the markers' names is missing.", "Export the file again.");
    std::vector<std::string_view> columns = columns_of(line, separator_);
    if (columns.size() < 3 || !columns[0].starts_with("Frame"))
      return refuse(ErrorCode::syntax, "the line of the markers' names begins with 'Frame#' and 'Time'.", "Export the file again.");
    // Empty columns within belong to the name before; empty ones at the end to the line.
    for (std::size_t i = 2; i < columns.size(); i += 3) {
      if (columns[i].empty()) {
        bool more = false;
        for (std::size_t k = i; k < columns.size(); ++k) more = more || !columns[k].empty();
        if (!more) break;
      }
      motion.labels.push_back(columns[i].empty() ? "*" + std::to_string(motion.labels.size()) : utf8(columns[i]));
    }
    if (motion.labels.empty()) return refuse(ErrorCode::structure, "no marker is named.", "Write each name over three columns.");
    if (promised_markers_ >= 0 && promised_markers_ != static_cast<long>(motion.labels.size()))
      return refuse(
          ErrorCode::structure,
          "NumMarkers is " + std::to_string(promised_markers_) + ", but " + std::to_string(motion.labels.size()) + " markers are named.",
          "Correct 'NumMarkers' or the names.");
    std::vector<std::string> sorted = motion.labels;
    std::sort(sorted.begin(), sorted.end());
    if (const auto twice = std::adjacent_find(sorted.begin(), sorted.end()); twice != sorted.end())
      return refuse(ErrorCode::duplicate, "two markers are called " + in_quotes(*twice) + ".", "Give each marker a name of its own.");
    if (!next_line(line) || columns_of(line, separator_).size() < 3)
      return refuse(ErrorCode::truncated, "the line 'X1 Y1 Z1 ...' is missing.", "Export the file again.");
    return true;
  }

  bool read_rows(MarkerMotion& motion) {
    const std::size_t n = motion.labels.size();
    if (lines_.remaining() / 2 > max_numbers)
      return refuse(ErrorCode::range, "the file has more than 400 million numbers.", "Cut it into parts.");
    std::string_view line;
    while (next_line(line)) {
      bool ended = false;
      const auto frame = next_column(line, separator_, ended);
      const auto time = next_column(line, separator_, ended);
      if (!frame || !time || !measured_number(*frame) || !measured_number(*time)) {
        const std::string_view wrong = frame && !measured_number(*frame) ? *frame : time.value_or("");
        refuse(ErrorCode::syntax, "a row begins with the frame's number and time, not " + in_quotes(wrong) + ".", "Correct the row.");
        if (problems_.full()) return false;
        continue;
      }
      times_.push_back(*measured_number(*time));
      last_columns_ = static_cast<std::size_t>(std::count(line.begin(), line.end(), separator_));
      most_columns_ = std::max(most_columns_, last_columns_);
      for (std::size_t i = 0; i < n; ++i) read_marker(motion, line, ended);
      if (problems_.full()) return false;
      if (!ended && line.find_first_not_of("\t, ") != std::string_view::npos)
        refuse(ErrorCode::structure, "the row has more numbers than the " + std::to_string(n) + " markers need.", "Correct the row.");
    }
    return problems_.empty();
  }

  void read_marker(MarkerMotion& motion, std::string_view& line, bool& ended) {
    Vec3 x;
    bool seen = true;
    for (int k = 0; k < 3; ++k) {
      const auto column = next_column(line, separator_, ended);
      if (!column || column->empty() || equal_ignoring_case(*column, "nan")) {
        seen = false;
        continue;
      }
      const auto number = measured_number(*column);
      if (!number) {
        const NumberFault fault = number_fault(*column);
        problems_.add(fault.code, lines_.number(), fault.message, fault.remedy);
        seen = false;
        if (problems_.full()) return;
      }
      x[k] = number.value_or(0);
    }
    motion.positions.push_back(seen ? x : Vec3{});
    motion.residuals.push_back(seen ? 0.0f : -1.0f);
  }

  bool finish(MarkerMotion& motion) {
    motion.frames = static_cast<int>(times_.size());
    if (motion.frames == 0) return refuse(ErrorCode::truncated, "the file has no frames.", "Export it again.");
    if (promised_frames_ >= 0 && promised_frames_ != motion.frames) {
      if (last_columns_ < most_columns_ || promised_frames_ < motion.frames)
        return refuse(promised_frames_ < motion.frames ? ErrorCode::structure : ErrorCode::truncated,
                      "NumFrames is " + std::to_string(promised_frames_) + ", but there are " + std::to_string(motion.frames) + " rows" +
                          (last_columns_ < most_columns_ ? ", the last one not whole." : "."),
                      "Export the file again, or correct 'NumFrames'.");
      notes_.remarks.push_back("NumFrames is " + std::to_string(promised_frames_) + ", but the file holds " +
                               std::to_string(motion.frames) + " rows, all whole; these are read.");
    }
    if (motion.frames > 1) {
      const double step = (times_.back() - times_.front()) / (motion.frames - 1);
      if (step > 0 && std::fabs(step * motion.rate - 1) > 0.01)
        notes_.remarks.push_back("The rows' times are " + to_fixed(1 / step, 2) + " a second apart and not " + to_fixed(motion.rate, 2) +
                                 " as DataRate says; DataRate is taken.");
      notes_.frame_time = step;
    }
    return true;
  }

  Lines lines_;
  std::string_view name_;
  Problems& problems_;
  ReadNotes& notes_;
  char separator_ = '\t';
  long promised_frames_ = -1, promised_markers_ = -1;
  std::size_t last_columns_ = 0, most_columns_ = 0;
  std::vector<double> times_;
};

}  // namespace

Result<MarkerMotion> read_trc(std::string_view text, std::string_view file_name, const MarkerOptions& options, ReadNotes* notes) {
  ReadNotes own;
  ReadNotes& told = notes != nullptr ? *notes : own;
  Problems problems(file_name);
  const auto plain = plain_text(text, "TRC", problems);
  if (!plain) return fail(problems.take());
  MarkerMotion motion;
  double metres = 0;
  if (!Reader(*plain, file_name, problems, told).read(motion, metres)) return fail(problems.take());
  motion.name = stem_of(file_name);
  motion.source = std::string(file_name);
  if (!to_our_axes(motion, options, UpAxis::automatic, metres, told)) {
    problems.add(ErrorCode::range, 1, "a marker is farther than 1e9 m from the origin.", "Give the right unit of length.");
    return fail(problems.take());
  }
  return motion;
}

}  // namespace ugoki::formats
