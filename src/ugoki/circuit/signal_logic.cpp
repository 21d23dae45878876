// Signal LSIs for logic, memory, time, curves and vectors.

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "ugoki/base/number.h"
#include "ugoki/circuit/declare.h"
#include "ugoki/circuit/setup.h"
#include "ugoki/circuit/signal_lsis.h"

namespace ugoki::circuit {
namespace {

StateField field(std::string name, std::uint32_t offset, FieldType type = FieldType::f64) {
  StateField f;
  f.name = std::move(name);
  f.offset = offset;
  f.type = type;
  return f;
}

/// Gives an LSI a state of doubles with these names. The doubles are declared as fields, so that a rebuilt circuit keeps their values.
LsiClass with_state(LsiClass c, std::initializer_list<const char*> names) {
  for (const char* name : names) {
    c.fields.push_back(field(name, static_cast<std::uint32_t>(c.state_bytes)));
    c.state_bytes += sizeof(double);
  }
  return c;
}
double* state(const Call* c) { return static_cast<double*>(c->state); }

template <double (*f)(double)>
std::int32_t unary(const Call* c) {
  *output(c, 0) = f(*input(c, 0));
  return 0;
}
template <double (*f)(double, double)>
std::int32_t binary(const Call* c) {
  *output(c, 0) = f(*input(c, 0), *input(c, 1));
  return 0;
}
double absolute(double x) { return std::fabs(x); }
double sign(double x) { return x > 0 ? 1.0 : x < 0 ? -1.0 : 0.0; }
double rounded(double x) { return std::floor(x + 0.5); }
double negated(double x) { return x > 0 ? 0.0 : 1.0; }
double minimum(double a, double b) { return a < b ? a : b; }
double maximum(double a, double b) { return a > b ? a : b; }
double both(double a, double b) { return a > 0 && b > 0 ? 1.0 : 0.0; }
double either(double a, double b) { return a > 0 || b > 0 ? 1.0 : 0.0; }
double same(double a, double b) { return a == b ? 1.0 : 0.0; }

std::int32_t square_root(const Call* c) {
  const double x = *input(c, 0);
  if (x < 0) return stop(c, "Its input 'in' is negative and has no square root.");
  *output(c, 0) = std::sqrt(x);
  return 0;
}
std::int32_t modulo(const Call* c) {
  const double a = *input(c, 0), b = *input(c, 1);
  if (b == 0) return stop(c, "Its input 'b' is zero.");
  *output(c, 0) = a - b * std::floor(a / b);
  return 0;
}

void add_maths(Library& l) {
  l.add(lsi("absolute", "Absolute value of the input.", {in("in")}, {out("out")}, unary<absolute>));
  l.add(lsi("sign", "Sign of the input: 1, 0 or -1.", {in("in")}, {out("out")}, unary<sign>));
  l.add(lsi("round", "Nearest integer; halves are rounded up.", {in("in")}, {out("out")}, unary<rounded>));
  l.add(lsi("square root", "Square root of the input; a negative input stops the circuit.", {in("in")}, {out("out")}, square_root));
  l.add(lsi("minimum", "The smaller of two numbers.", {in("a"), in("b")}, {out("out")}, binary<minimum>));
  l.add(lsi("maximum", "The larger of two numbers.", {in("a"), in("b")}, {out("out")}, binary<maximum>));
  l.add(lsi("modulo", "Remainder of a / b, with the sign of b: a - b floor(a / b). If b is zero, the circuit stops.", {in("a"), in("b")},
            {out("out")}, modulo));
  l.add(lsi("and", "1 if both inputs are above zero, otherwise 0.", {in("a"), in("b")}, {out("out")}, binary<both>));
  l.add(lsi("or", "1 if at least one input is above zero, otherwise 0.", {in("a"), in("b")}, {out("out")}, binary<either>));
  l.add(lsi("not", "1 if the input is not above zero, otherwise 0.", {in("in")}, {out("out")}, unary<negated>));
  l.add(lsi("equal", "1 if both numbers are exactly equal, otherwise 0.", {in("a"), in("b")}, {out("out")}, binary<same>));
}

void add_memory(Library& l) {
  LsiClass hold =
      with_state(lsi("hold", "Holds the last value that `in` had while `when` was above zero.", {in("in"), in("when")}, {out("out")},
                     [](const Call* c) -> std::int32_t {
                       if (*input(c, 1) > 0) *state(c) = *input(c, 0);
                       *output(c, 0) = *state(c);
                       return 0;
                     }),
                 {"held"});
  hold.parameters = {number("initial", 0, "Value until `when` is above zero for the first time.")};
  hold.init = [](const Call* c) -> std::int32_t {
    *state(c) = c->parameters[0];
    return 0;
  };
  l.add(std::move(hold));

  l.add(with_state(lsi("edge", "1 in the tick in which the input rises above zero, otherwise 0.", {in("in")}, {out("out")},
                       [](const Call* c) -> std::int32_t {
                         const double on = *input(c, 0) > 0 ? 1.0 : 0.0;
                         *output(c, 0) = on > *state(c) ? 1.0 : 0.0;
                         *state(c) = on;
                         return 0;
                       }),
                   {"was on"}));

  LsiClass counter = with_state(lsi("counter", "Counts how often the input rises above zero; `reset` above zero sets the count to 0.",
                                    {in("in"), optional("reset")}, {out("out")},
                                    [](const Call* c) -> std::int32_t {
                                      double* s = state(c);
                                      const double on = *input(c, 0) > 0 ? 1.0 : 0.0;
                                      if (on > s[1]) s[0] += 1;
                                      if (*input(c, 1) > 0) s[0] = 0;
                                      s[1] = on;
                                      *output(c, 0) = s[0];
                                      return 0;
                                    }),
                                {"count", "was on"});
  l.add(std::move(counter));

  LsiClass hysteresis =
      with_state(lsi("hysteresis", "1 (on) above `high`, 0 (off) below `low`; between them it keeps its state.", {in("in")}, {out("out")},
                     [](const Call* c) -> std::int32_t {
                       const double x = *input(c, 0);
                       if (x > c->parameters[1]) *state(c) = 1;
                       if (x < c->parameters[0]) *state(c) = 0;
                       *output(c, 0) = *state(c);
                       return 0;
                     }),
                 {"on"});
  hysteresis.parameters = {number("low", -1, "Switches off below this value."), number("high", 1, "Switches on above this value.")};
  l.add(std::move(hysteresis));

  l.add(with_state(lsi("derivative", "Rate of change of the input per second, from the previous tick to this one; 0 at the first tick.",
                       {in("in", PinTypeId::scalar)}, {out("out")},
                       [](const Call* c) -> std::int32_t {
                         double* s = state(c);
                         const double x = *input(c, 0);
                         *output(c, 0) = s[1] > 0 ? (x - s[0]) / c->tick->dt : 0.0;
                         s[0] = x;
                         s[1] = 1;
                         return 0;
                       }),
                   {"last", "has last"}));

  LsiClass limit = with_state(lsi("rate limit", "Follows its input, but changes by at most `rate` per second.", {in("in")}, {out("out")},
                                  [](const Call* c) -> std::int32_t {
                                    double* s = state(c);
                                    const double maximum = c->parameters[0] * c->tick->dt, change = *input(c, 0) - *s;
                                    *s += change > maximum ? maximum : change < -maximum ? -maximum : change;
                                    *output(c, 0) = *s;
                                    return 0;
                                  }),
                              {"value"});
  limit.parameters = {number("rate", 1, "Maximum change per second.", 0, 1e300, "1/s"), number("initial", 0, "Value at the start.")};
  limit.init = [](const Call* c) -> std::int32_t {
    *state(c) = c->parameters[1];
    return 0;
  };
  l.add(std::move(limit));

  LsiClass high = with_state(
      lsi("high-pass", "First-order high-pass filter: passes changes of its input and removes constant values.", {in("in")}, {out("out")},
          [](const Call* c) -> std::int32_t {
            const double x = *input(c, 0), share = c->tick->dt / (c->parameters[0] + c->tick->dt);
            *state(c) += (x - *state(c)) * share;
            *output(c, 0) = x - *state(c);
            return 0;
          }),
      {"slow part"});
  high.parameters = {number("time", 0.1, "Time constant of the filter.", 0, 1e6, "s")};
  l.add(std::move(high));
}

void add_time(Library& l) {
  LsiClass timer = with_state(lsi("timer", "Seconds during which `run` was above zero; `reset` above zero sets the time to 0.",
                                  {optional("run", 1), optional("reset")}, {out("time"), out("done")},
                                  [](const Call* c) -> std::int32_t {
                                    if (*input(c, 1) > 0) *state(c) = 0;
                                    *output(c, 0) = *state(c);
                                    *output(c, 1) = *state(c) >= c->parameters[0] ? 1.0 : 0.0;
                                    if (*input(c, 0) > 0) *state(c) += c->tick->dt;
                                    return 0;
                                  }),
                              {"time"});
  timer.parameters = {number("duration", 1, "`done` is 1 from this time on.", 0, 1e9, "s")};
  l.add(std::move(timer));

  LsiClass pulse =
      lsi("pulse", "1 during the first part of each period, otherwise 0.", {}, {out("out")}, [](const Call* c) -> std::int32_t {
        const double period = c->parameters[0], phase = c->tick->time + c->parameters[2];
        const double within = phase - period * std::floor(phase / period);
        *output(c, 0) = within < c->parameters[1] * period ? 1.0 : 0.0;
        return 0;
      });
  pulse.parameters = {number("period", 1, "Time from the start of one pulse to the start of the next.", 1e-6, 1e9, "s"),
                      number("share", 0.5, "Fraction of the period during which the output is 1.", 0, 1),
                      number("ahead", 0, "Time in the first period at which the circuit starts.", -1e9, 1e9, "s")};
  l.add(std::move(pulse));

  // Generator: xorshift64* (Vigna, 2016, An experimental exploration of Marsaglia's xorshift generators, scrambled).
  LsiClass noise = lsi("noise", "A random number at each tick; the same seed gives the same sequence.", {}, {out("out")},
                       [](const Call* c) -> std::int32_t {
                         auto& s = *static_cast<std::uint64_t*>(c->state);
                         const auto next = [&s] {
                           s ^= s >> 12;
                           s ^= s << 25;
                           s ^= s >> 27;
                           return static_cast<double>((s * 0x2545f4914f6cdd1dULL) >> 11) * 0x1p-53;
                         };
                         double x = next();
                         if (c->parameters[1] > 0) {  // normal: the sum of 12 uniform numbers from 0 to 1 has mean 6 and variance 1
                           for (int i = 0; i < 11; ++i) x += next();
                           x -= 6;
                         } else {
                           x = 2 * x - 1;
                         }
                         *output(c, 0) = c->parameters[2] * x;
                         return 0;
                       });
  Parameter shape;
  shape.name = "shape";
  shape.kind = ParameterKind::choice;
  shape.choices = {"even", "normal"};
  shape.initial = std::string("even");
  shape.doc = "even: uniformly distributed from -1 to 1; normal: approximately normal with mean 0 and variance 1.";
  Parameter seed = number("seed", 1, "A different seed gives a different sequence.", 0, 1e15);
  seed.kind = ParameterKind::integer;
  seed.live = false;
  noise.parameters = {seed, shape, number("size", 1, "Factor on the random numbers.")};
  noise.fields = {field("position", 0, FieldType::u64)};
  noise.state_bytes = sizeof(std::uint64_t);
  noise.init = [](const Call* c) -> std::int32_t {
    // splitmix64, so that neighbouring seeds give uncorrelated sequences; the state of xorshift must not be 0
    std::uint64_t z = static_cast<std::uint64_t>(c->parameters[0]) + 0x9e3779b97f4a7c15ULL;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    *static_cast<std::uint64_t*>(c->state) = (z ^ (z >> 31)) | 1;
    return 0;
  };
  l.add(std::move(noise));
}

struct CurvePoint {
  double x, y;
};

/// Reads points "x:y" such as "0:0, 0.5:2, 1:0". Returns false if the text has another form or x does not strictly increase.
bool read_points(const std::string& text, std::vector<CurvePoint>& points) {
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find(',', at), text.size());
    std::string part = text.substr(at, end - at);
    std::erase(part, ' ');
    const auto colon = part.find(':');
    if (colon == std::string::npos) return false;
    const auto x = parse_double(std::string_view(part).substr(0, colon)), y = parse_double(std::string_view(part).substr(colon + 1));
    if (!x || !y || (!points.empty() && *x <= points.back().x)) return false;
    points.push_back({*x, *y});
    at = end + 1;
  }
  return !points.empty();
}

