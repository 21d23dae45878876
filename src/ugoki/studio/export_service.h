#pragma once
// Export of the open project from the studio's page: GET /api/export/FORM (docs/studio-protocol.md).

#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/studio/server.h"

namespace ugoki::studio {

/// Returns content in one of the forms html, native, native-lsis, ugx, glb, usda, csv. For glb, usda and csv the content is simulated.
/// native-lsis is a native program that carries the installed libraries whose LSIs the content uses. The form `libraries` is the list of
/// these libraries: JSON {"libraries": [{"name", "sha256", "bytes"}]}.
/// @param ugx executable data @param name of the content
/// Errors: the form is unknown; the content uses LSIs of installed libraries; a part of the player is missing; the run stopped.
[[nodiscard]] Result<ApiReply> export_content(std::string_view form, std::string_view name, const std::vector<std::byte>& ugx);

}  // namespace ugoki::studio
