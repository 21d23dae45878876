#include "ugoki/retarget/holds.h"

#include <algorithm>
#include <cmath>

namespace ugoki::retarget {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }
constexpr double min_time = 0.4;              // s, shorter holds are ignored
constexpr double still_speed = 0.12;          // m/s for legs of 0.9 m (scales with the root of the length): maximum speed of a hand that
                                              // holds
constexpr double min_hip_travel = 0.08;       // fraction of the leg's length: if the hips move less, the person merely stands still
constexpr double max_hand_distance = 0.5;     // fraction of the leg's length: hands farther apart do not hold each other
constexpr double max_distance_change = 0.02;  // m for legs of 0.9 m: tolerance for the distance between the hands
constexpr double fade_time = 0.17;            // s, duration of the transition before and after a hold

/// Diagonal [m] of the bounding box of the points.
double spread(std::span<const Vec3> p) {
  Vec3 low{1e300, 1e300, 1e300}, high = low * -1.0;
  for (const Vec3& x : p)
    for (int k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], x[k]);
      high[k] = std::max(high[k], x[k]);
    }
  return norm(high - low);
}

}  // namespace

std::vector<Hold> find_holds(const std::array<std::vector<Vec3>, 2>& hands, std::span<const Vec3> hips, double rate, double size) {
  std::vector<Hold> out;
  const int n = static_cast<int>(hips.size()), minimum = static_cast<int>(min_time * rate),
            step = std::max(1, static_cast<int>(0.02 * rate + 0.5));
  const double still = still_speed * std::sqrt(size / 0.9);
  for (int hand = 0; hand < 2; ++hand) {
    const std::vector<Vec3>& p = hands[at(hand)];
    if (p.empty()) continue;
    const auto rests = [&](int f) {
      const int a = std::max(0, f - step), b = std::min(n - 1, f + step);
      return norm(p[at(b)] - p[at(a)]) * rate / std::max(1, b - a) < still;
    };
    for (int first = 0; first < n; ++first) {
      if (!rests(first)) continue;
      int last = first;
      Vec3 sum = p[at(first)];
      while (last + 1 < n && rests(last + 1) && norm(p[at(last + 1)] - p[at(first)]) < 0.05 * size) sum += p[at(++last)];
      const int count = last - first + 1;
      if (count >= minimum && spread(hips.subspan(at(first), at(count))) > min_hip_travel * size)
        out.push_back({Hold::Kind::fixed, hand, first, last, sum / static_cast<double>(count)});
      first = last;
    }
  }
  if (hands[0].empty() || hands[1].empty()) return out;
  const auto apart = [&](int f) { return norm(hands[0][at(f)] - hands[1][at(f)]); };
  for (int first = 0; first < n; ++first) {
    double low = apart(first), high = low;
    if (low > max_hand_distance * size) continue;
    int last = first;
    while (last + 1 < n) {
      const double d = apart(last + 1);
      if (std::max(high, d) - std::min(low, d) > max_distance_change * size / 0.9) break;
      low = std::min(low, d);
      high = std::max(high, d);
      ++last;
    }
    const std::span<const Vec3> left = std::span(hands[0]).subspan(at(first), at(last - first + 1));
    if (last - first + 1 < minimum || spread(left) < 0.1 * size) continue;
    out.push_back({Hold::Kind::together, 0, first, last, {}});
    first = last;
  }
  return out;
}

double weight_of(const Hold& hold, int frame, double rate) {
  const int away = std::max({0, hold.first - frame, frame - hold.last});
  const double s = std::min(1.0, away / (fade_time * rate));
  return 1 - s * s * (3 - 2 * s);
}

std::string text_of(const Hold& hold) {
  const std::string frames = " in frames " + std::to_string(hold.first) + " to " + std::to_string(hold.last);
  if (hold.kind == Hold::Kind::together) return "The hands keep their distance" + frames + ".";
  return std::string("The ") + (hold.hand == 0 ? "left" : "right") + " hand holds still" + frames + ".";
}

}  // namespace ugoki::retarget
