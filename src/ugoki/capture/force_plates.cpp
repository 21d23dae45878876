#include "ugoki/capture/force_plates.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "ugoki/motion/butterworth.h"

namespace ugoki::capture {
namespace {

constexpr double quiet_share = 0.1;  // minimum share of unloaded samples for determining an offset
constexpr double quiet_load = 0.05;  // share of the load's range; when the offset is determined, samples below this load count as unloaded
constexpr double min_size = 0.01;    // m, minimum length of a plate's sides
constexpr double newton_of_lbf = 4.4482216152605, metre_of_inch = 0.0254;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

std::string plate_name(std::size_t i) { return "force plate " + std::to_string(i + 1); }

/// Returns `s` in lower case, with letters and digits only.
std::string folded(std::string s) {
  std::erase_if(s, [](unsigned char c) { return std::isalnum(c) == 0; });
  for (char& c : s) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return s;
}

/// Returns newtons per unit; 1 if the unit is unknown.
double force_unit(const std::string& unit) {
  const std::string u = folded(unit);
  return u == "kn" ? 1000 : u == "lbf" || u == "lb" || u == "lbs" ? newton_of_lbf : 1;
}
/// Returns metres per unit; `otherwise` if the unit is unknown.
double length_unit(const std::string& unit, double otherwise) {
  const std::string u = folded(unit);
  return u == "m" ? 1 : u == "cm" ? 0.01 : u == "mm" ? 0.001 : u == "in" || u == "inch" ? metre_of_inch : otherwise;
}
/// Returns newton metres per unit. If the unit is unknown: `length`, the file's length unit [m], as the moment is then in N times this
/// unit.
double moment_unit(const std::string& unit, double length) {
  const std::string u = folded(unit);
  if (u == "nm") return 1;
  if (u == "nmm" || u == "mmn") return 0.001;
  if (u == "ncm") return 0.01;
  if (u == "lbfin" || u == "lbin" || u == "inlbf" || u == "inlb") return newton_of_lbf * metre_of_inch;
  if (u == "lbfft" || u == "lbft" || u == "ftlbf" || u == "ftlb") return newton_of_lbf * 12 * metre_of_inch;
  return length;
}

/// Pose of a plate. Its axes follow from its corners, which C3D lists in the order (+x +y), (-x +y), (-x -y), (+x -y).
struct PlatePose {
  Mat3 R;       ///< rotation from the plate to the world
  Vec3 middle;  ///< m, world: centre of the surface
};

/// Computes forces and moments of one plate from its analog channels.
class Plate {
 public:
  Plate(const MarkerMotion& motion, std::size_t index, const ForcePlateOptions& o)
      : motion_(motion), plate_(motion.plates[index]), name_(plate_name(index)), o_(o) {}

  Error check() const {
    Error errors;
    const int type = plate_.type;
    const std::size_t wanted = type == 3 ? 8 : 6;
    if (type < 1 || type > 4)
      errors.add(ErrorCode::unsupported, name_, "The plate is of type " + std::to_string(type) + "; types 1 to 4 are supported.",
                 "Export it as forces and moments (type 2).");
    else if (plate_.channels.size() < wanted)
      errors.add(ErrorCode::structure, name_,
                 "The plate lists " + std::to_string(plate_.channels.size()) + " channels; its type needs " + std::to_string(wanted) + ".",
                 "Export the recording again with all channels of the plate.");
    for (const int c : plate_.channels)
      if (c < 0 || at(c) >= motion_.analog.size())
        errors.add(
            ErrorCode::range, name_,
            "The plate refers to channel " + std::to_string(c + 1) + ", but the file has " + std::to_string(motion_.analog.size()) + ".",
            "Export the recording again with all channels of the plate.");
    if (type == 4 && plate_.calibration.size() != 36)
      errors.add(ErrorCode::structure, name_, "The plate is of type 4 but has no 6 x 6 calibration matrix.", "Add CAL_MATRIX to the file.");
    const Vec3 x = plate_.corners[0] - plate_.corners[1], y = plate_.corners[0] - plate_.corners[3];
    if (!(norm(x) > min_size && norm(y) > min_size && norm(cross(x, y)) > 0.1 * norm(x) * norm(y)))
      errors.add(ErrorCode::range, name_, "The corners of the plate enclose no area.", "Correct CORNERS in the file.");
    return errors;
  }

