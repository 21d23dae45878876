#pragma once
// JSON of mechanisms and of whole scenes, for web pages that draw them.

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/content/executable.h"
#include "ugoki/mechanism/mechanism.h"

namespace ugoki::content {

/// Returns a mechanism's links with their visible shapes as JSON: the answer of GET /api/mechanism/ID (docs/studio-protocol.md).
/// @param q [nq] position coordinates for the poses in the field "neutral"; empty: q of the mechanism's neutral position
[[nodiscard]] std::string mechanism_json(std::string_view id, const Mechanism& mechanism, std::span<const double> q = {});

/// Returns the pose as [x, y, z, qw, qx, qy, qz]: m, unit quaternion.
[[nodiscard]] std::vector<double> pose_json(const Pose& X);

/// Returns the height [m] of the visible shapes in the neutral position, from the lowest to the highest point; 0 without shapes.
[[nodiscard]] double shown_height(const Mechanism& mechanism);

/// Returns all data as JSON that a page needs to show executable data before the first frame:
/// {"name", "duration", "frame_rate", "step", "ground", "camera", "look", "characters": [{"id", "name", "color", "mechanism", "tracks"}],
/// "mechanisms": [mechanism_json() ...]}; `mechanism` of a character is an index into `mechanisms`.
/// @param skins false: without the skins of the mechanisms, which can be large
[[nodiscard]] std::string scene_json(const Executable& content, bool skins = true);

}  // namespace ugoki::content
