#include "ugoki/motion/butterworth.h"

#include <algorithm>
#include <cmath>

#include "ugoki/spatial/elementary.h"

namespace ugoki {

// Each pass computes y[i] = b (x[i] + 2 x[i-1] + x[i-2]) + c1 y[i-1] + c2 y[i-2]
void filter_both_ways(std::vector<double>& x, double rate, double cutoff) {
  const double w = ugoki::tan(pi * cutoff / rate) / 0.80237;
  const double k1 = std::sqrt(2.0) * w, k2 = w * w;
  const double b = k2 / (1 + k1 + k2);
  const double c1 = 2 * b * (1 / k2 - 1), c2 = 1 - (4 * b + c1);
  for (int pass = 0; pass < 2; ++pass) {
    double x1 = x[0], x2 = x[0], y1 = x[0], y2 = x[0];
    for (double& value : x) {
      const double y = b * (value + 2 * x1 + x2) + c1 * y1 + c2 * y2;
      x2 = x1;
      x1 = value;
      y2 = y1;
      y1 = y;
      value = y;
    }
    std::reverse(x.begin(), x.end());
  }
}

}  // namespace ugoki
