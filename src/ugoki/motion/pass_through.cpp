#include "ugoki/motion/pass_through.h"

#include <algorithm>

namespace ugoki {

std::vector<double> pass_through(std::span<const double> value, std::span<const double> weight, double stiffness) {
  const std::size_t n = value.size();
  std::vector<double> x(n, 0.0), pivot(n);
  if (std::all_of(weight.begin(), weight.end(), [](double w) { return !(w > 1e-3); })) return x;
  for (std::size_t i = 0; i < n; ++i) {
    pivot[i] = weight[i] + stiffness * ((i > 0 ? 1 : 0) + (i + 1 < n ? 1 : 0));
    x[i] = weight[i] * value[i];
    if (i == 0) continue;
    pivot[i] -= stiffness * stiffness / pivot[i - 1];
    x[i] += stiffness / pivot[i - 1] * x[i - 1];
  }
  for (std::size_t i = n; i-- > 0;) x[i] = (x[i] + (i + 1 < n ? stiffness * x[i + 1] : 0.0)) / pivot[i];
  return x;
}

}  // namespace ugoki
