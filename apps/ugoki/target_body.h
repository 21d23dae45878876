#pragma once
// The body to which an operation applies: named by an option or an argument.

#include <string>

#include "sources.h"

namespace ugoki::cli {

/// Loads a mechanism: from a mechanism file, an entry of the library (mechanism, or motion with its mechanism), the sample "dog" or
/// "human", or the body made for a measured file.
/// @param height m: a person of this height; 0: `name` decides
[[nodiscard]] Result<MechanismPtr> load_body(const std::string& name, double height, const SourceOptions& options);

}  // namespace ugoki::cli
