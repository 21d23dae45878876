#include "ugoki/body/calibration_frames.h"

#include <algorithm>
#include <array>
#include <vector>

#include "ugoki/body/body.h"
#include "ugoki/spatial/elementary.h"

namespace ugoki::body {
namespace {

constexpr double degree = pi / 180;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Largest rotation [rad] of any joint from frame f to the next.
double max_turn(const MeasuredMotion& m, int f) {
  const std::size_t n = m.skeleton.joints.size(), here = at(f) * n, next = here + n;
  double turn = 0;
  for (std::size_t i = 0; i < n; ++i) turn = std::max(turn, norm(log_map(m.rotations[here + i].conjugate() * m.rotations[next + i])));
  return turn;
}

}  // namespace

MeasuredMotion without_first(const MeasuredMotion& motion, int count) {
  MeasuredMotion out = motion;
  const auto values = static_cast<std::ptrdiff_t>(motion.skeleton.joints.size()) * count;
  out.frames -= count;
  out.translations.erase(out.translations.begin(), out.translations.begin() + values);
  out.rotations.erase(out.rotations.begin(), out.rotations.begin() + values);
  return out;
}

int count_calibration_frames(const MeasuredMotion& m) {
  if (m.frames < 4 || max_turn(m, 0) <= 20 * degree) return 0;
  const int single = max_turn(m, 0) > 5 * std::max(max_turn(m, 1), max_turn(m, 2)) ? 1 : 0;
  // The usual turn of a joint is the median over the steps `first_usual` to `last_usual`, after the smeared calibration pose.
  constexpr int max_count = 8, first_usual = 8, last_usual = 24;
  if (m.frames < last_usual + 1) return single;
  const std::size_t n = m.skeleton.joints.size();
  std::array<int, max_count> jumping{};  // [steps] number of joints that turn more than usual
  int moving = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const auto turn = [&](int f) { return norm(log_map(m.rotations[at(f) * n + i].conjugate() * m.rotations[at(f + 1) * n + i])); };
    std::vector<double> usual;
    for (int f = first_usual; f < last_usual; ++f) usual.push_back(turn(f));
    const auto middle = usual.begin() + static_cast<std::ptrdiff_t>(usual.size() / 2);
    std::nth_element(usual.begin(), middle, usual.end());
    const double limit = std::max(3 * degree, 4 * *middle);
    bool moves = *middle > 1e-3 * degree;
    for (int f = 0; f < max_count; ++f) {
      moves = moves || turn(f) > 0.1 * degree;
      jumping[at(f)] += turn(f) > limit ? 1 : 0;
    }
    moving += moves ? 1 : 0;
  }
  if (10 * jumping[0] < 6 * moving) return single;
  int count = 1;
  while (count < max_count && 4 * jumping[at(count)] > moving) ++count;
  return count;
}

}  // namespace ugoki::body
