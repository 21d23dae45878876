// Circuits exported as FMUs: checked by an independent program (check_fmu.py, checker.c), and imported again.

#include <cmath>
#include <cstring>
#include <random>

#include "fmi_test.h"
#include "ugoki/fmi/export.h"
#include "ugoki/fmi/load.h"
#include "ugoki/json/json.h"
#include "ugoki/lsi/standard_library.h"
#include "ugoki/plugin/run_program.h"

namespace ugoki::fmi {
namespace {

using circuit::Interpreter;

/// A driven pendulum of two integrators: has inputs, delayed and feed-through outputs, and parameters of several kinds.
constexpr const char* pendulum = R"({"version": 1, "name": "driven pendulum", "doc": "Swings, and can be pushed.",
  "inputs": [{"name": "push", "type": "scalar", "unit": "rad/s^2", "to": "acceleration.a"}, {"name": "gate", "type": "scalar", "to": "gated.condition"}],
  "outputs": [{"name": "angle", "type": "scalar", "unit": "rad", "from": "angle.out"}, {"name": "speed", "type": "scalar", "from": "speed.out"},
              {"name": "pull", "type": "scalar", "from": "acceleration.out"}, {"name": "shown", "type": "scalar", "from": "gated.out"},
              {"name": "slow", "type": "scalar", "from": "slow.out"}],
  "parameters": [{"name": "stiffness", "doc": "How strongly it is drawn back.", "to": "pull.gain"}, {"name": "begin", "to": "angle.initial"},
                 {"name": "shape", "to": "noise.shape"}],
  "lsis": [{"id": "angle", "type": "integrator", "parameters": {"initial": 0.5}}, {"id": "speed", "type": "integrator"},
           {"id": "pull", "type": "gain", "parameters": {"gain": -9.81}}, {"id": "noise", "type": "noise", "parameters": {"seed": 3, "size": 0.01}},
           {"id": "acceleration", "type": "add"}, {"id": "sum", "type": "add"}, {"id": "gated", "type": "switch"},
           {"id": "slow", "type": "low-pass", "every": 4, "parameters": {"time": 0.1}}],
  "wires": [{"from": "speed.out", "to": "angle.in"}, {"from": "sum.out", "to": "speed.in"}, {"from": "angle.out", "to": "pull.in"},
            {"from": "pull.out", "to": "acceleration.b"}, {"from": "acceleration.out", "to": "sum.a"}, {"from": "noise.out", "to": "sum.b"},
            {"from": "angle.out", "to": "gated.on"}, {"from": "speed.out", "to": "gated.off"}, {"from": "angle.out", "to": "slow.in"}]})";

/// Pins and parameters of many types: vectors, a rotation, a nested circuit, a device, a text, an integer, a choice, and an event, which
/// cannot be a variable.
constexpr const char* mixed = R"({"version": 1, "name": "2 mixed / pins", "doc": "<&\"'>",
  "inputs": [{"name": "place", "type": "vector", "to": ["moved.a", "far.in"]}, {"name": "turn", "type": "rotation", "to": "turned.in"},
             {"name": "knock", "type": "event", "to": "hit.in"}, {"name": "time", "type": "scalar", "to": "curve.in"}],
  "outputs": [{"name": "place", "type": "vector", "from": "moved.out"}, {"name": "turn", "type": "rotation", "from": "turned.out"},
              {"name": "far", "type": "scalar", "from": "far.out"}, {"name": "knock", "type": "event", "from": "hit.out"},
              {"name": "curve", "type": "scalar", "from": "curve.out"}, {"name": "count", "type": "scalar", "from": "box.count"},
              {"name": "key", "type": "scalar", "from": "key.pressed"}],
  "parameters": [{"name": "points", "to": "curve.points"}, {"name": "seed", "to": "box.seed"}, {"name": "shape", "to": "box.shape"}],
  "lsis": [{"id": "offset", "type": "make vector", "values": {"x": 1, "y": 2, "z": 3}}, {"id": "moved", "type": "add vectors"},
           {"id": "turned", "type": "delay rotation"}, {"id": "hit", "type": "delay event"}, {"id": "far", "type": "length"},
           {"id": "curve", "type": "curve", "parameters": {"points": "0:0, 1:2"}}, {"id": "box", "type": "box"}, {"id": "key", "type": "keyboard", "parameters": {"key": "Space"}}],
  "wires": [{"from": "offset.out", "to": "moved.b"}],
  "circuits": [{"name": "box", "outputs": [{"name": "count", "type": "scalar", "from": "sum.out"}],
     "parameters": [{"name": "seed", "to": "noise.seed"}, {"name": "shape", "to": "noise.shape"}],
     "lsis": [{"id": "noise", "type": "noise", "parameters": {"seed": 7}}, {"id": "last", "type": "delay"}, {"id": "sum", "type": "add"}],
     "wires": [{"from": "noise.out", "to": "sum.a"}, {"from": "sum.out", "to": "last.in"}, {"from": "last.out", "to": "sum.b"}]}]})";

