#include "ugoki/naturalness/report_svg.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <vector>

#include "ugoki/base/number.h"

namespace ugoki::naturalness {
namespace {

constexpr double width = 960, left = 160, right = 200, row_height = 46, row_gap = 10, head = 52, foot = 34;  // px

std::string px(double x) { return to_fixed(x, 1); }

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (static_cast<unsigned char>(c) >= 0x20)
      out += c;
  }
  return out;
}

std::string text(double x, double y, std::string_view anchor, std::string_view words, std::string_view more = "") {
  return "<text x=\"" + px(x) + "\" y=\"" + px(y) + "\" text-anchor=\"" + std::string(anchor) + "\"" + std::string(more) + ">" +
         escaped(words) + "</text>\n";
}

std::string line(double x1, double y1, double x2, double y2, std::string_view look) {
  return "<line x1=\"" + px(x1) + "\" y1=\"" + px(y1) + "\" x2=\"" + px(x2) + "\" y2=\"" + px(y2) + "\" " + std::string(look) + "/>\n";
}

std::string with_unit(const MeasureInfo& info, double value) {
  return to_fixed(value, info.digits) + (*info.unit != 0 ? " " + std::string(info.unit) : "");
}

/// Distance of the labels of a time axis [s]: 1, 2 or 5 times a power of ten.
double tick_distance(double duration) {
  const double raw = std::max(1e-3, duration / 10);
  double power = 1;
  while (power > raw) power /= 10;
  while (power * 10 <= raw) power *= 10;
  const double unit = raw / power;
  return power * (unit < 1.5 ? 1 : unit < 3.5 ? 2 : unit < 7.5 ? 5 : 10);
}

int decimals(double tick) { return tick >= 1 ? 0 : tick >= 0.1 ? 1 : 2; }

struct Frame {
  double x, y, w, h;  // px: plotted area
  double duration;    // s
  double top;         // value at the upper edge
  [[nodiscard]] double at_time(double t) const { return x + w * std::clamp(t / duration, 0.0, 1.0); }
  [[nodiscard]] double at_value(double v) const { return y + h - h * std::clamp(v / top, 0.0, 1.0); }
};

/// Largest value of the axis: twice the upper limit, or less if all values are far below it.
double axis_top(const MeasureReport& m, const MeasureInfo& info) {
  double maximum = 0;
  for (const double v : m.over_time) maximum = std::max(maximum, v);
  const double limit = info.now.high;
  if (limit <= 0) return std::max(1.0, maximum);
  return std::max(1.15 * limit, std::min(2 * limit, 1.1 * maximum));
}

/// The curve, the limits and the bands of a measure.
std::string plot(const Report& report, const MeasureInfo& info, const MeasureReport& m, const Frame& f) {
  std::string out = "<rect x=\"" + px(f.x) + "\" y=\"" + px(f.y) + "\" width=\"" + px(f.w) + "\" height=\"" + px(f.h) +
                    "\" fill=\"#f8fafc\" stroke=\"#d1d5db\"/>\n";
  for (const BadSpan& span : m.spans)
    out += "<rect class=\"bad\" x=\"" + px(f.at_time(span.from)) + "\" y=\"" + px(f.y) + "\" width=\"" +
           px(std::max(2.0, f.at_time(span.to) - f.at_time(span.from))) + "\" height=\"" + px(f.h) + "\" fill=\"#fecaca\"/>\n";
  for (const double limit : {info.now.low, info.now.high})
    if (limit > 0 && limit < f.top)
      out += line(f.x, f.at_value(limit), f.x + f.w, f.at_value(limit), "stroke=\"#dc2626\" stroke-width=\"0.8\" stroke-dasharray=\"4 3\"");
  // The maximum of the values in each pixel column, so that no peak is lost; gaps where there is no value.
  const int columns = std::min(static_cast<int>(f.w), std::max(1, report.frames));
  std::string points;
  const auto flush = [&] {
    if (!points.empty()) out += "<polyline fill=\"none\" stroke=\"#1d4ed8\" stroke-width=\"1.3\" points=\"" + points + "\"/>\n";
    points.clear();
  };
  for (int c = 0; c < columns; ++c) {
    const auto n = static_cast<double>(report.frames);
    const int from = static_cast<int>(n * c / columns), to = std::max(from + 1, static_cast<int>(n * (c + 1) / columns));
    double value = no_value;
    for (int i = from; i < to && i < report.frames; ++i) value = std::max(value, m.over_time[static_cast<std::size_t>(i)]);
    if (value < 0) {
      flush();
      continue;
    }
    points += px(f.at_time((from + 0.5 * (to - 1 - from)) / report.rate)) + "," + px(f.at_value(value)) + " ";
  }
  flush();
  return out;
}

