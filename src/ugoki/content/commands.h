#pragma once
// Commands. Every edit of a scenario document is one command; docs/scenario.md lists them.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/content/scenario.h"

namespace ugoki::content {

/// Result of a command.
struct CommandEffect {
  Scenario scenario;                 ///< the document after the command; it is valid
  std::string label;                 ///< label for undo menus, for example "Move clip"
  std::vector<std::string> created;  ///< ids of the clips, characters and events that the command created
};

/// Applies one command (a JSON object with `type`) to a valid document and returns the changed document. Errors: the command is malformed,
/// names an item that does not exist, or would make the document invalid; all problems are reported.
/// @param next_id counter for new ids. It only increases, so that an id is never reused; it is unchanged after an error
[[nodiscard]] Result<CommandEffect> apply_command(const Scenario& scenario, std::string_view command, const Catalogue& catalogue,
                                                  std::uint64_t& next_id);

/// Values of the field `type` of all commands, for example "clip.add".
[[nodiscard]] std::vector<std::string_view> command_types();

/// Returns the ids of the mechanisms and motions that the command refers to, so that the caller can fetch them from a library before it
/// applies the command. Empty for a malformed command.
[[nodiscard]] std::vector<std::string> resources_named(std::string_view command);

}  // namespace ugoki::content
