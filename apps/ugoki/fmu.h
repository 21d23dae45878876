#pragma once
// FMUs on the command line.

#include "output.h"
#include "ugoki/base/result.h"
#include "verb.h"

namespace ugoki::cli {

/// `ugoki circuit export-fmu`. @param circuit_verb `ugoki circuit`
void add_export_fmu(CLI::App& circuit_verb, Action& action);

/// What an FMU holds, for `ugoki info`. Runs none of its code.
[[nodiscard]] Result<Json> fmu_info(const std::string& path);

}  // namespace ugoki::cli
