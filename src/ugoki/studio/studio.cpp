#include "ugoki/studio/studio.h"

#include <pthread.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdlib>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>
#include <utility>

#include "ugoki/base/number.h"
#include "ugoki/store/library.h"
#include "ugoki/studio/display_json.h"
#include "ugoki/studio/error_json.h"
#include "ugoki/studio/import_service.h"
#include "ugoki/studio/library_service.h"
#include "ugoki/studio/preview_service.h"
#include "ugoki/studio/security.h"
#include "ugoki/studio/server.h"
#include "ugoki/studio/session.h"
#include "ugoki/studio/static_files.h"
#include "ugoki/studio/task_queue.h"

namespace ugoki::studio {
namespace {

constexpr std::chrono::milliseconds session_period{250};  // between calls of Session::on_time

ApiReply refused(const Error& error) { return {.status = http_status_of(error), .body = error_body(error)}; }
ApiReply answer_of(const Result<std::string>& result) { return result ? ApiReply{.body = *result} : refused(result.error()); }

/// "walk, slow" -> "walk", "slow"
std::vector<std::string> split_tags(std::string_view text) {
  std::vector<std::string> tags;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(','), text.size());
    std::string_view tag = text.substr(0, end);
    while (tag.starts_with(' ')) tag.remove_prefix(1);
    while (tag.ends_with(' ')) tag.remove_suffix(1);
    if (!tag.empty()) tags.emplace_back(tag);
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return tags;
}

/// Forwards texts and frames to the server; discards them while there is none.
class LateOutbox final : public Outbox {
 public:
  /// After set(nullptr) returned, the old server is not used any more.
  void set(Server* server) {
    const std::scoped_lock lock(mutex_);
    server_ = server;
  }
  void send(ClientId client, std::string text) override {
    const std::scoped_lock lock(mutex_);
    if (server_ != nullptr) server_->send(client, std::move(text));
  }
  void broadcast(std::string text) override {
    const std::scoped_lock lock(mutex_);
    if (server_ != nullptr) server_->broadcast(std::move(text));
  }
  void broadcast_frame(FrameBytes frame) override {
    const std::scoped_lock lock(mutex_);
    if (server_ != nullptr) server_->broadcast_frame(std::move(frame));
  }
  void send_frame(ClientId client, FrameBytes frame) override {
    const std::scoped_lock lock(mutex_);
    if (server_ != nullptr) server_->send_frame(client, std::move(frame));
  }

 private:
  std::mutex mutex_;
  Server* server_ = nullptr;
};

}  // namespace

/// Uses five threads in addition to the caller's: server, session (project, commands), operations on motions (owned by the session),
/// library (lists, previews), imports.
class Studio::Impl final : public ServerEvents {
 public:
  Impl(const StudioOptions& options, project::Project project)
      : library_(options.library_path), imports_(options.library_path), previews_(options.library_path) {
    const std::string choices = (std::filesystem::path(store::Library::folder_of(options.library_path)) / "choices.json").string();
    const SessionOptions session{options.library_path, choices, options.interpreter};
    session_ = std::make_unique<Session>(session, std::move(project), outbox_,
                                         [this](std::function<void()> task) { session_queue_->post(std::move(task)); });
    session_queue_ = std::make_unique<TaskQueue>(session_period, [this] { session_->on_time(); });
    library_queue_ = std::make_unique<TaskQueue>();
    import_queue_ = std::make_unique<TaskQueue>();
  }

  ~Impl() override {
    outbox_.set(nullptr);
    server_.reset();  // no request arrives after this
    import_queue_->close();
    library_queue_->close();
    session_queue_->post([this] { session_->stop(); });  // no interpreter callback is called after this
    session_queue_->close();
  }

  Result<void> start(const StudioOptions& options) {
    ServerOptions server;
    server.port = options.port;
    server.web = options.web;
    Result<std::unique_ptr<Server>> listening = Server::listen(std::move(server), *this);
    if (!listening) return fail(std::move(listening.error()));
    server_ = std::move(*listening);
    outbox_.set(server_.get());
    session_queue_->post([this] { session_->start(); });
    return {};
  }

