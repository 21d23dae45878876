#pragma once
// The JSON form of a mechanism that people write and read. Every field is described in docs/formats.md.

#include <string>
#include <string_view>

#include "ugoki/base/result.h"
#include "ugoki/mechanism/mechanism.h"

namespace ugoki::formats {

/// JSON text of the mechanism, SI units; what has its default value is left out. read_mechanism gives back the same bits.
[[nodiscard]] std::string write_mechanism(const Mechanism& mechanism);

/// Reads and validates. Errors: broken JSON has file:line; wrong types, unknown words and wrong lengths have
/// file:path/in/the/JSON; an impossible mechanism has file: link name. All problems found are reported, up to a
/// hundred of the first two kinds.
[[nodiscard]] Result<MechanismPtr> read_mechanism(std::string_view text, std::string_view file_name);

}  // namespace ugoki::formats
