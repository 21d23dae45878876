#pragma once
// The prims of a USD text file (*.usda) with those attributes that describe skeletons and their motion. Internal to scene_formats.

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "ugoki/base/result.h"

namespace ugoki::scene_formats {

/// A value: the numbers of nested tuples and lists in one sequence, or texts (strings, tokens).
struct UsdValue {
  std::vector<double> numbers;
  std::vector<std::string> texts;
};

struct UsdAttribute {
  int line = 0;
  std::optional<UsdValue> value;                     ///< the default
  std::vector<std::pair<double, UsdValue>> samples;  ///< by increasing time code
};

struct UsdPrim {
  std::string type, name, path;  ///< path: "/Content/Walker"
  int parent = -1;               ///< index of the parent, smaller than the prim's own index; -1: none
  int line = 0;
  bool defined = false;  ///< specified with `def`, not `over` or `class`
  bool active = true;
  std::map<std::string, UsdAttribute, std::less<>> attributes;
  std::map<std::string, std::string, std::less<>> targets;  ///< of relationships: absolute path of the first target
  [[nodiscard]] const UsdAttribute* attribute(std::string_view wanted) const;
};

struct UsdLayer {
  std::optional<double> metres_per_unit, time_codes_per_second, frames_per_second;
  char up = 'Y';        ///< the fallback of USD
  bool refers = false;  ///< the file refers to other files or prims (sublayers, references, payloads, inherited prims)
  std::vector<UsdPrim> prims;
};

/// Parses a file. Of the attributes, only those of skeletons, their animations and transformations are kept; the others are skipped.
/// Variants are read if they are selected in the file. Errors: syntax, nesting deeper than 200 prims, more than 200,000 prims, a kept
/// attribute whose numbers are not finite.
[[nodiscard]] Result<UsdLayer> read_usda_layer(std::string_view text, std::string_view file_name);

}  // namespace ugoki::scene_formats
