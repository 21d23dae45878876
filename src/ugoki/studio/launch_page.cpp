#include "ugoki/studio/launch_page.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <thread>
#include <utility>

namespace ugoki::studio {

Result<std::unique_ptr<LaunchPage>> LaunchPage::write(const std::string& address) {
  std::error_code ec;
  const char* runtime = std::getenv("XDG_RUNTIME_DIR");
  const std::filesystem::path folder =
      runtime != nullptr && *runtime == '/' ? std::filesystem::path(runtime) : std::filesystem::temp_directory_path(ec);
  constexpr std::string_view ending = ".html";
  std::string path = (folder / "ugoki-studio-XXXXXX").string() + std::string(ending);
  const int fd = ::mkostemps(path.data(), static_cast<int>(ending.size()), O_CLOEXEC);  // creates the file with permissions 0600
  if (fd < 0) {
    return fail(ErrorCode::io, folder.string(),
                std::string("The file that opens the browser cannot be written: ") + std::strerror(errno) + ".",
                "Open the printed address in a browser.");
  }
  std::unique_ptr<LaunchPage> page(new LaunchPage(path));
  const std::string text =
      "<!doctype html><meta charset=\"utf-8\"><meta name=\"referrer\" content=\"no-referrer\"><title>Ugoki</title>"
      "<meta http-equiv=\"refresh\" content=\"0;url=" +
      address + "\">\n";
  const bool written = ::write(fd, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  if (::close(fd) != 0 || !written) {
    return fail(ErrorCode::io, path, "The file that opens the browser cannot be written.", "Open the printed address in a browser.");
  }
  return page;
}

LaunchPage::~LaunchPage() { ::unlink(path_.c_str()); }

void open_browser(const std::string& path) {
  if (std::getenv("DISPLAY") == nullptr && std::getenv("WAYLAND_DISPLAY") == nullptr) return;
  const char* program = "xdg-open";
  char* const arguments[] = {const_cast<char*>(program), const_cast<char*>(path.c_str()), nullptr};
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t none;
  sigemptyset(&none);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addclosefrom_np(&actions, 3);  // closes the studio's sockets and files in the child
  pid_t pid = -1;
  if (posix_spawnp(&pid, program, &actions, &attributes, arguments, environ) == 0) {
    std::thread([pid] { waitpid(pid, nullptr, 0); }).detach();
  }
  posix_spawn_file_actions_destroy(&actions);
  posix_spawnattr_destroy(&attributes);
}

}  // namespace ugoki::studio
