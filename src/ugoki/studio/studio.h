#pragma once
// `ugoki studio`: the whole service, until it is told to end.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "ugoki/base/result.h"
#include "ugoki/project/project.h"
#include "ugoki/studio/interpreter_process.h"

namespace ugoki::studio {

struct StudioOptions {
  std::uint16_t port = 0;          ///< 0: any free one
  std::filesystem::path web;       ///< folder of the page; empty: found beside the program
  std::string library_path;        ///< empty: store::Library::default_path()
  InterpreterProgram interpreter;  ///< how this program starts an interpreter
};

/// A studio that serves from start() to its end.
class Studio {
 public:
  [[nodiscard]] static Result<std::unique_ptr<Studio>> start(StudioOptions options, project::Project project);
  ~Studio();
  Studio(const Studio&) = delete;
  Studio& operator=(const Studio&) = delete;

  [[nodiscard]] std::string address() const;  ///< with the token
  [[nodiscard]] std::uint16_t port() const;
  [[nodiscard]] const std::string& token() const;
  /// Process of the interpreter, or -1; for tests.
  [[nodiscard]] int interpreter_pid() const;

 private:
  class Impl;
  explicit Studio(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// Blocks SIGINT and SIGTERM in this thread and those it makes from now on; to be called before Studio::start.
void hold_signals();
/// Waits for SIGINT or SIGTERM.
void wait_for_signal();
/// Opens `address` in the user's browser if there is a display and a program for it; does not wait for it.
void open_browser(const std::string& address);

}  // namespace ugoki::studio
