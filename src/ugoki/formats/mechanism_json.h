#pragma once
// The JSON form of a mechanism, which people can read and write. docs/formats.md describes every field.

#include <string>
#include <string_view>

#include "ugoki/base/result.h"
#include "ugoki/mechanism/mechanism.h"

namespace ugoki::formats {

/// Returns the JSON text of the mechanism, SI units. Default values are omitted. read_mechanism restores every number bit for bit.
[[nodiscard]] std::string write_mechanism(const Mechanism& mechanism);

/// Reads and validates a mechanism. Locations of errors: "file:line" for broken JSON; "file:path/in/the/JSON" for wrong types, unknown
/// words and wrong lengths; "file: link name" for an impossible mechanism. All problems found are reported, but at most a hundred of the
/// first two kinds.
[[nodiscard]] Result<MechanismPtr> read_mechanism(std::string_view text, std::string_view file_name);

}  // namespace ugoki::formats
