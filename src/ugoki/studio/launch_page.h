#pragma once
// A file that `ugoki studio` opens in the browser and that contains the secret address. All users can see the arguments of a program, but
// not the content of this file.

#include <memory>
#include <string>

#include "ugoki/base/result.h"

namespace ugoki::studio {

/// An HTML file with permissions 0600 that redirects a browser to an address. The destructor removes the file.
class LaunchPage {
 public:
  /// Writes the file into $XDG_RUNTIME_DIR or the folder for temporary files. Errors: the folder cannot be written.
  [[nodiscard]] static Result<std::unique_ptr<LaunchPage>> write(const std::string& address);
  ~LaunchPage();
  LaunchPage(const LaunchPage&) = delete;
  LaunchPage& operator=(const LaunchPage&) = delete;

  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  explicit LaunchPage(std::string path) : path_(std::move(path)) {}
  std::string path_;
};

/// Opens a file in the user's browser (xdg-open) without waiting for it. Does nothing if there is no display.
void open_browser(const std::string& path);

}  // namespace ugoki::studio
