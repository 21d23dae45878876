#pragma once
// The command-line verb that exports an FMU (Functional Mock-up Unit), and information about FMUs for `ugoki info`.

#include "output.h"
#include "ugoki/base/result.h"
#include "verb.h"

namespace ugoki::cli {

/// Adds `export-fmu` to the verb `ugoki circuit`.
void add_export_fmu(Verb circuit_verb, Action& action);

/// Contents of an FMU as JSON, for `ugoki info`. Runs none of its code.
[[nodiscard]] Result<Json> fmu_info(const std::string& path);

}  // namespace ugoki::cli