class Export : public FmiTest, public ::testing::WithParamInterface<int> {
 protected:
  void SetUp() override {
    FmiTest::SetUp();
    signal_binary_ = text_of(UGOKI_FMU_BINARY);
    full_binary_ = text_of(UGOKI_FMU_FULL_BINARY);
  }
  Result<Exported> try_export(const circuit::Circuit& c, double dt) const {
    return export_fmu(c, lsi::standard_library(), {},
                      {.version = GetParam(), .dt = dt, .signal_binary = signal_binary_, .full_binary = full_binary_});
  }
  /// @return path of the exported FMU
  std::string exported(const std::string& circuit, double dt) const {
    const Result<Exported> out = try_export(parse(circuit), dt);
    EXPECT_TRUE(out) << (out ? "" : out.error().text());
    return out ? write(out->identifier + ".fmu", out->bytes) : "";
  }
  /// Runs the independent check.
  static void check(const std::string& fmu) {
    const auto ran =
        plugin::run_program({"/usr/bin/python3", std::string(UGOKI_SOURCE_DIR) + "/tests/fmi/check_fmu.py", UGOKI_FMI_CHECKER, fmu},
                            {std::chrono::seconds(60)});
    ASSERT_TRUE(ran);
    EXPECT_EQ(ran->status, 0) << ran->out << ran->err;
    EXPECT_NE(ran->out.find(", 0 wrong"), std::string::npos) << ran->out;
  }
  std::string signal_binary_, full_binary_;
};
INSTANTIATE_TEST_SUITE_P(Versions, Export, ::testing::Values(2, 3), [](const auto& each) { return "Fmi" + std::to_string(each.param); });

class ExampleExport : public Export {};
INSTANTIATE_TEST_SUITE_P(Slow_Versions, ExampleExport, ::testing::Values(2, 3),
                         [](const auto& each) { return "Fmi" + std::to_string(each.param); });

TEST_P(Export, PassesAnIndependentCheckOfTheStandard) {
  check(exported(pendulum, 0.01));
  check(exported(mixed, 0.002));
  check(exported(R"({"version": 1, "name": "", "lsis": []})", 0.5));
}

/// Exports the example circuits of every signal LSI.
TEST_P(ExampleExport, PassesAnIndependentCheckOfTheStandard) {
  int count = 0;
  for (const auto& e : std::filesystem::directory_iterator(std::string(UGOKI_SOURCE_DIR) + "/examples/lsi")) {
    if (!e.is_regular_file()) continue;
    SCOPED_TRACE(e.path().filename().string());
    const auto example = json::parse_json(text_of(e.path().string()), "example");
    if (!example) continue;
    const circuit::Circuit own = parse(json::to_text((*example)["circuit"]));
    auto runs = Interpreter::build(own, lsi::standard_library(), nullptr, {.dt = 0.01});
    if (!runs || !runs->tick()) continue;  // stops at its first tick, for example a division by the input, which is 0
    check(exported(json::to_text((*example)["circuit"]), 0.01));
    ++count;
  }
  EXPECT_GT(count, 50);
}

