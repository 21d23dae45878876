#include "output.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>

#include "ugoki/base/printable.h"
#include "ugoki/plugin/guard.h"

namespace ugoki::cli {
namespace {

volatile std::sig_atomic_t interrupt_mark = 0;
constexpr int ending_signals[] = {SIGINT, SIGTERM, SIGHUP};

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

/// Number of code points of a UTF-8 text, as an estimate of its columns on the screen.
std::size_t width_of(std::string_view text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xc0) != 0x80; }));
}

bool is_number(std::string_view text) {
  return text.empty() || text == "-" ||
         (text.find_first_not_of("0123456789.+-e") == std::string_view::npos && text.find_first_of("0123456789") != std::string_view::npos);
}

}  // namespace

int print_error(const Error& error, bool as_json) {
  for (const Problem& p : error.problems) print_message(p.text());
  if (as_json) print_json({{"error", json::error_json(error)}});
  return 1;
}

void print_message(std::string_view message) { std::fprintf(stderr, "ugoki: %s\n", printable(message).c_str()); }
void print_warning(const std::optional<Problem>& warning) {
  if (warning) print_message("warning: " + warning->text());
}

namespace {

void print(std::string_view line) {
  std::FILE* out = plugin::results();  // not stdout, because LSIs may print there
  std::fwrite(line.data(), 1, line.size(), out);
  std::fputc('\n', out);
  std::fflush(out);
}

}  // namespace

void print_json(const Json& value) { print_json_text(json::to_text(value, 2)); }
void print_json_text(std::string_view text) { print(printable_json(text)); }
void print_line(std::string_view line) { print(printable(line)); }

void print_table(const std::vector<std::vector<std::string>>& table) {
  std::vector<std::vector<std::string>> rows = table;
  for (auto& row : rows)
    for (std::string& cell : row) cell = printable(cell);
  std::vector<std::size_t> widths;
  std::vector<bool> numeric;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    widths.resize(std::max(widths.size(), rows[r].size()));
    numeric.resize(widths.size(), true);
    for (std::size_t c = 0; c < rows[r].size(); ++c) {
      widths[c] = std::max(widths[c], width_of(rows[r][c]));
      if (r > 0 && !is_number(rows[r][c])) numeric[c] = false;
    }
  }
  for (const auto& row : rows) {
    std::string line;
    for (std::size_t c = 0; c < row.size(); ++c) {
      const std::string pad(widths[c] - width_of(row[c]), ' ');
      line += (c ? "  " : "") + (numeric[c] ? pad + row[c] : row[c] + pad);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    print_line(line);
  }
}

Progress::Progress(std::string label) : label_(printable(label)), terminal_(::isatty(STDERR_FILENO) == 1), began_(now()) {}
Progress::~Progress() { clear(); }

void Progress::show(double done) {
  if (!terminal_) return;
  const double t = now();
  if (t - began_ < 0.5 || t - last_ < 0.1) return;
  last_ = t;
  drawn_ = true;
  constexpr int cells = 30;
  const int full = std::clamp(static_cast<int>(done * cells), 0, cells);
  const std::string bar = std::string(static_cast<std::size_t>(full), '#') + std::string(static_cast<std::size_t>(cells - full), '.');
  std::fprintf(stderr, "\r%s [%s] %3d %%\x1b[K", label_.c_str(), bar.c_str(), static_cast<int>(100 * std::clamp(done, 0.0, 1.0)));
  std::fflush(stderr);
}

void Progress::clear() {
  if (!drawn_) return;
  std::fputs("\r\x1b[K", stderr);
  std::fflush(stderr);
  drawn_ = false;
}

void catch_interrupt() {
  struct sigaction act{};
  act.sa_handler = [](int) {
    interrupt_mark = 1;
    for (const int signal : ending_signals) std::signal(signal, SIG_DFL);
  };
  for (const int signal : ending_signals) {
    struct sigaction now{};
    if (signal == SIGHUP && ::sigaction(signal, nullptr, &now) == 0 && now.sa_handler == SIG_IGN) continue;  // started by nohup
    ::sigaction(signal, &act, nullptr);
  }
}
bool interrupted() { return interrupt_mark != 0; }
Error interrupted_error() {
  return {ErrorCode::cancelled, "", "Stopped by a signal (Ctrl+C).", "No incomplete file was left; run the command again."};
}

}  // namespace ugoki::cli
