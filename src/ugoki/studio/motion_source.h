#pragma once
// Finds a motion and its mechanism by id: first in the open project, then in the library.

#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/store/library.h"
#include "ugoki/studio/session.h"

namespace ugoki::studio {

/// The motion with its mechanism. @param id id of an entry or of its content  @param library may be null
/// Errors: there is no such motion; its mechanism is unknown or does not fit.
[[nodiscard]] Result<ProjectEntry> find_motion(std::string_view id, const std::vector<ProjectEntry>& project,
                                               const store::Library* library);

/// Loads a mechanism of the library. @param id content id of the mechanism
[[nodiscard]] Result<MechanismPtr> load_mechanism(std::string_view id, const store::Library& library);

}  // namespace ugoki::studio
