#pragma once
// Mechanisms to files, by the ending of the name.

#include <string>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/mechanism/mechanism.h"

namespace ugoki::cli {

/// JSON (.json), URDF (.urdf, and beside it .yaml where loops are closed), MJCF (.xml); meshes are written beside.
/// @return sentences: what the format cannot hold, and the files that were written beside
[[nodiscard]] Result<std::vector<std::string>> write_mechanism_file(const Mechanism& mechanism, const std::string& path);

}  // namespace ugoki::cli
