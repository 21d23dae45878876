// Pictures and videos of `ugoki export`. A headless browser draws the player's page, and the page sends each picture to this program. The
// program writes the picture or passes it to ffmpeg. Pictures, the studio and exported pages therefore have the same renderer.

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <thread>

#include "child.h"
#include "export.h"
#include "output.h"
#include "picture_receiver.h"
#include "ugoki/base/number.h"
#include "ugoki/content/inputs.h"
#include "ugoki/content/mechanism_display.h"
#include "ugoki/files/files.h"
#include "ugoki/files/temporary_folder.h"
#include "ugoki/publish/page.h"
#include "ugoki/publish/parts.h"
#include "ugoki/studio/launch_page.h"
#include "ugoki/studio/server.h"
#include "video_files.h"

namespace ugoki::cli {
namespace {

namespace fs = std::filesystem;

constexpr int max_waiting = 4;    // pictures that have arrived but are not written yet
constexpr double patience = 120;  // s: a browser that draws no picture for this time is regarded as hanging
constexpr int max_pictures = 1'000'000;
constexpr int max_browsers = 4;         // each takes about 300 MB of memory
constexpr int pictures_a_browser = 30;  // the time in which a browser starts

/// Number of browsers that draw a share of the pictures each. Without a graphics processor, one browser leaves part of a second core idle,
/// because its threads wait for each other.
int browser_count(int pictures, bool graphics_processor) {
  if (graphics_processor) return 1;
  return std::clamp(pictures / pictures_a_browser, 1, std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1, max_browsers));
}

/// Finds the browser that draws. The headless shell of Chromium has no windows and starts with a little less processor time than Chromium,
/// but it does not use every graphics processor.
Result<std::string> find_browser(const std::string& given, bool graphics_processor) {
  const char* remedy = "Install Chromium (`apt-get install chromium`), or name a browser with --browser.";
  if (!graphics_processor && given.empty())
    if (Result<std::string> shell = find_program("", {"chromium-headless-shell", "chrome-headless-shell"}, remedy)) return shell;
  return find_program(given, {"chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chromium-headless-shell"}, remedy);
}

/// Returns the argument that opens `address`: in a window without tabs and menus, whose moving parts (such as the mark of a page that is
/// being loaded) would be drawn beside the pictures. A headless shell has no such window.
std::string page_word(const std::string& browser, const std::string& address) {
  return fs::path(browser).filename().string().contains("headless-shell") ? address : "--app=" + address;
}

/// Returns the file name of picture `number`: "%d" or "%04d" in the pattern is replaced.
std::string numbered(const std::string& pattern, int number) {
  const std::size_t at = pattern.find('%');
  const std::size_t end = at == std::string::npos ? at : pattern.find('d', at);
  if (end == std::string::npos) return pattern;
  const std::optional<long> width = end > at + 1 ? parse_long(pattern.substr(at + 1, end - at - 1)) : 0;
  std::string digits = std::to_string(number);
  if (width && *width > 0 && *width < 20)
    digits.insert(0, static_cast<std::size_t>(std::max(0L, *width - static_cast<long>(digits.size()))), '0');
  return pattern.substr(0, at) + digits + pattern.substr(end + 1);
}
bool is_pattern(const std::string& name) { return numbered(name, 1) != numbered(name, 2); }

/// The pictures to draw, as options and content specify them.
struct Plan {
  double rate = 0;  ///< pictures per second
  int count = 0;
  bool videos = false;
  bool single = false;  ///< one picture, whose file name is no pattern
  bool planar = false;  ///< the page sends planar YCbCr instead of RGBA for the videos
};

Result<Plan> plan_of(const content::Executable& content, const PictureOptions& o, const PictureOutputs& outputs) {
  Plan plan;
  plan.rate = o.rate > 0 ? o.rate : content.frame_rate;
  const double end = o.duration > 0 ? o.duration : content.duration;
  plan.videos = !outputs.mp4.empty() || !outputs.webm.empty() || !outputs.gif.empty();
  plan.single = !plan.videos && !is_pattern(outputs.png);
  if (plan.videos && !outputs.png.empty() && !is_pattern(outputs.png))
    return fail(ErrorCode::conflict, "--png", "One picture and a video cannot be written at once.",
                "Give --png a file name with %04d, or call `ugoki export` twice.");
  if (o.from >= end && !plan.single)
    return fail(ErrorCode::range, "--from",
                "The first picture is at " + to_fixed(o.from, 3) + " s, but the content ends at " + to_fixed(end, 3) + " s.",
                "Give an earlier time.");
  if (o.transparent && (!outputs.mp4.empty() || !outputs.gif.empty()))
    return fail(ErrorCode::unsupported, "--transparent", "MP4 and GIF videos have no transparent background.", "Use --webm or --png.");
  const double wanted = plan.single ? 1 : std::max(1.0, std::round((end - o.from) * plan.rate));
  if (wanted > max_pictures)
    return fail(ErrorCode::range, "--duration",
                "The export would have " + to_fixed(wanted, 0) + " pictures; the limit is " + std::to_string(max_pictures) + ".",
                "Give a shorter --duration or a lower --rate.");
  plan.count = static_cast<int>(wanted);
  const bool even = o.width % 2 == 0 && o.height % 2 == 0;
  if ((!outputs.mp4.empty() || !outputs.webm.empty()) && !even)
    return fail(ErrorCode::range, "--size", "Width and height of a video must be even.", "Give, for example, --size 1280x720.");
  // MP4 and WebM are coded from planar YCbCr. A GIF and a transparent background need RGBA.
  plan.planar = plan.videos && outputs.gif.empty() && !o.transparent && o.blur == 1 && even;
  return plan;
}

/// The settings of the page (web/src/player/pictures.ts).
Result<Json> page_settings(const content::Player& player, const Plan& plan, const PictureOptions& o, bool png) {
  Result<Json> scene = json::parse_json(content::scene_json(player.content()), "scene", std::size_t{1} << 31);
  if (!scene) return scene;
  return Json{{"scene", std::move(*scene)},
              {"width", o.width},
              {"height", o.height},
              {"rate", plan.rate},
              {"from", o.from},
              {"count", plan.count},
              {"blur", o.blur},
              {"shutter", o.shutter},
              {"transparent", o.transparent},
              {"theme", o.light ? "light" : "dark"},
              {"assist", o.overlays},
              {"png", png},
              {"raw", !plan.videos  ? ""
                      : plan.planar ? "planar"
                                    : "rgba"},
              {"ahead", max_waiting}};
}

using Children = std::vector<std::unique_ptr<Child>>;

/// Starts browsers that show `address`. @param folder for their profiles  @param log receives their output
Result<Children> start_browsers(const std::string& browser, int count, bool graphics_processor, const std::string& address,
                                const fs::path& folder, const fs::path& log) {
  std::vector<std::string> words = {browser,
                                    "--headless",
                                    "--no-first-run",
                                    "--no-default-browser-check",
                                    "--disable-background-networking",
                                    "--disable-component-update",
                                    "--disable-sync",
                                    "--disable-extensions",
                                    "--disable-background-timer-throttling",
                                    "--disable-renderer-backgrounding",
                                    "--mute-audio",
                                    "--hide-scrollbars",
                                    "--force-device-scale-factor=1",
                                    "--window-size=200,200"};  // the canvas of the pictures is not in the window
  std::vector<std::pair<const char*, std::string>> variables = {{"TMPDIR", folder.string()}};
  if (!graphics_processor) {
    // Without a graphics processor, Mesa's renderer (llvmpipe) draws with half the processor time of SwiftShader, the renderer of Chromium.
    // If Mesa is not installed, Chromium falls back to SwiftShader.
    words.insert(words.end(), {"--use-gl=angle", "--use-angle=gl-egl", "--ignore-gpu-blocklist", "--enable-unsafe-swiftshader",
                               "--disable-gpu-rasterization"});
    // The page draws by Mesa's code. To optimise its own script takes 1 s of processor time, which is more than the faster script saves.
    words.emplace_back("--js-flags=--no-opt");
    if (count > 1) variables.emplace_back("LP_NUM_THREADS", "0");  // llvmpipe draws on the thread that calls it
  }
  if (::geteuid() == 0) words.emplace_back("--no-sandbox");  // Chromium refuses to run as root with its sandbox
  Children out;
  for (int i = 0; i < count; ++i) {
    std::vector<std::string> own = words;
    own.push_back("--user-data-dir=" + (folder / ("profile" + std::to_string(i))).string());
    own.push_back(page_word(browser, address));
    Result<std::unique_ptr<Child>> child = Child::start(own, false, log.string(), variables);
    if (!child) return fail(std::move(child.error()));
    out.push_back(std::move(*child));
  }
  return out;
}

/// Waits for a picture, until it has arrived or drawing has failed.
Result<PictureReceiver::Picture> next_picture(PictureReceiver& receiver, int number, const Plan& plan, bool png, const Children& drawing,
                                              const std::string& browser, const fs::path& log) {
  PictureReceiver::Picture picture;
  double waited = 0;
  while (!receiver.wait(number, png, plan.videos, 0.2, picture)) {
    waited += 0.2;
    if (interrupted()) return fail(interrupted_error());
    if (const std::string failure = receiver.failure(); !failure.empty())
      return fail(ErrorCode::io, "picture " + std::to_string(number + 1), failure, "Check the content in the studio.");
    if (std::ranges::any_of(drawing, [](const std::unique_ptr<Child>& child) { return child->ended(); }))
      return fail(ErrorCode::io, browser, "The browser ended before all pictures were drawn." + tail_of(log),
                  "Try another browser with --browser.");
    if (waited > patience)
      return fail(ErrorCode::io, browser, "The browser has drawn no picture for " + to_fixed(patience, 0) + " s." + tail_of(log),
                  "Give a smaller --size, or another browser with --browser.");
  }
  return picture;
}

}  // namespace

