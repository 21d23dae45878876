#include "ugoki/studio/motion_source.h"

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "ugoki/formats/mechanism_json.h"
#include "ugoki/formats/motion_binary.h"

namespace ugoki::studio {

using Json = nlohmann::json;

Result<MechanismPtr> load_mechanism(std::string_view id, const store::Library& library) {
  const Result<std::vector<std::byte>> body = library.content(id);
  if (!body) return fail(body.error());
  return formats::read_mechanism({reinterpret_cast<const char*>(body->data()), body->size()}, id);
}

Result<ProjectEntry> find_motion(std::string_view id, const std::vector<ProjectEntry>& project, const store::Library* library) {
  const auto open = std::ranges::find_if(project, [&](const ProjectEntry& e) { return e.id == id && e.motion && e.mechanism; });
  if (open != project.end()) return *open;
  if (library == nullptr)
    return fail(ErrorCode::unknown, std::string(id), "The project has no such motion, and no library is open.", "Choose another motion.");
  const Result<store::LibraryEntry> entry = library->get(id);
  if (!entry) return fail(entry.error());
  const Json summary = Json::parse(entry->summary, nullptr, false);
  if (!summary.is_object() || !summary.contains("mechanism") || !summary["mechanism"].is_string())
    return fail(ErrorCode::structure, std::string(id), "The entry does not name its mechanism.", "Import the motion again.");
  ProjectEntry out;
  out.id = entry->id == id ? entry->content : std::string(id);
  out.mechanism_id = summary["mechanism"].get<std::string>();
  const Result<std::vector<std::byte>> data = library->content(out.id);
  if (!data) return fail(data.error());
  Result<Motion> motion = formats::read_motion(*data, entry->name);
  if (!motion) return fail(std::move(motion.error()));
  Result<MechanismPtr> mechanism = load_mechanism(out.mechanism_id, *library);
  if (!mechanism) return fail(std::move(mechanism.error()));
  if (Error wrong = check_motion(*motion, **mechanism); !wrong.empty()) return fail(std::move(wrong));
  out.mechanism = std::move(*mechanism);
  out.motion = std::make_shared<const Motion>(std::move(*motion));
  return out;
}

}  // namespace ugoki::studio
