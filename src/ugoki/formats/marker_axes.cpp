#include "ugoki/formats/marker_axes.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "ugoki/base/number.h"
#include "ugoki/formats/file_axes.h"
#include "ugoki/formats/text.h"

namespace ugoki::formats {
namespace {

struct NamedUnit {
  std::string_view name;
  double metres;
};
constexpr NamedUnit units[] = {{"mm", 0.001},          {"m", 1},
                               {"cm", 0.01},           {"dm", 0.1},
                               {"in", 0.0254},         {"ft", 0.3048},
                               {"inch", 0.0254},       {"inches", 0.0254},
                               {"millimeters", 0.001}, {"millimetres", 0.001},
                               {"meters", 1},          {"metres", 1},
                               {"centimeters", 0.01},  {"centimetres", 0.01},
                               {"feet", 0.3048}};

/// Returns an indicator [file units] that is smallest for the up axis k, because the lowest marker stays close to the floor at zero. Takes
/// the minimum of coordinate k over the markers in about 200 frames. Returns |median| + 2 * mean absolute deviation of these minima;
/// infinite if all markers share one value of the coordinate, as in planar recordings.
double unsteadiness(const MarkerMotion& m, int k) {
  std::vector<double> low;
  double highest = -std::numeric_limits<double>::infinity();
  const int stride = std::max(1, m.frames / 200);
  for (int f = 0; f < m.frames; f += stride) {
    double minimum = 0;
    bool any = false;
    for (int i = 0; i < m.marker_count(); ++i) {
      if (!m.seen(f, i)) continue;
      const double x = m.at(f, i)[k];
      highest = std::max(highest, x);
      minimum = any ? std::min(minimum, x) : x;
      any = true;
    }
    if (any) low.push_back(minimum);
  }
  if (low.empty()) return 0;
  const auto middle = low.begin() + static_cast<std::ptrdiff_t>(low.size() / 2);
  std::nth_element(low.begin(), middle, low.end());
  const double median = *middle;
  if (highest <= *std::min_element(low.begin(), low.end())) return std::numeric_limits<double>::infinity();
  double spread = 0;
  for (const double x : low) spread += std::fabs(x - median);
  return std::fabs(median) + 2 * spread / static_cast<double>(low.size());
}

/// Extent of the markers in the first frame with a seen marker, in file units.
struct Reach {
  double extent = 0;    ///< largest side of the axis-aligned box around the seen markers
  double distance = 0;  ///< distance of the farthest seen marker from the origin
};
Reach reach_of(const MarkerMotion& m) {
  for (int f = 0; f < m.frames; ++f) {
    Vec3 low, high;
    Reach reach;
    bool any = false;
    for (int i = 0; i < m.marker_count(); ++i) {
      if (!m.seen(f, i)) continue;
      const Vec3& x = m.at(f, i);
      for (int k = 0; k < 3; ++k) {
        low[k] = any ? std::min(low[k], x[k]) : x[k];
        high[k] = any ? std::max(high[k], x[k]) : x[k];
      }
      reach.distance = std::max(reach.distance, norm(x));
      any = true;
    }
    const Vec3 size = high - low;
    reach.extent = std::max({size.x, size.y, size.z});
    if (any) return reach;
  }
  return {};
}

/// True if the markers span more than 100 m, or are all within 4 mm of the origin. No recording of a subject has such a size.
bool implausible(const Reach& reach, double metres) {
  return reach.extent * metres > 100 || (reach.distance > 0 && reach.distance * metres < 0.004);
}

}  // namespace

std::optional<double> metres_of(std::string_view unit) {
  for (const NamedUnit& u : units)
    if (equal_ignoring_case(unit, u.name)) return u.metres;
  return std::nullopt;
}

std::string_view name_of_unit(double metres) {
  for (const NamedUnit& u : units)
    if (std::fabs(u.metres - metres) < 1e-9 * metres) return u.name;
  return {};
}

bool to_our_axes(MarkerMotion& motion, const MarkerOptions& options, UpAxis file_up, double metres, ReadNotes& notes) {
  UpAxis up = options.up != UpAxis::automatic ? options.up : file_up;
  if (up == UpAxis::automatic) {
    up = unsteadiness(motion, 1) < unsteadiness(motion, 2) ? UpAxis::y : UpAxis::z;
    notes.remarks.push_back(std::string("The file does not specify the up axis; ") + (up == UpAxis::y ? "Y" : "Z") +
                            " is assumed, because along it the lowest marker stays closest to a constant height.");
  }
  if (options.metres_per_unit > 0 && std::isfinite(options.metres_per_unit)) {
    metres = options.metres_per_unit;
  } else if (const Reach reach = reach_of(motion); metres <= 0 || implausible(reach, metres)) {
    if (metres > 0)
      notes.remarks.push_back("With the file's unit of length the markers would span " + to_text(reach.extent * metres) +
                              " m, which is implausible; the unit is replaced by a guess.");
    else
      notes.remarks.push_back("The file does not specify its unit of length.");
    const UnitGuess guess = guess_unit(reach.extent);
    metres = guess.metres;
    notes.unit_guessed = true;
    notes.remarks.push_back("Lengths are assumed to be in " + guess.name + ": the markers then span " + to_fixed(reach.extent * metres, 3) +
                            " m.");
  }
  motion.unit = notes.metres_per_unit = metres;
  const FileAxes axes{up == UpAxis::z};
  notes.z_up = axes.z_up;
  bool in_range = true;
  for (std::size_t i = 0; i < motion.positions.size(); ++i) {
    motion.positions[i] = axes.from_file(motion.positions[i]) * metres;
    in_range = in_range && norm(motion.positions[i]) <= max_magnitude;
    if (motion.residuals[i] >= 0) motion.residuals[i] = static_cast<float>(motion.residuals[i] * metres);
  }
  for (ForcePlate& plate : motion.plates) {
    for (Vec3& corner : plate.corners) corner = axes.from_file(corner) * metres;
    plate.origin *= metres;
  }
  return in_range;
}

}  // namespace ugoki::formats
