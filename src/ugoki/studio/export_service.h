#pragma once
// Export of the open project from the page: GET /api/export/FORM (docs/studio-protocol.md).

#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/studio/server.h"

namespace ugoki::studio {

/// Writes content in one of the forms html, native, ugx, glb, usda, csv. glb, usda and csv simulate the content first.
/// @param ugx executable data @param name of the content
/// Errors: an unknown form; content with LSIs of installed libraries, which no form carries; a part of the player is missing; the run
/// stopped.
[[nodiscard]] Result<ApiReply> export_content(std::string_view form, std::string_view name, const std::vector<std::byte>& ugx);

}  // namespace ugoki::studio
