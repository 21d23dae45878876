#pragma once
// Animated previews of motions, and the time intervals in which feet are on the ground in a motion.

#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/store/library.h"
#include "ugoki/studio/session.h"

namespace ugoki::studio {

/// Poses of a motion on its mechanism. @param id id of the entry or of its content
/// @param library source of motions that the project does not contain; may be null
/// @return motion_json with the field "mechanism": the id for GET /api/mechanism/ID
[[nodiscard]] Result<std::string> preview_motion(std::string_view id, const std::vector<ProjectEntry>& project,
                                                 const store::Library* library);
/// Time intervals of a motion, each with the number of feet on the ground. @param library as for preview_motion()
/// @return the answer of GET /api/contacts/ID
[[nodiscard]] Result<std::string> preview_contacts(std::string_view id, const std::vector<ProjectEntry>& project,
                                                   const store::Library* library);

}  // namespace ugoki::studio
