#include <algorithm>
#include <charconv>
#include <cmath>

#include "ugoki/base/number.h"
#include "ugoki/formats/csv.h"
#include "ugoki/formats/csv_coordinates.h"
#include "ugoki/formats/csv_table.h"

namespace ugoki::formats {
namespace {

constexpr const char* axis_names[] = {".x", ".y", ".z"};

/// Builds the text of a CSV file: first the columns, then the rows.
class Table {
 public:
  /// @param content word for the first comment, for example "markers"
  Table(std::string_view content, const std::string& name, double rate, const CsvWriteOptions& options)
      : decimals_(std::clamp(options.decimals, 0, 15)) {
    std::string clean;
    for (const char c : name) clean += c == '\n' || c == '\r' ? ' ' : c;
    out_ = "# " + std::string(content) + " of " + clean + "\n# rate: " + to_text(rate) + "\n# up: z\ntime[s]";
  }
  void column(const std::string& name, const char* unit) {
    const std::string quoted = csv_name(name);
    out_ += ',';
    if (*unit == 0) {
      out_ += quoted;
    } else if (quoted.starts_with('"')) {
      out_.append(quoted, 0, quoted.size() - 1) += std::string("[") + unit + "]\"";
    } else {
      out_ += quoted + "[" + unit + "]";
    }
  }
  void row(double time) {
    out_ += '\n';
    put(time);
  }
  void number(double value) {
    out_ += ',';
    put(value);
  }
  void empty() { out_ += ','; }
  std::string take() {
    out_ += '\n';
    return std::move(out_);
  }

 private:
  void put(double value) {
    char buffer[400];
    if (!std::isfinite(value)) return;
    const auto [end, error] = decimals_ == 0 ? std::to_chars(buffer, buffer + sizeof buffer, value)
                                             : std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::fixed, decimals_);
    const std::string_view digits(buffer, static_cast<std::size_t>(end - buffer));
    out_ += value == 0 ? std::string_view("0") : digits;
  }

  int decimals_;
  std::string out_;
};

}  // namespace

std::string write_csv(const MarkerMotion& motion, const CsvWriteOptions& options) {
  Table table("markers", motion.name, motion.rate, options);
  for (const std::string& label : motion.labels)
    for (const char* axis : axis_names) table.column(label + axis, "m");
  for (int f = 0; f < motion.frames; ++f) {
    table.row((motion.first_frame + f - 1) / motion.rate);
    for (int i = 0; i < motion.marker_count(); ++i)
      for (int k = 0; k < 3; ++k) {
        if (motion.seen(f, i))
          table.number(motion.at(f, i)[k]);
        else
          table.empty();
      }
  }
  return table.take();
}

std::string write_csv_positions(const MeasuredMotion& motion, const CsvWriteOptions& options) {
  Table table("positions", motion.name, motion.rate, options);
  for (const SkeletonJoint& j : motion.skeleton.joints)
    for (const char* axis : axis_names) table.column(j.name + axis, "m");
  std::vector<Pose> X(static_cast<std::size_t>(motion.joint_count()));
  for (int f = 0; f < motion.frames; ++f) {
    table.row(f / motion.rate);
    motion.calc_joint_poses(f, X);
    for (const Pose& pose : X)
      for (int k = 0; k < 3; ++k) table.number(pose.p[k]);
  }
  return table.take();
}

std::string write_csv(const Motion& motion, const Mechanism& mechanism, const CsvWriteOptions& options) {
  Table table("coordinates", motion.name, motion.rate, options);
  const std::vector<CsvCoordinate> coordinates = csv_coordinates(mechanism);
  for (const CsvCoordinate& c : coordinates)
    table.column(c.name, c.kind == CsvCoordinate::Kind::angle    ? (options.degrees ? "deg" : "rad")
                         : c.kind == CsvCoordinate::Kind::length ? "m"
                                                                 : "");
  for (const ContactTrack& track : motion.contacts) table.column(track.link + ".contact", "");
  const double per_radian = options.degrees ? 180 / pi : 1;
  for (int f = 0; f < motion.frames; ++f) {
    table.row(f / motion.rate);
    for (std::size_t i = 0; i < coordinates.size(); ++i)
      table.number(motion.frame(f)[i] * (coordinates[i].kind == CsvCoordinate::Kind::angle ? per_radian : 1));
    for (const ContactTrack& track : motion.contacts) table.number(track.on[static_cast<std::size_t>(f)]);
  }
  return table.take();
}

}  // namespace ugoki::formats
