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
// In the order of preference where two fit equally well.
constexpr NamedUnit units[] = {{0.01, "centimetres"},
                               {1.0, "metres"},
                               {0.001, "millimetres"},
                               {0.0254, "inches"},
                               {0.0254 / 0.45, "0.45ths of an inch, the unit of the CMU database"},
                               {0.1, "decimetres"}};

constexpr double usual_rates[] = {10,  12,  15,  20,  24,  25,  30,  40,  48,  50,  60,  72,  75,  90,
                                  100, 120, 144, 150, 180, 200, 240, 250, 300, 360, 480, 500, 1000};
constexpr double video_rates[] = {24000.0 / 1001, 30000.0 / 1001, 60000.0 / 1001, 120000.0 / 1001, 23.976, 29.97, 59.94, 119.88};

/// The rate whose frame time is nearest to `frame_time`, if nearer than `least`.
template <std::size_t n>
double nearest_rate(const double (&rates)[n], double frame_time, double least) {
  double best = 0;
  for (const double rate : rates) {
    const double miss = std::fabs(1 / rate - frame_time);
    if (miss < least) {
      least = miss;
      best = rate;
    }
  }
  return best;
}

/// Size of the last decimal place of the number as written: 1e-7 of ".0083333".
double last_place(std::string_view text) {
  double place = 1;
  bool point = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '.') {
      point = true;
    } else if (c >= '0' && c <= '9') {
      if (point) place *= 0.1;
    } else if (c == 'e' || c == 'E') {
      const auto exponent = parse_long(text.substr(i + 1));
      if (!exponent || std::labs(*exponent) > 300) return 0;
      for (long k = 0; k < std::labs(*exponent); ++k) place *= *exponent < 0 ? 0.1 : 10.0;
      break;
    }
  }
  return place;
}

}  // namespace

UnitGuess guess_unit(double extent) {
  constexpr double person = 1.7;
  UnitGuess best{0.01, "centimetres", false};
  if (!(extent > 0) || !std::isfinite(extent)) return best;
  double least = 0;
  for (const NamedUnit& u : units) {
    const double size = extent * u.metres;
    const double factor = std::max(size / person, person / size);
    if (least == 0 || factor < least * (1 - 1e-9)) {
      least = factor;
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
  const double place = std::max(last_place(text), 1e-15 * frame_time);
  if (place > 0.2 * frame_time) return exact;  // too few digits to tell rates apart
  if (const double rate = nearest_rate(usual_rates, frame_time, place); rate > 0) return rate;
  if (const double rate = nearest_rate(video_rates, frame_time, place); rate > 0) return rate;
  return whole >= 1 && std::fabs(1 / whole - frame_time) <= 0.5 * place ? whole : exact;
}

}  // namespace ugoki::formats
