#pragma once
// Circuits of tests: numbers are set at inputs and read at outputs.

#include <gtest/gtest.h>

#include <cstring>
#include <string>

#include "ugoki/circuit/circuit.h"
#include "ugoki/circuit/interpreter.h"
#include "ugoki/lsi/standard_library.h"

namespace ugoki::lsi {

/// @param text JSON of the circuit @param world resources of its LSIs; null: none @param dt time of a tick, s
inline circuit::Interpreter build(const circuit::Resources* world, const std::string& text, double dt) {
  const auto c = circuit::read_circuit(text);
  EXPECT_TRUE(c) << (c ? "" : c.error().text());
  auto i = circuit::Interpreter::build(*c, standard_library(), world, {.dt = dt, .check_finite = true});
  EXPECT_TRUE(i) << (i ? "" : i.error().text());
  return std::move(*i);
}
/// Sets an input of the circuit.
inline void set(circuit::Interpreter& i, const char* input, double value) {
  const auto bytes = i.find_circuit_input(input);
  ASSERT_EQ(bytes.size(), sizeof value);
  std::memcpy(bytes.data(), &value, sizeof value);
}
/// First number of an output "id.pin".
inline double get(const circuit::Interpreter& i, const char* pin) { return i.find_output(pin)->numbers()[0]; }

}  // namespace ugoki::lsi
