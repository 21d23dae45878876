#pragma once
// Writes mechanisms to files; the extension selects the format.

#include <string>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/mechanism/mechanism.h"

namespace ugoki::cli {

/// Writes JSON (.json), URDF (.urdf, with a .yaml file for closed loops) or MJCF (.xml). Meshes are written to the same folder.
/// @return sentences about data that the format cannot store and about the additional files
[[nodiscard]] Result<std::vector<std::string>> write_mechanism_file(const Mechanism& mechanism, const std::string& path);

}  // namespace ugoki::cli
