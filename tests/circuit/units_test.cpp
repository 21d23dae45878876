// Dimensions of units, and warnings about wires between pins of different dimensions.

#include "ugoki/circuit/units.h"

#include "circuit_test.h"

namespace ugoki::circuit {
namespace {

using Dimensions = std::vector<Dimension>;

TEST(Units, DimensionsAreRead) {
  const Dimension none{}, m{1}, speed{1, 0, -1}, force{1, 1, -2}, torque{2, 1, -2}, rate{0, 0, -1}, acceleration{1, 0, -2};
  const std::pair<const char*, Dimensions> cases[] = {
      {"m", {m}},
      {"mm", {m}},
      {"km", {m}},
      {"kg", {{0, 1}}},
      {"g", {{0, 1}}},
      {"s", {{0, 0, 1}}},
      {"ms", {{0, 0, 1}}},
      {"1", {none}},
      {"rad", {none}},
      {"deg", {none}},
      {"degrees", {none}},
      {"°", {none}},
      {"1/s", {rate}},
      {"rad/s", {rate}},
      {"Hz", {rate}},
      {"m/s", {speed}},
      {"m / s", {speed}},
      {"m s^-1", {speed}},
      {"m.s-1", {speed}},
      {"m/s^2", {acceleration}},
      {"m/s2", {acceleration}},
      {"m/s²", {acceleration}},
      {"m/s/s", {acceleration}},
      {"m/(s s)", {acceleration}},
      {"N", {force}},
      {"kg m/s^2", {force}},
      {"kg*m/s^2", {force}},
      {"kg·m/s²", {force}},
      {"N m", {torque}},
      {"Nm", {torque}},
      {"J", {torque}},
      {"N m s", {{2, 1, -1}}},
      {"kg m^2", {{2, 1}}},
      {"N/m", {{0, 1, -2}}},
      {"W", {{2, 1, -3}}},
      {"kW", {{2, 1, -3}}},
      {"m | rad", {m, none}},
      {"m/s | rad/s", {speed, rate}},
      {"N m, N", {torque, force}},
      {"1, 1/s, 1/s^2", {none, rate, {0, 0, -2}}},
  };
  for (const auto& [text, expected] : cases) {
    const auto got = read_dimensions(text);
    ASSERT_TRUE(got) << text;
    EXPECT_EQ(*got, expected) << text;
  }
  for (const char* unknown :
       {"", " ", "body weights", "furlong", "m/", "/s", "m^", "m^x", "m^1000", "m)", "(m", "m | ", "-", "^2", "N m furlong"})
    EXPECT_FALSE(read_dimensions(unknown)) << unknown;
  EXPECT_FALSE(read_dimensions(std::string(100'000, '(')));
  EXPECT_FALSE(read_dimensions("m^99999999999999999999"));
}

TEST(Units, UnitsFitIfTheyShareADimensionOrOneIsDimensionlessOrUnknown) {
  for (const auto& [a, b] : std::vector<std::pair<const char*, const char*>>{{"m", "mm"},
                                                                             {"m", "m | rad"},
                                                                             {"N m", "J"},
                                                                             {"rad/s", "1/s"},
                                                                             {"rad", "deg"},
                                                                             {"m", ""},
                                                                             {"rad", "kg"},
                                                                             {"1", "s"},
                                                                             {"body weights", "N"}}) {
    EXPECT_TRUE(fit(a, b)) << a << " " << b;
    EXPECT_TRUE(fit(b, a)) << a << " " << b;
  }
  for (const auto& [a, b] : std::vector<std::pair<const char*, const char*>>{
           {"m", "kg"}, {"m/s", "m"}, {"m | rad", "kg"}, {"m | rad", "rad/s"}, {"N", "N m"}, {"s", "1/s"}}) {
    EXPECT_FALSE(fit(a, b)) << a << " " << b;
    EXPECT_FALSE(fit(b, a)) << a << " " << b;
  }
}

TEST(Units, WiresOfDifferentDimensionsAreWarnedAboutAndRun) {
  Library library;
  const auto add = [&](const char* name, const char* in, const char* out) {
    LsiClass c;
    c.name = name;
    c.inputs.resize(1);
    c.inputs[0].name = "in";
    c.inputs[0].unit = in;
    c.outputs.resize(1);
    c.outputs[0].name = "out";
    c.outputs[0].unit = out;
    c.step = [](const Call*) { return std::int32_t{0}; };
    library.add(std::move(c));
  };
  add("ruler", "m", "m");
  add("scales", "kg", "kg");
  add("gain", "", "");
  const Circuit circuit = parse(R"({"version": 2, "name": "units",
    "inputs": [{"name": "time", "type": "scalar", "unit": "s", "to": "first.in"}],
    "outputs": [{"name": "mass", "type": "scalar", "unit": "kg", "from": "second.out"}, {"name": "speed", "type": "scalar", "unit": "m/s", "from": "first.out"}],
    "lsis": [{"id": "first", "type": "ruler"}, {"id": "plain", "type": "gain"}, {"id": "second", "type": "scales"}, {"id": "third", "type": "scales"}],
    "wires": [{"from": "first.out", "to": "second.in"}, {"from": "first.out", "to": "plain.in"}, {"from": "plain.out", "to": "third.in"}]})");
  const std::vector<Problem> found = check_units(circuit, library);
  ASSERT_EQ(found.size(), 3u);
  EXPECT_EQ(found[0].location, "circuit/lsis/0");
  EXPECT_EQ(found[0].message, "'time' is in s, but 'first.in' is in m.");
  EXPECT_EQ(found[1].location, "circuit/lsis/2");
  EXPECT_EQ(found[1].message, "'first.out' is in m, but 'second.in' is in kg.");
  EXPECT_EQ(found[2].location, "circuit/outputs/1");
  auto i = Interpreter::build(circuit, library, nullptr, {.dt = 0.01});
  ASSERT_TRUE(i) << i.error().text();
  EXPECT_TRUE(i->tick());
}

}  // namespace
}  // namespace ugoki::circuit
