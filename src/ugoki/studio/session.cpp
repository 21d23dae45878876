#include "ugoki/studio/session.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "ugoki/base/number.h"
#include "ugoki/circuit/circuit.h"
#include "ugoki/circuit/devices.h"
#include "ugoki/content/default_circuit.h"
#include "ugoki/content/flatten.h"
#include "ugoki/content/generate.h"
#include "ugoki/content/scenario_json.h"
#include "ugoki/content/track.h"
#include "ugoki/files/files.h"
#include "ugoki/json/json.h"
#include "ugoki/plugin/shelf.h"
#include "ugoki/studio/error_json.h"
#include "ugoki/studio/frame.h"
#include "ugoki/studio/interpreter.h"
#include "ugoki/studio/message_id.h"
#include "ugoki/studio/motion_compare.h"
#include "ugoki/studio/session_request.h"
#include "ugoki/studio/simulated_part.h"

namespace ugoki::studio {
namespace {

using json::Json;

constexpr std::size_t max_choices = 16'384;  // maximum size of the stored choices, bytes; keymap, theme and view need a few hundred

std::string text_of(const Json& json) { return json::to_text(json); }

std::string file_name(const std::string& path) { return std::filesystem::path(path).filename().string(); }

/// Modification time of the folder of installed libraries; it changes when a library is installed or removed.
std::filesystem::file_time_type shelf_stamp() {
  std::error_code ignored;
  return std::filesystem::last_write_time(plugin::default_shelf(), ignored);
}

/// The problems in a failed reply of the interpreter.
Error read_problems(const Json& reply) {
  Error out;
  const auto text = [](const Json& p, const char* key) {
    return p.contains(key) && p[key].is_string() ? p[key].get<std::string>() : std::string();
  };
  for (const Json& p : reply.value("error", Json::object()).value("problems", Json::array()))
    out.add(ErrorCode::structure, text(p, "location"), text(p, "message"), text(p, "remedy"));
  if (out.empty()) out.add(ErrorCode::structure, "content", "The content cannot be played.", "See the log for the reason.");
  return out;
}

std::string warning_event(const Problem& warning) {
  return text_of({{"event", "log"}, {"level", "warning"}, {"text", warning.text()}, {"notice", true}});
}

}  // namespace

Session::Session(SessionOptions options, project::Project project, Outbox& outbox, std::function<void(std::function<void()>)> post)
    : options_(std::move(options)), project_(std::move(project)), outbox_(outbox), post_(std::move(post)), shown_(project_) {}

Session::~Session() = default;

void Session::start() {
  remember_project();
  listed_ = used_motions();
  restore_breakpoints();
  generate();
  if (Result<void> r = ensure_interpreter(); !r) log("error", r.error().text());
}

void Session::stop() {
  cancel_motions();
  motion_queue_.close();
  ++generation_;
  pid_ = -1;
  process_.reset();
}

void Session::on_message(ClientId client, std::string_view text) {
  const auto made = std::make_shared<Request>();
  Request& request = *made;
  request.client = client;
  Result<Json> read = json::parse_json(text, "message");
  if (!read) return reply(client, id_of_invalid_message(text), fail(std::move(read.error())));
  request.json = std::move(*read);
  if (!request.json.is_object()) {
    return reply(
        client, "null",
        fail(ErrorCode::syntax, "message", "The message is not a JSON object.", "Send for example {\"id\": 1, \"op\": \"hello\"}."));
  }
  if (const auto id = request.json.find("id"); id != request.json.end() && (id->is_number() || id->is_string()))
    request.reply_to = text_of(*id);
  const auto op = request.json.find("op");
  if (op == request.json.end() || !op->is_string())
    return reply(client, request.reply_to, Request::invalid_field("op", "the name of an operation"));
  request.op = op->get<std::string>();
  begin(made);
}

void Session::answer(const Request& request) {
  bool answered = true;
  Result<std::string> result;
  try {
    result = serve(request, answered);
  } catch (const std::exception& e) {  // thrown by the JSON library, or for lack of memory
    result = fail(ErrorCode::io, request.op, std::string("The studio could not do this: ") + e.what() + ".",
                  "The project is safe. Try again, or continue working.");
  }
  if (answered || !result) reply(request.client, request.reply_to, result);
}

/// Executes a request. @param answered set to false if the answer was already sent or will be the interpreter's reply
/// @return fields of the answer, each with a comma before it
Result<std::string> Session::serve(const Request& request, bool& answered) {
  if (request.op == "hello") {
    const std::string fields = hello();
    FrameBytes frame;
    {
      const std::scoped_lock lock(frame_mutex_);
      frame = last_frame_;
    }
    reply(request.client, request.reply_to, fields);
    answered = false;
    for (const std::optional<Problem>* warning : {&project_.warning(), &std::as_const(library_warning_)})
      if (*warning) outbox_.send(request.client, warning_event(**warning));
    if (!summary_.empty()) outbox_.send(request.client, summary_);
    send_to_interpreter(R"({"op":"measures"})", {}, {});  // the measures so far, for the new page
    if (frame) outbox_.send_frame(request.client, frame);
    return {};
  }
  if (request.op == "command") return execute(request);
  if (request.op == "undo" || request.op == "redo") return undo_or_redo(request.op == "undo");
  if (request.op == "enter") return enter(request);
  if (request.op == "save") return save(request);
  if (request.op == "open") return open_project(request);
  if (request.op == "new") return new_project(request);
  if (request.op == "loop") {
    if (!request.json.contains("on") || !request.json["on"].is_boolean()) return Request::invalid_field("on", "true or false");
    loop_ = request.json["on"].get<bool>();
    send_range();
    return "";
  }
  if (request.op == "motion.cancel") return cancel_motion(request);
  if (request.op == "motion" || request.op == "gait") {
    if (Result<void> r = request.op == "gait" ? start_gait(request) : start_motion(request); !r) return fail(std::move(r.error()));
    answered = false;
    return {};
  }
  if (request.op == "pose") return poses_.pose(shown_, request.json);
  if (request.op == "curves") return poses_.curves(shown_, request.json);
  if (request.op == "poses") return PoseDesk::stored(shown_, request.json);
  if (request.op == "joints") return PoseDesk::joints(shown_, request.json);
  if (request.op == "compare") return compare_motion(shown_, request.json);
  if (request.op == "gaits") return list_gaits(request);
  if (request.op == "remember") return remember(request);
  if (request.op == "breakpoints") return set_breakpoints(request);
  const bool physics = request.op == "mode"
                           ? request.json.contains("mode") && request.json["mode"] == "simulate"
                           : simulate_ && (request.op == "play" || request.op == "restart" || request.op == "grab" ||
                                           request.op == "push" || (request.op == "step" && request.json.contains("ticks")));
  if (physics && !circuit_problems_.empty()) return fail(circuit_problems_);
  if (Result<void> r = check_transport(request); !r) return fail(std::move(r.error()));
  if (Result<void> r = forward(request); !r) return fail(std::move(r.error()));
  answered = false;
  return {};
}

std::string Session::hello() const {
  std::string fields =
      "," + document_fields() + ",\"transport\":" + transport_event() + ",\"choices\":" + choices() + ",\"recent\":" + recent();
  fields += ",\"circuit_problems\":" + text_of(json::error_json(circuit_problems_)["problems"]);
  if (!lsis_.empty()) fields += ",\"lsis\":" + lsis_;
  if (!stopped_.empty()) fields += ",\"stopped\":" + stopped_;
  fields += ",\"breakpoints\":" + breakpoints_;
  if (!devices_.empty()) fields += ",\"devices\":" + devices_;
  return fields;
}

std::string Session::document_event() const { return "{\"event\":\"document\"," + document_fields() + "}"; }

std::string Session::edited_event(const std::string& changes, std::uint64_t from) const {
  return "{\"event\":\"edited\",\"from\":" + std::to_string(from) + ",\"changes\":" + changes + "," + state_fields() + "}";
}

std::string Session::document_fields() const {
  std::string fields = state_fields();
  if (shown_.scenario().circuit.empty())
    fields += ",\"generated_circuit\":" + content::default_circuit(content::played_part(shown_.scenario()));
  return fields + ",\"open\":" + text_of(Json(shown_.opened())) + ",\"outermost\":" + text_of(project_.scenario().name) +
         ",\"document\":" + shown_.document();
}

std::string Session::state_fields() const {
  Json characters = Json::array();
  for (const content::ScenarioCharacter& c : content::played_part(shown_.scenario()).characters) {
    const auto mechanism = project_.resources().mechanisms.find(c.mechanism);
    const bool known = mechanism != project_.resources().mechanisms.end();
    const int links = known ? mechanism->second->link_count() : 0;
    const double end_speed = known ? content::calc_end_speed(c, *mechanism->second, project_.resources()) : 0;
    Json character = {{"id", c.id}, {"name", c.name}, {"mechanism", c.mechanism}, {"links", links}, {"end_speed", end_speed}};
    if (!shown_.scenario().find_character(c.id)) {  // of an instance: the pages do not flatten the document
      character["look"] = content::to_json(c);
      character["look"].erase("track");
    }
    characters.push_back(std::move(character));
  }
  const Json project = {{"path", project_.path()}, {"name", file_name(project_.path())}, {"unsaved", project_.unsaved()}};
  const Json state = {{"project", project},
                      {"characters", std::move(characters)},
                      {"can_undo", project_.can_undo()},
                      {"can_redo", project_.can_redo()},
                      {"undo_label", project_.undo_label()},
                      {"redo_label", project_.redo_label()},
                      {"unsaved", project_.unsaved()},
                      {"revision", project_.revision()}};
  const std::string fields = text_of(state);
  return fields.substr(1, fields.size() - 2);
}

std::string Session::transport_event() const {
  if (!transport_.empty()) return transport_;
  return text_of({{"event", "transport"},
                  {"mode", simulate_ ? "simulate" : "edit"},
                  {"playing", false},
                  {"speed", speed_},
                  {"loop", loop_},
                  {"time", 0},
                  {"duration", shown_.scenario().duration},
                  {"simulated", 0},
                  {"steps_per_s", 0},
                  {"realtime_factor", 0},
                  {"status", "ready"}});
}

Result<std::string> Session::execute(const Request& request) {
  const auto command = request.json.find("command");
  if (command == request.json.end() || !command->is_object())
    return Request::invalid_field("command", "a command object (docs/scenario.md)");
  // For an edit of the circuit the pages get only the changes: a large circuit need not be sent again.
  const bool edit = command->value("type", Json()) == "circuit.edit" && command->contains("changes");
  if (!request.resources) return fail(request.resources.error());
  const Json scenario = request.json.value("scenario", Json(""));
  if (!scenario.is_string()) return Request::invalid_field("scenario", "the id of an inner scenario");
  return apply(command_in(scenario.get<std::string>(), text_of(*command)), edit ? text_of((*command)["changes"]) : "", *request.resources);
}

Result<std::string> Session::apply(const std::string& command, const std::string& circuit_changes,
                                   std::span<const project::LibraryData> resources) {
  const std::uint64_t from = project_.revision();
  Result<project::Change> change = project_.execute_with(command, resources);
  if (!change) return fail(std::move(change.error()));
  if (!change->label.empty()) changed(circuit_changes.empty() ? document_event() : edited_event(circuit_changes, from));
  return ",\"label\":" + text_of(change->label) + ",\"created\":" + text_of(change->created) +
         ",\"revision\":" + std::to_string(project_.revision());
}

Result<std::string> Session::undo_or_redo(bool undo) {
  Result<std::string> label = undo ? project_.undo() : project_.redo();
  if (!label) return label;
  changed(document_event());
  return ",\"label\":" + text_of(*label) + ",\"revision\":" + std::to_string(project_.revision());
}

/// Shows another scenario on all pages.
Result<std::string> Session::enter(const Request& request) {
  const auto path = request.json.find("path");
  const auto is_text = [](const Json& id) { return id.is_string(); };
  if (path == request.json.end() || !path->is_array() || !std::all_of(path->begin(), path->end(), is_text))
    return Request::invalid_field("path", "a list of ids of inner scenarios");
  if (Result<void> opened = shown_.open(path->get<std::vector<std::string>>()); !opened) return fail(std::move(opened.error()));
  changed(document_event());
  return "";
}

/// The stored choices of the user as JSON, or {} if the file is missing or damaged. A damaged file is not reported to the user.
std::string Session::choices() const {
  const Result<std::string> text = options_.choices_path.empty() ? std::string() : files::read_file(options_.choices_path, max_choices);
  const Result<Json> read = text ? json::parse_json(*text, options_.choices_path) : fail(text.error());
  return read && read->is_object() ? text_of(*read) : "{}";
}

Result<std::string> Session::remember(const Request& request) const {
  const auto choices = request.json.find("choices");
  if (choices == request.json.end() || !choices->is_object()) return Request::invalid_field("choices", "an object");
  const std::string text = text_of(*choices);
  if (text.size() > max_choices) return Request::invalid_field("choices", "shorter than " + std::to_string(max_choices) + " bytes");
  if (options_.choices_path.empty()) return "";
  std::error_code ignored;
  std::filesystem::create_directories(std::filesystem::path(options_.choices_path).parent_path(),
                                      ignored);  // if this failed, write_file reports it
  if (Result<void> written = files::write_file(options_.choices_path, text + "\n"); !written) return fail(std::move(written.error()));
  return "";
}

Result<void> Session::forward(const Request& request) {
  const bool quiet = request.op == "drag" || request.op == "input";
  if (request.op == "input") input_client_ = request.client;
  if (!process_ && (quiet || request.op == "release" || request.op == "pause")) {
    if (!quiet) reply(request.client, request.reply_to, std::string());  // no interpreter runs, so there is nothing to release or pause
    return {};
  }
  if (Result<void> r = ensure_interpreter(); !r) return r;
  Json message = request.json;
  message.erase("id");
  if (message.contains("link") && message["link"].is_number()) message["link"] = text_of(message["link"]);
  if (request.op == "mode") {
    simulate_ = message["mode"] == "simulate";
    if (!simulate_ && !circuit_problems_.empty()) load_without_circuit();
  }
  if (request.op == "watch") watch_ = text_of(message);
  if (request.op == "play" && request.has_number("speed")) speed_ = message["speed"].get<double>();
  if (send_to_interpreter(text_of(message), {}, {request.client, request.reply_to, quiet})) return {};
  return fail(ErrorCode::io, "interpreter", "The interpreter stopped responding.", "Play again to restart the interpreter.");
}

void Session::changed(std::string event) {
  outbox_.broadcast(std::move(event));
  if (std::set<std::string> used = used_motions(); used != listed_) {  // the library's list contains the motions of the project
    listed_ = std::move(used);
    announce_library();
  }
  if (range_ != shown_.scenario().range) send_range();
  const std::vector<std::byte> before = executable_;
  generate();
  if (!process_ || executable_.empty() || executable_ == before) return;
  load_content();
}

void Session::generate() {
  content::Scenario scenario = shown_.scenario();
  remove_display(scenario);
  if (Result<circuit::Circuit> own = circuit::read_circuit(scenario.circuit); own && !scenario.circuit.empty()) {
    remove_display(*own);
    scenario.circuit = circuit::write_circuit(*own);
  }
  Result<std::vector<std::byte>> made = content::generate(scenario, project_.resources());
  if (!made) return log("error", "The changed content cannot be generated; the previous content stays loaded. " + made.error().text());
  executable_ = std::move(*made);
}

void Session::load_content() {
  send_to_interpreter(R"({"op":"load"})", executable_, {0, "content", false});
  content_request_ = last_request_;
}

void Session::load_without_circuit() {
  content::Scenario scenario = shown_.scenario();
  if (scenario.circuit.empty() || !process_) return;
  scenario.circuit.clear();
  if (Result<std::vector<std::byte>> made = content::generate(scenario, project_.resources()))
    send_to_interpreter(R"({"op":"load"})", *made, {0, "tracks", false});
}

void Session::set_circuit_problems(Error problems) {
  if (problems.empty() && circuit_problems_.empty()) return;
  circuit_problems_ = std::move(problems);
  outbox_.broadcast(R"({"event":"circuit",)" + text_of(json::error_json(circuit_problems_)).substr(1));
}

Result<void> Session::ensure_interpreter() {
  if (process_) return {};
  if (executable_.empty()) {
    return fail(ErrorCode::structure, "content", "The content could not be generated.", "Fix the errors listed in the log.");
  }
  const std::uint64_t generation = ++generation_;
  InterpreterEvents events;
  events.frame = [this](std::vector<std::byte> bytes) {
    auto frame = std::make_shared<const std::vector<std::byte>>(std::move(bytes));
    {
      const std::scoped_lock lock(frame_mutex_);
      last_frame_ = frame;
    }
    outbox_.broadcast_frame(std::move(frame));
  };
  events.message = [this, generation](std::string text) {
    post_([this, generation, message = std::move(text)] {
      if (generation == generation_) on_interpreter_message(message);
    });
  };
  events.ended = [this, generation](Problem problem) {
    post_([this, generation, why = std::move(problem)] {
      if (generation == generation_) on_interpreter_end(why);
    });
  };
  Result<std::unique_ptr<InterpreterProcess>> started = InterpreterProcess::start(options_.interpreter, std::move(events));
  if (!started) return fail(std::move(started.error()));
  process_ = std::move(*started);
  pid_ = process_->pid();
  ping_ = 0;
  load_content();
  send_range();
  if (simulate_) send_to_interpreter(R"({"op":"mode","mode":"simulate"})", {}, {});
  if (!watch_.empty()) send_to_interpreter(watch_, {}, {});
  if (!breakpoints_request_.empty()) send_to_interpreter(breakpoints_request_, {}, {});
  return {};
}

bool Session::send_to_interpreter(std::string request, const std::vector<std::byte>& block, Pending pending) {
  if (!process_) return false;
  const int id = ++last_request_;
  request.insert(1, "\"request\":" + std::to_string(id) + ",");
  pending_[id] = std::move(pending);
  if (process_->send(request, block)) return true;
  pending_.erase(id);
  process_->kill_unanswering();  // the `ended` callback then reports the end
  return false;
}

void Session::on_interpreter_message(const std::string& text) {
  const Json message = Json::parse(text, nullptr, false);
  if (!message.is_object()) return;
  if (const auto event = message.find("event"); event != message.end() && event->is_string()) {
    outbox_.broadcast(text);
    if (*event == "summary") summary_ = text;
    if (*event == "stopped") stopped_ = text;
    if (*event == "devices") devices_ = text;
    if (*event == "transport") {
      transport_ = text;
      if (message.value("playing", false) || message.value("status", "") == "ready") stopped_.clear();
    }
    if (*event == "lsis") {
      const bool others = !lsis_.empty() && text != lsis_;
      lsis_ = text;
      // The new library may contain the LSI classes that the circuit needs.
      if (others && !circuit_problems_.empty()) load_content();
    }
    return;
  }
  const auto id = message.find("reply");
  if (id == message.end() || !id->is_number_integer()) return;
  const int number = id->get<int>();
  if (number == ping_) ping_ = 0;
  const auto found = pending_.find(number);
  if (found == pending_.end()) return;
  const Pending pending = std::move(found->second);
  pending_.erase(found);
  const bool ok = message.value("ok", false);
  if (pending.client != 0) {
    if (ok && pending.quiet) return;
    const std::string error = message.contains("error") ? text_of(message["error"]) : "{\"problems\":[]}";
    outbox_.send(pending.client, "{\"reply\":" + pending.reply_to + ",\"ok\":" + (ok ? "true}" : "false,\"error\":" + error + "}"));
  } else if (pending.reply_to == "content" && number == content_request_) {  // replies about older content are outdated
    if (ok) return set_circuit_problems({});
    set_circuit_problems(read_problems(message));
    log("error", "The content cannot be played: " + circuit_problems_.text());
    if (simulate_)
      send_to_interpreter(R"({"op":"pause"})", {}, {});  // the previous content is still loaded; do not play it
    else
      load_without_circuit();
  }
}

void Session::on_interpreter_end(const Problem& why) {
  double time = 0;
  {
    const std::scoped_lock lock(frame_mutex_);
    if (last_frame_) time = frame_time(*last_frame_);
  }
  const std::string reason = why.message + " " + why.remedy + " Stopped at t = " + to_fixed(time, 2) + " s.";
  ++generation_;
  pid_ = -1;
  process_.reset();
  ping_ = 0;
  const std::map<int, Pending> lost = std::exchange(pending_, {});
  for (const auto& [id, pending] : lost) {
    if (pending.client != 0 && !pending.quiet) {
      reply(pending.client, pending.reply_to, fail(ErrorCode::io, "interpreter", reason, "Play again to restart the interpreter."));
    }
  }
  shelf_stamp_ = shelf_stamp();
  Error error;
  error.problems.push_back(why);
  stopped_ = text_of({{"event", "stopped"}, {"reason", reason}, {"problems", json::error_json(error)["problems"]}});
  outbox_.broadcast(stopped_);
  Json transport = Json::parse(transport_event(), nullptr, false);
  transport["playing"] = false;
  transport["simulated"] = 0;
  transport["status"] = "stopped";
  transport_ = text_of(transport);
  outbox_.broadcast(transport_);
}

void Session::on_close(ClientId client) {
  if (client != input_client_) return;
  input_client_ = 0;
  send_to_interpreter(R"({"op":"input","keyboard":[],"mouse":{},"gamepads":[]})", {}, {});
}

void Session::on_time() {
  if (!process_) {
    // A changed library may fix the LSI that stopped the interpreter: start a new one, which loads the library and the content.
    if (!stopped_.empty() && shelf_stamp() != shelf_stamp_) {
      shelf_stamp_ = shelf_stamp();
      if (Result<void> r = ensure_interpreter(); !r) log("error", r.error().text());
    }
    return;
  }
  const auto now = std::chrono::steady_clock::now();
  if (ping_ == 0) {
    if (now - ping_time_ < options_.answer_timeout / 10) return;
    ping_time_ = now;
    if (send_to_interpreter(R"({"op":"ping"})", {}, {})) ping_ = last_request_;
  } else if (now - ping_time_ > options_.answer_timeout) {
    ping_time_ = now;
    process_->kill_unanswering();
  }
}

void Session::announce_library() { outbox_.broadcast(R"({"event":"library"})"); }

std::set<std::string> Session::used_motions() const {
  std::set<std::string> used;
  content::for_each_scenario(project_.scenario(), [&](const content::Scenario& s) {
    for (const content::ScenarioCharacter& c : s.characters)
      for (const content::ScenarioClip& clip : c.track) used.insert(clip.motion);
    for (const content::Rule& r : s.rules)
      if (r.action.type == content::ActionType::play) used.insert(r.action.motion);
  });
  return used;
}

MechanismPtr Session::find_mechanism(std::string_view id) const {
  const auto found = project_.resources().mechanisms.find(id);
  return found != project_.resources().mechanisms.end() ? found->second : nullptr;
}

std::vector<ProjectEntry> Session::project_entries() const {
  const content::Resources& resources = project_.resources();
  const std::set<std::string> used = used_motions();
  std::vector<ProjectEntry> entries;
  for (const auto& [id, mechanism] : resources.mechanisms)
    if (!content::is_prop_mechanism(id)) entries.push_back({id, mechanism, id, nullptr});
  for (const auto& [id, motion] : resources.motions) {
    ProjectEntry entry{id, nullptr, "", motion};
    entry.used = used.contains(id) || !id.starts_with(made_motion_prefix);
    for (const auto& [mechanism_id, mechanism] : resources.mechanisms) {
      if (content::is_prop_mechanism(mechanism_id) || mechanism->nq() != motion->nq ||
          (entry.mechanism && mechanism->name() != motion->mechanism))
        continue;
      entry.mechanism = mechanism;
      entry.mechanism_id = mechanism_id;
    }
    entries.push_back(std::move(entry));
  }
  return entries;
}

void Session::warn_about_library(const Problem& warning) {
  library_warning_ = warning;
  outbox_.broadcast(warning_event(warning));
}

void Session::log(std::string_view level, std::string_view text) {
  while (!text.empty() && text.back() == '\n') text.remove_suffix(1);
  outbox_.broadcast(text_of({{"event", "log"}, {"level", level}, {"text", text}}));
}

void Session::reply(ClientId client, const std::string& reply_to, const Result<std::string>& result) {
  if (result) {
    outbox_.send(client, "{\"reply\":" + reply_to + ",\"ok\":true" + *result + "}");
  } else {
    outbox_.send(client, "{\"reply\":" + reply_to + ",\"ok\":false,\"error\":" + error_json(result.error()) + "}");
  }
}

}  // namespace ugoki::studio
