#pragma once
// Common functions of the circuit tests: the library of signal LSIs, and building a circuit from JSON text.

#include <gtest/gtest.h>

#include <string>

#include "ugoki/circuit/interpreter.h"
#include "ugoki/circuit/signal_lsis.h"

namespace ugoki::circuit {

inline Library& signal_library() {
  static Library library = [] {
    Library l;
    add_signal_lsis(l);
    return l;
  }();
  return library;
}

inline Circuit parse(const std::string& text) {
  auto circuit = read_circuit(text);
  EXPECT_TRUE(circuit) << (circuit ? "" : circuit.error().text());
  return circuit ? *circuit : Circuit{};
}

inline Result<Interpreter> build(const std::string& text, const Resources* resources = nullptr) {
  return Interpreter::build(parse(text), signal_library(), resources, BuildOptions{.dt = 0.01, .check_finite = true});
}

inline double value(const Interpreter& i, const std::string& pin) {
  const auto view = i.find_output(pin);
  EXPECT_TRUE(view) << pin;
  return view ? view->numbers()[0] : 0;
}

}  // namespace ugoki::circuit
