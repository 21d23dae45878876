#include "ugoki/studio/preview_service.h"

#include <nlohmann/json.hpp>
#include <utility>

#include "ugoki/motion_edit/foot_contacts.h"
#include "ugoki/studio/display_json.h"
#include "ugoki/studio/motion_source.h"

namespace ugoki::studio {
namespace {

using Json = nlohmann::json;

std::string text_of(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

/// Finds a motion and its mechanism. Error if the motion does not fit the mechanism.
Result<ProjectEntry> find(std::string_view id, const std::vector<ProjectEntry>& project, const store::Library* library) {
  Result<ProjectEntry> found = find_motion(id, project, library);
  if (!found) return found;
  if (Error wrong = check_motion(*found->motion, *found->mechanism); !wrong.empty()) return fail(std::move(wrong));
  return found;
}

}  // namespace

Result<std::string> preview_motion(std::string_view id, const std::vector<ProjectEntry>& project, const store::Library* library) {
  const Result<ProjectEntry> found = find(id, project, library);
  if (!found) return fail(found.error());
  Json j = Json::parse(motion_json(id, *found->motion, *found->mechanism));
  j["mechanism"] = found->mechanism_id;
  return text_of(j);
}

Result<std::string> preview_contacts(std::string_view id, const std::vector<ProjectEntry>& project, const store::Library* library) {
  const Result<ProjectEntry> found = find(id, project, library);
  if (!found) return fail(found.error());
  const Motion& motion = *found->motion;
  const Mechanism& mechanism = *found->mechanism;
  const motion_edit::FootContacts contacts = motion_edit::labelled_contacts(mechanism, motion, motion_edit::find_foot_limbs(mechanism));
  Json feet = Json::array(), bands = Json::array();
  for (const motion_edit::FootLimb& foot : contacts.feet) feet.push_back(mechanism.link(foot.link).name);
  const auto count = [&](int frame) {
    int standing = 0;
    for (const auto& on : contacts.bears) standing += on[static_cast<std::size_t>(frame)] != 0 ? 1 : 0;
    return standing;
  };
  for (int from = 0, to = 1; !contacts.feet.empty() && from < motion.frames; from = to++) {
    while (to < motion.frames && count(to) == count(from)) ++to;
    bands.push_back({from / motion.rate, std::min(to / motion.rate, motion.duration()), count(from)});
  }
  return text_of({{"id", id}, {"feet", std::move(feet)}, {"labelled", !motion.contacts.empty()}, {"bands", std::move(bands)}});
}

}  // namespace ugoki::studio