void add_curve(Library& l) {
  LsiClass curve = lsi("curve", "A piecewise linear function through the given points; constant before the first point and after the last.",
                       {in("in")}, {out("out")}, [](const Call* c) -> std::int32_t {
                         const auto& p = *static_cast<const std::vector<CurvePoint>*>(c->object);
                         const double x = *input(c, 0);
                         const auto after = std::upper_bound(p.begin(), p.end(), x, [](double v, const CurvePoint& q) { return v < q.x; });
                         if (after == p.begin() || after == p.end()) {
                           *output(c, 0) = after == p.begin() ? p.front().y : p.back().y;
                           return 0;
                         }
                         const CurvePoint &a = *(after - 1), &b = *after;
                         *output(c, 0) = a.y + (b.y - a.y) * ((x - a.x) / (b.x - a.x));
                         return 0;
                       });
  Parameter points;
  points.name = "points";
  points.kind = ParameterKind::text;
  points.initial = std::string("0:0, 1:1");
  points.doc = "Points x:y, x:y, ... with increasing x.";
  points.live = false;
  curve.parameters = {points};
  curve.make = [](Setup& s) -> void* {
    auto p = std::make_unique<std::vector<CurvePoint>>();
    if (read_points(s.text("points"), *p)) return p.release();
    s.fail(ErrorCode::syntax, "'" + s.text("points") + "' is not a list of points.",
           "Write the parameter 'points' as 0:0, 0.5:2, 1:0 with increasing x (the first number of each point).");
    return nullptr;
  };
  curve.destroy = [](void* p) { delete static_cast<std::vector<CurvePoint>*>(p); };
  l.add(std::move(curve));
}

