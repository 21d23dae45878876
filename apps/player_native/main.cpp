// The native player. An exported program is this program followed by a payload, which contains the page and the content.

#include <fcntl.h>
#include <sys/auxv.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <filesystem>

#include "carried_lsis.h"
#include "osc.h"
#include "page_session.h"
#include "ugoki/base/printable.h"
#include "ugoki/content/inputs.h"
#include "ugoki/files/files.h"
#include "ugoki/json/json.h"
#include "ugoki/publish/payload.h"
#include "ugoki/studio/launch_page.h"

namespace {

using namespace ugoki;
using json::Json;
using player_native::BrowserOpener;
using player_native::results;
using player_native::with_carried_lsis;

struct Options {
  bool headless = false, no_open = false, as_json = false;
  std::uint64_t frames = 0, steps = 0;
  std::uint16_t port = 0;
  int osc = -1;  // UDP port that receives OSC (Open Sound Control); -1: no port
  std::string out, inputs;
};

void print_json(const Json& value) { std::fprintf(results(), "%s\n", printable_json(json::to_text(value, 2)).c_str()); }

int print_error(const Error& error, bool as_json) {
  for (const Problem& p : error.problems) std::fprintf(stderr, "%s\n", printable(p.text()).c_str());
  if (as_json) print_json({{"error", json::error_json(error)}});
  return 1;
}

/// Path of this program's own file. In a minimal tree without /proc, it is the path with which the program was started.
std::string program_path() {
  const char* const here = "/proc/self/exe";
  if (::access(here, R_OK) == 0) return here;
  const auto started_as = reinterpret_cast<const char*>(::getauxval(AT_EXECFN));
  return started_as ? started_as : here;
}

/// Returns the bytes of this program's own file, mapped into memory until the process ends.
Result<std::span<const std::byte>> map_program() {
  const std::string path = program_path();
  const auto failed = [&](const char* what) {
    return fail(ErrorCode::io, path, std::string("The program's file cannot be read: ") + what + ".", "Check its permissions.");
  };
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return failed("open failed");
  struct stat facts{};
  const bool known = ::fstat(file, &facts) == 0 && facts.st_size > 0;
  void* at = known ? ::mmap(nullptr, static_cast<std::size_t>(facts.st_size), PROT_READ, MAP_PRIVATE, file, 0) : MAP_FAILED;
  ::close(file);
  if (at == MAP_FAILED) return failed("mmap failed");
  return std::span(static_cast<const std::byte*>(at), static_cast<std::size_t>(facts.st_size));
}

/// Runs without a page. Prints the state hash; writes display frames to options.out.
int run_headless(content::Player& player, const Options& o) {
  const content::Executable& content = player.content();
  const double step = player.step_size();
  const auto whole = static_cast<std::uint64_t>(std::llround(content.duration / step));
  std::uint64_t steps = whole;
  if (o.steps > 0) steps = o.steps;
  if (o.frames > 0) steps = static_cast<std::uint64_t>(std::llround(static_cast<double>(o.frames) / content.frame_rate / step));
  content::DisplayFrame frame;
  std::vector<std::byte> encoded, frames;
  std::uint32_t number = 0;
  const auto record = [&] {
    player.display_frame(frame);
    content::encode_frame(frame, number++, content::frame_simulate, encoded);
    frames.insert(frames.end(), encoded.begin(), encoded.end());
  };
  if (!o.out.empty()) record();
  for (std::uint64_t done = 1; done <= steps; ++done) {
    if (const Result<void> good = player.step(); !good) return print_error(good.error(), o.as_json);
    if (!o.out.empty() && static_cast<double>(done) * step >= number / content.frame_rate - 0.5 * step) record();
  }
  if (!o.out.empty())
    if (const Result<void> written = files::write_file(o.out, std::span<const std::byte>(frames)); !written)
      return print_error(written.error(), o.as_json);
  char hash[17];
  std::snprintf(hash, sizeof hash, "%016llx", static_cast<unsigned long long>(player.state_hash()));
  if (o.as_json)
    print_json(
        {{"name", content.name}, {"steps", player.step_count()}, {"time_s", player.time()}, {"frames", number}, {"state_hash", hash}});
  else
    std::fprintf(results(), "%s: %.3f s in %llu steps, state %s\n", printable(content.name).c_str(), player.time(),
                 static_cast<unsigned long long>(player.step_count()), hash);
  return 0;
}

int run_page(content::Player player, std::string page, const Options& o, BrowserOpener& browser) {
  sigset_t ends;
  sigemptyset(&ends);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&ends, signal);
  pthread_sigmask(SIG_BLOCK, &ends, nullptr);  // before any thread starts, because threads inherit the mask
  const std::string name = player.content().name;
  player_native::PageSession session(std::move(player));
  studio::ServerOptions server_options;
  server_options.port = o.port;
  server_options.page = std::move(page);
  Result<std::unique_ptr<studio::Server>> server = studio::Server::listen(server_options, session);
  if (!server) return print_error(server.error(), o.as_json);
  session.start(**server);
  const std::string address = (*server)->address();
  std::unique_ptr<player_native::OscReceiver> osc;
  if (o.osc >= 0) {
    constexpr auto osc_client = static_cast<studio::ClientId>(-1);  // not the id of any page
    auto listening = player_native::OscReceiver::listen(
        static_cast<std::uint16_t>(o.osc), [&session](std::string message) { session.on_message(osc_client, std::move(message), [] {}); });
    if (!listening) return print_error(listening.error(), o.as_json);
    osc = std::move(*listening);
  }
  if (o.as_json) {
    Json report = {{"address", address}, {"port", (*server)->port()}};
    if (osc) report["osc"] = osc->port();
    print_json(report);
  } else {
    std::fprintf(results(), "%s: %s (Ctrl+C ends the program)\n", printable(name).c_str(), address.c_str());
    if (osc) std::fprintf(results(), "OSC: UDP port %d of 127.0.0.1\n", osc->port());
  }
  std::fflush(results());
  std::unique_ptr<studio::LaunchPage> launch;
  if (!o.no_open) {
    if (Result<std::unique_ptr<studio::LaunchPage>> written = studio::LaunchPage::write(address)) {
      launch = std::move(*written);
      browser.open(launch->path());
    }
  }
  int got = 0;
  while (sigwait(&ends, &got) != 0) {
  }
  pthread_sigmask(SIG_UNBLOCK, &ends, nullptr);
  osc.reset();
  session.stop();
  return 0;
}

