#pragma once
// Functions that shorten the declarations of the signal LSIs. Internal to this module.

#include <string>
#include <utility>
#include <vector>

#include "ugoki/circuit/library.h"

namespace ugoki::circuit {

inline InputPin in(std::string name, PinTypeId type = PinTypeId::scalar, std::string doc = {}) {
  InputPin pin;
  pin.name = std::move(name);
  pin.type = type;
  pin.doc = std::move(doc);
  return pin;
}
inline OutputPin out(std::string name, PinTypeId type = PinTypeId::scalar, std::string doc = {}) {
  OutputPin pin;
  pin.name = std::move(name);
  pin.type = type;
  pin.doc = std::move(doc);
  return pin;
}
inline Parameter number(std::string name, double initial, std::string doc, double minimum = -1e300, double maximum = 1e300,
                        std::string unit = {}) {
  Parameter p;
  p.name = std::move(name);
  p.initial = initial;
  p.minimum = minimum;
  p.maximum = maximum;
  p.unit = std::move(unit);
  p.doc = std::move(doc);
  return p;
}

inline LsiClass lsi(std::string name, std::string doc, std::vector<InputPin> inputs, std::vector<OutputPin> outputs, StepFunction step) {
  LsiClass c;
  c.group = "signal";
  c.name = std::move(name);
  c.doc = std::move(doc);
  c.inputs = std::move(inputs);
  c.outputs = std::move(outputs);
  c.step = step;
  return c;
}

/// Makes a scalar input that needs no wire. Without a wire, the input has the value `value`.
inline InputPin optional(std::string name, double value = 0, std::string doc = {}) {
  InputPin pin = in(std::move(name), PinTypeId::scalar, std::move(doc));
  pin.required = false;
  pin.value = value;
  return pin;
}

/// Add groups of signal LSIs to the library. add_signal_lsis calls both functions.
void add_logic_lsis(Library& library);
void add_machine_lsis(Library& library);

}  // namespace ugoki::circuit
