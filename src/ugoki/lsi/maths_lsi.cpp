// Trigonometric functions, powers and exponentials, computed by the functions of spatial/elementary.h, which give the same bits on every
// machine.

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
  if (!(x >= -1 && x <= 1)) return circuit::stop(c, "Its input 'in' must be from -1 to 1.");
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
  return circuit::stop(c, x == 0 ? "Its input 'in' is 0 and 'exponent' is negative: the power is infinite."
                                 : "Its input 'in' is negative: powers are defined here for 'in' from 0 only.");
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
  library.add(maths("arc sine", "The angle from -pi/2 to pi/2 with this sine.", {scalar("in", "", "From -1 to 1.")}, "rad", arc<asin>));
  library.add(maths("arc cosine", "The angle from 0 to pi with this cosine.", {scalar("in", "", "From -1 to 1.")}, "rad", arc<acos>));
  library.add(maths("arc tangent", "The angle of the point (x, y) from the x axis, from -pi to pi.",
                    {scalar("y", "", ""), scalar("x", "", "")}, "rad", [](const Call* c) -> std::int32_t {
                      *output(c, 0) = atan2(*input(c, 0), *input(c, 1));
                      return 0;
                    }));
  library.add(maths("power", "The power in^exponent of a base that is not negative.",
                    {scalar("in", "", "The base."), scalar("exponent", "", "")}, "", power));
  library.add(maths("exponential", "The exponential function of the input.", {scalar("in", "", "")}, "", unary<exp>));
  library.add(maths("logarithm", "The natural logarithm of a positive number.", {scalar("in", "", "")}, "", logarithm));
  library.add(maths("degrees", "Converts an angle from radians to degrees.", {scalar("angle", "rad", "The angle.")}, "deg",
                    [](const Call* c) -> std::int32_t {
                      *output(c, 0) = *input(c, 0) * (180 / pi);
                      return 0;
                    }));
  library.add(maths("radians", "Converts an angle from degrees to radians.", {scalar("angle", "deg", "The angle.")}, "rad",
                    [](const Call* c) -> std::int32_t {
                      *output(c, 0) = *input(c, 0) * (pi / 180);
                      return 0;
                    }));
}

}  // namespace ugoki::lsi