TEST_P(Export, ImportedAgainGivesTheSameBits) {
  const std::string fmu = exported(pendulum, 0.01);
  const auto live = library(fmu);
  auto own = Interpreter::build(parse(pendulum), lsi::standard_library(), nullptr, {.dt = 0.01});
  auto other = build(
      parse(
          R"({"version": 1, "name": "test", "inputs": [{"name": "push", "type": "scalar", "to": "u.push"}, {"name": "gate", "type": "scalar", "to": "u.gate"}],
      "lsis": [{"id": "u", "type": "driven_pendulum"}]})"),
      live, 0.01);
  ASSERT_TRUE(own) << own.error().text();
  ASSERT_TRUE(other) << other.error().text();
  const std::vector<std::string> pins{"angle.out", "speed.out", "acceleration.out", "gated.out", "slow.out"};
  const std::vector<std::string> names{"u.angle", "u.speed", "u.pull", "u.shown", "u.slow"};
  ASSERT_TRUE(own->set_probes(pins, 1));
  std::mt19937 random(5);
  double push = 0, gate = 0;
  for (int n = 0; n < 500; ++n) {
    // Inputs change at every 10th tick. In that tick a feed-through output of the imported FMU still shows the old input, because
    // co-simulation passes inputs with the next step.
    const bool changes = n % 10 == 0 && n > 0;
    if (changes) {
      push = static_cast<double>(random() % 100) * 0.01;
      gate = static_cast<double>(random() % 2);
    }
    std::memcpy(own->find_circuit_input("push").data(), &push, sizeof push);
    std::memcpy(own->find_circuit_input("gate").data(), &gate, sizeof gate);
    std::memcpy(other->find_circuit_input("push").data(), &push, sizeof push);
    std::memcpy(other->find_circuit_input("gate").data(), &gate, sizeof gate);
    std::vector<double> shown;
    for (const std::string& name : names) shown.push_back(value(*other, name));
    ASSERT_TRUE(own->tick());
    ASSERT_TRUE(other->tick()) << other->stopped()->text();
    for (std::size_t k = 0; k < pins.size(); ++k) {
      const bool is_feed_through = k == 2 || k == 3;
      if (changes && is_feed_through) continue;
      ASSERT_EQ(shown[k], own->probes().numbers(0)[k]) << n << " " << names[k];
    }
  }
}

TEST_P(Export, ParametersTextsAndChoicesReachTheCircuit) {
  const auto live = library(exported(mixed, 0.01));
  const circuit::LsiClass* c = live.library()->find("c2_mixed_pins/c2_mixed_pins");
  ASSERT_NE(c, nullptr);
  const circuit::Parameter& shape = c->parameters[static_cast<std::size_t>(c->find_parameter("shape"))];
  EXPECT_EQ(shape.kind, circuit::ParameterKind::choice);
  EXPECT_EQ(shape.choices, (std::vector<std::string>{"even", "normal"}));
  const std::string arrays =
      GetParam() == 2 ? R"("place[1]": 4, "place[2]": 5, "place[3]": 6)" : R"("place": [4, 5, 6], "turn": [1, 0, 0, 0])";
  const std::string inputs = "\"values\": {" + arrays + ", \"time (input)\": 0.5, \"key:pressed\": 1}";
  auto own = Interpreter::build(parse(mixed), lsi::standard_library(), nullptr, {.dt = 0.01});
  for (const std::string shape_word : {"even", "normal"}) {
    const std::string text = ", \"parameters\": {\"points\": \"0:0, 1:8\", \"seed\": 7, \"shape\": \"" + shape_word + "\"}, " + inputs;
    auto i = build(alone("c2_mixed_pins", text), live, 0.01);
    ASSERT_TRUE(i) << i.error().text();
    EXPECT_EQ(value(*i, "u.curve"), 4);
    EXPECT_EQ(value(*i, "u.key"), 1);
    EXPECT_EQ(value(*i, "u.far"), std::sqrt(77.0));
    EXPECT_EQ(value(*i, GetParam() == 2 ? "u.place (output)[3]" : "u.place (output)"), GetParam() == 2 ? 9 : 5);
    i->run(30);
    if (shape_word == "even") {
      own->run(31);
      EXPECT_EQ(value(*i, "u.count"), value(*own, "box/sum.out"));
    } else {
      EXPECT_NE(value(*i, "u.count"), value(*own, "box/sum.out"));
    }
  }
}

