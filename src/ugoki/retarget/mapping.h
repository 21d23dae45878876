#pragma once
// What a user says about two figures where the automatic mapping is not what is wanted. docs/retarget.md describes the file.

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "ugoki/retarget/rig.h"

namespace ugoki::retarget {

struct Mapping {
  FigureNames source, target;
  std::vector<std::pair<std::string, std::string>> links;   ///< source link, target link: joints beyond the chains (ears, fingers)
  std::vector<SoleSpec> soles;                              ///< of the target
  double speed = 0;                                         ///< rad/s (m/s of sliding joints) that no joint may exceed; 0: none
  std::vector<std::pair<std::string, double>> link_speeds;  ///< the same for single links of the target
};

/// Reads the JSON text. Errors name the path in it.
[[nodiscard]] Result<Mapping> read_mapping(std::string_view text, std::string_view file_name);

}  // namespace ugoki::retarget
