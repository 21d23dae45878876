#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "ugoki/base/number.h"
#include "ugoki/formats/text.h"
#include "ugoki/robot_formats/osim_model.h"
#include "ugoki/scene_formats/opensim.h"

namespace ugoki::scene_formats {
namespace {

using formats::Problems;
using formats::Scanner;
using robot_formats::OsimBody;
using robot_formats::OsimJointFit;
using robot_formats::OsimModel;

constexpr double uneven = 0.02;     // relative difference of time steps above which a table is interpolated
constexpr double usual_rate = 100;  // frames per second of interpolated tables
constexpr double longest = 7200;    // s

std::size_t at(int i) { return static_cast<std::size_t>(i); }

struct Table {
  std::vector<std::string> names;
  std::vector<double> numbers;  // [rows][columns]
  bool degrees = false;
  [[nodiscard]] std::size_t rows() const { return names.empty() ? 0 : numbers.size() / names.size(); }
  [[nodiscard]] double at(std::size_t row, std::size_t column) const { return numbers[row * names.size() + column]; }
};

/// "knee_angle_r" for "/jointset/walker_knee_r/knee_angle_r/value"; empty for the names of speeds and muscles.
std::string coordinate_name(std::string_view name) {
  if (name.find('/') == std::string_view::npos) return std::string(name);
  if (!name.ends_with("/value")) return {};
  name.remove_suffix(6);
  return std::string(name.substr(name.find_last_of('/') + 1));
}

bool read_table(std::string_view text, Problems& problems, Table& out) {
  const std::optional<std::string_view> plain = formats::plain_text(text, "OpenSim", problems);
  if (!plain) return false;
  Scanner scan(*plain);
  bool ended = false;
  for (int lines = 0; lines < 1000 && !ended && scan.skip_space(); ++lines) {
    const std::string_view line = scan.rest_of_line();
    ended = formats::equal_ignoring_case(line, "endheader");
    const std::size_t equals = line.find('=');
    if (equals != std::string_view::npos && line.substr(0, line.find_last_not_of(' ', equals - 1) + 1) == "inDegrees")
      out.degrees = formats::equal_ignoring_case(line.substr(line.find_last_of("= ") + 1), "yes");
  }
  if (!ended) {
    problems.add(ErrorCode::syntax, 1, "The file has no line 'endheader', so it is not a motion of OpenSim.", "Give a .mot or .sto file.");
    return false;
  }
  if (!scan.skip_space()) {
    problems.add(ErrorCode::structure, scan.line(), "The table has no column names.", "Save the motion again.");
    return false;
  }
  for (std::string_view word = scan.word_on_line(); !word.empty(); word = scan.word_on_line()) out.names.emplace_back(word);
  if (out.names.size() > 100'000) {
    problems.add(ErrorCode::range, scan.line(), "The table has more than 100000 columns.", "Save fewer columns.");
    return false;
  }
  while (scan.skip_space() && !problems.full()) {
    std::size_t count = 0;
    const int line = scan.line();
    for (std::string_view word = scan.word_on_line(); !word.empty(); word = scan.word_on_line(), ++count) {
      const std::optional<double> number = formats::measured_number(word);
      if (!number) {
        const formats::NumberFault fault = formats::number_fault(word);
        problems.add(fault.code, line, fault.message, fault.remedy);
        if (problems.full()) return false;
      }
      if (count < out.names.size()) out.numbers.push_back(number.value_or(0));
    }
    if (count != out.names.size()) {
      problems.add(ErrorCode::structure, line,
                   "The row has " + std::to_string(count) + " numbers, but the table has " + std::to_string(out.names.size()) + " columns.",
                   "Give one number for each column.");
      return false;
    }
    if (out.numbers.size() > formats::max_numbers) {
      problems.add(ErrorCode::range, line, "The table is too large.", "Save fewer rows.");
      return false;
    }
  }
  if (problems.empty() && out.rows() == 0)
    problems.add(ErrorCode::structure, scan.line(), "The table has no rows.", "Save the motion again.");
  return problems.empty();
}

/// A joint of the skeleton: one for each body, at the joint's centre.
struct Bone {
  OsimJointFit fit;
  Pose X_BL;  // the last link of the joint's chain in the body's frame
  Pose rest;  // world pose at rest
};

class Converter {
 public:
  Converter(const OsimModel& model, const Table& table, Problems& problems, formats::ReadNotes& notes)
      : model_(model), table_(table), problems_(problems), notes_(notes) {}

