#pragma once
// A circuit with what it is given and what it must then show: documentation of an LSI that is also its test.

#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/circuit/circuit.h"
#include "ugoki/circuit/library.h"
#include "ugoki/circuit/resources.h"

namespace ugoki::circuit {

/// Numbers of a pin before (given) or after (expected) a tick.
struct ExampleMoment {
  std::uint64_t tick = 0;
  std::string pin;  ///< given: an input of the circuit, "id.pin" of a device, or "id.parameter"; expected: "id.pin"
  std::vector<double> numbers;
  double tolerance = 0;  ///< absolute
};

struct Example {
  std::string doc;
  Circuit circuit;
  double dt = 0.01;  ///< s
  std::vector<ExampleMoment> given, expected;
};

/// {"doc", "dt", "circuit", "given": [{"tick", "pin", "value"}], "expect": [{"tick", "pin", "value", "tolerance"}]}; "value" is a number
/// or a list of numbers.
[[nodiscard]] Result<Example> read_example(std::string_view text, std::string_view place);

/// Runs it up to its last moment. An error names every pin that shows something else.
/// @param resources that its LSIs ask for; null: none
[[nodiscard]] Result<void> check_example(const Example& example, const Library& library, std::string_view place,
                                         const Resources* resources = nullptr);

}  // namespace ugoki::circuit
