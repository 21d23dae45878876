#include "judge_output.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <set>

#include "ugoki/base/number.h"
#include "ugoki/naturalness/report_svg.h"

namespace ugoki::cli {
namespace {

using naturalness::BadSpan;
using naturalness::Grade;
using naturalness::MeasureInfo;
using naturalness::MeasureReport;

constexpr std::size_t max_spans = 5;  // spans of one measure in the table

Json number_or_null(double x) { return std::isfinite(x) ? Json(x) : Json(nullptr); }

std::string limit_text(const MeasureInfo& info, const naturalness::Limits& limits) {
  const std::string high = to_fixed(limits.high, info.digits);
  return limits.low > 0 ? to_fixed(limits.low, info.digits) + " to " + high : high;
}

/// The spans with the largest deviation from the limits, the worst one first.
std::vector<BadSpan> worst_spans(const MeasureReport& m, const MeasureInfo& info) {
  std::vector<BadSpan> spans = m.spans;
  const auto excess = [&](const BadSpan& s) { return std::max(s.value - info.now.high, info.now.low - s.value); };
  std::ranges::sort(spans,
                    [&](const BadSpan& a, const BadSpan& b) { return excess(a) != excess(b) ? excess(a) > excess(b) : a.from < b.from; });
  return spans;
}

/// The name as part of a file's name: letters, digits, '-' and '_'.
std::string file_part(const std::string& name) {
  std::string out;
  for (const char c : name) out += std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '_' ? c : '-';
  return out.empty() ? "part" : out.substr(0, 80);
}

}  // namespace

Json judge_json(const std::vector<JudgedPart>& parts) {
  Json out = Json::array();
  for (const JudgedPart& part : parts) {
    Json list = Json::array();
    for (const MeasureInfo& info : naturalness::measure_list()) {
      const MeasureReport& m = part.report.measures[naturalness::index_of(info.id)];
      Json spans = Json::array();
      for (const BadSpan& s : m.spans) spans.push_back({{"from", s.from}, {"to", s.to}, {"at", s.at}, {"value", s.value}});
      Json row = {{"measure", info.key},
                  {"name", info.name},
                  {"unit", info.unit},
                  {"total", naturalness::name_of(info.total)},
                  {"value", m.total < 0 ? Json(nullptr) : Json(m.total)},
                  {"minimum", number_or_null(m.limits.low)},
                  {"limit", number_or_null(m.limits.high)},
                  {"grade", naturalness::name_of(m.grade())},
                  {"good", m.grade() != Grade::bad},
                  {"bad", std::move(spans)}};
      if (m.total < 0) row["reason"] = m.reason;
      list.push_back(std::move(row));
    }
    out.push_back({{"part", part.name},
                   {"good", part.report.good()},
                   {"rate", part.report.rate},
                   {"frames", part.report.frames},
                   {"measures", std::move(list)}});
  }
  return out;
}

void print_judgement(const std::vector<JudgedPart>& parts) {
  std::vector<std::vector<std::string>> rows = {{"part", "measure", "value", "limit", "unit", "", ""}};
  std::vector<std::vector<std::string>> bad = {{"part", "measure", "from (s)", "to (s)", "worst", "unit", "at (s)"}};
  std::vector<std::string> notes;
  for (const JudgedPart& part : parts) {
    std::map<std::string, std::string> absent;  // names by reason
    for (const MeasureInfo& info : naturalness::measure_list()) {
      const MeasureReport& m = part.report.measures[naturalness::index_of(info.id)];
      if (m.total < 0) {
        std::string& names = absent[m.reason];
        names += (names.empty() ? "" : ", ") + std::string(info.name);
      } else {
        const Grade grade = m.grade();
        const char* words = grade == Grade::good     ? "good"
                            : grade == Grade::fair   ? "fair"
                            : m.total < m.limits.low ? "TOO LITTLE"
                                                     : "TOO MUCH";
        rows.push_back({part.name, info.name, to_fixed(m.total, info.digits), limit_text(info, m.limits), info.unit,
                        std::string(naturalness::name_of(info.total)), words});
      }
      const std::vector<BadSpan> spans = worst_spans(m, info);
      for (std::size_t i = 0; i < std::min(spans.size(), max_spans); ++i)
        bad.push_back({part.name, info.name, to_fixed(spans[i].from, 2), to_fixed(spans[i].to, 2), to_fixed(spans[i].value, info.digits),
                       info.unit, to_fixed(spans[i].at, 2)});
      if (spans.size() > max_spans)
        notes.push_back(part.name + ": " + info.name + ": " + std::to_string(spans.size() - max_spans) + " more bad time spans.");
    }
    for (const auto& [reason, names] : absent) notes.push_back(part.name + ": not measured (" + reason + "): " + names + ".");
  }
  print_table(rows);
  if (bad.size() > 1) {
    print_line("");
    print_line("Worst time spans:");
    print_table(bad);
  }
  if (!notes.empty()) print_line("");
  for (const std::string& note : notes) print_line(note);
}

std::vector<JudgePicture> judge_pictures(const std::vector<JudgedPart>& parts, const std::string& name, const std::string& path) {
  std::vector<naturalness::Report> reports;
  for (const JudgedPart& part : parts) {
    reports.push_back(part.report);
    reports.back().name = name + ": " + part.name;
  }
  if (path.ends_with(".svg")) return {{path, naturalness::report_svg(reports)}};
  std::vector<JudgePicture> out;
  std::set<std::string> used;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    std::string base = file_part(parts[i].name);
    for (int n = 2; !used.insert(base).second; ++n) base = file_part(parts[i].name) + "-" + std::to_string(n);
    base = path + "/" + base;
    out.push_back({base + ".svg", naturalness::report_svg({&reports[i], 1})});
    for (const MeasureInfo& info : naturalness::measure_list()) {
      const std::vector<double>& values = reports[i].measures[naturalness::index_of(info.id)].over_time;
      if (std::ranges::any_of(values, [](double v) { return v >= 0; }))
        out.push_back({base + "-" + info.key + ".svg", naturalness::measure_svg(reports[i], info.id)});
    }
  }
  return out;
}

}  // namespace ugoki::cli
