// FMUs with the interfaces of the Reference-FMUs, run as LSIs. Results are compared with closed forms and independent integrations.

#include <cmath>
#include <cstring>

#include "fmi_test.h"
#include "ugoki/fmi/load.h"
#include "ugoki/fmi/messages.h"

namespace ugoki::fmi {
namespace {

using circuit::Interpreter;

class Import : public FmiTest, public ::testing::WithParamInterface<int> {};
INSTANTIATE_TEST_SUITE_P(Versions, Import, ::testing::Values(2, 3), [](const auto& each) { return "Fmi" + std::to_string(each.param); });

/// Height, m, and velocity, m/s, at time t, s, of a ball dropped from 1 m, computed from successive parabolas. @param g gravity, m/s^2
/// @param e coefficient of restitution
std::pair<double, double> ball(double t, double g, double e) {
  double begin = std::sqrt(2 / g), v = std::sqrt(2 * g);
  if (t < begin) return {1 - g * t * t / 2, -g * t};
  while (true) {
    v *= e;
    if (v < 0.1) return {0, 0};
    const double duration = 2 * v / g;
    if (t < begin + duration) return {v * (t - begin) - g * (t - begin) * (t - begin) / 2, v - g * (t - begin)};
    begin += duration;
  }
}

TEST_P(Import, BouncingBallFollowsItsParabolas) {
  const auto live = library(unit("bouncing_ball", "BouncingBall", GetParam()));
  auto built = build(alone("BouncingBall"), live, 0.01);
  ASSERT_TRUE(built) << built.error().text();
  Interpreter& i = *built;
  EXPECT_EQ(value(i, "u.h"), 1);  // at time 0, before the first tick
  for (int n = 0; n < 300; ++n) {
    const auto [h, v] = ball(0.01 * n, 9.81, 0.7);
    EXPECT_NEAR(value(i, "u.h"), h, 1e-9) << n;
    EXPECT_NEAR(value(i, "u.v"), v, 1e-8) << n;
    ASSERT_TRUE(i.tick()) << i.stopped()->text();
  }
}

TEST_P(Import, ParametersCanBeSetBeforeAndDuringTheRun) {
  const auto live = library(unit("bouncing_ball", "BouncingBall", GetParam()));
  auto moon = build(alone("BouncingBall", R"(, "parameters": {"g": -1.62, "e": 0.9})"), live, 0.01);
  ASSERT_TRUE(moon) << moon.error().text();
  moon->run(150);
  EXPECT_NEAR(value(*moon, "u.h"), ball(1.5, 1.62, 0.9).first, 1e-9);
  // The coefficient of restitution is changed at 0.3 s, before the first bounce at 0.45 s; this bounce is then elastic.
  auto tuned = build(alone("BouncingBall"), live, 0.01);
  tuned->run(30);
  ASSERT_TRUE(tuned->set_parameter("u.e", 1.0));
  tuned->run(60);
  const double g = 9.81, t = 0.9 - std::sqrt(2 / g), v = std::sqrt(2 * g);
  EXPECT_NEAR(value(*tuned, "u.h"), v * t - g * t * t / 2, 1e-9);
  EXPECT_FALSE(tuned->set_parameter("u.g", -1.0));  // the parameter is fixed
  EXPECT_FALSE(tuned->set_parameter("u.e", 0.1));   // the value is out of its range
}

TEST_P(Import, PinsCarryUnitsAndRanges) {
  const auto live = library(unit("bouncing_ball", "BouncingBall", GetParam()));
  const circuit::LsiClass* c = live.library()->find("BouncingBall/BouncingBall");
  ASSERT_NE(c, nullptr);
  ASSERT_EQ(c->outputs.size(), 2u);
  EXPECT_EQ(c->outputs[0].unit, "m");
  EXPECT_EQ(c->outputs[1].unit, "m/s");
  EXPECT_TRUE(c->outputs[0].delayed);
  const circuit::Parameter& e = c->parameters[static_cast<std::size_t>(c->find_parameter("e"))];
  EXPECT_EQ(e.minimum, 0.5);
  EXPECT_EQ(e.maximum, 1);
  EXPECT_TRUE(e.live);
  EXPECT_FALSE(c->parameters[static_cast<std::size_t>(c->find_parameter("g"))].live);
  const circuit::LsiClass* all = live.library()->find("BouncingBall/BouncingBall, all variables");
  ASSERT_NE(all, nullptr);
  EXPECT_EQ(all->outputs.size(), 5u);
}

TEST_P(Import, LocalVariablesAreOutputsOfASecondLsi) {
  const auto live = library(unit("bouncing_ball", "BouncingBall", GetParam()));
  auto i = build(alone("BouncingBall/BouncingBall, all variables"), live, 0.01);
  ASSERT_TRUE(i) << i.error().text();
  i->run(10);
  EXPECT_NEAR(value(*i, "u.der(h)"), -0.981, 1e-12);
  EXPECT_EQ(value(*i, "u.der(v)"), -9.81);
  EXPECT_EQ(value(*i, "u.v_min"), 0.1);
}

/// State of the van der Pol oscillator at time t, s, from (2, 0): fourth-order Runge-Kutta with steps of 1e-4 s.
std::pair<double, double> van_der_pol(double t, double mu) {
  double a = 2, b = 0;
  const int n = static_cast<int>(std::lround(t / 1e-4));
  const double h = t / n;
  const auto f = [&](double x, double y) { return mu * (1 - x * x) * y - x; };
  for (int i = 0; i < n; ++i) {
    const double k1 = b, l1 = f(a, b), k2 = b + h / 2 * l1, l2 = f(a + h / 2 * k1, b + h / 2 * l1), k3 = b + h / 2 * l2,
                 l3 = f(a + h / 2 * k2, b + h / 2 * l2), k4 = b + h * l3, l4 = f(a + h * k3, b + h * l3);
    a += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    b += h / 6 * (l1 + 2 * l2 + 2 * l3 + l4);
  }
  return {a, b};
}

TEST_P(Import, VanDerPolFollowsAnIndependentIntegration) {
  const auto live = library(unit("van_der_pol", "VanDerPol", GetParam()));
  for (const double mu : {1.0, 3.0}) {
    auto i = build(alone("VanDerPol", ", \"parameters\": {\"mu\": " + std::to_string(mu) + "}"), live, 0.01);
    ASSERT_TRUE(i) << i.error().text();
    ASSERT_EQ(i->run(500), 500u);
    const auto [x0, x1] = van_der_pol(5, mu);
    EXPECT_NEAR(value(*i, "u.x0"), x0, 1e-6) << mu;  // error of Heun's method in the FMU, with steps of 1e-4 s
    EXPECT_NEAR(value(*i, "u.x1"), x1, 1e-6) << mu;
  }
}

TEST_P(Import, DahlquistDecays) {
  const auto live = library(unit("dahlquist", "Dahlquist", GetParam()));
  auto i = build(alone("Dahlquist", R"(, "parameters": {"k": 2})"), live, 0.1);
  ASSERT_TRUE(i) << i.error().text();
  for (int n = 0; n <= 20; ++n, i->tick())
    EXPECT_NEAR(value(*i, "u.x"), std::exp(-2 * 0.1 * n), 1e-4) << n;  // error of Euler's method in the FMU
}

TEST_P(Import, EverySetsTheCommunicationStep) {
  const auto live = library(unit("dahlquist", "Dahlquist", GetParam()));
  auto i = build(alone("Dahlquist", R"(, "every": 10)"), live, 0.01);
  ASSERT_TRUE(i) << i.error().text();
  i->run(11);
  const double first = value(*i, "u.x");
  EXPECT_NEAR(first, std::exp(-0.2), 1e-4);  // each run of the LSI (every 10th tick) computes up to the next run
  i->run(9);
  EXPECT_EQ(value(*i, "u.x"), first);  // the output is constant between these runs
}

TEST_P(Import, StairCountsAndEndsTheSimulation) {
  const auto live = library(unit("stair", "Stair", GetParam()));
  auto i = build(alone("Stair", R"(, "parameters": {"logging": true})"), live, 0.2);
  ASSERT_TRUE(i) << i.error().text();
  (void)take_messages();
  for (int n = 0; n < 44; ++n) {
    EXPECT_EQ(value(*i, "u.counter"), 1 + std::floor(0.2 * n + 1e-9)) << n;
    ASSERT_TRUE(i->tick());
  }
  EXPECT_FALSE(i->tick());
  EXPECT_EQ(i->stopped()->tick, 44u);
  EXPECT_EQ(i->stopped()->reason.substr(0, 55), "The FMU requests the end of the simulation at 9.000000 ");
  const std::vector<std::string> messages = take_messages();
  ASSERT_EQ(messages.size(), 1u);
  EXPECT_EQ(messages[0].substr(0, 37), "'u' reports: The last step of the sta");
  // Interpreter::reset calls the reset of the FMU.
  i->reset();
  EXPECT_EQ(value(*i, "u.counter"), 1);
  EXPECT_EQ(i->run(10), 10u);
  EXPECT_EQ(value(*i, "u.counter"), 3);
}

TEST_P(Import, FeedthroughCarriesEveryType) {
  const auto live = library(unit("feedthrough", "Feedthrough", GetParam()));
  const circuit::LsiClass* c = live.library()->find("Feedthrough");
  ASSERT_NE(c, nullptr);
  std::string values;
  const auto wanted = [](const std::string& name) {
    if (name.starts_with("Boolean")) return 1.0;
    if (name.starts_with("Enumeration")) return 2.0;
    if (name.starts_with("Int8")) return -128.0;
    if (name.starts_with("UInt8")) return 255.0;
    if (name.starts_with("Int16")) return -32768.0;
    if (name.starts_with("UInt16")) return 65535.0;
    if (name.starts_with("Int32")) return -2147483648.0;
    if (name.starts_with("UInt32")) return 4294967295.0;
    if (name.starts_with("Int64")) return -9007199254740992.0;
    if (name.starts_with("UInt64")) return 9007199254740992.0;
    if (name.starts_with("Float32")) return 0.375;
    return -1.25e-300;
  };
  for (const circuit::InputPin& pin : c->inputs)
    values += (values.empty() ? "\"" : ", \"") + pin.name + "\": " + [&] {
      char text[40];
      std::snprintf(text, sizeof text, "%.17g", wanted(pin.name));
      return std::string(text);
    }();
  EXPECT_EQ(c->inputs.size(), GetParam() == 2 ? 5u : 14u);
  EXPECT_EQ(c->outputs.size(), GetParam() == 2 ? 5u : 14u);
  auto i = build(alone("Feedthrough", ", \"values\": {" + values + "}"), live, 0.1);
  ASSERT_TRUE(i) << i.error().text();
  for (int n = 0; n < 2; ++n, i->tick())  // values of inputs without wire reach the FMU during the initialisation
    for (const circuit::OutputPin& pin : c->outputs) EXPECT_EQ(value(*i, "u." + pin.name), wanted(pin.name)) << pin.name;
}

TEST_P(Import, WiresParametersAndTextsReachTheFmu) {
  const auto live = library(unit("feedthrough", "Feedthrough", GetParam()));
  auto i = build(
      parse(
          R"({"version": 1, "name": "test", "inputs": [{"name": "x", "type": "scalar", "to": ["u.Float64_continuous_input", "u.Int32_input", "u.Boolean_input"]}],
      "lsis": [{"id": "u", "type": "Feedthrough", "parameters": {"Float64_fixed_parameter": 0.5, "String_parameter": "hello"}}]})"),
      live, 0.1);
  ASSERT_TRUE(i) << i.error().text();
  const double x = 2.6;
  std::memcpy(i->find_circuit_input("x").data(), &x, sizeof x);
  ASSERT_TRUE(i->set_parameter("u.Float64_tunable_parameter", 3));
  i->tick();
  EXPECT_EQ(value(*i, "u.Float64_continuous_output"), 2.6 + 0.5 + 30);
  EXPECT_EQ(value(*i, "u.Float64_discrete_output"), 5000);  // the model returns 1000 times the length of the text
  EXPECT_EQ(value(*i, "u.Int32_output"), 3);                // rounded to the nearest integer
  EXPECT_EQ(value(*i, "u.Boolean_output"), 1);
  const double huge = 3e9;
  std::memcpy(i->find_circuit_input("x").data(), &huge, sizeof huge);
  EXPECT_FALSE(i->tick());
  EXPECT_NE(i->stopped()->reason.find("The input 'Int32_input' has the value 3"), std::string::npos) << i->stopped()->reason;
}

TEST_P(Import, SavedStateIsRestored) {
  for (const bool serializes : {true, false}) {  // without serialisation, saved states are kept inside the FMU
    std::string description = description_of("bouncing_ball", GetParam());
    const std::string can = GetParam() == 2 ? "canSerializeFMUstate=\"true\"" : "canSerializeFMUState=\"true\"";
    ASSERT_NE(description.find(can), std::string::npos);
    if (!serializes) description.erase(description.find(can), can.size());
    const auto live = library(unit("bouncing_ball", "BouncingBall", GetParam(), description));
    auto i = build(alone("BouncingBall"), live, 0.01);
    ASSERT_TRUE(i) << i.error().text();
    i->run(60);
    std::vector<std::byte> saved;
    i->save(saved);
    std::vector<double> once, again;
    for (int n = 0; n < 100; ++n, i->tick()) once.push_back(value(*i, "u.h"));
    ASSERT_TRUE(i->restore(saved));
    for (int n = 0; n < 100; ++n, i->tick()) again.push_back(value(*i, "u.h"));
    EXPECT_EQ(once, again);
    EXPECT_TRUE(take_messages().empty());
    // Only a serialised state can be restored in another instance.
    auto other = build(alone("BouncingBall"), live, 0.01);
    ASSERT_TRUE(other->restore(saved));
    again.clear();
    for (int n = 0; n < 100; ++n, other->tick()) again.push_back(value(*other, "u.h"));
    EXPECT_EQ(once == again, serializes);
    EXPECT_EQ(take_messages().empty(), serializes);
  }
}

TEST_P(Import, WithoutSavedStatesItRestartsWithAMessage) {
  std::string description = description_of("dahlquist", GetParam());
  for (std::string can : {"canGetAndSetFMU", "canSerializeFMU"}) {
    can += GetParam() == 2 ? "state=\"true\"" : "State=\"true\"";
    description.erase(description.find(can), can.size());
  }
  const auto live = library(unit("dahlquist", "Dahlquist", GetParam(), description));
  EXPECT_NE(live.library()->find("Dahlquist")->doc.find("starts from its initial state"), std::string::npos);
  auto i = build(alone("Dahlquist"), live, 0.1);
  i->run(5);
  std::vector<std::byte> saved;
  i->save(saved);
  i->run(5);
  ASSERT_TRUE(i->restore(saved));
  i->tick();
  EXPECT_NEAR(value(*i, "u.x"), std::exp(-0.1), 1e-4);  // one step from its initial state
  const std::vector<std::string> messages = take_messages();
  ASSERT_EQ(messages.size(), 1u);
  EXPECT_NE(messages[0].find("'u' starts from its initial state"), std::string::npos);
}

TEST_P(Import, RecordedInputsAreReplayed) {
  const auto live = library(unit("naughty", "naughty", GetParam()));
  const auto c = parse(
      R"({"version": 1, "name": "test", "inputs": [{"name": "x", "type": "scalar", "to": "u.deed"}], "lsis": [{"id": "u", "type": "naughty"}]})");
  auto first = build(c, live, 0.1);
  ASSERT_TRUE(first) << first.error().text();
  first->start_recording();
  for (int n = 0; n < 20; ++n) {
    const double x = 0.125 * n * -1;
    std::memcpy(first->find_circuit_input("x").data(), &x, sizeof x);
    ASSERT_TRUE(first->tick());
  }
  auto second = build(c, live, 0.1);
  ASSERT_TRUE(second->replay(first->recording()));
  second->run(20);
  EXPECT_EQ(value(*first, "u.body:sum"), -0.125 * 190);
  EXPECT_EQ(value(*second, "u.body:sum"), value(*first, "u.body:sum"));
}

TEST_P(Import, ErrorsOfAnFmuStopTheCircuitWithItsMessage) {
  const auto live = library(unit("naughty", "naughty", GetParam()));
  const auto stop_of = [&](int deed) {
    auto i = build(alone("naughty", ", \"values\": {\"deed\": " + std::to_string(deed) + "}"), live, 0.1);
    EXPECT_TRUE(i) << i.error().text();
    EXPECT_FALSE(i->tick());
    return i->stopped() ? i->stopped()->text() : std::string();
  };
  EXPECT_NE(stop_of(4).find("0.000 s (tick 0): The FMU reports an error in its step: The gear is broken"), std::string::npos);
  EXPECT_NE(stop_of(5).find("(fatal: this instance cannot be used any more): The house is on fire."), std::string::npos);
  const std::string discarded = stop_of(6);
  EXPECT_NE(discarded.find("The FMU cannot compute beyond 0.025000 s"), std::string::npos) << discarded;
  const std::string not_a_number = stop_of(3);
  EXPECT_NE(not_a_number.find("of its output 'out' is not finite"), std::string::npos) << not_a_number;
}

TEST_F(FmiTest, StepThatReturnsEarlyIsContinued) {
  const auto live = library(unit("naughty", "naughty", 3));
  auto i = build(alone("naughty", R"(, "values": {"deed": 8})"), live, 0.1);
  ASSERT_TRUE(i) << i.error().text();
  i->tick();
  EXPECT_EQ(std::fmod(value(*i, "u.body:sum"), 8), 0);
  EXPECT_GT(value(*i, "u.body:sum"), 8);  // several substeps in one step
}

/// Triangle wave between -1 and 1 with this speed, 1/s, starting at 0 upwards.
double triangle_wave(double t, double speed) {
  const double s = std::fmod(t * speed + 1, 4);
  return s <= 2 ? s - 1 : 3 - s;
}

/// Fixture with the model "events" (units/events.h).
class Events : public FmiTest {
 protected:
  plugin::LiveLibrary live_ = library(unit("events", "events", 3));
  /// Sets an input of the circuit.
  static void give(Interpreter& i, const char* input, double x) { std::memcpy(i.find_circuit_input(input).data(), &x, sizeof x); }
  Result<Interpreter> build_wired(double rate) const {
    return build(parse(R"({"version": 1, "name": "test", "inputs": [{"name": "gear", "type": "scalar", "to": "u.gear"},
      {"name": "deed", "type": "scalar", "to": "u.deed"}],
      "lsis": [{"id": "u", "type": "events", "parameters": {"rate": )" +
                       std::to_string(rate) + "}}]}"),
                 live_, 0.1);
  }
};

TEST_F(Events, AreHandledAtTheirTime) {
  auto i = build(alone("events", R"(, "parameters": {"rate": 0.7})"), live_, 0.1);
  ASSERT_TRUE(i) << i.error().text();
  for (int n = 0; n < 80; ++n) {
    const double t = 0.1 * n, quarters = std::floor(t / 0.25 + 1e-9), turns = std::floor((t * 0.7 + 1) / 2);
    EXPECT_NEAR(value(*i, "u.x"), triangle_wave(t, 0.7), 1e-12) << n;
    EXPECT_EQ(value(*i, "u.held"), 0.25 * quarters) << n;
    EXPECT_EQ(value(*i, "u.events"), 1 + quarters + turns) << n;  // each event is counted once; the initialisation is the first
    ASSERT_TRUE(i->tick()) << i->stopped()->text();
  }
}

TEST_F(Events, AreCausedByChangesOfDiscreteInputsAndParameters) {
  auto i = build_wired(0.001);
  ASSERT_TRUE(i) << i.error().text();
  const auto events_of_a_step = [&] {  // call it only for steps without a time event (every 0.25 s)
    const double before = value(*i, "u.events");
    EXPECT_TRUE(i->tick());
    return value(*i, "u.events") - before;
  };
  give(*i, "gear", 1);
  EXPECT_EQ(events_of_a_step(), 1);  // the first values of the inputs cause an event
  EXPECT_EQ(events_of_a_step(), 0);
  i->run(4);
  give(*i, "gear", 3);
  EXPECT_EQ(events_of_a_step(), 1);
  EXPECT_EQ(value(*i, "u.in_use"), 0.003);
  i->run(4);
  ASSERT_TRUE(i->set_parameter("u.rate", 0.002));
  EXPECT_EQ(events_of_a_step(), 1);
  EXPECT_EQ(value(*i, "u.in_use"), 0.006);
}

TEST_F(Events, AreTheSameAfterRestoringAState) {
  auto i = build_wired(0.7), other = build_wired(0.7);
  ASSERT_TRUE(i && other);
  give(*i, "gear", 2);
  i->run(13);
  std::vector<std::byte> saved;
  i->save(saved);
  const auto follow = [&](Interpreter& on) {
    std::vector<double> out;
    for (int n = 0; n < 40; ++n, on.tick()) {
      if (n == 20) give(on, "gear", 1);
      for (const char* pin : {"u.x", "u.held", "u.events", "u.in_use"}) out.push_back(value(on, pin));
    }
    return out;
  };
  const std::vector<double> once = follow(*i);
  ASSERT_TRUE(i->restore(saved));
  give(*i, "gear", 2);
  EXPECT_EQ(follow(*i), once);
  ASSERT_TRUE(other->restore(saved));
  give(*other, "gear", 2);
  EXPECT_EQ(follow(*other), once);
}

TEST_F(Events, ThatFailStopTheCircuitWithAReason) {
  const auto stop_of = [&](int deed) {
    auto i = build_wired(1);
    EXPECT_TRUE(i) << i.error().text();
    give(*i, "gear", 1);
    i->run(1);
    give(*i, "deed", deed);
    i->run(5);
    return i->stopped() ? i->stopped()->text() : std::string();
  };
  EXPECT_NE(stop_of(1).find("cannot handle its event at 0.250000 s: Its events do not end"), std::string::npos) << stop_of(1);
  EXPECT_NE(stop_of(2).find("requests the end of the simulation at 0.250000 s"), std::string::npos) << stop_of(2);
  EXPECT_NE(stop_of(3).find("cannot handle its event at 0.250000 s: The event is too hard"), std::string::npos) << stop_of(3);
}

TEST_F(FmiTest, ArraysAreVectorsOrJointValues) {
  const auto live = library(unit("naughty", "naughty", 3));
  const circuit::LsiClass* c = live.library()->find("naughty");
  ASSERT_NE(c, nullptr);
  EXPECT_EQ(c->inputs[1].type, circuit::PinTypeId::vector);
  EXPECT_EQ(c->outputs[2].type, circuit::PinTypeId::joint_values);
  EXPECT_EQ(c->outputs[2].count, 6u);
  auto i = build(alone("naughty", R"(, "values": {"place": [1, 2, 3]}, "parameters": {"weights[2]": 10})"), live, 0.1);
  ASSERT_TRUE(i) << i.error().text();
  const auto matrix = i->find_output("u.matrix");
  ASSERT_TRUE(matrix);
  const std::vector<double> wanted{1, 2, 3, 10, 20, 30};
  EXPECT_EQ(std::vector<double>(matrix->numbers().begin(), matrix->numbers().end()), wanted);
  ASSERT_TRUE(i->set_parameter("u.weights[1]", 5));
  i->tick();
  EXPECT_EQ(matrix->numbers()[2], 15);
}

TEST_P(Import, InstancesAreIndependent) {
  const auto live = library(unit("dahlquist", "Dahlquist", GetParam()));
  auto i = build(
      parse(
          R"({"version": 1, "name": "test", "lsis": [{"id": "a", "type": "Dahlquist"}, {"id": "b", "type": "Dahlquist", "parameters": {"k": 3}}]})"),
      live, 0.1);
  ASSERT_TRUE(i) << i.error().text();
  i->run(10);
  EXPECT_NEAR(value(*i, "a.x"), std::exp(-1), 1e-4);
  EXPECT_NEAR(value(*i, "b.x"), std::exp(-3), 1e-3);
}

TEST_P(Import, SecondInstanceIsRefusedIfOnlyOneIsAllowed) {
  std::string description = description_of("dahlquist", GetParam());
  description.insert(description.find("modelIdentifier"), "canBeInstantiatedOnlyOncePerProcess=\"true\" ");
  const auto live = library(unit("dahlquist", "Dahlquist", GetParam(), description));
  const auto i = build(
      parse(R"({"version": 1, "name": "test", "lsis": [{"id": "a", "type": "Dahlquist"}, {"id": "b", "type": "Dahlquist"}]})"), live, 0.1);
  ASSERT_FALSE(i);
  EXPECT_NE(i.error().text().find("can have only one instance in a process"), std::string::npos) << i.error().text();
}

TEST_P(Import, WrongTokenIsRefusedWithTheReasonOfTheFmu) {
  std::string description = description_of("dahlquist", GetParam());
  description.replace(description.find("{8c4e810f"), 9, "{8c4e8100");
  const auto live = library(unit("dahlquist", "Dahlquist", GetParam(), description));
  const auto i = build(alone("Dahlquist"), live, 0.1);
  ASSERT_FALSE(i);
  EXPECT_NE(i.error().text().find("The FMU does not start: The name or the "), std::string::npos) << i.error().text();
}

TEST_F(FmiTest, StepsThatAreNoMultipleOfTheInternalStepAreRefused) {
  std::string description = description_of("stair", 3);
  const std::string any = "canHandleVariableCommunicationStepSize=\"true\"";
  description.erase(description.find(any), any.size());
  const auto live = library(unit("stair", "Stair", 3, description));
  EXPECT_TRUE(build(alone("Stair"), live, 0.4));
  const auto i = build(alone("Stair"), live, 0.3);
  ASSERT_FALSE(i);
  EXPECT_NE(i.error().text().find("computes in steps of 0.2 s"), std::string::npos) << i.error().text();
}

TEST_P(Import, TemporaryFoldersAreRemoved) {
  const auto count = [] {
    std::size_t n = 0;
    for (const auto& e : std::filesystem::directory_iterator(std::filesystem::temp_directory_path()))
      n += e.path().filename().string().starts_with("ugoki-fmu-" + std::to_string(::getpid()) + "-");
    return n;
  };
  const std::size_t before = count();
  {
    const auto live = library(unit("dahlquist", "Dahlquist", GetParam()));
    const auto i = build(alone("Dahlquist"), live, 0.1);
    ASSERT_TRUE(i);
    EXPECT_EQ(count(), before + 1);
  }
  EXPECT_EQ(count(), before);
}

}  // namespace
}  // namespace ugoki::fmi
