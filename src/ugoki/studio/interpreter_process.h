#pragma once
// Starts the interpreter's process and exchanges messages and frames with it, on the studio's side.

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

/// Command line of the interpreter's process.
struct InterpreterProgram {
  std::string path;                    ///< path of the executable
  std::vector<std::string> arguments;  ///< arguments that make the executable call run_interpreter
};

/// Callbacks. They are called on the thread of the InterpreterProcess and must not block.
struct InterpreterEvents {
  std::function<void(std::vector<std::byte>)> frame;
  std::function<void(std::string)> message;  ///< an event, or a reply to a request
  /// The process ended without being asked to: the reason, and the location (the flat id of an LSI if an LSI caused it). No callback
  /// follows.
  std::function<void(Problem)> ended;
};

class InterpreterProcess {
 public:
  [[nodiscard]] static Result<std::unique_ptr<InterpreterProcess>> start(const InterpreterProgram& program, InterpreterEvents events);
  /// Ends the process. No callback is called afterwards.
  ~InterpreterProcess();
  InterpreterProcess(const InterpreterProcess&) = delete;
  InterpreterProcess& operator=(const InterpreterProcess&) = delete;

  /// Sends a request. Returns false if the process has ended or does not read the socket. To be called from one thread only.
  bool send(std::string_view json, std::span<const std::byte> block = {}) { return control_.send(json, block); }
  /// Kills the process; `ended` then reports that it did not answer.
  void kill_unanswering();
  [[nodiscard]] int pid() const { return pid_; }

 private:
  InterpreterProcess(Channel control, FrameRing ring, int signal, int words, int pid, InterpreterEvents events);
  void listen();
  Problem wait_for_end();

  Channel control_;
  FrameRing ring_;
  int signal_;  ///< eventfd that signals new frames
  int words_;   ///< pipe from which last words are read
  int pid_;
  InterpreterEvents events_;
  std::atomic<bool> ending_ = false, unanswering_ = false;
  std::thread thread_;
};

}  // namespace ugoki::studio
