#pragma once
// Physical dimensions of the units of pins, used to find wires between pins of different physical quantities.

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/circuit/circuit.h"
#include "ugoki/circuit/library.h"

namespace ugoki::circuit {

/// Exponents of the SI base units: m, kg, s, A, K, mol, cd. Angles are dimensionless, as in the SI.
using Dimension = std::array<int, 7>;

/// Dimensions of a unit such as "N m", "kg m^2/s", "1/s" or "m | rad". '/' divides by the factor that follows it. "|" and "," separate
/// alternatives, for values whose unit depends on the joint or on the element. Prefixes and factors (mm, deg) do not change the dimension.
/// @return one dimension for each alternative; nullopt if the text is empty or has an unknown unit
[[nodiscard]] std::optional<std::vector<Dimension>> read_dimensions(std::string_view unit);

/// True if values of one unit may be wired to a pin of the other unit: they have a dimension in common, one unit is dimensionless, or
/// one unit is unknown.
[[nodiscard]] bool fit(std::string_view from, std::string_view to);

/// Warnings about wires between pins whose units do not fit. Such a circuit can still run. The list is empty if the circuit cannot be
/// built; Interpreter::build then reports the reason.
[[nodiscard]] std::vector<Problem> check_units(const Circuit& circuit, const Library& library);

}  // namespace ugoki::circuit
