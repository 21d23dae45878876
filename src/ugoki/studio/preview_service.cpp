#include "ugoki/studio/preview_service.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "ugoki/formats/mechanism_json.h"
#include "ugoki/formats/motion_binary.h"
#include "ugoki/studio/display_json.h"

namespace ugoki::studio {
namespace {

using Json = nlohmann::json;

Result<std::string> answer(std::string_view id, const Motion& motion, const std::string& mechanism_id, const Mechanism& mechanism) {
  if (Error wrong = check_motion(motion, mechanism); !wrong.empty()) return fail(std::move(wrong));
  Json j = Json::parse(motion_json(id, motion, mechanism));
  j["mechanism"] = mechanism_id;
  return j.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace

Result<std::string> PreviewService::motion(std::string_view id, const std::vector<ProjectEntry>& project) {
  const auto open = std::ranges::find_if(project, [&](const ProjectEntry& e) { return e.id == id && e.motion && e.mechanism; });
  if (open != project.end()) return answer(id, *open->motion, open->mechanism_id, *open->mechanism);
  if (!library_) {
    Result<store::Library> opened = store::Library::open(path_);
    if (!opened) return fail(std::move(opened.error()));
    library_.emplace(std::move(*opened));
  }
  const Result<store::LibraryEntry> entry = library_->get(id);
  if (!entry) return fail(entry.error());
  const Json summary = Json::parse(entry->summary, nullptr, false);
  if (!summary.is_object() || !summary.contains("mechanism") || !summary["mechanism"].is_string())
    return fail(ErrorCode::structure, std::string(id), "The entry does not tell which mechanism it moves.", "Import it again.");
  const std::string mechanism_id = summary["mechanism"].get<std::string>();
  const std::string content = entry->id == id ? entry->content : std::string(id);
  const Result<std::vector<std::byte>> data = library_->content(content), body = library_->content(mechanism_id);
  if (!data) return fail(data.error());
  if (!body) return fail(body.error());
  const Result<Motion> motion = formats::read_motion(*data, entry->name);
  if (!motion) return fail(motion.error());
  const Result<MechanismPtr> mechanism = formats::read_mechanism({reinterpret_cast<const char*>(body->data()), body->size()}, mechanism_id);
  if (!mechanism) return fail(mechanism.error());
  return answer(id, *motion, mechanism_id, **mechanism);
}

}  // namespace ugoki::studio
