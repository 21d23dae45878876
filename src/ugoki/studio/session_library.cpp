// Members of Session for requests that read the library. These requests wait for the library's thread; other requests do not.

#include <algorithm>
#include <utility>

#include "ugoki/json/json.h"
#include "ugoki/studio/motion_edits.h"
#include "ugoki/studio/motion_source.h"
#include "ugoki/studio/session_request.h"

namespace ugoki::studio {
namespace {

using json::Json;

bool changes_project(std::string_view op) {
  return op == "command" || op == "undo" || op == "redo" || op == "save" || op == "motion" || op == "gait" || op == "open" || op == "new";
}

std::string text_field(const Json& json, const char* key) {
  return json.contains(key) && json[key].is_string() ? json[key].get<std::string>() : std::string();
}

/// The mechanism with the entry id or content id `id`.
Result<ProjectEntry> find_body(std::string_view id, const store::Library& library) {
  const Result<store::LibraryEntry> entry = library.get(id);
  if (!entry) return fail(entry.error());
  ProjectEntry out;
  out.id = out.mechanism_id = entry->id == id ? entry->content : std::string(id);
  Result<MechanismPtr> loaded = load_mechanism(out.id, library);
  if (!loaded) return fail(std::move(loaded.error()));
  out.mechanism = std::move(*loaded);
  return out;
}

}  // namespace

void Session::begin(const RequestPtr& request) {
  if (!changes_project(request->op)) return answer(*request);
  if (const auto found = waiting_.find(request->client); found != waiting_.end()) return found->second.push_back(request);
  LibraryWork work = options_.with_library ? library_work(request) : LibraryWork();
  if (!work) return answer(*request);
  waiting_[request->client];
  options_.with_library([this, request, read = std::move(work)](const Result<store::Library*>& library) {
    bool done = false;
    try {
      done = read(library);
    } catch (const std::exception& e) {  // out of memory
      read(fail(ErrorCode::io, request->op, std::string("The library could not be read: ") + e.what() + ".", "Try again."));
    }
    post_([this, request] {
      const std::vector<RequestPtr> later = std::move(waiting_.extract(request->client).mapped());
      answer(*request);
      for (const RequestPtr& next : later) begin(next);
    });
    return done;
  });
}

LibraryWork Session::library_work(const RequestPtr& request) const {
  const Json& json = request->json;
  if (request->op == "command") {
    const auto command = json.find("command");
    if (command == json.end() || !command->is_object()) return {};
    std::vector<std::string> ids = project_.missing_resources(json::to_text(*command));
    if (ids.empty()) return {};
    return [request, wanted = std::move(ids)](const Result<store::Library*>& library) {
      request->resources = library ? project::Project::fetch(wanted, **library) : fail(library.error());
      return request->resources.has_value();
    };
  }
  if (request->op != "motion") return {};
  const Result<Needs> needs = needs_of(text_field(json, "operation"));
  const std::string motion = text_field(json, "motion"), body = text_field(json, "mechanism");
  const std::vector<ProjectEntry> own = project_entries();
  const bool known = std::ranges::any_of(own, [&](const ProjectEntry& e) { return e.id == motion && e.motion && e.mechanism; });
  if (needs && *needs == Needs::other_motion && !motion.empty() && !known) {
    return [request, motion](const Result<store::Library*>& library) {
      request->read_library = true;
      request->motion = library ? find_motion(motion, {}, *library) : fail(library.error());
      return request->motion.has_value();
    };
  }
  if (needs && *needs == Needs::body && !body.empty() && !find_mechanism(body)) {
    return [request, body](const Result<store::Library*>& library) {
      request->read_library = true;
      request->body = library ? find_body(body, **library) : fail(library.error());
      return request->body.has_value();
    };
  }
  return {};
}

}  // namespace ugoki::studio
