#include "ugoki/gait/centre.h"

#include <algorithm>

namespace ugoki::gait {
namespace {

/// Tridiagonal system -k[i] x[i-1] + d[i] x[i] - k[i] x[i+1] = r[i] (Thomas algorithm); x = r at both ends.
std::vector<double> solve(std::vector<double> d, const std::vector<double>& k, std::vector<double> r) {
  const std::size_t n = d.size();
  if (n < 2) return r;
  std::vector<double> c(n, 0.0);
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double m = d[i] + k[i] * c[i - 1];
    c[i] = -k[i] / m;
    r[i] = (r[i] + k[i] * r[i - 1]) / m;
  }
  for (std::size_t i = n - 1; i-- > 1;) r[i] -= c[i] * r[i + 1];
  return r;
}

}  // namespace

std::vector<Vec3> solve_centre(std::span<const CentreFrame> frames, double rate) {
  const std::size_t n = frames.size();
  std::vector<Vec3> out(n);
  std::vector<double> d(n), k(n), r(n);
  for (int axis = 0; axis < 2; ++axis) {
    for (std::size_t i = 0; i < n; ++i) {
      const CentreFrame& f = frames[i];
      const double stiff = f.share * std::max(f.load, 0.0), moment = axis == 0 ? -f.moment.y : f.moment.x;
      k[i] = f.height * rate * rate;
      d[i] = 2 * k[i] + stiff;
      r[i] = stiff * f.pressure[axis] - moment;
    }
    r.front() = frames.front().pressure[axis];
    r.back() = frames.back().pressure[axis];
    const std::vector<double> x = solve(d, k, r);
    for (std::size_t i = 0; i < n; ++i) out[i][axis] = x[i];
  }
  return out;
}

std::vector<double> integrate_twice(std::span<const double> a, double b, double rate) {
  const std::size_t n = a.size();
  std::vector<double> d(n, 2 * rate * rate + b * b), k(n, rate * rate), r(n);
  for (std::size_t i = 1; i + 1 < n; ++i) r[i] = -a[i];
  return solve(std::move(d), k, std::move(r));
}

}  // namespace ugoki::gait
