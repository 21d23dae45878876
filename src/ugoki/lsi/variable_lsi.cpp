// Variables of rules: the value that is kept from tick to tick, and the changes that rules make.

#include <algorithm>
#include <cmath>

#include "ugoki/lsi/declare.h"

namespace ugoki::lsi {
namespace {

constexpr double limit = 1e9;  // as content::max_variable

circuit::Parameter choice(std::string name, std::vector<std::string> choices, std::string doc) {
  circuit::Parameter p;
  p.name = std::move(name);
  p.kind = circuit::ParameterKind::choice;
  p.initial = choices[0];
  p.choices = std::move(choices);
  p.doc = std::move(doc);
  p.live = false;
  return p;
}

// ---- variable

struct Bounds {
  double initial, minimum, maximum;
  bool changes;  ///< `next` is wired
};

void add_variable(circuit::Library& library) {
  circuit::LsiClass c;
  c.group = "rules";
  c.name = "variable";
  c.doc = "A value that is kept from tick to tick, within its bounds. Changes are wired in series from `value` to `next`.";
  c.inputs = {input_pin("next", PinTypeId::scalar, "", "The value with the changes of this tick.")};
  c.inputs[0].direct = false;
  c.inputs[0].required = false;
  c.outputs = {output_pin("value", PinTypeId::scalar, "", "The value at the end of the previous tick.")};
  c.outputs[0].delayed = true;
  c.parameters = {number_parameter("initial", 0, -limit, limit, "", "Value at the start."),
                  number_parameter("minimum", -limit, -limit, limit, "", "The value is never below."),
                  number_parameter("maximum", limit, -limit, limit, "", "The value is never above.")};
  for (circuit::Parameter& p : c.parameters) p.live = false;
  c.make = [](Setup& s) -> void* { return new Bounds{s.number("initial"), s.number("minimum"), s.number("maximum"), s.wires(0) > 0}; };
  c.destroy = destroy<Bounds>;
  c.init = [](const Call* call) -> std::int32_t {
    circuit::output(call, 0)[0] = object_of<Bounds>(call).initial;
    return 0;
  };
  c.advance = [](const Call* call) -> std::int32_t {
    const auto& self = object_of<Bounds>(call);
    if (self.changes) circuit::output(call, 0)[0] = std::min(self.maximum, std::max(self.minimum, circuit::input(call, 0)[0]));
    return 0;
  };
  library.add(std::move(c));
}

// ---- set variable

enum class Change { set, add, toggle };

/// Plain data.
struct SetState {
  double held = 0;   ///< 1: the condition was true in the previous tick
  double count = 0;  ///< how often the condition became true
};
struct SetSaved {
  SetState now, next;
};
struct SetVariable {
  Change change;
  bool lasting;  ///< mode `while`
};

std::int32_t set_variable(const Call* call) {
  const auto& self = object_of<SetVariable>(call);
  auto& saved = *static_cast<SetSaved*>(call->state);
  SetState& s = saved.next = saved.now;
  const bool held = circuit::input(call, 0)[0] > 0, rise = held && s.held == 0;
  const double before = circuit::input(call, 1)[0], amount = circuit::input(call, 2)[0];
  double value = before;
  if (self.lasting ? held : rise) {
    if (self.change == Change::set) value = amount;
    if (self.change == Change::add) value = before + (self.lasting ? amount * call->tick->dt : amount);
  }
  if (rise && self.change == Change::toggle) value = before > 0 ? 0 : 1;
  if (rise) s.count += 1;
  s.held = held ? 1 : 0;
  circuit::output(call, 0)[0] = value;
  circuit::output(call, 1)[0] = s.held;
  circuit::output(call, 2)[0] = s.count;
  return 0;
}

void add_set_variable(circuit::Library& library) {
  circuit::LsiClass c;
  c.group = "rules";
  c.name = "set variable";
  c.doc = "Changes the value of a `variable` while a condition is true, or when it becomes true.";
  c.inputs = {input_pin("condition", PinTypeId::scalar, "", "The condition; true above 0."),
              input_pin("value", PinTypeId::scalar, "", "The value, from `variable` or from the previous change."),
              input_pin("amount", PinTypeId::scalar, "", "The new value, or the number that is added.")};
  c.inputs[2].required = false;
  c.outputs = {output_pin("value", PinTypeId::scalar, "", "The changed value."),
               output_pin("active", PinTypeId::scalar, "", "1 while the condition is true, otherwise 0."),
               output_pin("count", PinTypeId::scalar, "", "How often the condition became true.")};
  c.parameters = {
      choice("mode", {"when", "while"}, "`when`: once, in the tick in which the condition becomes true; `while`: as long as it is true."),
      choice("change", {"set", "add", "toggle"},
             "`set` to the amount; `add` the amount, in the mode `while` per second; `toggle` between 0 and 1, always once.")};
  c.state_bytes = sizeof(SetSaved);
  c.make = [](Setup& s) -> void* {
    const std::string& change = s.text("change");
    return new SetVariable{change == "set" ? Change::set : change == "add" ? Change::add : Change::toggle, s.text("mode") == "while"};
  };
  c.destroy = destroy<SetVariable>;
  c.step = set_variable;
  c.advance = [](const Call* call) -> std::int32_t {
    auto& saved = *static_cast<SetSaved*>(call->state);
    saved.now = saved.next;
    return 0;
  };
  library.add(std::move(c));
}

}  // namespace

void add_variables(circuit::Library& library) {
  add_variable(library);
  add_set_variable(library);
}

}  // namespace ugoki::lsi
