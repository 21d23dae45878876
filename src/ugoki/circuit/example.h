#pragma once
// An example: a circuit with inputs at given ticks and the outputs expected. It documents an LSI and is also a test.

#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/circuit/circuit.h"
#include "ugoki/circuit/library.h"
#include "ugoki/circuit/resources.h"

namespace ugoki::circuit {

struct Activity;

/// Numbers that a pin is set to before a tick (given), or must have after it (expected).
struct ExampleMoment {
  std::uint64_t tick = 0;  ///< index from 0
  std::string pin;         ///< given: an input of the circuit, "id.pin" of a device, or "id.parameter"; expected: "id.pin"
  std::vector<double> numbers;
  double tolerance = 0;  ///< absolute, in the unit of the pin; unused if given
};

struct Example {
  std::string doc;
  Circuit circuit;
  double dt = 0.01;  ///< s, between ticks
  std::vector<ExampleMoment> given, expected;
};

/// Reads {"doc", "dt", "circuit", "given": [{"tick", "pin", "value"}], "expect": [{"tick", "pin", "value", "tolerance"}]}. "value" is a
/// number or a list of numbers.
[[nodiscard]] Result<Example> read_example(std::string_view text, std::string_view location);

/// Runs the example up to its last expected tick. The error names every pin whose value at the first wrong tick differs.
/// @param resources objects that the LSIs request from the host; null: none
/// @param activity receives which LSI runs; null: nobody asks
[[nodiscard]] Result<void> check_example(const Example& example, const Library& library, std::string_view location,
                                         const Resources* resources = nullptr, Activity* activity = nullptr);

}  // namespace ugoki::circuit