  bool run(MeasuredMotion& out) {
    if (!find_columns() || !find_times()) return false;
    std::vector<double> q(model_.coordinates.size(), 0.0);
    for (const OsimBody& body : model_.bodies) {
      Bone bone;
      if (!body.joint.empty()) {
        bone.fit = fit_joint(model_, body);
        bone.X_BL = body.X_BM * bone.fit.X_LM.inverse();
      }
      bones_.push_back(std::move(bone));
    }
    model_.complete(q);
    std::vector<Pose> X;
    poses(q, X);
    for (std::size_t i = 0; i < bones_.size(); ++i) bones_[i].rest = X[i];
    make_skeleton(out);
    out.rate = rate_;
    out.frames = frames_;
    for (int f = 0; f < frames_; ++f) {
      row_at(f, q);
      poses(q, X);
      for (std::size_t i = 0; i < bones_.size(); ++i) {
        const int parent = model_.bodies[i].parent;
        // The frames of the skeleton are parallel to the world at rest.
        const Mat3 R = X[i].R * bones_[i].rest.R.transposed();
        const Mat3 P = parent < 0 ? Mat3::identity() : X[at(parent)].R * bones_[at(parent)].rest.R.transposed();
        out.rotations.push_back(to_quat(P.transposed() * R));
        out.translations.push_back(parent < 0 ? X[i].p : P.transposed() * (X[i].p - X[at(parent)].p));
        if (!is_finite(out.translations.back()) || norm(out.translations.back()) > 1e6) {
          problems_.add(ErrorCode::range, 1, "The coordinates move a body more than 1000 km away.", "Check the units of the columns.");
          return false;
        }
      }
      if (head_) {
        out.rotations.push_back({});
        out.translations.push_back(out.skeleton.joints.back().offset);
      }
    }
    steady_bones(out);
    return true;
  }

 private:
  bool find_columns() {
    time_ = table_.names.size();
    column_.assign(model_.coordinates.size(), -1);
    std::size_t found = 0;
    for (std::size_t c = 0; c < table_.names.size(); ++c) {
      if (formats::equal_ignoring_case(table_.names[c], "time")) time_ = c;
      const int k = model_.find_coordinate(coordinate_name(table_.names[c]));
      if (k < 0 || column_[at(k)] >= 0) continue;
      column_[at(k)] = static_cast<int>(c);
      ++found;
    }
    if (time_ == table_.names.size())
      problems_.add(ErrorCode::structure, 1, "The table has no column 'time'.", "Save the motion with its times.");
    if (found == 0)
      problems_.add(ErrorCode::unknown, 1, "No column names a coordinate of the model.",
                    "Give a motion of this model (not forces or muscles), and the model to which it belongs.");
    std::string missing;
    for (std::size_t i = 0; i < column_.size(); ++i)
      if (column_[i] < 0 && !model_.coordinates[i].locked && model_.coordinates[i].source < 0)
        missing += (missing.empty() ? "" : ", ") + model_.coordinates[i].name;
    if (!missing.empty() && found > 0)
      notes_.remarks.push_back("No column gives " + missing.substr(0, 300) + "; they keep their defaults.");
    return problems_.empty();
  }

