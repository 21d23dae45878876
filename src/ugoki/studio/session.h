#pragma once
// The open project and the pages that edit it: commands, undo, events to all pages, start and end of the interpreter. Independent of
// sockets. All members are called on one thread; only the interpreter's frames arrive on another.

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
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/project/project.h"
#include "ugoki/store/library.h"
#include "ugoki/studio/interpreter_process.h"
#include "ugoki/studio/outbox.h"
#include "ugoki/studio/pose_desk.h"
#include "ugoki/studio/shown_scenario.h"
#include "ugoki/studio/task_queue.h"

namespace ugoki::studio {

/// Work that runs on the library's thread. `library` is an error if the library could not be opened or does not respond. The work returns
/// false if the library failed.
using LibraryWork = std::function<bool(const Result<store::Library*>& library)>;

struct SessionOptions {
  /// Runs work on the library's thread, for requests that read mechanisms and motions of the library; empty: there is no library
  std::function<void(LibraryWork)> with_library;
  std::string recent_path;   ///< file that stores the list of recently opened projects; empty: it is not stored
  std::string choices_path;  ///< file that stores the user's keymap, theme and view; empty: they are not stored
  InterpreterProgram interpreter;
  std::chrono::milliseconds answer_timeout{10'000};  ///< an interpreter that does not answer for this time is killed
};

/// A motion or mechanism of the open project, for the lists of the library.
struct ProjectEntry {
  std::string id;
  MechanismPtr mechanism;  ///< the mechanism, or for a motion the mechanism that it fits; may be null
  std::string mechanism_id;
  MotionPtr motion;  ///< the motion; null: the entry is the mechanism
  bool used = true;  ///< false: a motion made by an operation that no clip uses; it is kept for undo and redo only
};

class Session {
 public:
  /// @param post queues a task for the session's thread; the session calls it from any thread
  Session(SessionOptions options, project::Project project, Outbox& outbox, std::function<void(std::function<void()>)> post);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  /// Starts the interpreter with the current content.
  void start();
  /// Ends the interpreter and the running operations on motions. The session cannot be started again.
  void stop();
  /// Handles a message from a page (docs/studio-protocol.md). Every message is answered, even an invalid one, except a successful `drag` or
  /// `input`.
  void on_message(ClientId client, std::string_view text);
  /// Handles a closed page: releases the keys and buttons that its user held.
  void on_close(ClientId client);
  /// To be called a few times a second: kills an interpreter that does not answer, and restarts a stopped one when a library changed.
  void on_time();
  /// Notifies all pages that the library's entries changed (event `library`).
  void announce_library();
  /// Shows the warning of the library (Library::warning()) on all pages, also on those that connect later.
  void warn_about_library(const Problem& warning);

  [[nodiscard]] MechanismPtr find_mechanism(std::string_view id) const;
  [[nodiscard]] std::vector<ProjectEntry> project_entries() const;
  [[nodiscard]] const project::Project& project() const { return project_; }
  [[nodiscard]] int interpreter_pid() const { return pid_; }  ///< process id of the interpreter; -1: none. Thread-safe

 private:
  struct Request;  // one message from a page
  using RequestPtr = std::shared_ptr<Request>;
  /// A request to the interpreter that has no reply yet.
  struct Pending {
    ClientId client = 0;   ///< page that waits for the reply; 0: none
    std::string reply_to;  ///< request id that the page gave, as JSON; for client 0: a name of the request
    bool quiet = false;    ///< true: only a failure is reported to the page
  };

  void answer(const Request& request);
  [[nodiscard]] Result<std::string> serve(const Request& request, bool& answered);
  [[nodiscard]] std::string hello() const;
  [[nodiscard]] Result<std::string> execute(const Request& request);
  /// Applies a command and sends the change to the pages. @return JSON fields of the answer
  /// @param circuit_changes the changes of a `circuit.edit`, JSON; if not empty, the pages get only these and not the whole document
  /// @param resources data of the library entries that the command names
  [[nodiscard]] Result<std::string> apply(const std::string& command, const std::string& circuit_changes = "",
                                          std::span<const project::LibraryData> resources = {});

  // session_library.cpp: the library is read on the library's thread. Meanwhile the session serves other requests. Only later project
  // changes of the same page wait, so that they are applied in the order of the requests.
  void begin(const RequestPtr& request);
  /// Returns work that reads the library data that the request needs and stores them in the request; empty: the request needs none.
  [[nodiscard]] LibraryWork library_work(const RequestPtr& request) const;

