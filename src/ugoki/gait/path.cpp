#include "ugoki/gait/path.h"

#include <algorithm>
#include <cmath>

#include "ugoki/spatial/elementary.h"

namespace ugoki::gait {
namespace {

constexpr double spacing = 0.02;  // m

/// Barry and Goldman's algorithm for one segment of a centripetal Catmull-Rom curve.
Vec3 segment_point(const Vec3* p, double s) {
  double t[4] = {0, 0, 0, 0};
  for (int i = 1; i < 4; ++i) t[i] = t[i - 1] + std::sqrt(std::max(1e-6, norm(p[i] - p[i - 1])));
  const double x = t[1] + s * (t[2] - t[1]);
  const auto mix = [&](const Vec3& a, const Vec3& b, double ta, double tb) {
    return a * ((tb - x) / (tb - ta)) + b * ((x - ta) / (tb - ta));
  };
  const Vec3 a1 = mix(p[0], p[1], t[0], t[1]), a2 = mix(p[1], p[2], t[1], t[2]), a3 = mix(p[2], p[3], t[2], t[3]);
  return mix(mix(a1, a2, t[0], t[2]), mix(a2, a3, t[1], t[3]), t[1], t[2]);
}

}  // namespace

SmoothPath::SmoothPath(std::span<const Vec3> points) {
  std::vector<Vec3> p;
  for (const Vec3& q : points)
    if (p.empty() || norm(Vec3{q.x - p.back().x, q.y - p.back().y, 0}) > 1e-3) p.push_back({q.x, q.y, 0});
  if (p.size() < 2) p.push_back(p.front() + Vec3{1, 0, 0});
  p.insert(p.begin(), p[0] * 2 - p[1]);
  p.push_back(p[p.size() - 1] * 2 - p[p.size() - 2]);
  std::vector<Vec3> dense;
  for (std::size_t i = 0; i + 3 < p.size(); ++i) {
    const int parts = std::max(8, static_cast<int>(norm(p[i + 2] - p[i + 1]) / 0.005));
    for (int k = 0; k < parts; ++k) dense.push_back(segment_point(&p[i], static_cast<double>(k) / parts));
  }
  dense.push_back(p[p.size() - 2]);
  double along = 0, next = 0;
  for (std::size_t i = 0; i + 1 < dense.size(); ++i) {
    const double length = norm(dense[i + 1] - dense[i]);
    for (; next <= along + length; next += spacing) {
      const Vec3 q = dense[i] + (dense[i + 1] - dense[i]) * (length > 0 ? (next - along) / length : 0.0);
      samples_.push_back({q.x, q.y, 0});
    }
    along += length;
  }
  const int n = static_cast<int>(samples_.size());
  for (int i = 0; i < n; ++i) {
    const Point &a = samples_[static_cast<std::size_t>(std::max(0, i - 1))],
                &b = samples_[static_cast<std::size_t>(std::min(n - 1, i + 1))];
    double heading = n > 1 ? atan2(b.y - a.y, b.x - a.x) : 0;
    if (i > 0) {
      const double before = samples_[static_cast<std::size_t>(i - 1)].heading;
      heading += 2 * pi * std::floor((before - heading) / (2 * pi) + 0.5);
    }
    samples_[static_cast<std::size_t>(i)].heading = heading;
  }
}

SmoothPath::Point SmoothPath::at(double s) const {
  const double last = length();
  if (s < 0 || s > last) {
    Point p = s < 0 ? samples_.front() : samples_.back();
    const double d = s < 0 ? s : s - last;
    p.x += d * cos(p.heading);
    p.y += d * sin(p.heading);
    return p;
  }
  const double i = s / spacing;
  const std::size_t k = std::min(static_cast<std::size_t>(i), samples_.size() > 1 ? samples_.size() - 2 : 0);
  const Point &a = samples_[k], &b = samples_[std::min(k + 1, samples_.size() - 1)];
  const double t = i - static_cast<double>(k);
  return {a.x + t * (b.x - a.x), a.y + t * (b.y - a.y), a.heading + t * (b.heading - a.heading)};
}

}  // namespace ugoki::gait
