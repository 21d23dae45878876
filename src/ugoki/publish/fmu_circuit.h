#pragma once
// The circuit of an FMU that contains a whole piece of content: its execution circuit, with inputs and outputs that other tools can use.

#include "ugoki/base/result.h"
#include "ugoki/circuit/circuit.h"
#include "ugoki/content/executable.h"

namespace ugoki::publish {

/// Returns the execution circuit of the content with other pins. For each character ID it has the input `ID.push` (N, world axes), a force
/// at the centre of mass of the root link, and the outputs `ID.position` (m), `ID.rotation` and `ID.velocity` (m/s) of the root link,
/// `ID.centre of mass` (m), `ID.q` and `ID.v` (position and velocity of all coordinates), and `ID.measures` (lsi::Measure) if the circuit
/// measures the naturalness of the character. Inputs and outputs of the execution circuit that are events, contacts or display data are
/// removed; its other pins, and its parameters, remain. '.' is ':' in the names of pins, because '.' separates LSI and pin.
/// Error: the circuit has not exactly one LSI `dynamics` and one LSI `status` at its outermost level.
[[nodiscard]] Result<circuit::Circuit> make_fmu_circuit(const content::Executable& content, const std::string& name);

}  // namespace ugoki::publish
