#include "ugoki/formats/motive_csv.h"

#include <cmath>
#include <set>

#include "ugoki/formats/marker_axes.h"
#include "ugoki/formats/text.h"

namespace ugoki::formats {
namespace {

std::vector<std::string_view> fields_of(std::string_view line) {
  std::vector<std::string_view> out;
  for (std::size_t from = 0;;) {
    const std::size_t end = std::min(line.find(',', from), line.size());
    std::string_view field = line.substr(from, end - from);
    while (!field.empty() && (field.front() == ' ' || field.front() == '"')) field.remove_prefix(1);
    while (!field.empty() && (field.back() == ' ' || field.back() == '"')) field.remove_suffix(1);
    out.push_back(field);
    if (end == line.size()) return out;
    from = end + 1;
  }
}

/// A marker's three columns.
struct Point {
  std::string name;
  std::size_t column = 0;
};

class Reader {
 public:
  Reader(std::string_view text, Problems& problems, ReadNotes& notes) : scan_(text), problems_(problems), notes_(notes) {}

  bool read(MarkerMotion& motion, double& metres) { return read_head(motion, metres) && read_columns(motion) && read_rows(motion); }

 private:
  bool refuse(ErrorCode code, const std::string& message, const std::string& remedy) {
    problems_.add(code, scan_.line(), message, remedy);
    return false;
  }

  bool read_head(MarkerMotion& motion, double& metres) {
    const std::vector<std::string_view> head = fields_of(scan_.rest_of_line());
    std::string_view rate;
    for (std::size_t i = 0; i + 1 < head.size(); i += 2) {
      if (equal_ignoring_case(head[i], "Export Frame Rate") || (rate.empty() && equal_ignoring_case(head[i], "Capture Frame Rate")))
        rate = head[i + 1];
      if (equal_ignoring_case(head[i], "Length Units")) {
        const std::string_view unit = head[i + 1];
        metres = equal_ignoring_case(unit, "Meters")        ? 1
                 : equal_ignoring_case(unit, "Centimeters") ? 0.01
                 : equal_ignoring_case(unit, "Millimeters") ? 0.001
                                                            : metres_of(unit).value_or(0);
      }
    }
    const std::optional<double> number = measured_number(rate);
    if (!number || !(*number >= 1e-3 && *number <= 1e6))
      return refuse(ErrorCode::range, "The frame rate " + in_quotes(rate) + " is missing or not between 0.001 and 1e6 per second.",
                    "Export the take again, with its header.");
    motion.rate = *number;
    return true;
  }

  /// Reads the rows above the numbers: types, names, others, "Position" or "Rotation", and the axes.
  bool read_columns(MarkerMotion& motion) {
    std::vector<std::vector<std::string_view>> rows;
    for (;;) {
      if (!scan_.skip_space() || rows.size() > 20)
        return refuse(ErrorCode::truncated, "The row with the axes, which begins with 'Frame', is missing.", "Export the take again.");
      std::vector<std::string_view> row = fields_of(scan_.rest_of_line());
      bool blank = true;
      for (const std::string_view field : row) blank = blank && field.empty();
      if (blank) continue;
      rows.push_back(std::move(row));
      if (equal_ignoring_case(rows.back()[0], "Frame")) break;
    }
    if (rows.size() < 4)
      return refuse(ErrorCode::structure, "The rows with types, names and quantities of the columns are missing.",
                    "Export the take again.");
    const auto &types = rows.front(), &names = rows[1], &quantities = rows[rows.size() - 2], &axes = rows.back();
    width_ = axes.size();
    const auto at = [](const std::vector<std::string_view>& row, std::size_t i) { return i < row.size() ? row[i] : std::string_view(); };
    std::vector<Point> labelled, modelled, unlabelled;
    std::size_t others = 0;
    for (std::size_t i = 2; i + 2 < axes.size(); ++i) {
      if (!equal_ignoring_case(at(quantities, i), "Position") || axes[i] != "X" || axes[i + 1] != "Y" || axes[i + 2] != "Z") continue;
      const std::string_view type = at(types, i), name = at(names, i);
      if (!type.ends_with("Marker")) {
        ++others;
        continue;
      }
      const bool free = name.empty() || name.starts_with("Unlabeled");
      (type != "Marker" ? modelled : free ? unlabelled : labelled).push_back({utf8(name), i});
    }
    for (std::vector<Point>* list : {&labelled, &modelled, &unlabelled}) {
      std::set<std::string> known;
      if (!points_.empty()) break;
      for (Point& p : *list) {
        if (p.name.empty()) p.name = "column " + std::to_string(p.column + 1);
        if (known.insert(p.name).second) points_.push_back(std::move(p));
      }
    }
    if (points_.empty())
      return refuse(ErrorCode::structure, "The file has no positions of markers.", "Export the take with its markers, or as BVH.");
    if (others > 0) notes_.remarks.push_back(std::to_string(others) + " rigid bodies or bones are left out; the markers are read.");
    for (const Point& p : points_) motion.labels.push_back(p.name);
    return true;
  }

