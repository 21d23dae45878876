#pragma once
// The open project and everybody who works on it: commands, undo, events to all pages, the interpreter's life. Knows no
// sockets. All members are called on one thread but for the interpreter's frames.

#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/project/project.h"
#include "ugoki/store/library.h"
#include "ugoki/studio/interpreter_process.h"
#include "ugoki/studio/outbox.h"
#include "ugoki/studio/task_queue.h"

namespace ugoki::studio {

struct SessionOptions {
  std::string library_path;  ///< where commands fetch mechanisms and motions from; empty: nowhere
  std::string choices_path;  ///< file that keeps the user's keymap, theme and view; empty: they last as long as the page
  InterpreterProgram interpreter;
  std::chrono::milliseconds patience{10'000};  ///< with an interpreter that does not answer
};

/// A motion or mechanism of the open project, as the library lists it.
struct ProjectEntry {
  std::string id;
  MechanismPtr mechanism;  ///< of a motion: the one that it fits, perhaps null
  std::string mechanism_id;
  MotionPtr motion;  ///< null: the entry is the mechanism
  bool used = true;  ///< false: an operation made it, and only a document that undo or redo brings back plays it
};

class Session {
 public:
  /// @param post runs a task on the session's thread, later
  Session(SessionOptions options, project::Project project, Outbox& outbox, std::function<void(std::function<void()>)> post);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  /// Starts the interpreter with the content as it is.
  void start();
  /// Ends the interpreter for good.
  void stop();
  /// A message from a page (docs/studio-protocol.md). Whatever it is, it is answered.
  void on_message(ClientId client, std::string_view text);
  /// A page went away: what its user held in hand is let go.
  void on_close(ClientId client);
  /// To be called a few times a second: notices an interpreter that does not answer.
  void on_time();
  /// Tells every page that the library's entries changed.
  void announce_library();

  [[nodiscard]] MechanismPtr find_mechanism(std::string_view id) const;
  [[nodiscard]] std::vector<ProjectEntry> project_entries() const;
  [[nodiscard]] const project::Project& project() const { return project_; }
  [[nodiscard]] int interpreter_pid() const { return pid_; }  ///< -1: none. From any thread

 private:
  struct Request;  // one message from a page
  struct Pending {
    ClientId client = 0;   ///< 0: nobody waits for the reply
    std::string reply_to;  ///< the page's id as JSON
    bool quiet = false;    ///< only a failure is told
  };

  [[nodiscard]] Result<std::string> serve(const Request& request, bool& answered);
  [[nodiscard]] std::string hello() const;
  [[nodiscard]] Result<std::string> execute(const Request& request);
  /// Applies a command, with what the pages are told of it. @return the answer's fields
  [[nodiscard]] Result<std::string> apply(const std::string& command, const std::string& circuit_changes = "");
  /// The library, opened when it is first needed; null where there is none.
  [[nodiscard]] const store::Library* library();

  // session_motion.cpp: operations on the motions of clips, done on a thread of their own
  struct MotionTask;
  [[nodiscard]] Result<void> start_motion(const Request& request);
  [[nodiscard]] Result<std::string> cancel_motion(const Request& request);
  void cancel_motions();
  void finish_motion(MotionTask& task);
  [[nodiscard]] Result<std::string> place_motion(const MotionTask& task);
  [[nodiscard]] Result<std::string> undo_or_redo(bool undo);
  [[nodiscard]] Result<std::string> save(const Request& request);
  [[nodiscard]] std::string choices() const;
  [[nodiscard]] Result<std::string> remember(const Request& request) const;
  [[nodiscard]] Result<std::string> set_breakpoints(const Request& request);  // session_breakpoints.cpp
  [[nodiscard]] Result<void> take_breakpoints(const Request& request);
  void restore_breakpoints();
  [[nodiscard]] Result<void> check_transport(const Request& request) const;
  [[nodiscard]] Result<void> forward(const Request& request);

  [[nodiscard]] std::set<std::string> used_motions() const;
  /// @param event that tells the pages
  void changed(std::string event);
  [[nodiscard]] std::string document_event() const;
  [[nodiscard]] std::string edited_event(const std::string& changes, std::uint64_t from) const;
  [[nodiscard]] std::string state_fields() const;
  void generate();
  void load_content();
  /// The content, which does not play, with the circuit that the generator makes: so that the tracks can still be seen.
  void load_without_circuit();
  void set_circuit_problems(Error problems);
  [[nodiscard]] Result<void> ensure_interpreter();
  bool send_to_interpreter(std::string request, const std::vector<std::byte>& block, Pending pending);
  void on_interpreter_message(const std::string& text);
  void on_interpreter_end(const Problem& why);
  [[nodiscard]] std::string document_fields() const;
  [[nodiscard]] std::string transport_event() const;
  void log(std::string_view level, std::string_view text);
  void reply(ClientId client, const std::string& reply_to, const Result<std::string>& result);

  SessionOptions options_;
  project::Project project_;
  std::optional<store::Library> library_;
  Outbox& outbox_;
  std::function<void(std::function<void()>)> post_;
  std::map<std::string, std::shared_ptr<MotionTask>> motion_tasks_;  ///< by the page's name for them
  TaskQueue motion_queue_;

  std::unique_ptr<InterpreterProcess> process_;
  std::atomic<int> pid_ = -1;
  std::uint64_t generation_ = 0;                 ///< of the process; what comes from older ones is ignored
  std::vector<std::byte> executable_;            ///< the newest that could be generated
  std::set<std::string> listed_;                 ///< motions of the project that the library's list has
  std::string lsis_;                             ///< newest lsis event: what circuits may be made of
  std::string devices_;                          ///< newest devices event: what the circuit reads of keyboard, mouse and gamepads
  ClientId holder_ = 0;                          ///< page whose user holds something in hand; 0: none
  std::string stopped_;                          ///< newest stopped event, until it runs again; may be empty
  std::filesystem::file_time_type shelf_stamp_;  ///< of the installed libraries when the interpreter was lost
  std::string watch_;                            ///< newest request to watch the circuit, for a new interpreter; may be empty
  std::string breakpoints_ = "[]";               ///< as the pages know them
  std::string breakpoints_request_;              ///< those that are on, for a new interpreter; may be empty
  Error circuit_problems_;                       ///< why the content as it is cannot be played; empty: it can
  int last_request_ = 0;
  int content_request_ = 0;  ///< the newest that brought content
  std::map<int, Pending> pending_;
  int ping_ = 0;  ///< request id of a ping without answer; 0: none
  std::chrono::steady_clock::time_point ping_time_;

  std::string transport_;  ///< newest transport event
  std::string summary_;    ///< newest summary event
  bool simulate_ = false;  ///< mode that a new interpreter gets
  double speed_ = 1;
  mutable std::mutex frame_mutex_;
  FrameBytes last_frame_;
};

}  // namespace ugoki::studio
