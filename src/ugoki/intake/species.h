#pragma once
// Species of four-legged animals that names state, and their usual masses.

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace ugoki::intake {

/// Usual masses of the animals that a name or several names state, from small young ones to large adults.
struct SpeciesMass {
  std::string names;                  ///< for display: "deer", or "cat, fox"
  std::string source;                 ///< for display: where the names were found; empty: the caller named the species
  double lightest = 0, heaviest = 0;  ///< kg
};

/// Mass range of one species or breed ("deer", "husky"). @return nothing if the name is unknown
[[nodiscard]] std::optional<SpeciesMass> species_mass(std::string_view name);

/// Species that the words of a file's name state, or otherwise those of the other names: of motions and of root joints, for example.
/// Several species in names of the same kind give a common range. A name is divided into words at punctuation, digits and capitals; a word
/// may also begin or end with the name of a species ("wolfrig", "DEERwalk1").
/// @param file_name without folder
[[nodiscard]] std::optional<SpeciesMass> species_in_names(std::string_view file_name, std::span<const std::string> others);

/// Names that species_mass knows, separated by ", ".
[[nodiscard]] std::string known_species();

}  // namespace ugoki::intake
