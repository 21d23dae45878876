// ugoki_<topic>_bench [--json FILE] [--orders LOW-HIGH] [--rows PATTERN]: prints the table; FILE gets a JSON list of {"row", "ours_ns",
// "peer", "peer_ns", "ratio"} and Row::extra. --rows is for topics that call is_selected().

#include "table.h"

#include <fnmatch.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <limits>

namespace ugoki::benchmarks {
namespace {

struct Registered {
  int order;
  RowMaker maker;
};
std::vector<Registered>& registry() {
  static std::vector<Registered> all;
  return all;
}

std::string& row_pattern() {
  static std::string pattern = "*";
  return pattern;
}

using Clock = std::chrono::steady_clock;

double time_of(const std::function<void()>& f, int count) {
  const auto begin = Clock::now();
  for (int i = 0; i < count; ++i) f();
  return std::chrono::duration<double, std::nano>(Clock::now() - begin).count();
}

void write_json(const std::vector<Row>& rows, const char* file) {
  std::ofstream out(file);
  out << "[";
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Row& r = rows[i];
    out << (i == 0 ? "\n" : ",\n") << R"(  {"row": ")" << r.row << R"(", "ours_ns": )" << r.ours_ns << R"(, "peer": )";
    if (r.peer.empty())
      out << R"(null, "peer_ns": null, "ratio": null)";
    else
      out << '"' << r.peer << R"(", "peer_ns": )" << r.peer_ns << R"(, "ratio": )" << r.peer_ns / r.ours_ns;
    for (const auto& [name, value] : r.extra) out << ", \"" << name << "\": " << value;
    out << "}";
  }
  out << "\n]\n";
}

}  // namespace

RowRegistration::RowRegistration(int order, RowMaker maker) { registry().push_back({order, maker}); }

void Table::add(const Row& r) {
  rows_.push_back(r);
  std::printf("%-44s %12.0f", r.row.c_str(), r.ours_ns);
  if (r.per > 0)
    std::printf(" %10.1f", r.ours_ns / r.per);
  else
    std::printf(" %10s", "");
  if (r.peer.empty())
    std::printf("  %-34s", "-");
  else
    std::printf("  %-34s %12.0f %8.2f", r.peer.c_str(), r.peer_ns, r.peer_ns / r.ours_ns);
  std::printf("%s%s\n", r.note.empty() ? "" : "  ", r.note.c_str());
  std::fflush(stdout);
}

bool is_selected(const std::string& row) { return fnmatch(row_pattern().c_str(), row.c_str(), 0) == 0; }

std::vector<double> measure(const std::vector<std::function<void()>>& functions, double seconds) {
  std::vector<int> counts;
  std::vector<double> best(functions.size(), std::numeric_limits<double>::infinity());
  for (const auto& f : functions) {
    int count = 1;
    while (time_of(f, count) < 1e5 && count < 1'000'000) count *= 2;
    counts.push_back(count);
  }
  std::vector<double> spent(functions.size());
  for (bool more = true; more;) {
    more = false;
    for (std::size_t i = 0; i < functions.size(); ++i) {
      if (spent[i] > seconds * 1e9) continue;
      const double ns = time_of(functions[i], counts[i]);
      spent[i] += ns;
      best[i] = std::min(best[i], ns / counts[i]);
      more = true;
    }
  }
  return best;
}

void require_same(const std::vector<double>& a, const std::vector<double>& b, double relative, const std::string& what) {
  double scale = 1, worst = 0;
  if (a.size() != b.size()) throw std::runtime_error(what + ": results of different sizes");
  for (std::size_t i = 0; i < a.size(); ++i) {
    scale = std::max(scale, std::fabs(b[i]));
    const double difference = std::fabs(a[i] - b[i]);
    worst = difference <= worst ? worst : difference;  // a NaN difference stays NaN
  }
  if (!(worst <= relative * scale))
    throw std::runtime_error(what + ": results differ by " + std::to_string(worst) + " of " + std::to_string(scale));
}

}  // namespace ugoki::benchmarks

int main(int argc, char** argv) {
  using namespace ugoki::benchmarks;
  const char* json = nullptr;
  int low = 0, high = std::numeric_limits<int>::max();
  for (int i = 1; i < argc; i += 2) {
    if (i + 1 < argc && std::strcmp(argv[i], "--json") == 0) {
      json = argv[i + 1];
    } else if (i + 1 < argc && std::strcmp(argv[i], "--rows") == 0) {
      row_pattern() = std::string("*") + argv[i + 1] + "*";
    } else if (i + 1 >= argc || std::strcmp(argv[i], "--orders") != 0 || std::sscanf(argv[i + 1], "%d-%d", &low, &high) != 2) {
      std::fprintf(stderr, "usage: %s [--json FILE] [--orders LOW-HIGH] [--rows PATTERN]\n", argv[0]);
      return 2;
    }
  }
  std::sort(registry().begin(), registry().end(), [](const auto& a, const auto& b) { return a.order < b.order; });
  std::printf("%-44s %12s %10s  %-34s %12s %8s\n", "row", "ours, ns", "ns each", "peer", "peer, ns", "ratio");
  Table table;
  int failed = 0;
  for (const auto& r : registry()) {
    if (r.order < low || r.order > high) continue;
    try {
      r.maker(table);
    } catch (const std::exception& error) {
      std::printf("NOT MEASURED: %s\n", error.what());
      std::fflush(stdout);
      ++failed;
    }
  }
  if (json != nullptr) write_json(table.rows(), json);
  if (failed > 0)
    std::fprintf(stderr, "FAILED: %d group(s) of rows were not measured; see the lines NOT MEASURED above for the reasons\n", failed);
  return failed > 0 ? 1 : 0;
}