/// Compares both pendulums with the closed form of a damped oscillator.
TEST_P(Export, TwoPendulumsExampleMatchesClosedForm) {
  const std::string folder = std::string(UGOKI_SOURCE_DIR) + "/examples/fmu/";
  const std::string fmu = exported(text_of(folder + "pendulum.json"), 0.001);
  check(fmu);
  const auto live = library(fmu);
  auto i = build(parse(text_of(folder + "two_pendulums.json")), live, 0.001);
  ASSERT_TRUE(i) << i.error().text();
  double widest = 0;
  for (int n = 1; n <= 2000; ++n) {
    ASSERT_TRUE(i->tick()) << i->stopped()->text();
    widest = std::max(widest, std::fabs(value(*i, "second.angle")));
    const double t = 0.001 * n, decay = 0.05, omega = std::sqrt(9.81 - decay * decay);
    const double angle = 0.2 * std::exp(-decay * t) * (std::cos(omega * t) + decay / omega * std::sin(omega * t));
    ASSERT_NEAR(value(*i, "first.angle"), angle, 0.2 * 9.81 * 0.001 * t + 1e-4) << n;  // first-order error of the integrators
  }
  EXPECT_GT(widest, 0.05);
}

TEST_P(Export, SeveralTicksMakeACommunicationStep) {
  const auto live = library(exported(pendulum, 0.001));
  auto own = Interpreter::build(parse(pendulum), lsi::standard_library(), nullptr, {.dt = 0.001});
  auto other = build(alone("driven_pendulum", R"(, "parameters": {"begin": 0.25})"), live, 0.02);
  auto changed = parse(pendulum);
  changed.lsis[0].parameters = {{"initial", 0.25}};
  own = Interpreter::build(changed, lsi::standard_library(), nullptr, {.dt = 0.001});
  ASSERT_TRUE(other) << other.error().text();
  for (int n = 0; n < 50; ++n) {
    EXPECT_EQ(value(*other, "u.angle"), value(*own, "angle.out")) << n;
    own->run(20);
    other->tick();
  }
}

TEST_P(Export, StoppedCircuitReportsItsReason) {
  const auto live = library(exported(R"({"version": 1, "name": "rooted", "inputs": [{"name": "x", "type": "scalar", "to": "r.in"}],
      "outputs": [{"name": "y", "type": "scalar", "from": "r.out"}], "lsis": [{"id": "r", "type": "square root"}]})",
                                     0.01));
  auto i = build(alone("rooted", R"(, "values": {"x": -4})"), live, 0.01);
  ASSERT_FALSE(i);
  EXPECT_NE(i.error().text().find("'r' stopped at 0.000 s (tick 0): Its input 'in' is negative"), std::string::npos) << i.error().text();
}

TEST_P(Export, EqualCircuitsGiveEqualBytes) {
  const auto a = try_export(parse(pendulum), 0.01), b = try_export(parse(pendulum), 0.01), c = try_export(parse(pendulum), 0.02);
  ASSERT_TRUE(a && b && c);
  EXPECT_TRUE(a->bytes == b->bytes);
  EXPECT_FALSE(a->bytes == c->bytes);
}

TEST_P(Export, LsisOfInstalledLibrariesAreRefused) {
  circuit::LsiClass spring;
  spring.name = "springs/spring";
  spring.from = "springs";
  spring.step = [](const circuit::Call*) { return std::int32_t{0}; };
  const auto c = alone("springs/spring");
  const auto refused = export_fmu(c, lsi::standard_library(), {spring},
                                  {.version = GetParam(), .dt = 0.01, .signal_binary = signal_binary_, .full_binary = full_binary_});
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().text().find("'u' is of the installed library 'springs'. Its native code is not packed"), std::string::npos)
      << refused.error().text();
  const auto missing = export_fmu(c, lsi::standard_library(), {},
                                  {.version = GetParam(), .dt = 0.01, .signal_binary = signal_binary_, .full_binary = full_binary_});
  ASSERT_FALSE(missing);
  EXPECT_NE(missing.error().text().find("is missing"), std::string::npos);
}

TEST_P(Export, LsisThatNeedContentAreRefused) {
  const auto refused = try_export(alone("status"), 0.01);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().text().find("'u' (LSI 'status') uses the mechanisms and motions of content"), std::string::npos)
      << refused.error().text();
}