  void on_message(ClientId client, std::string text, std::function<void()> done) override {
    session_queue_->post([this, client, message = std::move(text), finished = std::move(done)] {
      session_->on_message(client, message);
      finished();
    });
  }
  void on_close(ClientId client) override {
    session_queue_->post([this, client] { session_->on_close(client); });
  }
  void on_api(ApiRequest request, std::function<void(ApiReply)> answer) override;

  [[nodiscard]] const Server& server() const { return *server_; }
  [[nodiscard]] const Session& session() const { return *session_; }

 private:
  void on_library(ApiRequest request, std::function<void(ApiReply)> answer);
  /// Handles the paths under /api/import/. Returns false without answering if `request` has none of these paths.
  bool on_import(ApiRequest& request, std::function<void(ApiReply)>& answer);

  /// Runs `work` on a queue and answers with its result, or with an error if it throws.
  template <class Work>
  static void answer_on(TaskQueue& queue, std::function<void(ApiReply)> answer, Work work) {
    queue.post([reply = std::move(answer), make = std::move(work)]() mutable {
      Result<std::string> result;
      try {
        result = make();
      } catch (const std::exception& e) {  // from a library, or out of memory
        result = fail(ErrorCode::io, "studio", std::string("The studio could not do this: ") + e.what() + ".",
                      "The project is safe. Try again, or continue working.");
      }
      reply(answer_of(result));
    });
  }

  LateOutbox outbox_;
  std::unique_ptr<Server> server_;
  std::unique_ptr<Session> session_;
  LibraryService library_;
  ImportService imports_;
  PreviewService previews_;
  std::unique_ptr<TaskQueue> session_queue_, library_queue_, import_queue_;
};

void Studio::Impl::on_library(ApiRequest request, std::function<void(ApiReply)> answer) {
  session_queue_->post([this, asked = std::move(request), reply = std::move(answer)]() mutable {
    library_queue_->post([this, entries = session_->project_entries(), call = std::move(asked), give = std::move(reply)] {
      bool changed = false;
      try {
        give(library_.answer(call, entries, changed));
      } catch (const std::exception& e) {  // out of memory
        give(refused({ErrorCode::io, call.path, std::string("The studio could not do this: ") + e.what() + ".", "Try again."}));
      }
      if (changed) session_queue_->post([this] { session_->announce_library(); });
    });
  });
}

bool Studio::Impl::on_import(ApiRequest& request, std::function<void(ApiReply)>& answer) {
  constexpr std::string_view prefix = "/api/import/";
  if (!request.path.starts_with(prefix)) return false;
  const std::string rest = request.path.substr(prefix.size());
  const std::string action = rest.substr(0, rest.find('/')), id = action.size() < rest.size() ? rest.substr(action.size() + 1) : "";
  const auto text = [&](std::string_view name) { return query_value(request.query, name).value_or(""); };
  const auto number = [&](std::string_view name) { return std::max(0.0, parse_double(text(name)).value_or(0)); };
  const ImportSettings settings{number("unit"), text("up"), text("forward"), number("rate")};
  const std::string name = text("name"), tags = text("tags");
  auto body = std::make_shared<std::string>(std::move(request.body));  // shared, because the queue copies tasks
  if (action == "file") {
    answer_on(*import_queue_, std::move(answer), [this, name, body] { return imports_.companion(name, std::move(*body)); });
  } else if (action == "stage") {
    answer_on(*import_queue_, std::move(answer), [this, id, name, body, settings] {
      return id.empty() ? imports_.stage(name, std::move(*body), settings) : imports_.restage(id, settings);
    });
  } else if (action == "store" && !id.empty()) {
    answer_on(*import_queue_, std::move(answer), [this, id, name, tags] {
      Result<std::string> stored = imports_.store(id, name, split_tags(tags));
      if (stored) session_queue_->post([this] { session_->announce_library(); });
      return stored;
    });
  } else if (action == "drop" && !id.empty()) {
    answer_on(*import_queue_, std::move(answer), [this, id]() -> Result<std::string> {
      imports_.drop(id);
      return "{}";
    });
  } else {
    return false;
  }
  return true;
}