/// Opens the content and runs it with or without a page. @return exit status
int play(const publish::Payload& payload, const std::string& name, const Options& o, const content::PlayerOptions& host,
         BrowserOpener& browser) {
  Result<content::Player> player = content::Player::open(payload.ugx, name, host);
  if (!player) return print_error(player.error(), o.as_json);
  std::error_code ignored;
  for (const auto& [what, path] : {std::pair<const char*, std::string>{"this program", program_path()}, {"the file of --inputs", o.inputs}})
    if (!o.out.empty() && !path.empty() && std::filesystem::equivalent(o.out, path, ignored))
      return print_error(Error(ErrorCode::conflict, o.out, std::string("The output is ") + what + ".", "Name another file with --out."),
                         o.as_json);
  if (!o.inputs.empty()) {
    const Result<std::string> text = files::read_file(o.inputs);
    if (!text) return print_error(text.error(), o.as_json);
    auto inputs = content::read_inputs(*text, player->content(), o.inputs);
    if (!inputs) return print_error(inputs.error(), o.as_json);
    player->schedule(std::move(*inputs));
  }
  if (o.headless) return run_headless(*player, o);
  return run_page(std::move(*player), std::string(payload.page), o, browser);
}

}  // namespace

int main(int argc, char** argv) {
  Options o;
  CLI::App app("Plays the content inside this program: opens its page in the browser, or runs without one.", "program");
  app.set_version_flag("--version", "ugoki player 0.1.0");
  app.add_flag("--headless", o.headless, "Run without a page and print the state hash");
  auto* frames = app.add_option("--frames", o.frames, "Display frames to run (--headless; default: the whole content)")
                     ->check(CLI::Range(1, 100'000'000));
  app.add_option("--steps", o.steps, "Simulation steps to run (--headless)")->check(CLI::Range(1, 1'000'000'000))->excludes(frames);
  app.add_option("--out", o.out, "Write the display frames to this file (--headless; docs/files.md)");
  app.add_option("--inputs", o.inputs, "Recorded inputs, JSON (docs/export.md)");
  app.add_option("--port", o.port, "Port of the page on 127.0.0.1 (default: any free port)");
  app.add_option("--osc", o.osc, "Receive keys, mouse and gamepads by OSC on this UDP port of 127.0.0.1; 0: any free port")
      ->check(CLI::Range(0, 65535));
  app.add_flag("--no-open", o.no_open, "Print the page's address, but do not open the browser");
  app.add_flag("--json", o.as_json, "Print one JSON object");
  app.footer("Example:\n  ./walk --headless --frames 600 --out walk.frames");
  app.failure_message(
      [](const CLI::App*, const CLI::Error& error) { return printable(error.what()) + "\nRun with --help for more information.\n"; });
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }

  const Result<std::span<const std::byte>> program = map_program();
  if (!program) return print_error(program.error(), o.as_json);
  const std::string name = argc > 0 ? std::filesystem::path(argv[0]).filename().string() : "program";
  const Result<publish::Payload> payload = publish::read_payload(*program, name);
  if (!payload) return print_error(payload.error(), o.as_json);
  BrowserOpener browser(!o.headless && !o.no_open && !payload->libraries.empty());
  const Result<int> status = with_carried_lsis(payload->libraries, name,
                                               [&](const content::PlayerOptions& host) { return play(*payload, name, o, host, browser); });
  return status ? *status : print_error(status.error(), o.as_json);
}
