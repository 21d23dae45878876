#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "ugoki/base/number.h"
#include "ugoki/formats/csv.h"
#include "ugoki/formats/csv_coordinates.h"
#include "ugoki/formats/csv_table.h"
#include "ugoki/formats/file_axes.h"
#include "ugoki/formats/marker_axes.h"
#include "ugoki/formats/motive_csv.h"

namespace ugoki::formats {
namespace {

constexpr double max_angle = 1e7;  ///< rad; in degrees still a number that the reader accepts

/// The point and the component in a column: "LASI" and 0 for "LASI.x". An empty name: the column is not a component of a point.
struct Component {
  std::string_view name;
  int axis = 0;  ///< 0 x, 1 y, 2 z
};

Component component_of(std::string_view column) {
  if (column.size() < 3) return {};
  const std::size_t axis = std::string_view("xyzXYZ").find(column.back());
  if (axis == std::string_view::npos || std::string_view("._:- ").find(column[column.size() - 2]) == std::string_view::npos) return {};
  return {column.substr(0, column.size() - 2), static_cast<int>(axis % 3)};
}

bool is_time(std::string_view name) { return equal_ignoring_case(name, "time") || equal_ignoring_case(name, "t"); }
bool is_frame(std::string_view name) {
  return equal_ignoring_case(name, "frame") || equal_ignoring_case(name, "frame#") || equal_ignoring_case(name, "frames");
}

/// Returns the frames per second: from the rows' times if there is a time column, otherwise from the comment "# rate". Adds a problem if
/// the times do not increase or are not evenly spaced (10 % tolerance).
std::optional<double> rate_of_rows(const CsvTable& table, Problems& problems, ReadNotes& notes) {
  std::size_t column = table.columns.size();
  for (std::size_t i = 0; i < table.columns.size(); ++i)
    if (is_time(table.columns[i].name)) column = i;
  if (column == table.columns.size() || table.rows() < 2) {
    if (table.rate > 0) return table.rate;
    notes.remarks.push_back("The file does not specify the frame rate; 100 frames per second are assumed.");
    return 100;
  }
  const std::string& unit = table.columns[column].unit;
  const double second = unit == "ms" ? 1e-3 : 1;
  const double step = (table.at(table.rows() - 1, column) - table.at(0, column)) * second / static_cast<double>(table.rows() - 1);
  if (!(step > 1e-6 && step < 1e3)) {
    problems.add(ErrorCode::range, table.lines[0], "The times of the rows do not increase.", "Write the time of each row in seconds.");
    return std::nullopt;
  }
  for (std::size_t r = 1; r < table.rows(); ++r)
    if (const double gap = (table.at(r, column) - table.at(r - 1, column)) * second; !(std::fabs(gap / step - 1) < 0.1)) {
      problems.add(ErrorCode::structure, table.lines[r],
                   "The rows are not evenly spaced in time: " + to_text(gap) + " s before this row, " + to_text(step) + " s on average.",
                   "Resample the recording to one rate, or remove the column of times.");
      return std::nullopt;
    }
  notes.frame_time = step;
  if (table.rate > 0 && std::fabs(table.rate * step - 1) < 1e-3) return table.rate;
  if (table.rate > 0)
    notes.remarks.push_back("The times of the rows correspond to " + to_fixed(1 / step, 2) + " frames per second, but '# rate' is " +
                            to_fixed(table.rate, 2) + "; the times are assumed to be right.");
  const double whole = std::round(1 / step);
  return whole >= 1 && std::fabs(step * whole - 1) < 1e-3 ? whole : 1 / step;
}

/// The points of a table and their columns.
struct Points {
  std::vector<std::string> names;
  std::vector<std::array<int, 3>> columns;  ///< [points] indices of the columns of x, y and z; -1: missing
};

bool find_points(const CsvTable& table, Problems& problems, ReadNotes& notes, Points& points) {
  std::map<std::string, std::size_t, std::less<>> index;
  std::size_t others = 0;
  for (std::size_t i = 0; i < table.columns.size(); ++i) {
    const Component c = component_of(table.columns[i].name);
    if (is_time(table.columns[i].name) || is_frame(table.columns[i].name)) continue;
    if (c.name.empty()) {
      ++others;
      continue;
    }
    const auto [it, is_new] = index.emplace(c.name, points.names.size());
    if (is_new) {
      points.names.emplace_back(c.name);
      points.columns.push_back({-1, -1, -1});
    }
    int& column = points.columns[it->second][static_cast<std::size_t>(c.axis)];
    if (column >= 0) {
      problems.add(ErrorCode::duplicate, 1, "Two columns are named " + in_quotes(table.columns[i].name) + ".",
                   "Give each column a different name.");
      return false;
    }
    column = static_cast<int>(i);
  }
  for (std::size_t i = 0; i < points.names.size(); ++i)
    if (*std::min_element(points.columns[i].begin(), points.columns[i].end()) < 0) {
      problems.add(ErrorCode::structure, 1, "Point " + in_quotes(points.names[i]) + " does not have all of .x, .y and .z.",
                   "Add the missing columns.");
      if (problems.full()) return false;
    }
  if (points.names.empty())
    problems.add(ErrorCode::structure, 1, "No columns NAME.x, NAME.y, NAME.z were found.",
                 "Name the columns of a point like this, or read coordinates together with their mechanism.");
  if (others > 0) notes.remarks.push_back(std::to_string(others) + " columns are not components of points and were skipped.");
  return problems.empty();
}

}  // namespace

std::vector<CsvCoordinate> csv_coordinates(const Mechanism& mechanism) {
  using Kind = CsvCoordinate::Kind;
  std::vector<CsvCoordinate> out;
  for (const Link& link : mechanism.links()) {
    const auto add = [&](Kind kind, const char* end) { out.push_back({kind, link.name + end}); };
    const auto add_quaternion = [&] {
      for (const char* end : {".qw", ".qx", ".qy", ".qz"}) add(Kind::quaternion, end);
    };
    switch (link.joint.type) {
      case JointType::fixed: break;
      case JointType::revolute:
      case JointType::helical: add(Kind::angle, ""); break;
      case JointType::prismatic: add(Kind::length, ""); break;
      case JointType::cylindrical:
        add(Kind::angle, ".angle");
        add(Kind::length, ".distance");
        break;
      case JointType::planar:
        add(Kind::length, ".x");
        add(Kind::length, ".y");
        add(Kind::angle, ".angle");
        break;
      case JointType::universal:
        add(Kind::angle, ".angle1");
        add(Kind::angle, ".angle2");
        break;
      case JointType::spherical: add_quaternion(); break;
      case JointType::floating:
        for (const char* end : {".x", ".y", ".z"}) add(Kind::length, end);
        add_quaternion();
        break;
    }
  }
  return out;
}

CsvKind csv_kind(std::string_view text) {
  if (is_motive_csv(text)) return CsvKind::points;
  Problems problems("head");
  CsvTable table;
  if (!read_csv_table(text.substr(0, 4'000'000), problems, table, false)) return CsvKind::points;
  std::size_t points = 0, others = 0;
  for (const CsvColumn& c : table.columns) {
    if (is_time(c.name) || is_frame(c.name)) continue;
    const bool coordinate = c.unit == "deg" || c.unit == "rad" || c.name.ends_with(".qw");
    if (coordinate) return CsvKind::coordinates;
    (component_of(c.name).name.empty() ? others : points) += 1;
  }
  return points == 0 && others > 0 ? CsvKind::coordinates : CsvKind::points;
}

Result<MarkerMotion> read_csv(std::string_view text, std::string_view file_name, const MarkerOptions& options, ReadNotes* notes) {
  ReadNotes own;
  ReadNotes& collected = notes != nullptr ? *notes : own;
  if (is_motive_csv(text)) return read_motive_csv(text, file_name, options, collected);
  Problems problems(file_name);
  CsvTable table;
  Points points;
  if (!read_csv_table(text, problems, table) || !find_points(table, problems, collected, points)) return fail(problems.take());
  const std::optional<double> rate = rate_of_rows(table, problems, collected);
  if (!rate) return fail(problems.take());
  MarkerMotion motion;
  motion.name = stem_of(file_name);
  motion.source = std::string(file_name);
  motion.labels = points.names;
  motion.rate = *rate;
  motion.frames = static_cast<int>(table.rows());
  for (std::size_t i = 0; i < table.columns.size(); ++i)  // the number of the first frame follows from its time
    if (is_time(table.columns[i].name) && table.columns[i].unit != "ms")
      if (const double first = table.at(0, i) * *rate; first >= 0 && first < 1e9)
        motion.first_frame = static_cast<int>(std::lround(first)) + 1;
  for (std::size_t r = 0; r < table.rows(); ++r)
    for (const std::array<int, 3>& c : points.columns) {
      const Vec3 p{table.at(r, static_cast<std::size_t>(c[0])), table.at(r, static_cast<std::size_t>(c[1])),
                   table.at(r, static_cast<std::size_t>(c[2]))};
      const bool seen = is_finite(p);
      motion.positions.push_back(seen ? p : Vec3{});
      motion.residuals.push_back(seen ? 0.0f : -1.0f);
    }
  const std::string& unit = table.columns[static_cast<std::size_t>(points.columns[0][0])].unit;
  const std::optional<double> metres = unit.empty() ? std::nullopt : metres_of(unit);
  if (!unit.empty() && !metres) collected.remarks.push_back("The unit of length " + in_quotes(unit) + " is not known.");
  const UpAxis up = equal_ignoring_case(table.up, "z") || table.up == "+z" ? UpAxis::z
                    : equal_ignoring_case(table.up, "y")                   ? UpAxis::y
                                                                           : UpAxis::automatic;
  if (!to_our_axes(motion, options, up, metres.value_or(0), collected)) {
    problems.add(ErrorCode::range, 1, "A point is farther than 1e9 m from the origin.", "Set the correct unit of length.");
    return fail(problems.take());
  }
  return motion;
}

Result<Motion> read_csv(std::string_view text, std::string_view file_name, const Mechanism& mechanism, ReadNotes* notes) {
  ReadNotes own;
  ReadNotes& collected = notes != nullptr ? *notes : own;
  Problems problems(file_name);
  CsvTable table;
  if (!read_csv_table(text, problems, table)) return fail(problems.take());
  const std::optional<double> rate = rate_of_rows(table, problems, collected);
  if (!rate) return fail(problems.take());
  const std::vector<CsvCoordinate> coordinates = csv_coordinates(mechanism);
  std::map<std::string_view, std::size_t> index;
  for (std::size_t i = 0; i < coordinates.size(); ++i) index.emplace(coordinates[i].name, i);

  Motion motion;
  motion.name = stem_of(file_name);
  motion.source = std::string(file_name);
  motion.mechanism = mechanism.name();
  motion.rate = *rate;
  motion.frames = static_cast<int>(table.rows());
  motion.nq = mechanism.nq();
  const std::size_t nq = static_cast<std::size_t>(motion.nq);
  if (nq * table.rows() > max_numbers) {
    problems.add(ErrorCode::range, 1, "The motion would have more than 400 million coordinates.", "Split it into several files.");
    return fail(problems.take());
  }
  const std::vector<double> neutral = mechanism.neutral();
  for (std::size_t r = 0; r < table.rows(); ++r) motion.q.insert(motion.q.end(), neutral.begin(), neutral.end());
  std::vector<char> given(nq, 0);
  for (std::size_t c = 0; c < table.columns.size(); ++c) {
    const CsvColumn& column = table.columns[c];
    if (is_time(column.name) || is_frame(column.name)) continue;
    if (column.name.ends_with(".contact")) {
      ContactTrack track{column.name.substr(0, column.name.size() - 8), {}};
      if (mechanism.find_link(track.link) >= 0) {
        for (std::size_t r = 0; r < table.rows(); ++r) track.on.push_back(table.at(r, c) > 0.5);
        motion.contacts.push_back(std::move(track));
        continue;
      }
    }
    const auto found = index.find(column.name);
    if (found == index.end()) {
      problems.add(ErrorCode::unknown, 1, "The mechanism has no coordinate " + in_quotes(column.name) + ".",
                   "Read the motion with the mechanism for which it was written, or name the column after one of its links.");
      if (problems.full()) return fail(problems.take());
      continue;
    }
    if (given[found->second]) {
      problems.add(ErrorCode::duplicate, 1, "Two columns are named " + in_quotes(column.name) + ".", "Give each column a different name.");
      return fail(problems.take());
    }
    given[found->second] = 1;
    const CsvCoordinate::Kind kind = coordinates[found->second].kind;
    double unit = 1;
    if (kind == CsvCoordinate::Kind::angle && column.unit != "rad") {
      unit = pi / 180;
      if (column.unit.empty()) collected.remarks.push_back("The angle " + in_quotes(column.name) + " has no unit; degrees are assumed.");
    }
    if (kind == CsvCoordinate::Kind::length && !column.unit.empty()) unit = metres_of(column.unit).value_or(1);
    for (std::size_t r = 0; r < table.rows(); ++r) {
      const double x = table.at(r, c);
      if (!std::isfinite(x)) {
        problems.add(ErrorCode::structure, table.lines[r], "The value of " + in_quotes(column.name) + " is missing.",
                     "Write a number for each coordinate in every row.");
        if (problems.full()) return fail(problems.take());
        continue;
      }
      // write_csv writes degrees and metres, and numbers above 1e9 are not read.
      const double value = x * unit;
      if (std::fabs(value) > (kind == CsvCoordinate::Kind::angle ? max_angle : 1e9)) {
        problems.add(ErrorCode::range, table.lines[r],
                     "The value " + to_text(x) + " of " + in_quotes(column.name) + " is too large; the maximum is " +
                         (kind == CsvCoordinate::Kind::angle ? to_text(max_angle) + " rad." : "1e9 m."),
                     "Check the value and its unit.");
        if (problems.full()) return fail(problems.take());
        continue;
      }
      motion.q[r * nq + found->second] = value;
    }
  }
  if (!problems.empty()) return fail(problems.take());
  const auto missing = std::count(given.begin(), given.end(), 0);
  if (missing == static_cast<long>(nq) && nq > 0) {
    problems.add(ErrorCode::structure, 1, "No column is a coordinate of the mechanism.",
                 "Name the columns after the links of the mechanism.");
    return fail(problems.take());
  }
  if (missing > 0) collected.remarks.push_back(std::to_string(missing) + " coordinates have no column; they keep their neutral value.");
  for (const Link& link : mechanism.links()) {
    const bool floating = link.joint.type == JointType::floating;
    if (!floating && link.joint.type != JointType::spherical) continue;
    for (std::size_t r = 0; r < table.rows(); ++r) {
      double* q = motion.q.data() + r * nq + static_cast<std::size_t>(link.q_index) + (floating ? 3 : 0);
      const double n = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
      if (!(n > 0.5 && n < 2)) {
        problems.add(ErrorCode::range, table.lines[r],
                     "The quaternion of " + in_quotes(link.name) + " has the norm " + to_text(n) + "; it must be between 0.5 and 2.",
                     "Write a unit quaternion.");
        return fail(problems.take());
      }
      if (std::fabs(n - 1) > 1e-15)
        for (int k = 0; k < 4; ++k) q[k] /= n;
    }
  }
  return motion;
}

}  // namespace ugoki::formats
