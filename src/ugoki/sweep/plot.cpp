#include "ugoki/sweep/plot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "ugoki/base/number.h"
#include "ugoki/publish/page.h"

namespace ugoki::sweep {
namespace {

constexpr double width = 720, height = 440;                      // px
constexpr double left = 74, right = 150, top = 44, bottom = 58;  // px: margins around the plotted area
constexpr std::array colors = {"#2563eb", "#dc2626", "#059669", "#d97706", "#7c3aed", "#0891b2",
                               "#be185d", "#4d7c0f", "#475569", "#b45309", "#1d4ed8", "#9f1239"};

std::string px(double x) { return to_fixed(x, 1); }

/// Returns the value of a tick as text without trailing zeros.
std::string tick_text(double x) {
  if (std::fabs(x) < 1e-12) return "0";
  std::string out = to_fixed(x, std::fabs(x) >= 1e5 || std::fabs(x) < 1e-3 ? 6 : 4);
  if (out.find('.') != std::string::npos) out.erase(out.find_last_not_of('0') + 1);
  if (out.ends_with('.')) out.pop_back();
  return out;
}

struct Axis {
  double low = 0, high = 1;

  void include(double x) {
    low = std::min(low, x);
    high = std::max(high, x);
  }
  /// Returns the position of a value on the axis: 0 at `low`, 1 at `high`.
  [[nodiscard]] double at(double x) const { return (x - low) / (high - low); }
  /// Widens an empty range, so that at() is defined.
  void widen() {
    if (high > low) return;
    const double margin = low == 0 ? 1 : 0.1 * std::fabs(low);
    low -= margin;
    high += margin;
  }
};

}  // namespace

std::vector<double> axis_ticks(double low, double high, int count) {
  const double raw = (high - low) / std::max(1, count), power = std::pow(10, std::floor(std::log10(raw)));
  const double unit = raw / power, step = power * (unit < 1.5 ? 1 : unit < 3.5 ? 2 : unit < 7.5 ? 5 : 10);
  std::vector<double> out;
  constexpr double slack = 1e-9;  // fraction of the distance between ticks: keeps a tick at the end of the axis in spite of rounding
  for (double k = std::ceil(low / step - slack); k * step <= high + slack * step; ++k) out.push_back(k * step);
  return out;
}

Result<std::string> plot_svg(const std::vector<PlotPoint>& points, const PlotLabels& labels) {
  if (points.empty())
    return fail(ErrorCode::structure, labels.y + " over " + labels.x, "No run has a value of both.",
                "Choose other columns, or run the sweep first.");
  std::vector<std::string> words, series;  // distinct values of x, and distinct series, in the order of their first occurrence
  bool numeric = true;
  for (const PlotPoint& p : points) {
    numeric = numeric && parse_double(p.x).has_value();
    if (std::ranges::find(words, p.x) == words.end()) words.push_back(p.x);
    if (std::ranges::find(series, p.series) == series.end()) series.push_back(p.series);
  }
  if (series.size() > colors.size())
    return fail(ErrorCode::range, "--by " + labels.series,
                "It has " + std::to_string(series.size()) + " values; the limit is " + std::to_string(colors.size()) + ".",
                "Choose another column, or none.");
  const auto position = [&](const std::string& x) {
    return numeric ? *parse_double(x) : static_cast<double>(std::ranges::find(words, x) - words.begin());
  };
  Axis x_axis{position(points[0].x), position(points[0].x)}, y_axis{points[0].y, points[0].y};
  for (const PlotPoint& p : points) {
    x_axis.include(position(p.x));
    y_axis.include(p.y);
  }
  if (y_axis.low > 0 && y_axis.low < 0.5 * y_axis.high) y_axis.low = 0;  // show zero if the points then fill at least half of the axis
  x_axis.widen();
  y_axis.widen();
  const auto x_px = [&](double x) { return left + 12 + x_axis.at(x) * (width - left - right - 24); };
  const auto y_px = [&](double y) { return height - bottom - 8 - y_axis.at(y) * (height - top - bottom - 16); };
  const auto text = [&](double x, double y, const char* anchor, const std::string& words_shown, const std::string& more = "") {
    return "<text x=\"" + px(x) + "\" y=\"" + px(y) + "\" text-anchor=\"" + anchor + "\"" + more + ">" + publish::escape_html(words_shown) +
           "</text>\n";
  };
  std::string out = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" + px(width) + "\" height=\"" + px(height) + "\" viewBox=\"0 0 " +
                    px(width) + " " + px(height) +
                    "\" font-family=\"sans-serif\" font-size=\"12\" fill=\"#1f2937\">\n<rect width=\"100%\" "
                    "height=\"100%\" fill=\"#ffffff\"/>\n";
  out += text(left, 24, "start", labels.title, " font-size=\"15\" font-weight=\"bold\"");
  out += "<rect x=\"" + px(left) + "\" y=\"" + px(top) + "\" width=\"" + px(width - left - right) + "\" height=\"" +
         px(height - top - bottom) + "\" fill=\"none\" stroke=\"#9ca3af\"/>\n";
  for (const double y : axis_ticks(y_axis.low, y_axis.high, 6)) {
    out += "<line x1=\"" + px(left) + "\" x2=\"" + px(width - right) + "\" y1=\"" + px(y_px(y)) + "\" y2=\"" + px(y_px(y)) +
           "\" stroke=\"#e5e7eb\"/>\n";
    out += text(left - 7, y_px(y) + 4, "end", tick_text(y));
  }
  if (numeric) {
    for (const double x : axis_ticks(x_axis.low, x_axis.high, 8)) {
      out += "<line x1=\"" + px(x_px(x)) + "\" x2=\"" + px(x_px(x)) + "\" y1=\"" + px(height - bottom) + "\" y2=\"" +
             px(height - bottom + 5) + "\" stroke=\"#9ca3af\"/>\n";
      out += text(x_px(x), height - bottom + 19, "middle", tick_text(x));
    }
  } else {
    const std::size_t every = (words.size() + 11) / 12;  // at most 12 words fit below the axis
    for (std::size_t i = 0; i < words.size(); i += every)
      out += text(x_px(static_cast<double>(i)), height - bottom + 19, "middle", words[i]);
  }
  out += text(left + (width - left - right) / 2, height - 14, "middle", labels.x);
  out += text(0, 0, "middle", labels.y, " transform=\"translate(18 " + px(top + (height - top - bottom) / 2) + ") rotate(-90)\"");
  if (series.size() > 1) out += text(width - right + 14, top + 10, "start", labels.series, " font-weight=\"bold\"");
  for (std::size_t s = 0; s < series.size(); ++s) {
    const std::string color = colors[s];
    std::map<double, std::pair<double, int>> sums;  // for each x: sum and number of the values of y
    out += "<g fill=\"" + color + "\" stroke=\"none\">\n";
    for (const PlotPoint& p : points) {
      if (p.series != series[s]) continue;
      auto& [sum, count] = sums[position(p.x)];
      sum += p.y;
      ++count;
      out += "<circle cx=\"" + px(x_px(position(p.x))) + "\" cy=\"" + px(y_px(p.y)) + "\" r=\"2.5\" fill-opacity=\"0.55\"/>\n";
    }
    out += "</g>\n";
    const auto many = [](const auto& entry) { return entry.second.second > 1; };
    // With many random values of x, each value has a single point, and a line would only show the scatter of the points.
    if (sums.size() > 1 && (sums.size() <= 60 || std::ranges::any_of(sums, many))) {
      out += "<polyline fill=\"none\" stroke=\"" + color + "\" stroke-width=\"1.6\" points=\"";
      for (const auto& [x, mean] : sums) out += px(x_px(x)) + "," + px(y_px(mean.first / mean.second)) + " ";
      out.back() = '"';
      out += "/>\n";
    }
    if (series.size() > 1) {
      const double y = top + 28 + 17 * static_cast<double>(s);
      out += "<circle cx=\"" + px(width - right + 19) + "\" cy=\"" + px(y - 4) + "\" r=\"4\" fill=\"" + color + "\"/>\n";
      out += text(width - right + 30, y, "start", series[s]);
    }
  }
  return out + "</svg>\n";
}

Result<TablePlot> plot_table(const TableAddress& address, PlotLabels labels) {
  std::vector<std::string> columns = {labels.x, labels.y};
  if (!labels.series.empty()) columns.push_back(labels.series);
  const Result<Results> read = read_columns(address, columns);
  if (!read) return fail(read.error());
  std::vector<PlotPoint> points;
  for (const std::vector<std::string>& row : read->cells) {
    if (row[0].empty() || row[1].empty()) continue;
    const std::optional<double> y = parse_double(row[1]);
    if (!y) return fail(ErrorCode::syntax, "--y " + labels.y, "'" + row[1] + "' is not a number.", "Choose a measure for --y.");
    points.push_back({row[0], *y, labels.series.empty() ? "" : row[2]});
  }
  if (labels.title.empty()) labels.title = labels.y + " over " + labels.x;
  Result<std::string> svg = plot_svg(points, labels);
  if (!svg) return fail(std::move(svg.error()));
  return TablePlot{std::move(*svg), points.size()};
}

}  // namespace ugoki::sweep
