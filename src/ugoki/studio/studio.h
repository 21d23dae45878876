#pragma once
// The complete service behind `ugoki studio`.

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
  std::uint16_t port = 0;          ///< port on 127.0.0.1; 0: any free port
  std::filesystem::path web;       ///< folder of the page, with index.html; empty: no page is served
  std::string key;                 ///< see session_key.h; empty: a random key, so that open pages lose their access at a restart
  std::string library_path;        ///< location of the library; empty: store::Library::default_path()
  InterpreterProgram interpreter;  ///< command line that starts an interpreter
};

/// A running studio: it serves from start() until it is destroyed.
class Studio {
 public:
  [[nodiscard]] static Result<std::unique_ptr<Studio>> start(StudioOptions options, project::Project project);
  ~Studio();
  Studio(const Studio&) = delete;
  Studio& operator=(const Studio&) = delete;

  [[nodiscard]] std::string address() const;  ///< URL of the page, with the access code (see Server::address)
  [[nodiscard]] std::uint16_t port() const;
  [[nodiscard]] const std::string& token() const;
  /// Process id of the interpreter, or -1 if none runs; for tests.
  [[nodiscard]] int interpreter_pid() const;

 private:
  class Impl;
  explicit Studio(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// Blocks SIGINT and SIGTERM in this thread and in threads that it creates later, and ignores SIGPIPE. To be called before Studio::start.
void hold_signals();
/// Waits for SIGINT or SIGTERM. Requires hold_signals().
void wait_for_signal();

}  // namespace ugoki::studio
