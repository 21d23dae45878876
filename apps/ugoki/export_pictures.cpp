// Pictures and videos of `ugoki export`. A headless browser draws the player's page, and the page sends each picture to this program. The
// program writes the picture or passes it to ffmpeg. Pictures, the studio and exported pages therefore have the same renderer.

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <condition_variable>
#include <csignal>
#include <deque>
#include <filesystem>
#include <map>
#include <mutex>
#include <thread>

#include "child.h"
#include "export.h"
#include "output.h"
#include "ugoki/base/number.h"
#include "ugoki/content/executable.h"
#include "ugoki/files/files.h"
#include "ugoki/files/temporary_folder.h"
#include "ugoki/publish/page.h"
#include "ugoki/studio/launch_page.h"
#include "ugoki/studio/security.h"
#include "ugoki/studio/server.h"

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

/// Receives the pictures of the page.
class Receiver final : public studio::ServerEvents {
 public:
  struct Picture {
    std::string png, raw;
  };

  /// @param settings of all pages, JSON @param pages number of pages; page k draws the pictures k, k + pages, k + 2 pages ...
  Receiver(Json settings, int pages) : settings_(std::move(settings)), pages_(pages) {}

  void on_api(studio::ApiRequest request, std::function<void(studio::ApiReply)> answer) override {
    if (request.path == "/api/pictures") {
      Json settings = settings_;
      settings["first"] = next_page_++ % pages_;
      settings["stride"] = pages_;
      return answer({200, json::to_text(settings)});
    }
    if (request.path == "/api/picture") {
      const std::optional<long> number = parse_long(studio::query_value(request.query, "number").value_or(""));
      const bool png = studio::query_value(request.query, "form").value_or("") == "png";
      if (!number) return answer({400, "{}"});
      {
        const std::lock_guard lock(mutex_);
        Picture& p = arrived_[static_cast<int>(*number)];
        (png ? p.png : p.raw) = std::move(request.body);
        answers_.emplace(static_cast<int>(*number), std::move(answer));
      }
      return changed_.notify_all();
    }
    if (request.path == "/api/failed") {
      {
        const std::lock_guard lock(mutex_);
        failure_ = request.body.substr(0, 2000);
      }
      changed_.notify_all();
      return answer({200, "{}"});
    }
    answer({404, "{}"});
  }
  void on_message(studio::ClientId, std::string, std::function<void()> done) override { done(); }
  void on_close(studio::ClientId) override {}

  /// Waits for the picture `number` for at most `seconds`. @return whether it has arrived with all wanted forms
  bool wait(int number, bool png, bool raw, double seconds, Picture& out) {
    std::unique_lock lock(mutex_);
    const auto complete = [&] {
      const auto found = arrived_.find(number);
      return !failure_.empty() || (found != arrived_.end() && (!png || !found->second.png.empty()) && (!raw || !found->second.raw.empty()));
    };
    if (!changed_.wait_for(lock, std::chrono::duration<double>(seconds), complete) || !failure_.empty()) return false;
    out = std::move(arrived_[number]);
    arrived_.erase(number);
    return true;
  }
  /// Answers the page's requests with this picture, so that the page sends further pictures.
  void done(int number) {
    std::vector<std::function<void(studio::ApiReply)>> answers;
    {
      const std::lock_guard lock(mutex_);
      const auto [begin, end] = answers_.equal_range(number);
      for (auto i = begin; i != end; ++i) answers.push_back(std::move(i->second));
      answers_.erase(begin, end);
    }
    for (const auto& answer : answers) answer({200, "{}"});
  }
  std::string failure() {
    const std::lock_guard lock(mutex_);
    return failure_;
  }

 private:
  const Json settings_;
  const int pages_;
  std::atomic<int> next_page_ = 0;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::map<int, Picture> arrived_;
  std::multimap<int, std::function<void(studio::ApiReply)>> answers_;
  std::string failure_;
};

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

