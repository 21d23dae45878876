#pragma once
// Recorded inputs of a run as JSON, so that the same run can be repeated by every player: the studio's engine, `ugoki run`, a native
// program and a web page. docs/export.md describes the format.

#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/content/player.h"

namespace ugoki::content {

/// Maximum number of inputs of one recording.
inline constexpr std::size_t max_recorded_inputs = 1'000'000;

/// Reads {"inputs": [{"step": n, "type": "push" | "grab" | "drag" | "release" | "throw" | "input", ...}]}. Inputs of one step keep their
/// order. Characters are given by id or index, links by name, label or index. The result is the argument of Player::schedule().
/// @param content the executable data that the inputs refer to @param name for messages
[[nodiscard]] Result<std::vector<PlayerInput>> read_inputs(std::string_view text, const Executable& content, std::string_view name);

/// Returns the inputs as JSON text, from which read_inputs() restores the same inputs bit by bit.
[[nodiscard]] std::string write_inputs(const std::vector<PlayerInput>& inputs, const Executable& content);

}  // namespace ugoki::content
