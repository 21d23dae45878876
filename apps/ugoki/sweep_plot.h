#pragma once
// Plots of `ugoki bake plot`: a measure of a sweep over one of its parameters, as SVG.

#include <string>
#include <vector>

#include "ugoki/base/result.h"

namespace ugoki::cli {

/// One run in a plot.
struct PlotPoint {
  std::string x;       ///< value of the parameter: a number or a word
  double y = 0;        ///< value of the measure
  std::string series;  ///< points of equal series have one colour and one line; empty: one series
};

struct PlotLabels {
  std::string title, x, y, series;
};

/// An SVG picture with one dot for each point, and for each series a line through the means at equal x. If a value of x is no number, the
/// values are spaced evenly in the order in which they first occur.
/// Errors: no point; more than 12 series.
[[nodiscard]] Result<std::string> plot_svg(const std::vector<PlotPoint>& points, const PlotLabels& labels);

/// Ticks of an axis from `low` to `high`: multiples of 1, 2 or 5 times a power of ten, about `count` of them.
[[nodiscard]] std::vector<double> axis_ticks(double low, double high, int count);

}  // namespace ugoki::cli
