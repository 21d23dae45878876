#pragma once
// JSON files of anatomy mappings: written with the recognised anatomy of a file, edited, and read as a correction.

#include <string>
#include <string_view>

#include "ugoki/base/result.h"
#include "ugoki/body/mapping.h"

namespace ugoki::intake {

/// The mapping as a JSON document (docs/formats.md, "Anatomy mapping").
[[nodiscard]] std::string write_mapping(const body::AnatomyMapping& mapping);

/// Reads a JSON document of a mapping. Confidences and evidence are skipped: what the file contains is certain.
/// @param file_name begins the location of every problem
/// Errors: not JSON; another document; fields of wrong type or unknown fields.
[[nodiscard]] Result<body::AnatomyMapping> read_mapping(std::string_view text, std::string_view file_name);

}  // namespace ugoki::intake
