#pragma once
// Plots of tables of results: one column over another column, as SVG.

#include <string>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/sweep/results.h"

namespace ugoki::sweep {

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

/// A plot of a table of results.
struct TablePlot {
  std::string svg;
  std::size_t points = 0;  ///< number of drawn runs
};
/// Draws the column `labels.y` over the column `labels.x`, with a series for each value of the column `labels.series` (empty: one series).
/// Runs without a value are left out. An empty title becomes the names of the columns. Errors: those of read_columns() and plot_svg(); a
/// value of `labels.y` is not a number.
[[nodiscard]] Result<TablePlot> plot_table(const TableAddress& address, PlotLabels labels);

/// Returns about `count` ticks of an axis from `low` to `high`. Their distance is 1, 2 or 5 times a power of ten.
[[nodiscard]] std::vector<double> axis_ticks(double low, double high, int count);

}  // namespace ugoki::sweep
