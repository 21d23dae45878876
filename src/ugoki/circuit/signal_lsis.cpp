#include "ugoki/circuit/signal_lsis.h"

#include <cstring>
#include <utility>

#include "ugoki/circuit/declare.h"
#include "ugoki/circuit/setup.h"

namespace ugoki::circuit {
namespace {

/// Step function of an LSI with the output f(a, b) of its inputs a and b.
template <double (*f)(double, double)>
std::int32_t binary(const Call* c) {
  *output(c, 0) = f(*input(c, 0), *input(c, 1));
  return 0;
}
double add(double a, double b) { return a + b; }
double subtract(double a, double b) { return a - b; }
double multiply(double a, double b) { return a * b; }
double is_above(double a, double b) { return a > b ? 1.0 : 0.0; }

std::int32_t divide(const Call* c) {
  const double b = *input(c, 1);
  if (b == 0) return stop(c, "Its input 'b' is zero, so 'a' cannot be divided by it.");
  *output(c, 0) = *input(c, 0) / b;
  return 0;
}

void add_scalar_parts(Library& library) {
  LsiClass constant = lsi("constant", "A constant number.", {}, {out("out")}, [](const Call* c) -> std::int32_t {
    *output(c, 0) = c->parameters[0];
    return 0;
  });
  constant.parameters = {number("value", 0, "The number.")};
  library.add(std::move(constant));

  library.add(lsi("clock", "Time of this tick, s.", {}, {out("time")}, [](const Call* c) -> std::int32_t {
    *output(c, 0) = c->tick->time;
    return 0;
  }));
  library.add(lsi("add", "a + b.", {in("a"), in("b")}, {out("out")}, binary<add>));
  library.add(lsi("subtract", "a - b.", {in("a"), in("b")}, {out("out")}, binary<subtract>));
  library.add(lsi("multiply", "a b (product).", {in("a"), in("b")}, {out("out")}, binary<multiply>));
  library.add(lsi("divide", "a / b; if b is zero, the circuit stops.", {in("a"), in("b")}, {out("out")}, divide));
  library.add(lsi("compare", "1 if a > b, otherwise 0.", {in("a"), in("b")}, {out("out")}, binary<is_above>));

  LsiClass gain = lsi("gain", "Multiplies its input by a constant factor.", {in("in")}, {out("out")}, [](const Call* c) -> std::int32_t {
    *output(c, 0) = c->parameters[0] * *input(c, 0);
    return 0;
  });
  gain.parameters = {number("gain", 1, "The factor.")};
  library.add(std::move(gain));

  LsiClass sum = lsi("sum", "Sum of all inputs that are wired to it.", {in("in")}, {out("out")}, [](const Call* c) -> std::int32_t {
    double total = 0;
    for (std::uint32_t i = 0; i < c->in_first[1]; ++i) total += *input(c, i);
    *output(c, 0) = total;
    return 0;
  });
  sum.inputs[0].multiple = true;
  sum.inputs[0].required = false;
  library.add(std::move(sum));

  LsiClass clamp = lsi("clamp", "Limits its input to the range from `minimum` to `maximum`.", {in("in")}, {out("out")},
                       [](const Call* c) -> std::int32_t {
                         const double x = *input(c, 0);
                         *output(c, 0) = x < c->parameters[0] ? c->parameters[0] : x > c->parameters[1] ? c->parameters[1] : x;
                         return 0;
                       });
  clamp.parameters = {number("minimum", 0, "Lower limit."), number("maximum", 1, "Upper limit.")};
  library.add(std::move(clamp));

  library.add(lsi("switch", "The value of `on` if `condition` is above zero, otherwise the value of `off`.",
                  {in("condition"), in("on"), in("off")}, {out("out")}, [](const Call* c) -> std::int32_t {
                    *output(c, 0) = *input(c, 0) > 0 ? *input(c, 1) : *input(c, 2);
                    return 0;
                  }));
}

/// Adds LSIs with one scalar state y, kept in the state bytes so that y is saved and restored.
void add_scalar_dynamics(Library& library) {
  LsiClass integrator =
      lsi("integrator", "Integral of its input over time (explicit Euler): out' = in.", {in("in")}, {out("out")}, nullptr);
  integrator.parameters = {number("initial", 0, "Value at the start.")};
  integrator.inputs[0].direct = false;
  integrator.outputs[0].delayed = true;
  integrator.configure = [](Setup& s) { s.set_state(sizeof(double)); };
  integrator.init = [](const Call* c) -> std::int32_t {
    *static_cast<double*>(c->state) = *output(c, 0) = c->parameters[0];
    return 0;
  };
  integrator.advance = [](const Call* c) -> std::int32_t {
    auto& y = *static_cast<double*>(c->state);
    y += *input(c, 0) * c->tick->dt;
    *output(c, 0) = y;
    return 0;
  };
  library.add(std::move(integrator));

  LsiClass low_pass =
      lsi("low-pass", "First-order filter: follows its input with a time constant (backward Euler).", {in("in")}, {out("out")}, nullptr);
  low_pass.parameters = {number("time", 0.1, "Time constant.", 0, 1e6, "s"), number("initial", 0, "Value at the start.")};
  low_pass.configure = [](Setup& s) { s.set_state(sizeof(double)); };
  low_pass.init = [](const Call* c) -> std::int32_t {
    *static_cast<double*>(c->state) = c->parameters[1];
    return 0;
  };
  low_pass.step = [](const Call* c) -> std::int32_t {
    const double y = *static_cast<const double*>(c->state);
    *output(c, 0) = y + (*input(c, 0) - y) * (c->tick->dt / (c->parameters[0] + c->tick->dt));
    return 0;
  };
  low_pass.advance = [](const Call* c) -> std::int32_t {
    *static_cast<double*>(c->state) = *output(c, 0);
    return 0;
  };
  library.add(std::move(low_pass));
}

void add_vector_parts(Library& library) {
  constexpr PinTypeId vector = PinTypeId::vector;
  library.add(lsi("make vector", "A vector from its components.", {in("x"), in("y"), in("z")}, {out("out", vector)},
                  [](const Call* c) -> std::int32_t {
                    for (std::size_t i = 0; i < 3; ++i) output(c, 0)[i] = *input(c, i);
                    return 0;
                  }));
  library.add(lsi("split vector", "The components of a vector.", {in("in", vector)}, {out("x"), out("y"), out("z")},
                  [](const Call* c) -> std::int32_t {
                    for (std::size_t i = 0; i < 3; ++i) *output(c, i) = input(c, 0)[i];
                    return 0;
                  }));
  library.add(lsi("add vectors", "a + b.", {in("a", vector), in("b", vector)}, {out("out", vector)}, [](const Call* c) -> std::int32_t {
    for (std::size_t i = 0; i < 3; ++i) output(c, 0)[i] = input(c, 0)[i] + input(c, 1)[i];
    return 0;
  }));
  library.add(lsi("scale vector", "A vector times a number.", {in("in", vector), in("factor")}, {out("out", vector)},
                  [](const Call* c) -> std::int32_t {
                    for (std::size_t i = 0; i < 3; ++i) output(c, 0)[i] = input(c, 0)[i] * *input(c, 1);
                    return 0;
                  }));
}

/// "delay" for scalars, "delay vector", ...: the value of the previous tick. For a type without a fixed size, the input gives the size; if
/// the input depends on the delay's own output (a cycle of wires), the parameter `count` gives it.
void add_delays(Library& library) {
  for (const PinType& type : pin_types()) {
    const std::string name = type.id == PinTypeId::scalar ? "delay" : "delay " + std::string(type.name);
    LsiClass c = lsi(name, "The value that the input had at the previous tick; allows cycles of wires (feedback).", {in("in", type.id)},
                     {out("out", type.id)}, nullptr);
    c.inputs[0].direct = false;
    c.outputs[0].delayed = true;
    if (type.default_count == 0) {
      Parameter count = number("count", 0, "Number of elements; 0: as many as the input has.", 0, 1e6);
      count.kind = ParameterKind::integer;
      count.live = false;
      c.parameters.push_back(std::move(count));
      c.configure = [](Setup& s) {
        const double given = s.number("count");
        const Shape from = s.in(0);
        if (given > 0 && from.count > 0 && static_cast<double>(from.count) != given)
          s.fail(ErrorCode::structure, "Its input has " + std::to_string(from.count) + " elements, but its parameter 'count' is different.",
                 "Set 'count' to 0 or to " + std::to_string(from.count) + ".");
        s.set_out(0, given > 0 ? static_cast<std::uint32_t>(given) : from.count, from.subject);
      };
    }
    if (type.id == PinTypeId::scalar) {
      c.parameters.push_back(number("initial", 0, "Value at the start."));
      c.init = [](const Call* call) -> std::int32_t {
        *output(call, 0) = call->parameters[0];
        return 0;
      };
      c.advance = [](const Call* call) -> std::int32_t {
        *output(call, 0) = *input(call, 0);
        return 0;
      };
    } else {
      if (type.id == PinTypeId::rotation)
        c.init = [](const Call* call) -> std::int32_t {
          output(call, 0)[0] = 1;
          return 0;
        };
      if (type.id == PinTypeId::pose)
        c.init = [](const Call* call) -> std::int32_t {
          output(call, 0)[3] = 1;
          return 0;
        };
      // A call does not contain the size of an element, so each pin type has its own function.
      c.advance = [&]() -> StepFunction {
        switch (type.id) {
          case PinTypeId::vector:
            return [](const Call* call) -> std::int32_t {
              std::memcpy(call->out[0], call->in[0], 24);
              return 0;
            };
          case PinTypeId::rotation:
            return [](const Call* call) -> std::int32_t {
              std::memcpy(call->out[0], call->in[0], 32);
              return 0;
            };
          case PinTypeId::pose:
            return [](const Call* call) -> std::int32_t {
              std::memcpy(call->out[0], call->in[0], 56);
              return 0;
            };
          case PinTypeId::contacts:
          case PinTypeId::event:
            return [](const Call* call) -> std::int32_t {
              std::memcpy(call->out[0], call->in[0], 8 + 128 * std::size_t{call->out_count[0]});
              return 0;
            };
          default:
            return [](const Call* call) -> std::int32_t {
              std::memcpy(call->out[0], call->in[0], 8 * std::size_t{call->out_count[0]});
              return 0;
            };
        }
      }();
    }
    library.add(std::move(c));
  }
}

}  // namespace

void add_signal_lsis(Library& library) {
  add_scalar_parts(library);
  add_scalar_dynamics(library);
  add_vector_parts(library);
  add_delays(library);
  add_logic_lsis(library);
  add_machine_lsis(library);
}

}  // namespace ugoki::circuit