/// Angle -> rotation -> rotated vector, with LSIs of pure mathematics, which use no content.
constexpr const char* rotated = R"({"version": 1, "name": "rotated",
  "inputs": [{"name": "angle", "type": "scalar", "to": ["turn.angle", "wave.angle"]}],
  "outputs": [{"name": "sine", "type": "scalar", "from": "wave.sine"}, {"name": "x", "type": "scalar", "from": "parts.x"}],
  "lsis": [{"id": "wave", "type": "sine"}, {"id": "turn", "type": "make rotation", "values": {"axis": [0, 0, 1]}},
           {"id": "ahead", "type": "make vector", "values": {"x": 1, "y": 0, "z": 0}}, {"id": "turned", "type": "rotate vector"},
           {"id": "parts", "type": "split vector"}],
  "wires": [{"from": "turn.out", "to": "turned.rotation"}, {"from": "ahead.out", "to": "turned.in"}, {"from": "turned.out", "to": "parts.in"}]})";

TEST_P(Export, LsisOfMathematicsNeedNoContent) {
  const std::string fmu = exported(rotated, 0.01);
  check(fmu);
  const auto live = library(fmu);
  auto i = build(alone("rotated", R"(, "values": {"angle": 0.5})"), live, 0.01);
  ASSERT_TRUE(i) << i.error().text();
  ASSERT_TRUE(i->tick() && i->tick()) << i->stopped()->text();
  EXPECT_NEAR(value(*i, "u.sine"), std::sin(0.5), 1e-15);
  EXPECT_NEAR(value(*i, "u.x"), std::cos(0.5), 1e-15);
}

/// For each standard LSI, a circuit with this LSI alone is exported, or the error names what the LSI needs. Only LSIs that read a mechanism
/// or a motion need content.
TEST_P(Export, OnlyLsisThatUseContentAreRefusedWithoutContent) {
  int exported = 0;
  for (const circuit::LsiClass& c : lsi::standard_library().classes()) {
    const auto out = try_export(alone(c.name), 0.01);
    if (out) ++exported;
    if (out || out.error().text().find("uses the mechanisms and motions of content") == std::string::npos) {
      EXPECT_TRUE(out || out.error().text().find("content") == std::string::npos) << c.name << ": " << out.error().text();
      continue;
    }
    EXPECT_FALSE(Interpreter::build(alone(c.name), lsi::standard_library(), nullptr, {.dt = 0.01})) << c.name;
  }
  EXPECT_GT(exported, 10);
}

TEST_P(Export, PinsThatCannotBeVariablesAreNoted) {
  const auto out = try_export(parse(mixed), 0.01);
  ASSERT_TRUE(out);
  ASSERT_EQ(out->notes.size(), 2u);
  EXPECT_EQ(out->notes[0], "The input 'knock' (event) has no numeric values and is left out.");
}

/// The checker itself must find faults: FMUs with duplicate names, duplicate value references or a wrong token.
TEST_P(Export, CheckerFindsFaults) {
  const auto status = [&](const std::string& description) {
    const auto ran = plugin::run_program({"/usr/bin/python3", std::string(UGOKI_SOURCE_DIR) + "/tests/fmi/check_fmu.py", UGOKI_FMI_CHECKER,
                                          unit("dahlquist", "Dahlquist", GetParam(), description), "0.1"},
                                         {std::chrono::seconds(60)});
    return ran ? ran->out : "";
  };
  std::string twice = description_of("dahlquist", GetParam());
  twice.replace(twice.find("\"k\""), 3, "\"x\"");
  EXPECT_NE(status(twice).find("WRONG: names are not unique"), std::string::npos);
  std::string same = description_of("dahlquist", GetParam());
  same.replace(same.find("valueReference=\"3\""), 18, "valueReference=\"2\"");
  EXPECT_NE(status(same).find("WRONG: value references are not unique"), std::string::npos);
  std::string token = description_of("dahlquist", GetParam());
  token.replace(token.find("{8c4e810f"), 9, "{8c4e8100");
  EXPECT_NE(status(token).find("instantiate"), std::string::npos);
}

}  // namespace
}  // namespace ugoki::fmi
