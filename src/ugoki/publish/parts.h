#pragma once
// The parts of the player that Ugoki's build makes beforehand: player.html, ugoki-player.js, and the program ugoki_player.

#include <string>

#include "ugoki/base/result.h"

namespace ugoki::publish {

/// Returns the bytes of a part. Looks in `folder`. If `folder` is empty, looks in three folders relative to the running program's folder:
/// ../share/ugoki, the folder itself, and ../libexec/ugoki. Errors: the part was not found or cannot be read.
[[nodiscard]] Result<std::string> read_player_part(const std::string& name, const std::string& folder = {});

}  // namespace ugoki::publish