  std::vector<PlateForce> run(std::vector<std::string>& report) {
    read();
    if (o_.remove_offset) remove_offset(report);
    const PlatePose plate_pose = find_pose();
    // The sensor is below the surface, whatever the sign of its position in the file.
    Vec3 to_surface = plate_.origin;
    if (plate_.type == 3) to_surface = {0, 0, plate_.origin.z};
    if ((plate_pose.R * to_surface).z < 0) to_surface = -to_surface;
    for (std::size_t s = 0; s < samples_; ++s) find_wrench(s, to_surface);
    if (o_.cutoff > 0) filter();
    turn_upwards(plate_pose, report);
    return frames(plate_pose);
  }

 private:
  [[nodiscard]] double raw(std::size_t sample, std::size_t k) const {
    return motion_.samples[sample * motion_.analog.size() + at(plate_.channels[k])];
  }

  void read() {
    samples_ = motion_.samples.size() / motion_.analog.size();
    channels_ = plate_.type == 3 ? 8 : 6;
    values_.resize(samples_ * channels_);
    for (std::size_t k = 0; k < channels_; ++k) {
      const std::string& unit = motion_.analog[at(plate_.channels[k])].unit;
      const bool force = plate_.type == 3 || k < 3;
      const double factor = plate_.type == 4            ? 1  // the calibration matrix contains the units
                            : force                     ? force_unit(unit)
                            : plate_.type == 1 && k < 5 ? length_unit(unit, motion_.unit)
                                                        : moment_unit(unit, motion_.unit);
      for (std::size_t s = 0; s < samples_; ++s) values_[s * channels_ + k] = factor * raw(s, k);
    }
    if (plate_.type != 4) return;
    for (std::size_t s = 0; s < samples_; ++s) {
      double in[6];
      std::copy_n(values_.data() + s * 6, 6, in);
      for (std::size_t r = 0; r < 6; ++r) {
        double sum = 0;
        for (std::size_t c = 0; c < 6; ++c) sum += plate_.calibration[6 * r + c] * in[c];
        values_[s * 6 + r] = r < 3 ? sum : sum * motion_.unit;  // the matrix gives moments in N times the file's length unit
      }
    }
  }

  [[nodiscard]] double vertical(std::size_t s) const {
    const double* v = values_.data() + s * channels_;
    return plate_.type == 3 ? v[4] + v[5] + v[6] + v[7] : v[2];
  }

  void remove_offset(std::vector<std::string>& report) {
    std::vector<double> load(samples_);
    for (std::size_t s = 0; s < samples_; ++s) load[s] = vertical(s);
    std::vector<double> sorted = load;
    std::sort(sorted.begin(), sorted.end());
    // A load has only one sign, so the unloaded value is the end of the range that is closer to zero.
    const double low = sorted.front(), high = sorted.back();
    const double base = std::fabs(low) < std::fabs(high) ? low : high;
    if (high - low < 10 * o_.threshold) return;
    std::vector<std::vector<double>> quiet(channels_);
    for (std::size_t s = 0; s < samples_; ++s) {
      if (std::fabs(load[s] - base) > quiet_load * (high - low)) continue;
      for (std::size_t k = 0; k < channels_; ++k) quiet[k].push_back(values_[s * channels_ + k]);
    }
    if (static_cast<double>(quiet[0].size()) < quiet_share * static_cast<double>(samples_)) return;
    const std::size_t last = plate_.type == 1 ? 3 : channels_;  // type 1: channels 4 to 6 (centre of pressure, moment) keep their offset
    std::vector<double> offset(channels_, 0.0);
    for (std::size_t k = 0; k < last; ++k) {
      const auto middle = quiet[k].begin() + static_cast<std::ptrdiff_t>(quiet[k].size() / 2);
      std::nth_element(quiet[k].begin(), middle, quiet[k].end());  // median, because samples at the beginning of a step are outliers
      offset[k] = *middle;
      for (std::size_t s = 0; s < samples_; ++s) values_[s * channels_ + k] -= offset[k];
    }
    const double vertical_offset = plate_.type == 3 ? offset[4] + offset[5] + offset[6] + offset[7] : offset[2];
    if (std::fabs(vertical_offset) > 1)
      report.push_back(name_ + ": an offset of " + std::to_string(static_cast<int>(std::lround(vertical_offset))) +
                       " N of the empty plate was removed.");
  }

  [[nodiscard]] PlatePose find_pose() const {
    const Vec3* c = plate_.corners;
    const Vec3 x = normalized(c[0] + c[3] - c[1] - c[2]), z = normalized(cross(x, c[0] + c[1] - c[2] - c[3]));
    return {Mat3::columns(x, cross(z, x), z), (c[0] + c[1] + c[2] + c[3]) / 4};
  }