void Studio::Impl::on_api(ApiRequest request, std::function<void(ApiReply)> answer) {
  const std::string& path = request.path;
  const bool get = request.method == "GET", post = request.method == "POST";
  if (LibraryService::answers(path)) {
    on_library(std::move(request), std::move(answer));
  } else if (path.starts_with("/api/mechanism/") && get) {
    const std::string id = path.substr(std::string_view("/api/mechanism/").size());
    session_queue_->post([this, id, reply = std::move(answer)]() mutable {
      answer_on(*library_queue_, std::move(reply), [this, id, found = session_->find_mechanism(id)]() -> Result<std::string> {
        if (found) return mechanism_json(id, *found);
        const Result<MechanismPtr> stored = library_.mechanism(id);
        if (!stored) return fail(stored.error());
        return mechanism_json(id, **stored);
      });
    });
  } else if (path.starts_with("/api/motion/") && get) {
    const std::string id = path.substr(std::string_view("/api/motion/").size());
    session_queue_->post([this, id, reply = std::move(answer)]() mutable {
      answer_on(*library_queue_, std::move(reply),
                [this, id, project = session_->project_entries()] { return previews_.motion(id, project); });
    });
  } else if (path.starts_with("/api/contacts/") && get) {
    const std::string id = path.substr(std::string_view("/api/contacts/").size());
    session_queue_->post([this, id, reply = std::move(answer)]() mutable {
      answer_on(*library_queue_, std::move(reply),
                [this, id, project = session_->project_entries()] { return previews_.contacts(id, project); });
    });
  } else if (path == "/api/reference-character" && get) {
    const double height = parse_double(query_value(request.query, "height").value_or("")).value_or(1.8);
    answer_on(*library_queue_, std::move(answer), [height] { return reference_character_json(std::clamp(height, 0.3, 3.0)); });
  } else if (post && on_import(request, answer)) {
    return;
  } else if (path == "/api/import" && post) {
    const std::string name = query_value(request.query, "name").value_or("");
    answer_on(*library_queue_, std::move(answer), [this, name, body = std::move(request.body)] {
      Result<std::string> imported = library_.import(name, body);
      if (imported) session_queue_->post([this] { session_->announce_library(); });
      return imported;
    });
  } else {
    answer(refused(
        {ErrorCode::unknown, path, "The studio has no address " + request.method + " " + path + ".", "See docs/studio-protocol.md."}));
  }
}

Studio::Studio(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Studio::~Studio() = default;

Result<std::unique_ptr<Studio>> Studio::start(StudioOptions options, project::Project project) {
  if (options.library_path.empty()) options.library_path = store::Library::default_path();
  auto impl = std::make_unique<Impl>(options, std::move(project));
  if (Result<void> r = impl->start(options); !r) return fail(std::move(r.error()));
  return std::unique_ptr<Studio>(new Studio(std::move(impl)));
}

std::string Studio::address() const { return impl_->server().address(); }
std::uint16_t Studio::port() const { return impl_->server().port(); }
const std::string& Studio::token() const { return impl_->server().token(); }
int Studio::interpreter_pid() const { return impl_->session().interpreter_pid(); }

namespace {
sigset_t end_signals() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGINT);
  sigaddset(&set, SIGTERM);
  return set;
}
}  // namespace

void hold_signals() {
  const sigset_t set = end_signals();
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
}

void wait_for_signal() {
  const sigset_t set = end_signals();
  int got = 0;
  while (sigwait(&set, &got) != 0) {
  }
}

void open_browser(const std::string& address) {
  if (std::getenv("DISPLAY") == nullptr && std::getenv("WAYLAND_DISPLAY") == nullptr) return;
  const char* program = "xdg-open";
  char* const arguments[] = {const_cast<char*>(program), const_cast<char*>(address.c_str()), nullptr};
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t none;
  sigemptyset(&none);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK);
  pid_t pid = -1;
  if (posix_spawnp(&pid, program, nullptr, &attributes, arguments, environ) == 0) {
    std::thread([pid] { waitpid(pid, nullptr, 0); }).detach();
  }
  posix_spawnattr_destroy(&attributes);
}

}  // namespace ugoki::studio
