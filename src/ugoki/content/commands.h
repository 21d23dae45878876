#pragma once
// Commands: every edit of a scenario document is one of them. Their list stands in docs/scenario.md.

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/content/scenario.h"

namespace ugoki::content {

struct CommandEffect {
  Scenario scenario;                 ///< the document after the command, valid
  std::string label;                 ///< for undo menus: "Move clip"
  std::vector<std::string> created;  ///< ids of what the command made
};

/// Applies one command (a JSON object with `type`) to a valid document. The document is left alone if the command is
/// malformed, names something that is not there, or would leave the document invalid; all problems are then reported.
/// @param next_id counter from which ids are made; only grows, so that ids are never used twice
[[nodiscard]] Result<CommandEffect> apply_command(const Scenario& scenario, std::string_view command, const Catalogue& catalogue,
                                                  std::uint64_t& next_id);

/// Ids of mechanisms and motions that the command brings into the document, so that they can be fetched from a library
/// before it is applied. Empty for a malformed command.
[[nodiscard]] std::vector<std::string> resources_named(std::string_view command);

}  // namespace ugoki::content