  /// Appends the wrench of one sample: force [N] and moment [N m] about the centre of the plate's surface, in the plate's axes.
  void find_wrench(std::size_t s, const Vec3& to_surface) {
    const double* v = values_.data() + s * channels_;
    Vec3 F, M;
    if (plate_.type == 3) {
      const double a = std::fabs(plate_.origin.x), b = std::fabs(plate_.origin.y);
      F = {v[0] + v[1], v[2] + v[3], v[4] + v[5] + v[6] + v[7]};
      M = {b * (v[4] + v[5] - v[6] - v[7]), a * (-v[4] + v[5] + v[6] - v[7]), b * (-v[0] + v[1]) + a * (v[2] - v[3])};
      M += cross(F, to_surface);
    } else if (plate_.type == 1) {
      F = {v[0], v[1], v[2]};
      M = cross(Vec3{v[3], v[4], 0}, F) + Vec3{0, 0, v[5]};
    } else {
      F = {v[0], v[1], v[2]};
      M = Vec3{v[3], v[4], v[5]} + cross(F, to_surface);
    }
    wrench_.insert(wrench_.end(), {F.x, F.y, F.z, M.x, M.y, M.z});
  }

  /// Low-pass filters the wrench. Without effect if the cut-off is a third of the sampling rate or more.
  void filter() {
    const double rate = motion_.analog_rate;
    if (o_.cutoff >= rate / 3) return;
    const std::size_t pad = std::min(samples_ - 1, static_cast<std::size_t>(rate / o_.cutoff * 2));
    for (std::size_t k = 0; k < 6; ++k) {
      std::vector<double> row;
      const auto value = [&](std::size_t s) { return wrench_[6 * s + k]; };
      for (std::size_t i = pad; i > 0; --i) row.push_back(2 * value(0) - value(i));  // pad both ends by point reflection
      for (std::size_t s = 0; s < samples_; ++s) row.push_back(value(s));
      for (std::size_t i = 1; i <= pad; ++i) row.push_back(2 * value(samples_ - 1) - value(samples_ - 1 - i));
      filter_both_ways(row, rate, o_.cutoff);
      for (std::size_t s = 0; s < samples_; ++s) wrench_[6 * s + k] = row[pad + s];
    }
  }

  /// Inverts the wrench if its mean force points down: some laboratories record the force on the plate instead of the force on the foot.
  void turn_upwards(const PlatePose& plate_pose, std::vector<std::string>& report) {
    double sum = 0;
    for (std::size_t s = 0; s < samples_; ++s) sum += (plate_pose.R * Vec3{wrench_[6 * s], wrench_[6 * s + 1], wrench_[6 * s + 2]}).z;
    if (sum >= 0) return;
    for (double& x : wrench_) x = -x;
    report.push_back(name_ + ": the file contains the load on the plate; its sign was inverted to get the force of the ground.");
  }

  [[nodiscard]] std::vector<PlateForce> frames(const PlatePose& plate_pose) const {
    const std::size_t each = at(motion_.samples_per_frame());
    std::vector<PlateForce> out;
    for (std::size_t f = 0; f < at(motion_.frames) && each > 0; ++f) {
      Vec3 F, M;
      for (std::size_t s = f * each; s < std::min(samples_, (f + 1) * each); ++s) {
        F += Vec3{wrench_[6 * s], wrench_[6 * s + 1], wrench_[6 * s + 2]} / static_cast<double>(each);
        M += Vec3{wrench_[6 * s + 3], wrench_[6 * s + 4], wrench_[6 * s + 5]} / static_cast<double>(each);
      }
      PlateForce p;
      p.force = plate_pose.R * F;
      p.centre = plate_pose.middle;
      p.loaded = p.force.z > o_.threshold;
      if (p.loaded) {
        const Vec3 centre{-M.y / F.z, M.x / F.z, 0};
        p.centre = plate_pose.middle + plate_pose.R * centre;
        // The free moment refers to the upward normal, also for plates whose z axis points down.
        p.free_moment = (M.z - (centre.x * F.y - centre.y * F.x)) * (plate_pose.R.zz >= 0 ? 1 : -1);
      }
      out.push_back(p);
    }
    return out;
  }