std::string time_axis(const Frame& f) {
  std::string out;
  const double tick = tick_distance(f.duration);
  for (int k = 0; k * tick <= f.duration * (1 + 1e-9); ++k) {
    const double x = f.at_time(k * tick);
    out += line(x, f.y + f.h, x, f.y + f.h + 4, "stroke=\"#6b7280\"");
    out += text(x, f.y + f.h + 17, "middle", to_fixed(k * tick, decimals(tick)));
  }
  return out + text(f.x + f.w + 12, f.y + f.h + 17, "start", "s");
}

std::string open_svg(double height) {
  return "<svg class=\"ugoki-measures\" xmlns=\"http://www.w3.org/2000/svg\" width=\"" + px(width) + "\" height=\"" + px(height) +
         "\" viewBox=\"0 0 " + px(width) + " " + px(height) +
         "\" font-family=\"sans-serif\" font-size=\"12\" fill=\"#1f2937\">\n<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n";
}

const char* color_of(Grade grade) { return grade == Grade::bad ? "#b91c1c" : grade == Grade::good ? "#15803d" : "#92400e"; }

bool has_values(const MeasureReport& m) {
  return std::ranges::any_of(m.over_time, [](double v) { return v >= 0; });
}

double duration_of(const Report& report) { return std::max(1e-3, report.frames / std::max(1e-9, report.rate)); }

}  // namespace

std::string report_svg(std::span<const Report> reports) {
  double height = 8;
  for (const Report& report : reports)
    height += head + foot + (row_height + row_gap) * static_cast<double>(std::ranges::count_if(report.measures, has_values));
  std::string out = open_svg(height);
  double y = 8;
  for (const Report& report : reports) {
    out += text(16, y + 22, "start", report.name, " font-size=\"16\" font-weight=\"bold\"");
    out += text(width - right + 12, y + 40, "start", "whole motion", " fill=\"#6b7280\"");
    y += head;
    Frame frame{left, y, width - left - right, row_height, duration_of(report), 1};
    for (const MeasureInfo& info : measure_list()) {
      const MeasureReport& m = report.measures[index_of(info.id)];
      if (!has_values(m)) continue;
      frame.y = y;
      frame.top = axis_top(m, info);
      out += text(left - 12, y + 20, "end", info.name, " font-weight=\"600\"");
      out += text(left - 12, y + 35, "end", "0 to " + with_unit(info, frame.top), " fill=\"#6b7280\" font-size=\"11\"");
      out += plot(report, info, m, frame);
      const Grade grade = m.grade();
      out += text(width - right + 12, y + 20, "start", grade == Grade::none ? "no value" : with_unit(info, m.total),
                  " font-weight=\"600\" fill=\"" + std::string(color_of(grade)) + "\"");
      const std::string count = m.spans.empty() ? "" : std::to_string(m.spans.size()) + (m.spans.size() == 1 ? " bad span" : " bad spans");
      out += text(width - right + 12, y + 35, "start",
                  grade == Grade::none ? m.reason : std::string(name_of(info.total)) + (count.empty() ? "" : ", " + count),
                  " fill=\"#6b7280\" font-size=\"11\"");
      y += row_height + row_gap;
    }
    frame.y = y - row_gap - row_height;
    out += time_axis(frame);
    y += foot;
  }
  return out + "</svg>\n";
}

std::string measure_svg(const Report& report, MeasureId id) {
  const MeasureInfo& info = info_of(id);
  const MeasureReport& m = report.measures[index_of(id)];
  constexpr double height = 300;
  std::string out = open_svg(height);
  const Frame frame{70, 70, width - 100, height - 120, duration_of(report), axis_top(m, info)};
  out += text(16, 26, "start", report.name + ": " + info.name, " font-size=\"16\" font-weight=\"bold\"");
  out += text(16, 46, "start",
              std::string(info.meaning) +
                  (m.total >= 0 ? ". Whole motion: " + with_unit(info, m.total) + " " + std::string(name_of(info.total)) : ". " + m.reason),
              " fill=\"#4b5563\"");
  out += plot(report, info, m, frame);
  const double tick = tick_distance(2 * frame.top);
  for (int k = 0; k * tick <= frame.top * (1 + 1e-9); ++k)
    out += text(frame.x - 7, frame.at_value(k * tick) + 4, "end",
                to_fixed(k * tick, tick >= 1      ? 0
                                   : tick >= 0.1  ? 1
                                   : tick >= 0.01 ? 2
                                                  : 3));
  out += time_axis(frame);
  return out + "</svg>\n";
}

}  // namespace ugoki::naturalness
