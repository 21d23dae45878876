// Trigonometric functions, powers, exponentials: the functions of spatial/elementary.h, with the same bits on every machine.

#include "ugoki/lsi/declare.h"
#include "ugoki/spatial/elementary.h"

namespace ugoki::lsi {
namespace {

using circuit::input;
using circuit::output;

circuit::LsiClass maths(std::string name, std::string doc, std::vector<circuit::InputPin> inputs, std::string unit,
                        circuit::StepFunction step) {
  circuit::LsiClass c;
  c.group = "maths";
  c.name = std::move(name);
  c.doc = std::move(doc);
  c.inputs = std::move(inputs);
  c.outputs = {output_pin("out", PinTypeId::scalar, std::move(unit), "")};
  c.step = step;
  return c;
}
circuit::InputPin scalar(std::string name, std::string unit, std::string doc) {
  return input_pin(std::move(name), PinTypeId::scalar, std::move(unit), std::move(doc));
}

template <double (*f)(double)>
std::int32_t unary(const Call* c) {
  *output(c, 0) = f(*input(c, 0));
  return 0;
}

std::int32_t sine(const Call* c) {
  const SinCos sc = sin_cos(*input(c, 0));
  *output(c, 0) = sc.sin;
  *output(c, 1) = sc.cos;
  return 0;
}

template <double (*f)(double)>
std::int32_t arc(const Call* c) {
  const double x = *input(c, 0);
  if (!(x >= -1 && x <= 1)) return circuit::stop(c, "Its input 'in' must lie between -1 and 1.");
  *output(c, 0) = f(x);
  return 0;
}

std::int32_t power(const Call* c) {
  const double x = *input(c, 0), y = *input(c, 1);
  if (x > 0) {
    *output(c, 0) = pow(x, y);
    return 0;
  }
  if (x == 0 && y >= 0) {
    *output(c, 0) = y == 0 ? 1 : 0;
    return 0;
  }
  return circuit::stop(c, x == 0 ? "Zero has no power below 0." : "Its input 'in' is below 0: a power is real for positive numbers only.");
}

std::int32_t logarithm(const Call* c) {
  const double x = *input(c, 0);
  if (!(x > 0)) return circuit::stop(c, "Its input 'in' must be above 0.");
  *output(c, 0) = log(x);
  return 0;
}

}  // namespace

void add_maths(circuit::Library& library) {
  circuit::LsiClass both = maths("sine", "Sine and cosine of an angle.", {scalar("angle", "rad", "The angle.")}, "", sine);
  both.outputs = {output_pin("sine", PinTypeId::scalar, "", ""), output_pin("cosine", PinTypeId::scalar, "", "")};
  library.add(std::move(both));
  library.add(maths("tangent", "Tangent of an angle.", {scalar("angle", "rad", "The angle.")}, "", unary<tan>));
  library.add(maths("arc sine", "The angle that has this sine.", {scalar("in", "", "-1 to 1.")}, "rad", arc<asin>));
  library.add(maths("arc cosine", "The angle that has this cosine.", {scalar("in", "", "-1 to 1.")}, "rad", arc<acos>));
  library.add(maths("arc tangent", "The angle of the point (x, y), -pi to pi.", {scalar("y", "", ""), scalar("x", "", "")}, "rad",
                    [](const Call* c) -> std::int32_t {
                      *output(c, 0) = atan2(*input(c, 0), *input(c, 1));
                      return 0;
                    }));
  library.add(maths("power", "A positive number to any power.", {scalar("in", "", "The base."), scalar("exponent", "", "")}, "", power));
  library.add(maths("exponential", "e to the power of its input.", {scalar("in", "", "")}, "", unary<exp>));
  library.add(maths("logarithm", "The natural logarithm of a positive number.", {scalar("in", "", "")}, "", logarithm));
  library.add(maths("degrees", "An angle in degrees.", {scalar("angle", "rad", "The angle.")}, "deg", [](const Call* c) -> std::int32_t {
    *output(c, 0) = *input(c, 0) * (180 / pi);
    return 0;
  }));
  library.add(maths("radians", "An angle in radians.", {scalar("angle", "deg", "The angle.")}, "rad", [](const Call* c) -> std::int32_t {
    *output(c, 0) = *input(c, 0) * (pi / 180);
    return 0;
  }));
}

}  // namespace ugoki::lsi
