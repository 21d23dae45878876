#pragma once
// Plots of `ugoki bake plot`: one column of a sweep's table over another column, as SVG.

#include <string>
#include <vector>

#include "ugoki/base/result.h"

namespace ugoki::cli {

/// The point of one run in a plot.
struct PlotPoint {
  std::string x;       ///< value of the horizontal axis: a number or a word
  double y = 0;        ///< value of the vertical axis
  std::string series;  ///< name of the series to which the point belongs; each series has its own colour and line
};

struct PlotLabels {
  std::string title, x, y, series;
};

/// Returns an SVG picture with one dot for each point, and for each series a line through the means at equal x. If a value of x is not a
/// number, all values of x are spaced evenly in the order of their first occurrence.
/// Errors: no points; more than 12 series.
[[nodiscard]] Result<std::string> plot_svg(const std::vector<PlotPoint>& points, const PlotLabels& labels);

/// Returns about `count` ticks of an axis from `low` to `high`. Their distance is 1, 2 or 5 times a power of ten.
[[nodiscard]] std::vector<double> axis_ticks(double low, double high, int count);

}  // namespace ugoki::cli