std::int32_t cross(const Call* c) {
  const double *a = input(c, 0), *b = input(c, 1);
  for (std::size_t i = 0; i < 3; ++i) output(c, 0)[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
  return 0;
}
double dot_of(const double* a, const double* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

void add_vectors(Library& l) {
  constexpr PinTypeId vector = PinTypeId::vector;
  l.add(lsi("subtract vectors", "a - b.", {in("a", vector), in("b", vector)}, {out("out", vector)}, [](const Call* c) -> std::int32_t {
    for (std::size_t i = 0; i < 3; ++i) output(c, 0)[i] = input(c, 0)[i] - input(c, 1)[i];
    return 0;
  }));
  l.add(
      lsi("dot product", "Scalar product of a and b.", {in("a", vector), in("b", vector)}, {out("out")}, [](const Call* c) -> std::int32_t {
        *output(c, 0) = dot_of(input(c, 0), input(c, 1));
        return 0;
      }));
  l.add(lsi("cross product", "Vector product a x b, perpendicular to both inputs.", {in("a", vector), in("b", vector)},
            {out("out", vector)}, cross));
  l.add(lsi("length", "Length of a vector.", {in("in", vector)}, {out("out")}, [](const Call* c) -> std::int32_t {
    *output(c, 0) = std::sqrt(dot_of(input(c, 0), input(c, 0)));
    return 0;
  }));
  l.add(lsi("direction", "Unit vector in the direction of the input; an input of length 0 stops the circuit.", {in("in", vector)},
            {out("out", vector)}, [](const Call* c) -> std::int32_t {
              const double size = std::sqrt(dot_of(input(c, 0), input(c, 0)));
              if (!(size > 0)) return stop(c, "Its input 'in' has length 0 and therefore no direction.");
              for (std::size_t i = 0; i < 3; ++i) output(c, 0)[i] = input(c, 0)[i] / size;
              return 0;
            }));
}

}  // namespace

void add_logic_lsis(Library& library) {
  add_maths(library);
  add_memory(library);
  add_time(library);
  add_curve(library);
  add_vectors(library);
}

}  // namespace ugoki::circuit
