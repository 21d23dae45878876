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
#include "ugoki/plugin/guard_block.h"
#include "ugoki/studio/channel.h"
#include "ugoki/studio/frame_ring.h"

namespace ugoki::studio {

/// Command line that starts the interpreter's process.
struct InterpreterProgram {
  std::string path;                    ///< path of the executable
  std::vector<std::string> arguments;  ///< arguments that make the executable call run_interpreter
};

/// Callbacks. They are called on the thread of the InterpreterProcess and must not block.
struct InterpreterEvents {
  std::function<void(std::vector<std::byte>)> frame;
  std::function<void(std::string)> message;  ///< receives an event, or a reply to a request
  /// The process ended unexpectedly. The argument is the reason; its location is the LSI's id if an LSI caused the end. No callback
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
  /// Kills a process that does not answer. The callback `ended` then reports this.
  void kill_unanswering();
  [[nodiscard]] int pid() const { return pid_; }

 private:
  InterpreterProcess(Channel control, FrameRing ring, plugin::GuardMemory guard, int signal, int words, int pid, std::string mark,
                     InterpreterEvents events);
  void listen();
  /// Waits for the end of the process, or ends it, and ends the processes that it started. @return the reason of the end
  Problem wait_for_end();

  Channel control_;
  FrameRing ring_;
  plugin::GuardMemory guard_;  ///< memory in which the process records the LSI that is running
  int signal_;                 ///< eventfd that signals new frames
  int words_;                  ///< pipe from which the fault report of a crash is read
  int pid_;
  std::string mark_;  ///< entry of the environment of the process and of those that it starts: "NAME=VALUE"
  int process_;       ///< pidfd of the process: readable when the process has ended; -1 if the system has none
  InterpreterEvents events_;
  std::atomic<bool> ending_ = false, unanswering_ = false;
  bool replaced_ = false;  ///< an LSI has replaced the process by another program; used by thread_ only
  std::thread thread_;
};

}  // namespace ugoki::studio