  bool read_rows(MarkerMotion& motion) {
    bool first = true;
    while (scan_.skip_space()) {
      const std::vector<std::string_view> row = fields_of(scan_.rest_of_line());
      if (row.size() > width_ + 1 || row.size() < 2)
        return refuse(ErrorCode::structure,
                      "The row has " + std::to_string(row.size()) + " columns, but the header has " + std::to_string(width_) + ".",
                      "Export the take again.");
      if (first)
        if (const std::optional<double> frame = measured_number(row[0]); frame && *frame >= 0 && *frame < 1e9)
          motion.first_frame = static_cast<int>(*frame) + 1;
      first = false;
      if (motion.positions.size() + points_.size() > max_numbers / 4)
        return refuse(ErrorCode::range, "The file has more than 100 million positions.", "Export fewer frames.");
      for (const Point& p : points_) {
        Vec3 x;
        bool seen = true;
        for (std::size_t k = 0; k < 3; ++k) {
          const std::string_view field = p.column + k < row.size() ? row[p.column + k] : std::string_view();
          if (field.empty()) {
            seen = false;
            continue;
          }
          const std::optional<double> number = measured_number(field);
          if (!number) {
            const NumberFault fault = number_fault(field);
            return refuse(fault.code, fault.message, fault.remedy);
          }
          x[static_cast<int>(k)] = *number;
        }
        motion.positions.push_back(seen ? x : Vec3{});
        motion.residuals.push_back(seen ? 0.0f : -1.0f);
      }
      ++motion.frames;
    }
    return motion.frames > 0 || refuse(ErrorCode::truncated, "The file has no frames.", "Export the take again.");
  }

  Scanner scan_;
  Problems& problems_;
  ReadNotes& notes_;
  std::vector<Point> points_;
  std::size_t width_ = 0;
};

}  // namespace

bool is_motive_csv(std::string_view text) {
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  return text.starts_with("Format Version,");
}

Result<MarkerMotion> read_motive_csv(std::string_view text, std::string_view file_name, const MarkerOptions& options, ReadNotes& notes) {
  Problems problems(file_name);
  const std::optional<std::string_view> plain = plain_text(text, "CSV", problems);
  if (!plain) return fail(problems.take());
  MarkerMotion motion;
  motion.name = stem_of(file_name);
  motion.source = std::string(file_name);
  double metres = 0;
  if (!Reader(*plain, problems, notes).read(motion, metres)) return fail(problems.take());
  notes.frame_time = 1 / motion.rate;
  if (!to_our_axes(motion, options, UpAxis::y, metres, notes))
    return fail(ErrorCode::range, std::string(file_name), "A marker is farther than 1e9 m from the origin.", "Check the unit.");
  return motion;
}

}  // namespace ugoki::formats