  // session_motion.cpp: operations on the motions of clips; they run on the thread of motion_queue_
  struct MotionTask;
  [[nodiscard]] Result<void> start_motion(const Request& request);
  [[nodiscard]] Result<void> start_gait(const Request& request);
  [[nodiscard]] Result<std::shared_ptr<MotionTask>> new_motion_task(const Request& request) const;
  void post_motion_task(const std::shared_ptr<MotionTask>& task);
  [[nodiscard]] Result<std::string> list_gaits(const Request& request) const;
  [[nodiscard]] Result<std::string> cancel_motion(const Request& request);
  void cancel_motions();
  void finish_motion(MotionTask& task);
  [[nodiscard]] Result<std::string> insert_motion(const MotionTask& task);
  [[nodiscard]] Result<std::string> undo_or_redo(bool undo);
  [[nodiscard]] Result<std::string> enter(const Request& request);
  [[nodiscard]] Result<std::string> save(const Request& request);
  // session_project.cpp: another project is opened or created, in place of the open project
  [[nodiscard]] Result<std::string> open_project(const Request& request);
  [[nodiscard]] Result<std::string> new_project(const Request& request);
  void replace_project(project::Project project);
  /// The recently opened projects that still exist, newest first, JSON.
  [[nodiscard]] std::string recent() const;
  void remember_project() const;
  [[nodiscard]] std::string choices() const;
  [[nodiscard]] Result<std::string> remember(const Request& request) const;
  [[nodiscard]] Result<std::string> set_breakpoints(const Request& request);  // in session_breakpoints.cpp
  [[nodiscard]] Result<void> take_breakpoints(const Request& request);
  void restore_breakpoints();
  [[nodiscard]] Result<void> check_transport(const Request& request) const;
  [[nodiscard]] Result<void> forward(const Request& request);

  [[nodiscard]] std::set<std::string> used_motions() const;
  /// Handles a changed document. @param event message about the change for the pages
  void changed(std::string event);
  /// Sends the range of the document and whether playing repeats it.
  void send_range();
  [[nodiscard]] std::string document_event() const;
  [[nodiscard]] std::string edited_event(const std::string& changes, std::uint64_t from) const;
  [[nodiscard]] std::string state_fields() const;
  void generate();
  void load_content();
  /// Loads the content with a generated circuit instead of its own circuit, which cannot run, so that edit mode can show the tracks.
  void load_without_circuit();
  void set_circuit_problems(Error problems);
  /// Starts the interpreter if none is running.
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
  Outbox& outbox_;
  std::function<void(std::function<void()>)> post_;
  std::map<ClientId, std::vector<RequestPtr>> waiting_;  ///< project changes that wait for an earlier library request of the same page
  std::map<std::string, std::shared_ptr<MotionTask>> motion_tasks_;  ///< running operations on motions, by the name that the page gave
  TaskQueue motion_queue_;
  PoseDesk poses_;
  ShownScenario shown_;

  std::unique_ptr<InterpreterProcess> process_;
  std::atomic<int> pid_ = -1;
  std::uint64_t generation_ = 0;                 ///< number of the current interpreter process; messages of older ones are ignored
  std::vector<std::byte> executable_;            ///< executable data of the last content that could be generated
  std::set<std::string> listed_;                 ///< motions of the project that were last announced in the library's list
  std::string lsis_;                             ///< last `lsis` event: the LSI classes that circuits may use
  std::string devices_;                          ///< last `devices` event: what the circuit reads of keyboard, mouse and gamepads
  ClientId input_client_ = 0;                    ///< page that sent the last device input; 0: none
  std::string stopped_;                          ///< last `stopped` event, until playing starts again; may be empty
  std::filesystem::file_time_type shelf_stamp_;  ///< modification time of the installed libraries when the interpreter ended
  std::string watch_;                            ///< last `watch` request, sent again to a new interpreter; may be empty
  std::string breakpoints_ = "[]";               ///< list of breakpoints as sent to the pages, JSON
  std::string breakpoints_request_;              ///< request with the enabled breakpoints, sent again to a new interpreter; may be empty
  Error circuit_problems_;                       ///< why the current content cannot be played; empty: it can
  int last_request_ = 0;                         ///< id of the last request to the interpreter
  int content_request_ = 0;                      ///< id of the last request that loaded content
  std::map<int, Pending> pending_;               ///< requests without a reply, by request id
  int ping_ = 0;                                 ///< request id of a ping without answer; 0: none
  std::chrono::steady_clock::time_point ping_time_;

  std::string transport_;                   ///< last `transport` event
  std::optional<Problem> library_warning_;  ///< see warn_about_library()
  std::string summary_;                     ///< last `summary` event
  bool simulate_ = false;                   ///< true: simulate mode; false: edit mode
  double speed_ = 1;
  bool loop_ = false;             ///< true: playing repeats the range
  content::ScenarioRange range_;  ///< range that the interpreter has
  mutable std::mutex frame_mutex_;
  FrameBytes last_frame_;  ///< guarded by frame_mutex_: written on the interpreter process's thread
};

}  // namespace ugoki::studio
