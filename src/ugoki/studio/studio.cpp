#include "ugoki/studio/studio.h"
#include "ugoki/content/generate.h"

#include <pthread.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdlib>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>
#include <utility>

#include "ugoki/store/connection.h"
#include "ugoki/store/library.h"
#include "ugoki/studio/display_json.h"
#include "ugoki/studio/error_json.h"
#include "ugoki/studio/export_service.h"
#include "ugoki/studio/import_service.h"
#include "ugoki/studio/library_queue.h"
#include "ugoki/studio/library_service.h"
#include "ugoki/studio/preview_service.h"
#include "ugoki/studio/security.h"
#include "ugoki/studio/server.h"
#include "ugoki/studio/session.h"
#include "ugoki/studio/static_files.h"
#include "ugoki/studio/sweep_service.h"
#include "ugoki/studio/task_queue.h"

namespace ugoki::studio {
namespace {

constexpr std::chrono::milliseconds session_period{250};  // time between two calls of Session::on_time

constexpr double min_unit = 1e-9, max_unit = 1e6;  // m per unit of length; formats use from nanometres to kilometres
constexpr double min_rate = 1e-3, max_rate = 1e6;  // limits of the frame rate of an imported file, 1/s

ApiReply refused(const Error& error) { return {.status = http_status_of(error), .body = error_body(error)}; }
ApiReply answer_of(const Result<std::string>& result) { return result ? ApiReply{.body = *result} : refused(result.error()); }

/// Splits a list of tags at the commas: "walk, slow" -> "walk", "slow".
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

/// Forwards texts and frames to the server; discards them while there is no server.
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

/// Implements Studio with six threads in addition to the caller's: server, session (project, commands), operations on motions (owned by the
/// session), library (everything that uses the library), reading of imported files, display (meshes and previews of the project). No thread
/// waits for the library's thread.
class Studio::Impl final : public ServerEvents {
 public:
  Impl(const StudioOptions& options, project::Project project) : library_location_(options.library_path), library_(options.library_path) {
    const std::string choices = (std::filesystem::path(store::Library::folder_of(options.library_path)) / "choices.json").string();
    const std::string recent = (std::filesystem::path(store::Library::folder_of(options.library_path)) / "recent.json").string();
    const SessionOptions session{[this](LibraryWork work) { use_library(std::move(work)); }, recent, choices, options.interpreter};
    session_ = std::make_unique<Session>(session, std::move(project), outbox_,
                                         [this](std::function<void()> task) { session_queue_->post(std::move(task)); });
    session_queue_ = std::make_unique<TaskQueue>(session_period, [this] { session_->on_time(); });
    library_queue_ = std::make_unique<LibraryQueue>([this](bool away) { return poll_library(away); });
    display_queue_ = std::make_unique<TaskQueue>();
    import_queue_ = std::make_unique<TaskQueue>();
  }

  ~Impl() override {
    outbox_.set(nullptr);
    server_.reset();  // no request arrives after this
    import_queue_->close();
    library_queue_->close();
    display_queue_->close();
    session_queue_->post([this] { session_->stop(); });  // no interpreter callback is called after this
    session_queue_->close();
  }