Result<std::vector<std::string>> export_pictures(const std::string& page, const std::string& name, std::span<const std::byte> ugx,
                                                 const PictureOptions& o, const PictureOutputs& outputs,
                                                 const std::function<Result<void>(const std::vector<std::string>&)>& check) {
  Result<HostedPlayer> hosted = open_hosted(ugx, name);
  if (!hosted) return fail(hosted.error());
  content::Player& player = hosted->player;
  if (!o.inputs.empty()) {
    auto inputs = content::read_inputs(o.inputs, player.content(), "inputs");
    if (!inputs) return fail(std::move(inputs.error()));
    player.schedule(std::move(*inputs));
  }
  const Result<Plan> plan = plan_of(player.content(), o, outputs);
  if (!plan) return fail(plan.error());
  const bool png = !outputs.png.empty();
  std::vector<std::string> pictures;  // the paths of the pictures of --png
  for (int i = 0; png && i < plan->count; ++i) pictures.push_back(plan->single ? outputs.png : numbered(outputs.png, i));
  if (Result<void> may = check(pictures); !may) return fail(std::move(may.error()));

  std::error_code ec;
  const bool graphics_processor = fs::exists("/dev/dri", ec);
  const Result<std::string> browser = find_browser(o.browser, graphics_processor);
  if (!browser) return fail(browser.error());
  std::string ffmpeg;
  if (plan->videos) {
    Result<std::string> found =
        find_program(o.ffmpeg, {"ffmpeg"}, "Install ffmpeg (`apt-get install ffmpeg`), or write pictures with --png frame%04d.png.");
    if (!found) return fail(std::move(found.error()));
    ffmpeg = std::move(*found);
  }
  std::string converter;
  if (plan->planar) {
    Result<std::string> part = publish::read_player_part("ugoki_planar.wasm", o.player);
    if (!part) return fail(std::move(part.error()));
    converter = std::move(*part);
  }
  const Result<std::string> filled = publish::make_page(page, name, {}, publish::PageEngine::pictures);
  if (!filled) return fail(filled.error());
  Result<Json> settings = page_settings(player, *plan, o, png);
  if (!settings) return fail(std::move(settings.error()));

  const Result<files::TemporaryFolder> scratch = files::TemporaryFolder::make("pictures", "temporary folder");
  if (!scratch) return fail(scratch.error());
  const fs::path folder = scratch->path();
  catch_interrupt();
  std::signal(SIGPIPE, SIG_IGN);
  const int browsers = browser_count(plan->count, graphics_processor);
  const std::size_t pixel_count = static_cast<std::size_t>(o.width) * static_cast<std::size_t>(o.height);
  PictureReceiver receiver(std::move(*hosted), std::move(*settings), std::move(converter), browsers,
                           plan->planar ? pixel_count * 3 / 2 : pixel_count * 4, plan->planar ? static_cast<std::size_t>(o.width) : 0);
  studio::ServerOptions server_options;
  server_options.page = *filled;
  server_options.binary_messages = true;
  const Result<std::unique_ptr<studio::Server>> server = studio::Server::listen(server_options, receiver);
  if (!server) return fail(server.error());
  receiver.answer_by(**server);
  const Result<std::unique_ptr<studio::LaunchPage>> launch = studio::LaunchPage::write((*server)->address());
  if (!launch) return fail(launch.error());
  const fs::path log = folder / "browser.log";
  const Result<Children> drawing = start_browsers(*browser, browsers, graphics_processor, "file://" + (*launch)->path(), folder, log);
  if (!drawing) return fail(drawing.error());
  VideoFiles videos(ffmpeg, {o.width, o.height, plan->rate, plan->planar, o.transparent}, folder / "ffmpeg.log");
  if (Result<void> done = videos.start(outputs); !done) return fail(std::move(done.error()));

  std::vector<std::string> written;
  Progress progress("pictures of " + name);
  for (int i = 0; i < plan->count; ++i) {
    const Result<PictureReceiver::Picture> picture = next_picture(receiver, i, *plan, png, *drawing, *browser, log);
    if (!picture) return fail(picture.error());
    if (png) {
      written.push_back(pictures[static_cast<std::size_t>(i)]);
      if (Result<void> done = files::write_file(written.back(), picture->png); !done) return fail(std::move(done.error()));
    }
    if (Result<void> done = videos.write(picture->raw); !done) return fail(std::move(done.error()));
    receiver.done(i);
    progress.show(static_cast<double>(i + 1) / plan->count);
  }
  progress.clear();
  Result<std::vector<std::string>> files = videos.finish();
  if (!files) return files;
  written.insert(written.end(), files->begin(), files->end());
  return written;
}

}  // namespace ugoki::cli
