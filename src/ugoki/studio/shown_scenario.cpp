#include "ugoki/studio/shown_scenario.h"

#include "ugoki/content/flatten.h"
#include "ugoki/json/json.h"

namespace ugoki::studio {

Result<void> ShownScenario::open(std::vector<std::string> ids) {
  for (const std::string& id : ids)
    if (!project_.scenario().find_scenario(id))
      return fail(ErrorCode::unknown, "path", "There is no scenario '" + id + "'.", "It may have been removed; reload the document.");
  ids_ = std::move(ids);
  revision_ = project_.revision() + 1;  // refresh() rebuilds it
  return {};
}

void ShownScenario::refresh() const {
  if (ids_.empty() || revision_ == project_.revision()) return;
  revision_ = project_.revision();
  for (std::size_t i = 0; i < ids_.size(); ++i)
    if (!project_.scenario().find_scenario(ids_[i])) ids_.resize(i);
  if (ids_.empty()) return;
  inner_ = content::open_scenario(project_.scenario(), ids_.back());
  inner_document_ = content::write_scenario(inner_);
}

const std::vector<std::string>& ShownScenario::opened() const {
  refresh();
  return ids_;
}

const content::Scenario& ShownScenario::scenario() const {
  refresh();
  return ids_.empty() ? project_.scenario() : inner_;
}

const std::string& ShownScenario::document() const {
  refresh();
  return ids_.empty() ? project_.document() : inner_document_;
}

content::Scenario ShownScenario::find(const std::string& id) const {
  return id.empty() ? project_.scenario() : content::open_scenario(project_.scenario(), id);
}

std::string command_in(const std::string& scenario, const std::string& command) {
  if (scenario.empty()) return command;
  return R"({"type":"in","scenario":)" + json::to_text(json::Json(scenario)) + R"(,"command":)" + command + "}";
}

}  // namespace ugoki::studio
