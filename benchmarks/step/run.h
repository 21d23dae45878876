#pragma once
// Runs a scene in all engines and adds its rows to the table.

#include "source.h"
#include "table.h"

namespace ugoki::benchmarks {

/// Adds one row for each phase of the scene and each peer. The conversion for each peer is checked first: equal mass and DOFs, and equal
/// motion while the bodies fall freely with moving joints. A run is checked as well: poses are finite, energy does not grow, bodies are not
/// in the ground, and they are at rest at the end if the scene demands it. Throws std::runtime_error after adding the rows if a check
/// failed.
void run_scene(Table& table, const StepSource& source);

}  // namespace ugoki::benchmarks
