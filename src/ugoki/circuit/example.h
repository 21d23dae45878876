#pragma once
// An example is a circuit with inputs at given ticks and the expected outputs. It documents an LSI and is also a test.

#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/circuit/circuit.h"
#include "ugoki/circuit/library.h"
#include "ugoki/circuit/resources.h"

namespace ugoki::circuit {

struct Activity;

/// Numbers of a pin: values written to it before a tick (given), or required of it after the tick (expected).
struct ExampleMoment {
  std::uint64_t tick = 0;  ///< index of the tick, from 0
  std::string pin;         ///< given: an input of the circuit, "id.pin" of a device, or "id.parameter"; expected: "id.pin"
  std::vector<double> numbers;
  double tolerance = 0;  ///< expected: absolute tolerance, in the unit of the pin; given: unused
};

struct Example {
  std::string doc;
  Circuit circuit;
  double dt = 0.01;  ///< time between two ticks, s
  std::vector<ExampleMoment> given, expected;
};

/// Reads {"doc", "dt", "circuit", "given": [{"tick", "pin", "value"}], "expect": [{"tick", "pin", "value", "tolerance"}]}. "value" is a
/// number or a list of numbers.
[[nodiscard]] Result<Example> read_example(std::string_view text, std::string_view location);

/// Runs the example up to the last tick with expected numbers. The error names every pin with a wrong value at the first wrong tick.
/// @param resources objects that the LSIs request from the host; null: none
/// @param activity receives the LSI that is running; null: none
[[nodiscard]] Result<void> check_example(const Example& example, const Library& library, std::string_view location,
                                         const Resources* resources = nullptr, Activity* activity = nullptr);

}  // namespace ugoki::circuit
