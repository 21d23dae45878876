#include "ugoki/formats/file_axes.h"

#include <algorithm>
#include <cmath>

#include "ugoki/base/number.h"

namespace ugoki::formats {
namespace {

struct NamedUnit {
  double metres;
  const char* name;
};
// Units that guess_unit() tries. If two units fit equally well, it chooses the earlier one.
constexpr NamedUnit units[] = {{0.01, "centimetres"},
                               {1.0, "metres"},
                               {0.001, "millimetres"},
                               {0.0254, "inches"},
                               {0.0254 / 0.45, "units of 1/0.45 inch (CMU database)"},
                               {0.1, "decimetres"}};

constexpr double usual_rates[] = {10,  12,  15,  20,  24,  25,  30,  40,  48,  50,  60,  72,  75,  90,
                                  100, 120, 144, 150, 180, 200, 240, 250, 300, 360, 480, 500, 1000};
constexpr double video_rates[] = {24000.0 / 1001, 30000.0 / 1001, 60000.0 / 1001, 120000.0 / 1001, 23.976, 29.97, 59.94, 119.88};

/// Returns the rate whose frame time is closest to `frame_time` [s]; 0 if the difference is at least `tolerance` [s] for every rate.
template <std::size_t n>
double closest_rate(const double (&rates)[n], double frame_time, double tolerance) {
  double best = 0;
  for (const double rate : rates) {
    const double miss = std::fabs(1 / rate - frame_time);
    if (miss < tolerance) {
      tolerance = miss;
      best = rate;
    }
  }
  return best;
}

/// Returns the value of one unit in the last written digit: 1e-7 for ".0083333"; 0 if the exponent is out of range.
double last_digit_value(std::string_view text) {
  double digit = 1;
  bool point = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '.') {
      point = true;
    } else if (c >= '0' && c <= '9') {
      if (point) digit *= 0.1;
    } else if (c == 'e' || c == 'E') {
      const auto exponent = parse_long(text.substr(i + 1));
      if (!exponent || std::labs(*exponent) > 300) return 0;
      for (long k = 0; k < std::labs(*exponent); ++k) digit *= *exponent < 0 ? 0.1 : 10.0;
      break;
    }
  }
  return digit;
}

}  // namespace

UnitGuess guess_unit(double extent) {
  constexpr double person = 1.7;  // m, height of an adult
  UnitGuess best{0.01, "centimetres", false};
  if (!(extent > 0) || !std::isfinite(extent)) return best;
  double best_factor = 0;
  for (const NamedUnit& u : units) {
    const double size = extent * u.metres;
    const double factor = std::max(size / person, person / size);
    if (best_factor == 0 || factor < best_factor * (1 - 1e-9)) {
      best_factor = factor;
      best = {u.metres, u.name, size > 1.0 && size < 2.5};
    }
  }
  return best;
}

double rest_extent(const Skeleton& skeleton) {
  const std::vector<Vec3> p = rest_positions(skeleton);
  if (p.empty()) return 0;
  Vec3 low = p[0], high = p[0];
  const auto include = [&](const Vec3& x) {
    for (int k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], x[k]);
      high[k] = std::max(high[k], x[k]);
    }
  };
  for (std::size_t i = 0; i < p.size(); ++i) {
    include(p[i]);
    for (const Vec3& e : skeleton.joints[i].end_sites) include(p[i] + e);
  }
  const Vec3 size = high - low;
  return std::max({size.x, size.y, size.z});
}

double rate_of(double frame_time, std::string_view text) {
  const double exact = 1 / frame_time;
  const double whole = std::round(exact);
  if (std::fabs(exact - whole) < 1e-9 * exact) return whole;
  // A frame time that was rounded in the file has an error of at most half a unit in its last digit, a truncated one of up to a whole unit.
  const double digit = std::max(last_digit_value(text), 1e-15 * frame_time);
  if (digit > 0.2 * frame_time) return exact;  // too few digits to distinguish the rates
  if (const double rate = closest_rate(usual_rates, frame_time, digit); rate > 0) return rate;
  if (const double rate = closest_rate(video_rates, frame_time, digit); rate > 0) return rate;
  return whole >= 1 && std::fabs(1 / whole - frame_time) <= 0.5 * digit ? whole : exact;
}

}  // namespace ugoki::formats
