#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "ugoki/base/number.h"
#include "ugoki/formats/file_axes.h"
#include "ugoki/formats/marker_axes.h"
#include "ugoki/formats/text.h"
#include "ugoki/formats/trc.h"

namespace ugoki::formats {
namespace {

/// The lines of a text, numbered from 1. Lines end with LF, CR LF or CR.
class Lines {
 public:
  explicit Lines(std::string_view text) : text_(text) {}

  /// Returns the next line without its line end in `line`; false at the end of the text.
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

/// Removes the first column from `rest` and returns it; std::nullopt if the last column has already been returned.
/// @param ended [in, out] true after the last column was returned
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

/// Columns of a line of the header. In some files the header is aligned by blanks although the rows have tabs.
std::vector<std::string_view> header_columns(std::string_view line, char separator) {
  if (separator != '\t' || std::count(line.begin(), line.end(), separator) > 1) return columns_of(line, separator);
  std::vector<std::string_view> out;
  for (std::size_t at = 0; at < line.size();) {
    const std::size_t begin = line.find_first_not_of(" \t", at);
    if (begin == std::string_view::npos) break;
    at = std::min(line.find_first_of(" \t", begin), line.size());
    out.push_back(trimmed(line.substr(begin, at - begin)));
  }
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

  /// Returns the next line that is not blank in `line`; false at the end of the text.
  bool next_line(std::string_view& line) {
    while (lines_.next(line))
      if (!trimmed(line).empty() && line.find_first_not_of("\t, ") != std::string_view::npos) return true;
    return false;
  }

  bool read_head(MarkerMotion& motion, double& metres) {
    std::string_view line;
    if (!next_line(line)) return refuse(ErrorCode::truncated, "The file is empty.", "Export it again.");
    separator_ = line.find('\t') != std::string_view::npos ? '\t' : ',';
    if (!columns_of(line, separator_)[0].starts_with("PathFileType"))
      return refuse(ErrorCode::syntax, "The file does not begin with 'PathFileType'.", "Check that it is a TRC file.");
    std::string_view names, values;
    if (!next_line(names) || !next_line(values))
      return refuse(ErrorCode::truncated, "The file ends within its header.", "Export it again.");
    const auto keys = header_columns(names, separator_), given = header_columns(values, separator_);
    const auto value = [&](std::string_view key) -> std::string_view {
      for (std::size_t i = 0; i < keys.size() && i < given.size(); ++i)
        if (equal_ignoring_case(keys[i], key)) return given[i];
      return {};
    };
    const auto rate = measured_number(value("DataRate"));
    if (!rate || *rate < 1e-3 || *rate > 1e6)
      return refuse(ErrorCode::range,
                    "DataRate is " + in_quotes(value("DataRate")) + "; it must be a number of frames per second between 0.001 and 1e6.",
                    "Write the frame rate under 'DataRate'.");
    motion.rate = *rate;
    if (const auto count = parse_long(value("NumFrames"))) declared_frames_ = *count;
    if (const auto count = parse_long(value("NumMarkers"))) declared_markers_ = *count;
    if (const auto first = parse_long(value("OrigDataStartFrame")); first && *first >= 0 && *first < 1'000'000'000)
      motion.first_frame = static_cast<int>(*first);
    const std::string_view unit = value("Units");
    if (const auto known = metres_of(unit))
      metres = *known;
    else if (!unit.empty())
      notes_.remarks.push_back("The unit of length " + in_quotes(unit) + " is not known.");
    return true;
  }

  /// Reads two lines: the marker names "Frame#  Time  LASI    RASI ..." (each above three columns), and "X1 Y1 Z1 ...".
  bool read_labels(MarkerMotion& motion) {
    std::string_view line;
    if (!next_line(line)) return refuse(ErrorCode::truncated, "The line with the marker names is missing.", "Export the file again.");
    std::vector<std::string_view> columns = header_columns(line, separator_);
    if (columns.size() < 3 || !columns[0].starts_with("Frame"))
      return refuse(ErrorCode::syntax, "The line with the marker names does not begin with 'Frame#' and 'Time'.", "Export the file again.");
    // A name is in the first of its three columns. Empty columns at the end of the line are padding.
    for (std::size_t i = 2; i < columns.size(); i += 3) {
      if (columns[i].empty()) {
        bool more = false;
        for (std::size_t k = i; k < columns.size(); ++k) more = more || !columns[k].empty();
        if (!more) break;
      }
      motion.labels.push_back(columns[i].empty() ? "*" + std::to_string(motion.labels.size()) : utf8(columns[i]));
    }
    // Some programs write other numbers of tabs between names: then names are matched in order, if their number equals NumMarkers.
    std::vector<std::string> named;
    for (std::size_t i = 2; i < columns.size(); ++i)
      if (!columns[i].empty()) named.push_back(utf8(columns[i]));
    if (declared_markers_ >= 0 && declared_markers_ != static_cast<long>(motion.labels.size()) &&
        declared_markers_ == static_cast<long>(named.size()))
      motion.labels = std::move(named);
    if (motion.labels.empty()) return refuse(ErrorCode::structure, "No marker is named.", "Write each name above its three columns.");
    name_duplicates(motion.labels);
    if (!next_line(line) || header_columns(line, separator_).size() < 3)
      return refuse(ErrorCode::truncated, "The line 'X1 Y1 Z1 ...' is missing.", "Export the file again.");
    return true;
  }

  /// Numbers repeated names. Programs that add computed markers repeat names.
  void name_duplicates(std::vector<std::string>& labels) {
    std::set<std::string> used;
    for (std::string& label : labels) {
      const std::string plain = label;
      for (int k = 2; !used.insert(label).second; ++k) label = plain + " " + std::to_string(k);
      if (label != plain) notes_.remarks.push_back("A second marker " + in_quotes(plain) + " was renamed to " + in_quotes(label) + ".");
    }
  }

  /// Compares NumMarkers with the number of names. If they differ, the filled columns of the data rows decide which of them is right.
  bool check_count(MarkerMotion& motion, std::string_view row) {
    const auto named = static_cast<long>(motion.labels.size());
    if (declared_markers_ < 0 || declared_markers_ == named) return true;
    const auto filled_columns = [&](std::string_view line) {
      if (line.starts_with(separator_)) line.remove_prefix(1);
      std::vector<std::string_view> columns = columns_of(line, separator_);
      while (!columns.empty() && columns.back().empty()) columns.pop_back();
      return static_cast<long>(columns.size());
    };
    long filled = filled_columns(row);
    std::string_view line;
    for (Lines rest = lines_; rest.next(line);) filled = std::max(filled, filled_columns(line));
    const long count = filled / 3;  // number of markers with values; the columns of frame number and time add no marker
    const bool padded = static_cast<long>(columns_of(row, separator_).size()) >= 2 + 3 * named;
    if (count == declared_markers_ && declared_markers_ < named && !padded) {
      motion.labels.resize(static_cast<std::size_t>(declared_markers_));
    } else if (declared_markers_ > named && count > named) {
      // Trajectories without a name follow the named ones. Each gets the name `*` and its index.
      const auto all = static_cast<std::size_t>(count);
      while (motion.labels.size() < all) motion.labels.push_back("*" + std::to_string(motion.labels.size()));
    } else if (!(count == named || (padded && count <= named))) {
      return refuse(ErrorCode::structure,
                    "NumMarkers is " + std::to_string(declared_markers_) + ", but " + std::to_string(named) +
                        " markers are named, and the row has values of " + std::to_string(count) + " markers.",
                    "Correct 'NumMarkers' or the names.");
    }
    notes_.remarks.push_back("NumMarkers is " + std::to_string(declared_markers_) + ", but " + std::to_string(named) +
                             " markers are named; " + std::to_string(motion.labels.size()) +
                             " are assumed, because the rows have columns for them.");
    return true;
  }

  bool read_rows(MarkerMotion& motion) {
    if (lines_.remaining() / 2 > max_numbers)
      return refuse(ErrorCode::range, "The file has more than 400 million numbers.", "Split it into several files.");
    std::string_view line;
    bool first = true;
    while (next_line(line)) {
      if (line.front() == separator_) line.remove_prefix(1);  // an empty column before the frame number
      if (first && !check_count(motion, line)) return false;
      first = false;
      const std::size_t n = motion.labels.size();
      bool ended = false;
      const auto frame = next_column(line, separator_, ended);
      const auto time = next_column(line, separator_, ended);
      const bool numbered = frame && time && (!frame->empty() || !time->empty());
      if (!numbered && declared_frames_ > 0 && times_.size() == static_cast<std::size_t>(declared_frames_)) {
        // Spreadsheets leave results of the user's own formulas below the last frame.
        if (std::exchange(trailing_, true)) continue;
        notes_.remarks.push_back("Values below the last frame, which have no frame number (first in line " +
                                 std::to_string(lines_.number()) + "), are left out.");
        continue;
      }
      if (!frame || !time || !measured_number(*frame) || !measured_number(*time)) {
        const std::string_view wrong = frame && !measured_number(*frame) ? *frame : time.value_or("");
        refuse(ErrorCode::syntax, "The row begins with " + in_quotes(wrong) + " instead of the frame number and time.", "Correct the row.");
        if (problems_.full()) return false;
        continue;
      }
      times_.push_back(*measured_number(*time));
      last_columns_ = static_cast<std::size_t>(std::count(line.begin(), line.end(), separator_));
      max_columns_ = std::max(max_columns_, last_columns_);
      for (std::size_t i = 0; i < n; ++i) read_marker(motion, line, ended);
      if (problems_.full()) return false;
      if (!ended && line.find_first_not_of("\t, ") != std::string_view::npos)
        refuse(ErrorCode::structure, "The row has more values than " + std::to_string(n) + " markers need.", "Correct the row.");
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
    if (motion.frames == 0) return refuse(ErrorCode::truncated, "The file has no frames.", "Export it again.");
    if (declared_frames_ >= 0 && declared_frames_ != motion.frames) {
      if (last_columns_ < max_columns_ || declared_frames_ < motion.frames)
        return refuse(declared_frames_ < motion.frames ? ErrorCode::structure : ErrorCode::truncated,
                      "NumFrames is " + std::to_string(declared_frames_) + ", but there are " + std::to_string(motion.frames) + " rows" +
                          (last_columns_ < max_columns_ ? ", the last one incomplete." : "."),
                      "Export the file again, or correct 'NumFrames'.");
      notes_.remarks.push_back("NumFrames is " + std::to_string(declared_frames_) + ", but the file has " + std::to_string(motion.frames) +
                               " complete rows; all of them are read.");
    }
    if (motion.frames > 1) {
      const double step = (times_.back() - times_.front()) / (motion.frames - 1);
      if (step > 0 && std::fabs(step * motion.rate - 1) > 0.01) {
        const double usual = steady_step();
        notes_.remarks.push_back("The times of the rows correspond to " + to_fixed(1 / step, 2) + " frames per second, but DataRate is " +
                                 to_fixed(motion.rate, 2) +
                                 (usual > 0 ? "; the times are assumed to be right." : "; DataRate is assumed to be right."));
        if (usual > 0) motion.rate = 1 / usual;
      }
      notes_.frame_time = step;
    }
    return true;
  }

  /// Median step of the rows' times, s; 0 if there are fewer than 10 times, or more than a tenth of the steps differ from the median by a
  /// fifth (times with three decimals at 250 frames/s are rounded by an eighth).
  [[nodiscard]] double steady_step() const {
    if (times_.size() < 10) return 0;
    std::vector<double> steps;
    for (std::size_t i = 1; i < times_.size(); ++i) steps.push_back(times_[i] - times_[i - 1]);
    const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
    std::nth_element(steps.begin(), middle, steps.end());
    const double usual = *middle;
    const auto others = std::ranges::count_if(steps, [&](double s) { return std::fabs(s - usual) > 0.2 * usual; });
    return usual > 0 && 10 * static_cast<std::size_t>(others) <= steps.size() ? usual : 0;
  }

  Lines lines_;
  std::string_view name_;
  Problems& problems_;
  ReadNotes& notes_;
  char separator_ = '\t';
  long declared_frames_ = -1, declared_markers_ = -1;  ///< from the header; -1: not given
  bool trailing_ = false;                              ///< values below the last frame were found
  std::size_t last_columns_ = 0, max_columns_ = 0;     ///< number of value columns in the last row, and maximum over all rows
  std::vector<double> times_;                          ///< [frames] s
};

}  // namespace

Result<MarkerMotion> read_trc(std::string_view text, std::string_view file_name, const MarkerOptions& options, ReadNotes* notes) {
  ReadNotes own;
  ReadNotes& collected = notes != nullptr ? *notes : own;
  Problems problems(file_name);
  const auto plain = plain_text(text, "TRC", problems);
  if (!plain) return fail(problems.take());
  MarkerMotion motion;
  double metres = 0;
  if (!Reader(*plain, file_name, problems, collected).read(motion, metres)) return fail(problems.take());
  motion.name = stem_of(file_name);
  motion.source = std::string(file_name);
  if (!to_our_axes(motion, options, UpAxis::automatic, metres, collected)) {
    problems.add(ErrorCode::range, 1, "A marker is farther than 1e9 m from the origin.", "Set the correct unit of length.");
    return fail(problems.take());
  }
  return motion;
}

}  // namespace ugoki::formats