/// A video that is being written. ffmpeg writes a temporary file, which is renamed at the end.
struct Video {
  std::string file, part;
  std::unique_ptr<Child> ffmpeg;
};

}  // namespace

Result<std::vector<std::string>> export_pictures(const std::string& page, const std::string& name, std::span<const std::byte> ugx,
                                                 const PictureOptions& o, const PictureOutputs& outputs,
                                                 const std::function<Result<void>(const std::vector<std::string>&)>& check) {
  const Result<content::Executable> content = content::read_executable(ugx, name);
  if (!content) return fail(content.error());
  const double rate = o.rate > 0 ? o.rate : content->frame_rate;
  const double end = o.duration > 0 ? o.duration : content->duration;
  const bool videos = !outputs.mp4.empty() || !outputs.webm.empty() || !outputs.gif.empty();
  const bool single = !videos && !is_pattern(outputs.png);
  if (videos && !outputs.png.empty() && !is_pattern(outputs.png))
    return fail(ErrorCode::conflict, "--png", "One picture and a video cannot be written at once.",
                "Give --png a file name with %04d, or call `ugoki export` twice.");
  if (o.from >= end && !single)
    return fail(ErrorCode::range, "--from",
                "The first picture is at " + to_fixed(o.from, 3) + " s, but the content ends at " + to_fixed(end, 3) + " s.",
                "Give an earlier time.");
  if (o.transparent && (!outputs.mp4.empty() || !outputs.gif.empty()))
    return fail(ErrorCode::unsupported, "--transparent", "MP4 and GIF videos have no transparent background.", "Use --webm or --png.");
  const double wanted = single ? 1 : std::max(1.0, std::round((end - o.from) * rate));
  if (wanted > max_pictures)
    return fail(ErrorCode::range, "--duration",
                "The export would have " + to_fixed(wanted, 0) + " pictures; the limit is " + std::to_string(max_pictures) + ".",
                "Give a shorter --duration or a lower --rate.");
  const int count = static_cast<int>(wanted);
  if ((!outputs.mp4.empty() || !outputs.webm.empty()) && (o.width % 2 != 0 || o.height % 2 != 0))
    return fail(ErrorCode::range, "--size", "Width and height of a video must be even.", "Give, for example, --size 1280x720.");

  std::error_code ec;
  std::vector<std::string> pictures;  // the paths of the pictures of --png
  for (int i = 0; !outputs.png.empty() && i < count; ++i) pictures.push_back(single ? outputs.png : numbered(outputs.png, i));
  if (Result<void> may = check(pictures); !may) return fail(std::move(may.error()));

  const bool graphics_processor = fs::exists("/dev/dri", ec);
  const Result<std::string> browser = find_browser(o.browser, graphics_processor);
  if (!browser) return fail(browser.error());
  std::string ffmpeg;
  if (videos) {
    Result<std::string> found =
        find_program(o.ffmpeg, {"ffmpeg"}, "Install ffmpeg (`apt-get install ffmpeg`), or write pictures with --png frame%04d.png.");
    if (!found) return fail(std::move(found.error()));
    ffmpeg = std::move(*found);
  }
  const Result<std::string> filled = publish::make_page(page, name, ugx, publish::PageEngine::pictures);
  if (!filled) return fail(filled.error());

  const Result<files::TemporaryFolder> scratch = files::TemporaryFolder::make("pictures", "temporary folder");
  if (!scratch) return fail(scratch.error());
  const fs::path folder = scratch->path();
  catch_interrupt();
  std::signal(SIGPIPE, SIG_IGN);

  // For MP4 and WebM alone, the page sends planar YCbCr, the input form of the coders. A GIF and a transparent background need RGBA.
  const bool planar = videos && outputs.gif.empty() && !o.transparent && o.blur == 1 && o.width % 2 == 0 && o.height % 2 == 0;
  Json settings = {{"width", o.width},
                   {"height", o.height},
                   {"rate", rate},
                   {"from", o.from},
                   {"count", count},
                   {"blur", o.blur},
                   {"shutter", o.shutter},
                   {"transparent", o.transparent},
                   {"theme", o.light ? "light" : "dark"},
                   {"assist", o.overlays},
                   {"png", !outputs.png.empty()},
                   {"raw", !videos  ? ""
                           : planar ? "planar"
                                    : "rgba"},
                   {"ahead", max_waiting}};
  if (!o.inputs.empty()) {
    Result<Json> inputs = json::parse_json(o.inputs, "inputs");
    if (!inputs) return fail(std::move(inputs.error()));
    settings["inputs"] = inputs->contains("inputs") ? (*inputs)["inputs"] : *inputs;
  }
  const int browsers = browser_count(count, graphics_processor);
  Receiver receiver(std::move(settings), browsers);
  studio::ServerOptions server_options;
  server_options.page = *filled;
  const Result<std::unique_ptr<studio::Server>> server = studio::Server::listen(server_options, receiver);
  if (!server) return fail(server.error());
  const Result<std::unique_ptr<studio::LaunchPage>> launch = studio::LaunchPage::write((*server)->address());
  if (!launch) return fail(launch.error());

  const fs::path browser_log = folder / "browser.log", ffmpeg_log = folder / "ffmpeg.log";
  std::vector<std::string> words = {*browser,
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
    if (browsers > 1) variables.emplace_back("LP_NUM_THREADS", "0");  // llvmpipe draws on the thread that calls it
  }
  if (::geteuid() == 0) words.emplace_back("--no-sandbox");  // Chromium refuses to run as root with its sandbox
  std::vector<std::unique_ptr<Child>> drawing;
  for (int i = 0; i < browsers; ++i) {
    std::vector<std::string> own = words;
    own.push_back("--user-data-dir=" + (folder / ("profile" + std::to_string(i))).string());
    own.push_back(page_word(*browser, "file://" + (*launch)->path()));
    Result<std::unique_ptr<Child>> child = Child::start(own, false, browser_log.string(), variables);
    if (!child) return fail(std::move(child.error()));
    drawing.push_back(std::move(*child));
  }

  std::vector<Video> started;
  struct Unfinished {  // removes the files of videos that were not completed
    std::vector<Video>& videos;
    ~Unfinished() {
      for (Video& v : videos) {
        v.ffmpeg.reset();
        std::error_code ignored;
        if (!v.part.empty()) fs::remove(v.part, ignored);
      }
    }
  } unfinished{started};
  const auto start_video = [&](const std::string& file, std::vector<std::string> codec, const char* ending) -> Result<void> {
    if (file.empty()) return {};
    const fs::path target = file;
    std::error_code missing;
    if (fs::exists(target, missing) && !fs::is_regular_file(target, missing))
      return fail(ErrorCode::io, file, "Videos can be written only to files, not to folders, pipes and devices.", "Name another file.");
    const std::string part = (target.parent_path() / ("." + target.filename().string() + ".part" + ending)).string();
    std::vector<std::string> command = {ffmpeg,
                                        "-hide_banner",
                                        "-loglevel",
                                        "error",
                                        "-y",
                                        "-f",
                                        "rawvideo",
                                        "-pix_fmt",
                                        planar ? "yuv420p" : "rgba",
                                        "-s",
                                        std::to_string(o.width) + "x" + std::to_string(o.height),
                                        "-r",
                                        to_text(rate),
                                        "-i",
                                        "-",
                                        "-an"};
    command.insert(command.end(), codec.begin(), codec.end());
    command.push_back(part);
    Result<std::unique_ptr<Child>> child = Child::start(command, true, ffmpeg_log.string());
    if (!child) return fail(std::move(child.error()));
    started.push_back({file, part, std::move(*child)});
    return {};
  };
  // Videos have the colours of ITU-R BT.709, limited range. The file states this, because players assume BT.709 for large pictures only.
  // The rows of RGBA pictures arrive from the bottom to the top, in the order of WebGL; vflip turns them.
  const auto coder = [&](std::initializer_list<const char*> words) {
    std::vector<std::string> out;
    if (!planar) out = {"-vf", "vflip,scale=out_color_matrix=bt709:out_range=tv"};
    out.insert(out.end(), words.begin(), words.end());
    out.insert(out.end(), {"-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "bt709", "-color_range", "tv"});
    return out;
  };
  if (Result<void> done = start_video(outputs.mp4,
                                      coder({"-c:v", "libx264", "-preset", "ultrafast", "-aq-mode", "1", "-crf", "18", "-pix_fmt",
                                             "yuv420p", "-movflags", "+faststart"}),
                                      ".mp4");
      !done)
    return fail(std::move(done.error()));
  if (Result<void> done = start_video(outputs.webm,
                                      coder({"-c:v", "libvpx-vp9", "-crf", "24", "-b:v", "0", "-row-mt", "1", "-deadline", "good",
                                             "-cpu-used", "5", "-pix_fmt", o.transparent ? "yuva420p" : "yuv420p"}),
                                      ".webm");
      !done)
    return fail(std::move(done.error()));
  if (Result<void> done = start_video(
          outputs.gif,
          {"-vf", "vflip,split[a][b];[a]palettegen=stats_mode=diff[p];[b][p]paletteuse=dither=bayer:bayer_scale=4", "-loop", "0"}, ".gif");
      !done)
    return fail(std::move(done.error()));

  std::vector<std::string> written;
  Progress progress("pictures of " + name);
  for (int i = 0; i < count; ++i) {
    Receiver::Picture picture;
    double waited = 0;
    while (!receiver.wait(i, !outputs.png.empty(), videos, 0.2, picture)) {
      waited += 0.2;
      if (interrupted()) return fail(interrupted_error());
      if (const std::string failure = receiver.failure(); !failure.empty())
        return fail(ErrorCode::io, "picture " + std::to_string(i + 1), failure, "Check the content in the studio.");
      if (std::ranges::any_of(drawing, [](const std::unique_ptr<Child>& child) { return child->ended(); }))
        return fail(ErrorCode::io, *browser, "The browser ended before all pictures were drawn." + tail_of(browser_log),
                    "Try another browser with --browser.");
      if (waited > patience)
        return fail(ErrorCode::io, *browser, "The browser has drawn no picture for " + to_fixed(patience, 0) + " s." + tail_of(browser_log),
                    "Give a smaller --size, or another browser with --browser.");
    }
    if (!outputs.png.empty()) {
      const std::string& file = pictures[static_cast<std::size_t>(i)];
      if (Result<void> done = files::write_file(file, picture.png); !done) return fail(std::move(done.error()));
      written.push_back(file);
    }
    for (const Video& v : started)
      if (!v.ffmpeg->write(picture.raw))
        return fail(ErrorCode::io, v.file, "ffmpeg stopped." + tail_of(ffmpeg_log),
                    "Check the permissions of the folder and the free space on the disk.");
    receiver.done(i);
    progress.show(static_cast<double>(i + 1) / count);
  }
  progress.clear();
  for (Video& v : started) {
    if (!v.ffmpeg->wait())
      return fail(interrupted() ? interrupted_error()
                                : Error(ErrorCode::io, v.file, "ffmpeg reported an error." + tail_of(ffmpeg_log),
                                        "Check that ffmpeg has the codec."));
    fs::rename(v.part, v.file, ec);
    if (ec) return fail(ErrorCode::io, v.file, "The video cannot be renamed: " + ec.message() + ".", "Check the folder's permissions.");
    v.part.clear();
    written.push_back(v.file);
  }
  return written;
}

}  // namespace ugoki::cli
