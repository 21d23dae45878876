#pragma once
// The studio's end of the interpreter's process.

#include <atomic>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/studio/channel.h"
#include "ugoki/studio/frame_ring.h"

namespace ugoki::studio {

/// How the interpreter's process is started.
struct InterpreterProgram {
  std::string path;                    ///< of the executable
  std::vector<std::string> arguments;  ///< that make it call run_interpreter
};

/// Called on a thread of the process object's own; must return at once.
struct InterpreterEvents {
  std::function<void(std::vector<std::byte>)> frame;
  std::function<void(std::string)> message;  ///< an event, or a reply to a request
  /// The process died by itself: how, and where (the flat id of an LSI, if it was one's fault). The last call.
  std::function<void(Problem)> ended;
};

class InterpreterProcess {
 public:
  [[nodiscard]] static Result<std::unique_ptr<InterpreterProcess>> start(const InterpreterProgram& program, InterpreterEvents events);
  /// Ends the process; no event comes after.
  ~InterpreterProcess();
  InterpreterProcess(const InterpreterProcess&) = delete;
  InterpreterProcess& operator=(const InterpreterProcess&) = delete;

  /// False if it is gone or does not listen. Called from one thread.
  bool send(std::string_view json, std::span<const std::byte> block = {}) { return control_.send(json, block); }
  /// Ends it by force; `ended` tells that it did not answer.
  void kill_unanswering();
  [[nodiscard]] int pid() const { return pid_; }

 private:
  InterpreterProcess(Channel control, FrameRing ring, int signal, int words, int pid, InterpreterEvents events);
  void listen();
  Problem wait_for_end();

  Channel control_;
  FrameRing ring_;
  int signal_;
  int words_;  ///< pipe of last words
  int pid_;
  InterpreterEvents events_;
  std::atomic<bool> ending_ = false, unanswering_ = false;
  std::thread thread_;
};

}  // namespace ugoki::studio