  Result<void> start(const StudioOptions& options) {
    ServerOptions server;
    server.port = options.port;
    server.web = options.web;
    server.key = options.key;
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

  /// Runs `work`, which the session requested, on the library's thread.
  void use_library(LibraryWork work) {
    library_queue_->post(
        [this, work] {
          const bool done = work(library_.library());
          pass_warning();
          return done;
        },
        [work](const Error& error) { (void)work(fail(error)); });
  }
  /// Runs `work`, which uses the library, on the library's thread, and answers with its result. Status 503: the library does not respond.
  void answer_on_library(std::function<void(ApiReply)> answer, std::function<ApiReply()> work) {
    library_queue_->post(
        [this, answer, work] {
          const auto begun = std::chrono::steady_clock::now();
          ApiReply reply = work();
          pass_warning();
          const bool failed = reply.status >= 500;
          if (failed && std::chrono::steady_clock::now() - begun >= LibraryQueue::min_silence) reply.status = 503;
          answer(std::move(reply));
          return !failed;
        },
        [answer](const Error& error) {
          ApiReply reply = refused(error);
          reply.status = 503;
          answer(std::move(reply));
        });
  }
  /// Passes the library's warning, if it is new, to the pages. To be called on the library's thread.
  void pass_warning() {
    if (std::optional<Problem> warning = library_.take_warning())
      session_queue_->post([this, w = std::move(*warning)] { session_->warn_about_library(w); });
  }
  /// Notifies the pages that the library changed. Thread-safe.
  void announce() {
    session_queue_->post([this] { session_->announce_library(); });
  }
  /// Looks for changes of the library and notifies the pages. @param away the library did not respond before. @return false: no response
  bool poll_library(bool away) {
    try {
      const LibraryService::Poll poll = library_.poll();
      if (poll.responds && (poll.changed || away)) announce();
      return poll.responds;
    } catch (const std::exception&) {
      return false;  // out of memory; the next poll tries again
    }
  }
  /// Answers with a preview of a motion. The library is used only for a motion that the project does not contain.
  void preview(const std::string& id, std::function<void(ApiReply)> answer,
               Result<std::string> (*make)(std::string_view, const std::vector<ProjectEntry>&, const store::Library*)) {
    session_queue_->post([this, id, make, reply = std::move(answer)]() mutable {
      std::vector<ProjectEntry> own = session_->project_entries();
      std::erase_if(own, [&](const ProjectEntry& e) { return e.id != id || !e.motion || !e.mechanism; });
      if (!own.empty()) return answer_on(*display_queue_, std::move(reply), [id, make, own] { return make(id, own, nullptr); });
      answer_on_library(std::move(reply), [this, id, make] {
        const Result<store::Library*> library = library_.library();
        return library ? answer_of(make(id, {}, *library)) : refused(library.error());
      });
    });
  }

  /// Runs `work` on a queue and answers the request with the result of `work`, or with an error if `work` throws.
  template <class Work>
  static void answer_on(TaskQueue& queue, std::function<void(ApiReply)> answer, Work work) {
    queue.post([reply = std::move(answer), make = std::move(work)]() mutable {
      Result<std::string> result;
      try {
        result = make();
      } catch (const std::exception& e) {  // thrown by a third-party library, or for lack of memory
        result = fail(ErrorCode::io, "studio", std::string("The studio could not do this: ") + e.what() + ".",
                      "The project is safe. Try again, or continue working.");
      }
      reply(answer_of(result));
    });
  }

  LateOutbox outbox_;
  std::unique_ptr<Server> server_;
  std::unique_ptr<Session> session_;
  const std::string library_location_;
  LibraryService library_;
  ImportService imports_;
  std::unique_ptr<LibraryQueue> library_queue_;
  std::unique_ptr<TaskQueue> session_queue_, import_queue_, display_queue_;
};

void Studio::Impl::on_library(ApiRequest request, std::function<void(ApiReply)> answer) {
  session_queue_->post([this, asked = std::move(request), reply = std::move(answer)]() mutable {
    answer_on_library(std::move(reply), [this, entries = session_->project_entries(), call = std::move(asked)] {
      bool changed = false;
      ApiReply made = library_.answer(call, entries, changed);
      if (changed) announce();
      return made;
    });
  });
}

bool Studio::Impl::on_import(ApiRequest& request, std::function<void(ApiReply)>& answer) {
  constexpr std::string_view prefix = "/api/import/";
  if (!request.path.starts_with(prefix)) return false;
  const std::string rest = request.path.substr(prefix.size());
  const std::string action = rest.substr(0, rest.find('/')), id = action.size() < rest.size() ? rest.substr(action.size() + 1) : "";
  const auto text = [&](std::string_view name) { return query_value(request.query, name).value_or(""); };
  const Result<std::optional<double>> unit = query_number(request.query, "unit", min_unit, max_unit);
  const Result<std::optional<double>> rate = query_number(request.query, "rate", min_rate, max_rate);
  for (const auto* number : {&unit, &rate}) {
    if (*number) continue;
    answer(refused(number->error()));
    return true;
  }
  if (const std::string travel = text("travel"); !travel.empty() && travel != "0" && travel != "1") {
    answer(refused(Error(ErrorCode::range, "travel", "'" + travel.substr(0, 40) + "' is neither 0 nor 1.", "Give 1 to add the travel.")));
    return true;
  }
  const ImportSettings settings{unit->value_or(0), text("up"),        text("forward"), rate->value_or(0),
                                text("mapping"),   text("character"), text("take"),    text("travel") == "1"};
  const std::string name = text("name"), tags = text("tags");
  auto body = std::make_shared<std::string>(std::move(request.body));  // shared, because the queue copies tasks
  if (action == "file") {
    answer_on(*import_queue_, std::move(answer), [this, name, body] { return imports_.companion(name, std::move(*body)); });
  } else if (action == "stage") {
    answer_on(*import_queue_, std::move(answer), [this, id, name, body, settings] {
      return id.empty() ? imports_.stage(name, std::move(*body), settings) : imports_.restage(id, settings);
    });
  } else if (action == "store" && !id.empty()) {
    import_queue_->post([this, id, name, tags, reply = std::move(answer)] {
      Result<intake::Intake> read = imports_.prepare(id, name, split_tags(tags));
      if (!read) return reply(refused(read.error()));
      answer_on_library(reply, [this, id, intake = std::make_shared<intake::Intake>(std::move(*read))] {
        const Result<store::Library*> library = library_.library();
        const Result<std::string> stored = library ? ImportService::store(*intake, **library) : fail(library.error());
        if (!stored) return refused(stored.error());
        import_queue_->post([this, id] { imports_.drop(id); });
        announce();
        return answer_of(stored);
      });
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
      if (const MechanismPtr own = session_->find_mechanism(id))
        return answer_on(*display_queue_, std::move(reply), [id, own]() -> Result<std::string> { return mechanism_json(id, *own); });
      answer_on_library(std::move(reply), [this, id] {
        const Result<MechanismPtr> stored = library_.mechanism(id);
        return stored ? answer_of(mechanism_json(id, **stored)) : refused(stored.error());
      });
    });
  } else if (path.starts_with("/api/motion/") && get) {
    const std::string id = path.substr(std::string_view("/api/motion/").size());
    preview(id, std::move(answer), preview_motion);
  } else if (path.starts_with("/api/contacts/") && get) {
    const std::string id = path.substr(std::string_view("/api/contacts/").size());
    preview(id, std::move(answer), preview_contacts);
  } else if (path.starts_with("/api/export/") && get) {
    const std::string form = path.substr(std::string_view("/api/export/").size());
    session_queue_->post([this, form, reply = std::move(answer)]() mutable {
      const content::Scenario& scenario = session_->project().scenario();
      auto ugx = std::make_shared<Result<std::vector<std::byte>>>(content::generate(scenario, session_->project().resources()));
      display_queue_->post([form, name = scenario.name, ugx, answered = std::move(reply)] {
        Result<ApiReply> file = *ugx ? export_content(form, name, **ugx) : fail(ugx->error());
        answered(file ? std::move(*file) : refused(file.error()));
      });
    });
  } else if (is_sweep_path(path) && get) {
    session_queue_->post([this, asked = std::move(request), reply = std::move(answer)]() mutable {
      const std::filesystem::path folder = std::filesystem::absolute(session_->project().path()).parent_path();
      const auto work = [asked, places = SweepPlaces{folder.string(), library_location_}] {
        Result<ApiReply> made = answer_sweeps(asked, places);
        return made ? std::move(*made) : refused(made.error());
      };
      // a database server may not respond, so only the library's thread asks it
      if (store::is_postgres(library_location_)) return answer_on_library(std::move(reply), work);
      display_queue_->post([work, answered = std::move(reply)] { answered(work()); });
    });
  } else if (path == "/api/reference-character" && get) {
    const Result<std::optional<double>> height = query_number(request.query, "height", 0.3, 3);
    if (!height) return answer(refused(height.error()));
    answer_on(*display_queue_, std::move(answer), [size = height->value_or(1.8)] { return reference_character_json(size); });
  } else if (post && on_import(request, answer)) {
    return;
  } else if (path == "/api/import" && post) {
    const std::string name = query_value(request.query, "name").value_or("");
    answer_on_library(std::move(answer), [this, name, body = std::move(request.body)] {
      const Result<std::string> imported = library_.import(name, body);
      if (imported) announce();
      return answer_of(imported);
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
  pthread_sigmask(SIG_UNBLOCK, &set, nullptr);  // from now on a second signal ends the process even if the studio does not finish
}

}  // namespace ugoki::studio
