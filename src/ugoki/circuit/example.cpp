#include "ugoki/circuit/example.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "ugoki/base/number.h"
#include "ugoki/circuit/interpreter.h"
#include "ugoki/json/fields.h"

namespace ugoki::circuit {
namespace {

using json::Json;

constexpr std::uint64_t max_ticks = 100'000'000;

ExampleMoment read_moment(const Json& json, const std::string& location, Error& problems) {
  ExampleMoment m;
  json::Fields f(json, location, problems);
  double tick = 0;
  for (const char* field : {"tick", "pin", "value"}) f.require(field, "see docs/lsi.md");
  f.number("tick", tick);
  f.text("pin", m.pin);
  if (const Json* value = f.find("value")) {
    m.numbers.resize(value->is_array() ? value->size() : 1);
    if (value->is_array())
      f.numbers("value", m.numbers);
    else
      f.number("value", m.numbers[0]);
  }
  f.number("tolerance", m.tolerance);
  f.refuse_others();
  if (!(tick >= 0 && tick <= static_cast<double>(max_ticks) && std::floor(tick) == tick))
    f.report(ErrorCode::range, f.path("tick"), "A tick is an integer from 0 to 100000000.", "Count ticks from 0.");
  else
    m.tick = static_cast<std::uint64_t>(tick);
  if (!(m.tolerance >= 0)) f.report(ErrorCode::range, f.path("tolerance"), "The tolerance is negative.", "Give a number from 0.");
  return m;
}

std::string text_of(std::span<const double> numbers) {
  std::string out;
  for (const double x : numbers) out += (out.empty() ? "" : ", ") + to_text(x);
  return numbers.size() == 1 ? out : "[" + out + "]";
}

Result<void> give(Interpreter& interpreter, const ExampleMoment& m, const std::string& location) {
  std::span<std::byte> input = interpreter.find_circuit_input(m.pin);
  for (const DeviceSlot& d : interpreter.devices())
    if (d.id + "." + d.pin == m.pin) input = std::as_writable_bytes(d.numbers);
  if (input.empty() && m.numbers.size() == 1) return interpreter.set_parameter(m.pin, m.numbers[0]);
  if (input.size() != m.numbers.size() * sizeof(double))
    return fail(ErrorCode::structure, location,
                "'" + m.pin + "' is not an input, device pin or parameter of " + std::to_string(m.numbers.size()) + " numbers.",
                "Name an input of the circuit, a pin of a device or a parameter, and give as many numbers as it has.");
  if (!input.empty()) std::memcpy(input.data(), m.numbers.data(), input.size());
  return {};
}

void compare(const Interpreter& interpreter, const ExampleMoment& m, const std::string& location, Error& problems) {
  const Result<PinView> view = interpreter.find_output(m.pin);
  if (!view) {
    problems.add(ErrorCode::unknown, location, "The circuit has no output '" + m.pin + "'.", "Write it as \"id.pin\".");
    return;
  }
  const std::span<const double> got = view->numbers();
  bool same = got.size() == m.numbers.size();
  for (std::size_t i = 0; same && i < got.size(); ++i) same = std::abs(got[i] - m.numbers[i]) <= m.tolerance;
  if (same) return;
  problems.add(ErrorCode::range, location,
               "After tick " + std::to_string(m.tick) + " '" + m.pin + "' is " + text_of(got) + "; expected " + text_of(m.numbers) + ".",
               "Correct the LSI or the expected value.");
}

}  // namespace

Result<Example> read_example(std::string_view text, std::string_view location) {
  const Result<Json> json = json::parse_json(text, location);
  if (!json) return fail(json.error());
  Error problems;
  Example out;
  json::Fields f(*json, std::string(location) + ":", problems);
  f.require("circuit", "a circuit of docs/circuit.md");
  f.text("doc", out.doc);
  f.number("dt", out.dt);
  for (const bool given : {true, false}) {
    const char* key = given ? "given" : "expect";
    if (const Json* list = f.list(key, 100'000, "moments"))
      for (std::size_t i = 0; i < list->size(); ++i)
        (given ? out.given : out.expected).push_back(read_moment((*list)[i], f.path(key) + "/" + std::to_string(i), problems));
  }
  if (const Json* circuit = f.find("circuit")) {
    Result<Circuit> read = read_circuit(json::to_text(*circuit), f.path("circuit"));
    if (read)
      out.circuit = std::move(*read);
    else
      problems.problems.insert(problems.problems.end(), read.error().problems.begin(), read.error().problems.end());
  }
  f.refuse_others();
  if (!problems.empty()) return fail(std::move(problems));
  return out;
}

Result<void> check_example(const Example& example, const Library& library, std::string_view location, const Resources* resources,
                           Activity* activity) {
  Result<Interpreter> interpreter =
      Interpreter::build(example.circuit, library, resources, {.dt = example.dt, .check_finite = true, .activity = activity});
  if (!interpreter) return fail(std::move(interpreter.error()));
  std::uint64_t last = 0;
  for (const ExampleMoment& m : example.expected) last = std::max(last, m.tick);
  Error problems;
  const auto at = [&](const char* key, std::size_t i) { return std::string(location) + ": " + key + "/" + std::to_string(i); };
  for (std::uint64_t tick = 0; tick <= last && problems.empty(); ++tick) {
    for (std::size_t i = 0; i < example.given.size(); ++i)
      if (example.given[i].tick == tick)
        if (Result<void> done = give(*interpreter, example.given[i], at("given", i)); !done) return done;
    if (!interpreter->tick())
      return fail(ErrorCode::structure, std::string(location), interpreter->stopped()->text(), "Correct the LSI or the circuit.");
    for (std::size_t i = 0; i < example.expected.size(); ++i)
      if (example.expected[i].tick == tick) compare(*interpreter, example.expected[i], at("expect", i), problems);
  }
  if (!problems.empty()) return fail(std::move(problems));
  return {};
}

}  // namespace ugoki::circuit
