#include "carried_lsis.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <memory>
#include <vector>

#include "ugoki/base/printable.h"
#include "ugoki/files/files.h"
#include "ugoki/files/temporary_folder.h"
#include "ugoki/lsi/standard_library.h"
#include "ugoki/plugin/guard.h"
#include "ugoki/plugin/live_library.h"
#include "ugoki/plugin/load.h"
#include "ugoki/studio/launch_page.h"

namespace ugoki::player_native {
namespace {

/// Reads the path of a page and a line break from a pipe, and opens the page. Opens nothing if the program ends first.
void open_received(int pipe) {
  std::string path;
  for (char c = 0; ::read(pipe, &c, 1) == 1;) {
    if (c == '\n') return studio::open_browser(path);
    path += c;
  }
}

}  // namespace

BrowserOpener::BrowserOpener(bool detached) {
  int ends[2];
  if (!detached || ::pipe2(ends, O_CLOEXEC) != 0) return;
  const pid_t child = ::fork();
  if (child == 0) {
    // The process that opens the browser belongs to init, because its parent ends at once. Ctrl+C of the terminal does not reach it.
    if (::fork() != 0) _exit(0);
    ::setsid();
    ::close(ends[1]);
    open_received(ends[0]);
    _exit(0);
  }
  ::close(ends[0]);
  if (child > 0) {
    ::waitpid(child, nullptr, 0);
    pipe_ = ends[1];
  } else {
    ::close(ends[1]);
  }
}

BrowserOpener::~BrowserOpener() {
  if (pipe_ >= 0) ::close(pipe_);
}

void BrowserOpener::open(const std::string& path) {
  if (pipe_ < 0) return studio::open_browser(path);
  const std::string line = path + '\n';
  [[maybe_unused]] const ssize_t n = ::write(pipe_, line.data(), line.size());
  ::close(pipe_);
  pipe_ = -1;
}

std::FILE* results() { return plugin::results(); }

Result<int> with_carried_lsis(std::span<const publish::CarriedLibrary> libraries, const std::string& name,
                              const std::function<int(const content::PlayerOptions&)>& work) {
  if (libraries.empty()) return work({});
  const auto guarded = [&] {
    std::vector<std::string> files;
    std::unique_ptr<plugin::LiveLibrary> live;
    {
      const Result<files::TemporaryFolder> folder = files::TemporaryFolder::make("lsi", name);
      Result<void> good;
      if (!folder) good = fail(folder.error());
      for (const publish::CarriedLibrary& each : libraries) {
        if (!good) break;
        files.push_back(folder->path() + "/" + each.name);
        good = files::write_file(files.back(), each.bytes);
        if (good) good = plugin::try_library(files.back());
      }
      if (!good) {
        for (const Problem& p : good.error().problems) std::fprintf(stderr, "%s\n", printable(p.text()).c_str());
        return 1;
      }
      live = std::make_unique<plugin::LiveLibrary>(lsi::standard_library(), "", files);
    }  // removes the files: the loaded code is a copy
    content::PlayerOptions host;
    host.library = live->library();
    host.activity = &plugin::process_activity();
    return work(host);
  };
  return plugin::run_guarded(guarded);
}

}  // namespace ugoki::player_native
