#pragma once
// Mapping file: the user's corrections of the automatic mapping between two characters. docs/retarget.md describes the format.

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "ugoki/retarget/rig.h"

namespace ugoki::retarget {

/// Content of a mapping file. In a default-constructed mapping everything is found automatically.
struct Mapping {
  AnatomyNames source, target;
  std::vector<std::pair<std::string, std::string>> links;  ///< (source link, target link) outside trunk and limbs (ears, fingers)
  std::vector<SoleSpec> soles;                             ///< soles of the target
  double speed = 0;  ///< rad/s (m/s for sliding joints), speed limit of all joints of the target; 0: none
  std::vector<std::pair<std::string, double>> link_speeds;  ///< (target link, its speed limit, same unit); takes precedence over `speed`
};

/// Reads the JSON text. Error locations are the file name followed by the JSON path ("m.json/target/left leg").
[[nodiscard]] Result<Mapping> read_mapping(std::string_view text, std::string_view file_name);

}  // namespace ugoki::retarget