  const MarkerMotion& motion_;
  const ForcePlate& plate_;
  std::string name_;
  const ForcePlateOptions& o_;
  std::size_t samples_ = 0, channels_ = 0;
  std::vector<double> values_;  // [samples][channels] N, N m (m for the centre of pressure of type 1)
  std::vector<double> wrench_;  // [samples][6] N, N m about the centre of the surface
};

/// Horizontal distance [m] of p from the foot in a frame: minimum over the segments between all pairs of the foot's points.
double distance_to(const SolePoints& foot, int frame, const Vec3& p) {
  const Vec3* s = foot.points.data() + at(frame) * at(foot.count);
  double minimum = 1e300;
  for (int i = 0; i < foot.count; ++i)
    for (int k = i; k < foot.count; ++k) {
      const Vec3 a{s[i].x, s[i].y, 0}, d{s[k].x - s[i].x, s[k].y - s[i].y, 0}, q{p.x - a.x, p.y - a.y, 0};
      const double dd = dot(d, d), t = dd > 0 ? std::clamp(dot(q, d) / dd, 0.0, 1.0) : 0;
      minimum = std::min(minimum, norm(q - d * t));
    }
  return minimum;
}

/// True if p is above or below the plate's quadrilateral (horizontal test).
bool inside(const ForcePlate& plate, const Vec3& p) {
  for (std::size_t i = 0, sides = 0; i < 4; ++i) {
    const Vec3 d = plate.corners[(i + 1) % 4] - plate.corners[i], q = p - plate.corners[i];
    sides += d.x * q.y - d.y * q.x >= 0 ? 1 : 0;
    if (i == 3) return sides == 0 || sides == 4;
  }
  return false;
}

}  // namespace

Result<ForceRecording> calc_contact_forces(const MarkerMotion& motion, const ForcePlateOptions& options) {
  if (motion.plates.empty() || motion.analog.empty() || motion.samples.empty())
    return fail(ErrorCode::structure, motion.source, "The recording has no force plates.",
                "Use a recording with force plates and their analog channels.");
  Error errors;
  for (std::size_t i = 0; i < motion.plates.size(); ++i) {
    const Error wrong = Plate(motion, i, options).check();
    errors.problems.insert(errors.problems.end(), wrong.problems.begin(), wrong.problems.end());
  }
  for (const double x : motion.samples)
    if (!std::isfinite(x)) {
      errors.add(ErrorCode::range, motion.source, "An analog sample is not finite.", "Export the recording again.");
      break;
    }
  if (motion.samples_per_frame() < 1)
    errors.add(ErrorCode::range, motion.source, "The analog rate is below the frame rate.", "Export the recording again.");
  if (!errors.empty()) return fail(std::move(errors));
  ForceRecording out;
  for (std::size_t i = 0; i < motion.plates.size(); ++i) out.plates.push_back(Plate(motion, i, options).run(out.report));
  return out;
}

std::vector<PlateStep> find_plate_steps(const MarkerMotion& motion, const ForceRecording& forces, std::span<const SolePoints> feet,
                                        double near) {
  std::vector<PlateStep> steps;
  for (std::size_t k = 0; k < forces.plates.size(); ++k) {
    const std::vector<PlateForce>& row = forces.plates[k];
    for (int f = 0; f < static_cast<int>(row.size()); ++f) {
      if (!row[at(f)].loaded) continue;
      if (f == 0 || !row[at(f - 1)].loaded) steps.push_back({static_cast<int>(k), f, f, -1, 0, false});
      steps.back().last = f;
    }
  }
  for (PlateStep& step : steps) {
    const std::vector<PlateForce>& row = forces.plates[at(step.plate)];
    std::vector<double> mean(feet.size(), 0.0), on_plate(feet.size(), 0.0);
    double weight = 0;
    for (int f = step.first; f <= step.last; ++f) {
      const double w = row[at(f)].force.z;
      weight += w;
      for (std::size_t i = 0; i < feet.size(); ++i) {
        mean[i] += w * distance_to(feet[i], f, row[at(f)].centre);
        Vec3 middle;
        double low = 1e300;
        for (int p = 0; p < feet[i].count; ++p) {
          const Vec3& s = feet[i].points[at(f) * at(feet[i].count) + at(p)];
          middle += s / feet[i].count;
          low = std::min(low, s.z);
        }
        const bool stands = inside(motion.plates[at(step.plate)], middle) && low - row[at(f)].centre.z < 0.1;
        on_plate[i] += stands ? w : 0;
      }
    }
    for (std::size_t i = 0; i < feet.size(); ++i) {
      mean[i] /= weight;
      if (mean[i] < near && (step.foot < 0 || mean[i] < mean[at(step.foot)])) step.foot = static_cast<int>(i);
    }
    if (step.foot >= 0) step.distance = mean[at(step.foot)];
    for (std::size_t i = 0; i < feet.size(); ++i)
      step.shared = step.shared || (static_cast<int>(i) != step.foot && on_plate[i] > 0.2 * weight);
  }
  return steps;
}

}  // namespace ugoki::capture
