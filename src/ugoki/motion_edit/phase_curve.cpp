#include "ugoki/motion_edit/phase_curve.h"

#include <algorithm>
#include <cmath>

#include "ugoki/base/check.h"

namespace ugoki::motion_edit {

PhaseCurve::PhaseCurve(std::vector<Point> points) : points_(std::move(points)) {
  UGOKI_CHECK(!points_.empty());
  const std::size_t n = points_.size();
  std::vector<double> rise(n);  // mean slope of the piece that begins at each point
  for (std::size_t i = 0; i < n; ++i) {
    const bool last = i + 1 == n;
    const Point& a = points_[i];
    const Point b = last ? Point{points_[0].x + 1, points_[0].y + 1} : points_[i + 1];
    UGOKI_CHECK(b.x > a.x && b.y > a.y);
    rise[i] = (b.y - a.y) / (b.x - a.x);
  }
  for (std::size_t i = 0; i < n; ++i) {
    const double before = rise[(i + n - 1) % n], after = rise[i];
    slopes_.push_back(2 * before * after /
                      (before + after));  // the harmonic mean is at most twice either slope, so the pieces are monotone
  }
}

double PhaseCurve::operator()(double x) const {
  const std::size_t n = points_.size();
  const double rounds = std::floor(x - points_[0].x), local = x - rounds;
  std::size_t i = n - 1;
  while (i > 0 && points_[i].x > local) --i;
  const Point& a = points_[i];
  const Point b = i + 1 == n ? Point{points_[0].x + 1, points_[0].y + 1} : points_[i + 1];
  const double h = b.x - a.x, s = (local - a.x) / h, m0 = slopes_[i] * h, m1 = slopes_[(i + 1) % n] * h;
  const double rise = b.y - a.y;
  return rounds + a.y + s * (m0 + s * ((3 * rise - 2 * m0 - m1) + s * (m0 + m1 - 2 * rise)));
}

double PhaseCurve::inverse(double y) const {
  const double rounds = std::floor(y - points_[0].y), local = y - rounds;
  double low = points_[0].x, high = low + 1;
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (low + high);
    ((*this)(middle) < local ? low : high) = middle;
  }
  return rounds + 0.5 * (low + high);
}

}  // namespace ugoki::motion_edit
