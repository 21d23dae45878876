// Members of Session that open or create another project in place of the open one, that keep the list of recent projects, and that send the
// range of the project to the interpreter.

#include <filesystem>
#include <utility>

#include "ugoki/files/files.h"
#include "ugoki/samples/samples.h"
#include "ugoki/studio/content_recipes.h"
#include "ugoki/studio/session_request.h"

namespace ugoki::studio {
namespace {

using json::Json;
namespace fs = std::filesystem;

constexpr std::size_t max_recent = 24;            // projects in the list of recent projects
constexpr std::size_t max_recent_size = 131'072;  // maximum size of the stored list, bytes: 24 paths of at most 4096 bytes

/// The path that a request names: with the suffix .ugoki, and if relative, in the folder of the open project.
fs::path named_path(const std::string& name, const std::string& open_project) {
  fs::path path = name;
  if (path.extension() != ".ugoki") path += ".ugoki";
  return path.is_relative() ? fs::path(open_project).parent_path() / path : path;
}

/// Error `range` if the path of a new project ends with no name, or with one that begins with a dot: a hidden file.
Result<void> check_name(const fs::path& path) {
  const std::string name = path.filename().string();
  if (!name.empty() && name.front() != '.') return {};
  return fail(ErrorCode::range, "path", "'" + name + "' cannot be the name of a project.", "Give a name that does not begin with a dot.");
}

/// The first of NAME.ugoki, NAME-2.ugoki, NAME-3.ugoki, ... that does not exist.
fs::path free_path(const fs::path& wanted) {
  std::error_code ignored;
  fs::path path = wanted;
  for (int n = 2; fs::exists(path, ignored); ++n)
    path = wanted.parent_path() / (wanted.stem().string() + "-" + std::to_string(n) + ".ugoki");
  return path;
}

/// The stored list of paths; empty if the file is missing or damaged, which is not reported to the user.
std::vector<std::string> read_list(const std::string& path) {
  std::vector<std::string> list;
  const Result<std::string> text = path.empty() ? std::string() : files::read_file(path, max_recent_size);
  const Result<Json> read = text ? json::parse_json(*text, path) : fail(text.error());
  if (!read || !read->is_array()) return list;
  for (const Json& item : *read)
    if (item.is_string()) list.push_back(item.get<std::string>());
  return list;
}

Result<content::ContentText> content_of(const Json& from) {
  if (from == "empty" || from == "sample") {
    samples::Sample sample = samples::make_sample();
    // An empty project has the bodies and motions of the sample, because the library of a new user is empty.
    if (from == "empty") return content::ContentText{{}, std::move(sample.resources)};
    Result<content::Scenario> document = content::read_scenario(sample.document, "sample");
    if (!document) return fail(std::move(document.error()));
    return content::ContentText{std::move(*document), std::move(sample.resources)};
  }
  return make_content(json::to_text(from), "from");
}

}  // namespace

Result<std::string> Session::open_project(const Request& request) {
  if (!request.has_path("path")) return Request::invalid_field("path", "the path of a project");
  const fs::path to = named_path(request.json["path"].get<std::string>(), project_.path());
  std::error_code ignored;
  if (fs::equivalent(to, project_.path(), ignored)) return ",\"path\":" + json::to_text(project_.path());
  Result<project::Project> opened = project::Project::open(to.string());
  if (!opened) return fail(std::move(opened.error()));
  replace_project(std::move(*opened));
  return ",\"path\":" + json::to_text(project_.path());
}

Result<std::string> Session::save(const Request& request) {
  const auto path = request.json.find("path");
  const auto overwrite = request.json.find("overwrite");
  Result<void> saved;
  if (path == request.json.end() || path->is_null()) {
    saved = project_.save();
  } else {
    if (!request.has_path("path")) return Request::invalid_field("path", "the path of a file");
    const fs::path to = named_path(path->get<std::string>(), project_.path());
    if (Result<void> good = check_name(to); !good) return fail(std::move(good.error()));
    saved = project_.save_as(to.string(), overwrite != request.json.end() && overwrite->is_boolean() && overwrite->get<bool>());
  }
  if (!saved) return fail(std::move(saved.error()));
  remember_project();
  outbox_.broadcast(document_event());
  return ",\"path\":" + json::to_text(project_.path());
}

Result<std::string> Session::new_project(const Request& request) {
  const auto from = request.json.find("from");
  if (!request.has_path("path")) return Request::invalid_field("path", "the path of the new project");
  if (from == request.json.end() || (*from != "empty" && *from != "sample" && !from->is_object()))
    return Request::invalid_field("from", R"("empty", "sample" or an object with a scenario)");
  Result<content::ContentText> made = content_of(*from);
  if (!made) return fail(std::move(made.error()));
  const fs::path to = free_path(named_path(request.json["path"].get<std::string>(), project_.path()));
  if (Result<void> good = check_name(to); !good) return fail(std::move(good.error()));
  if (*from == "empty") made->scenario.name = to.stem().string();
  Result<project::Project> created = project::Project::create(to.string(), made->scenario, made->resources);
  if (!created) return fail(std::move(created.error()));
  replace_project(std::move(*created));
  return ",\"path\":" + json::to_text(project_.path());
}

/// Closes the open project, whose commands are all on the disk, and starts an interpreter with the content of `project`. Nothing of the old
/// content remains: a simulation could otherwise keep live inputs for characters of the same names.
void Session::replace_project(project::Project project) {
  cancel_motions();
  ++generation_;  // messages of the old interpreter are ignored
  pid_ = -1;
  process_.reset();
  for (const auto& [id, pending] : std::exchange(pending_, {}))
    if (pending.client != 0 && !pending.quiet)
      reply(pending.client, pending.reply_to,
            fail(ErrorCode::conflict, "interpreter", "Another project was opened.", "Repeat this in the new project."));
  ping_ = 0;
  {
    const std::scoped_lock lock(frame_mutex_);
    last_frame_ = {};
  }
  transport_.clear();
  summary_.clear();
  stopped_.clear();
  devices_.clear();
  watch_.clear();
  breakpoints_ = "[]";
  breakpoints_request_.clear();
  circuit_problems_ = {};
  simulate_ = loop_ = false;
  executable_.clear();
  project_ = std::move(project);
  (void)shown_.open({});
  outbox_.broadcast(R"({"event":"opened"})");
  start();
  announce_library();  // the list contains the motions of the project
}

void Session::send_range() {
  range_ = shown_.scenario().range;
  Json message = {{"op", "range"}, {"loop", loop_}};
  if (range_.is_set()) {
    message["from"] = range_.from;
    message["to"] = range_.to;
  }
  send_to_interpreter(json::to_text(message), {}, {});
}

std::string Session::recent() const {
  Json list = Json::array();
  std::error_code ignored;
  for (const std::string& path : read_list(options_.recent_path))
    if (fs::exists(path, ignored)) list.push_back({{"path", path}, {"name", fs::path(path).stem().string()}});
  return json::to_text(list);
}

void Session::remember_project() const {
  if (options_.recent_path.empty()) return;
  std::error_code ignored;
  const std::string path = fs::absolute(project_.path(), ignored).string();
  std::vector<std::string> list = read_list(options_.recent_path);
  std::erase(list, path);
  list.insert(list.begin(), path);
  if (list.size() > max_recent) list.resize(max_recent);
  fs::create_directories(fs::path(options_.recent_path).parent_path(), ignored);  // if this failed, the list is not stored
  (void)files::write_file(options_.recent_path, json::to_text(list) + "\n");      // without it the studio works
}

}  // namespace ugoki::studio