  bool find_times() {
    const std::size_t n = table_.rows();
    std::vector<double> steps;
    for (std::size_t r = 1; r < n; ++r) steps.push_back(table_.at(r, time_) - table_.at(r - 1, time_));
    if (std::any_of(steps.begin(), steps.end(), [](double s) { return !(s > 0); })) {
      problems_.add(ErrorCode::structure, 1, "The times do not rise.", "Sort the rows by time, each time once.");
      return false;
    }
    frames_ = static_cast<int>(n);
    if (n < 2) {
      rate_ = usual_rate;
      return true;
    }
    const double duration = table_.at(n - 1, time_) - table_.at(0, time_), mean = duration / static_cast<double>(n - 1);
    if (duration > longest) {
      problems_.add(ErrorCode::range, 1, "The motion is longer than two hours.", "Save a part of it.");
      return false;
    }
    const auto [low, high] = std::minmax_element(steps.begin(), steps.end());
    rate_ = 1 / mean;
    even_ = *high - *low <= uneven * mean && rate_ <= 2000;
    if (even_) {
      if (std::fabs(rate_ - std::round(rate_)) < 1e-3 * rate_) rate_ = std::round(rate_);
      return true;
    }
    rate_ = usual_rate;
    frames_ = static_cast<int>(std::floor(duration * rate_ + 1e-6)) + 1;
    notes_.remarks.push_back("The times of the rows are not steady; the motion is interpolated to 100 frames per second.");
    return true;
  }

  void row_at(int frame, std::vector<double>& q) {
    std::size_t row = at(frame);
    double part = 0;
    if (!even_ && table_.rows() > 1) {
      const double t = table_.at(0, time_) + frame / rate_;
      while (last_ + 2 < table_.rows() && table_.at(last_ + 1, time_) <= t) ++last_;
      row = last_;
      part = std::clamp((t - table_.at(row, time_)) / (table_.at(row + 1, time_) - table_.at(row, time_)), 0.0, 1.0);
    }
    for (std::size_t i = 0; i < q.size(); ++i) {
      q[i] = model_.coordinates[i].rest;
      if (column_[i] < 0) continue;
      const std::size_t c = at(column_[i]);
      double value = table_.at(row, c);
      if (part > 0) value += part * (table_.at(row + 1, c) - value);
      q[i] = table_.degrees && model_.coordinates[i].rotational ? value * 0.017453292519943295 : value;
    }
    // A coupled coordinate with a column of its own keeps it.
    std::vector<double> own = q;
    model_.complete(own);
    for (std::size_t i = 0; i < q.size(); ++i)
      if (column_[i] < 0) q[i] = own[i];
  }

  /// World poses (Z up) of the link frames of all bodies.
  void poses(const std::vector<double>& q, std::vector<Pose>& X) {
    X.resize(bones_.size());
    std::vector<Pose> body(bones_.size());
    for (std::size_t i = 0; i < bones_.size(); ++i) {
      const OsimBody& b = model_.bodies[i];
      const Pose above = b.parent < 0 ? Pose{model_.to_world, {}} : body[at(b.parent)];
      body[i] = b.joint.empty() ? above : above * b.X_PF * model_.joint_pose(b, q) * b.X_BM.inverse();
      X[i] = body[i] * bones_[i].X_BL;
    }
  }

