#pragma once
// Motions by id, with the mechanism that each one moves: of the open project, otherwise of the library.

#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/store/library.h"
#include "ugoki/studio/session.h"

namespace ugoki::studio {

/// @param id of an entry, or of its content  @param library may be null
/// Errors: nobody has it; its mechanism is not known, or does not fit.
[[nodiscard]] Result<ProjectEntry> find_motion(std::string_view id, const std::vector<ProjectEntry>& project,
                                               const store::Library* library);

/// A mechanism of the library by the id of its content.
[[nodiscard]] Result<MechanismPtr> load_mechanism(std::string_view id, const store::Library& library);

}  // namespace ugoki::studio
