// LSIs of rules that keep and change variables, and that make and open grips.

#include "signals.h"
#include "small_world.h"

namespace ugoki::lsi {
namespace {

/// Variable "v" with the changes "one" (input `one`) and, after it, "two" (input `two`).
std::string changes_circuit(const std::string& variable, const std::string& one, const std::string& two) {
  return R"({"version": 2, "name": "t", "inputs": [{"name": "one", "type": "scalar", "to": "one.condition"},
             {"name": "two", "type": "scalar", "to": "two.condition"}],
             "lsis": [{"id": "v", "type": "variable", "parameters": {)" +
         variable + R"(}},
                      {"id": "one", "type": "set variable", )" +
         one + R"(}, {"id": "two", "type": "set variable", )" + two + R"(}],
             "wires": [{"from": "v.value", "to": "one.value"}, {"from": "one.value", "to": "two.value"}, {"from": "two.value", "to": "v.next"}]})";
}
constexpr const char* add_one = R"("parameters": {"change": "add"}, "values": {"amount": 1})";

TEST(Variable, CountsEachRiseOfACondition) {
  circuit::Interpreter i = build(nullptr, changes_circuit(R"("initial": 5)", add_one, add_one), 0.01);
  EXPECT_EQ(get(i, "v.value"), 5) << "the initial value before the first tick";
  i.run(10);
  EXPECT_EQ(get(i, "v.value"), 5);
  for (int round = 1; round <= 3; ++round) {
    set(i, "one", 1);
    i.run(7);
    EXPECT_EQ(get(i, "v.value"), 5 + round);
    EXPECT_EQ(get(i, "one.active"), 1);
    set(i, "one", 0);
    i.run(7);
  }
  set(i, "one", 1);
  set(i, "two", 1);
  i.run(1);
  EXPECT_EQ(get(i, "v.value"), 10) << "both changes of the same tick count";
  EXPECT_EQ(get(i, "one.count"), 4);
  EXPECT_EQ(get(i, "two.count"), 1);
}

TEST(Variable, AddsPerSecondWhileAConditionIsTrueAndStaysWithinItsBounds) {
  const std::string per_second = R"("parameters": {"change": "add", "mode": "while"}, "values": {"amount": )";
  circuit::Interpreter i =
      build(nullptr, changes_circuit(R"("initial": 100, "minimum": 0, "maximum": 100)", per_second + "-25}", per_second + "10}"), 0.01);
  set(i, "two", 1);
  i.run(100);
  EXPECT_EQ(get(i, "v.value"), 100) << "the maximum";
  set(i, "two", 0);
  set(i, "one", 1);
  i.run(200);
  EXPECT_NEAR(get(i, "v.value"), 100 - 25 * 2.0, 1e-9);
  i.run(300);
  EXPECT_EQ(get(i, "v.value"), 0) << "the minimum";
  set(i, "one", 0);
  set(i, "two", 1);
  i.run(100);
  EXPECT_NEAR(get(i, "v.value"), 10, 1e-9);
}

TEST(Variable, SetsAndTogglesAndTheLastChangeHasPriority) {
  circuit::Interpreter i = build(nullptr,
                                 changes_circuit("", R"("parameters": {"change": "toggle"})",
                                                 R"("parameters": {"change": "set", "mode": "while"}, "values": {"amount": 0})"),
                                 0.01);
  const auto press = [&](double expected) {
    set(i, "one", 1);
    i.run(4);
    EXPECT_EQ(get(i, "v.value"), expected);
    set(i, "one", 0);
    i.run(3);
  };
  press(1);
  press(0);
  press(1);
  set(i, "two", 1);
  press(0);
  press(0);
}

TEST(Variable, KeepsItsValueWithoutChangesAndAfterARestore) {
  const char* text =
      R"({"version": 2, "name": "t", "lsis": [{"id": "v", "type": "variable", "parameters": {"initial": -3}}], "wires": []})";
  circuit::Interpreter lone = build(nullptr, text, 0.01);
  lone.run(5);
  EXPECT_EQ(get(lone, "v.value"), -3);

  const std::string c = changes_circuit("", add_one, add_one);
  circuit::Interpreter a = build(nullptr, c, 0.01), b = build(nullptr, c, 0.01);
  set(a, "one", 1);
  a.run(4);
  std::vector<std::byte> saved;
  a.save(saved);
  ASSERT_TRUE(b.restore(saved));
  set(b, "one", 1);  // still held: no further rise
  b.run(4);
  EXPECT_EQ(get(b, "v.value"), 1);
}

/// A world with a walking character and a ball beside it.
std::unique_ptr<World> make_world() {
  std::vector<CharacterSpec> specs(2);
  specs[0].id = "character";
  specs[0].mechanism = make_character();
  TrackClip sway{{}, make_sway(*specs[0].mechanism, 4)};
  sway.clip.length = 4;
  specs[0].track = {sway};
  specs[1].id = "ball";
  specs[1].mechanism = make_ball();
  specs[1].q0 = specs[1].mechanism->neutral();
  specs[1].q0[0] = 2;
  specs[1].q0[2] = 1;
  return std::make_unique<World>(std::move(specs), std::vector<ScheduledEvent>{}, Vec3{0, 0, -9.81}, collision::Ground{});
}

std::string grip_circuit(const std::string& mode, const std::string& link = "ball") {
  circuit::Circuit c = make_execution_circuit({{"character", true, 1, 1, 0.5}, {"ball", false, 1, 1, 0.5}}, 0.002);
  circuit::Instance grip;
  grip.id = "grip";
  grip.type = "grip rule";
  grip.parameters = {{"character", std::string("ball")}, {"link", link}, {"mode", mode}};
  c.lsis.push_back(grip);
  c.inputs.push_back({"go", circuit::PinTypeId::scalar, "", "", {"grip.when"}});
  for (circuit::Wire& w : c.wires)
    if (w.to == "dynamics.events") w.from = "grip.events";
  c.wires.push_back({"event.events", "grip.events"});
  return circuit::write_circuit(c);
}

TEST(GripRule, ABallThatGripsTheWorldStopsFalling) {
  const auto world = make_world();
  const Character& ball = world->characters()[1];
  for (const bool hold : {false, true}) {
    circuit::Interpreter i = build(world.get(), grip_circuit(hold ? "hold" : "grab"), 0.002);
    const auto height = [&] { return q_of(ball, i.find_circuit_output("state")->numbers().data())[2]; };
    ASSERT_TRUE(i.run(50));
    const double fallen = 0.5 * 9.81 * 0.1 * 0.1;
    EXPECT_NEAR(height(), 1 - fallen, 0.002) << "0.1 s of free fall";
    set(i, "go", 1);
    ASSERT_TRUE(i.run(100));
    const double gripped = height();
    EXPECT_NEAR(gripped, 1 - fallen, 0.01) << "it hangs where it gripped";
    set(i, "go", 0);
    ASSERT_TRUE(i.run(100));
    EXPECT_EQ(get(i, "grip.count"), 1);
    if (hold)
      EXPECT_NEAR(height(), gripped - 0.5 * 9.81 * 0.2 * 0.2, 0.01) << "released: 0.2 s of free fall";
    else
      EXPECT_NEAR(height(), gripped, 1e-3) << "`grab` keeps the grip";
  }
}

TEST(GripRule, UnknownLinksAreErrors) {
  const auto world = make_world();
  const auto c = circuit::read_circuit(grip_circuit("grab", "nose"));
  ASSERT_TRUE(c);
  const auto i = circuit::Interpreter::build(*c, standard_library(), world.get(), {.dt = 0.002});
  ASSERT_FALSE(i);
  EXPECT_NE(i.error().text().find("nose"), std::string::npos);
}

}  // namespace
}  // namespace ugoki::lsi