  void make_skeleton(MeasuredMotion& out) {
    for (std::size_t i = 0; i < bones_.size(); ++i) {
      const OsimBody& body = model_.bodies[i];
      SkeletonJoint joint;
      joint.name = body.name;
      joint.parent = body.parent;
      joint.offset = bones_[i].rest.p - (body.parent < 0 ? Vec3{} : bones_[at(body.parent)].rest.p);
      joint.translates = body.parent < 0;
      for (int axis = 0; axis < 3; ++axis)
        joint.dofs.push_back({axis == 0 ? Vec3{0, 0, 1} : axis == 1 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}, false, 0, 0});
      out.skeleton.mass += body.inertia.mass;
      bool leaf = true;
      for (const OsimBody& other : model_.bodies) leaf = leaf && (other.parent != static_cast<int>(i));
      // The end of a bone without a further joint is unknown: a bar with its centre of mass is twice as long.
      if (std::ranges::any_of(std::array{"torso", "thorax", "trunk"}, [&](const char* word) { return body.name.starts_with(word); }) &&
          !leaf)
        trunk_ = static_cast<int>(i);
      if (leaf && body.inertia.mass > 0)
        joint.end_sites.push_back(bones_[i].rest.R * (bones_[i].X_BL.inverse() * body.inertia.centre()) * 2);
      out.skeleton.joints.push_back(std::move(joint));
    }
    // Most models have one body for trunk and head. The head begins at about 1.7 times the height of its centre of mass above its joint.
    const bool head = std::ranges::any_of(model_.bodies, [](const OsimBody& b) {
      return b.name.find("head") != std::string::npos || b.name.find("skull") != std::string::npos;
    });
    if (head || trunk_ < 0) return;
    const Bone& bone = bones_[at(trunk_)];
    const Vec3 centre = bone.rest.R * (bone.X_BL.inverse() * model_.bodies[at(trunk_)].inertia.centre());
    SkeletonJoint joint;
    joint.name = "head";
    joint.parent = trunk_;
    joint.offset = centre * 1.7;
    joint.end_sites = {centre * 0.6};
    out.skeleton.joints.push_back(std::move(joint));
    head_ = true;
    notes_.remarks.push_back("The model has no body for the head; a joint for it was added to " + model_.bodies[at(trunk_)].name + ".");
  }

  /// Replaces the translation of each joint except the roots by its mean.
  void steady_bones(MeasuredMotion& out) {
    const std::size_t n = out.skeleton.joints.size();
    double max_shift = 0;
    for (std::size_t i = 0; i < bones_.size(); ++i) {
      if (model_.bodies[i].parent < 0) continue;
      Vec3 mean;
      for (std::size_t f = 0; f < at(out.frames); ++f) mean += out.translations[f * n + i];
      mean = mean / out.frames;
      for (std::size_t f = 0; f < at(out.frames); ++f) {
        max_shift = std::max(max_shift, norm(out.translations[f * n + i] - mean));
        out.translations[f * n + i] = mean;
      }
      out.skeleton.joints[i].offset = mean;
    }
    if (max_shift > 0.001)
      notes_.remarks.push_back("Joints of the model shift by up to " + std::to_string(static_cast<int>(std::lround(1000 * max_shift))) +
                               " mm; their mean positions are used.");
  }

  const OsimModel& model_;
  const Table& table_;
  Problems& problems_;
  formats::ReadNotes& notes_;
  std::vector<int> column_;  // [coordinates] column; -1: none
  std::vector<Bone> bones_;
  std::size_t time_ = 0, last_ = 0;
  double rate_ = usual_rate;
  int frames_ = 0, trunk_ = -1;
  bool even_ = true, head_ = false;
};

}  // namespace

Result<MeasuredMotion> read_opensim(std::string_view table_text, std::string_view table_name, std::string_view model_text,
                                    std::string_view model_name, formats::ReadNotes* notes) {
  robot_formats::XmlFields xml(model_name, "OpenSim");
  OsimModel model;
  if (!xml.parse(model_text) || !read_osim_model(xml, model)) return fail(xml.take_problems());
  Problems problems(table_name);
  Table table;
  if (!read_table(table_text, problems, table)) return fail(problems.take());
  formats::ReadNotes own;
  MeasuredMotion out;
  out.name = formats::stem_of(table_name);
  out.source = std::string(table_name);
  out.skeleton.name = model.name;
  if (!Converter(model, table, problems, notes != nullptr ? *notes : own).run(out)) return fail(problems.take());
  return out;
}

}  // namespace ugoki::scene_formats
