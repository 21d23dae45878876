// Running circuits: order of state changes, rates, save and restore, failures, timing.

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "allocation_count.h"
#include "circuit_test.h"
#include "ugoki/circuit/setup.h"

namespace ugoki::circuit {
namespace {

// Oscillator of a mass on a spring: x'' = -40 x.
const char* const oscillator = R"({"version": 2, "name": "oscillator",
  "lsis": [{"id": "x", "type": "integrator", "parameters": {"initial": 1}}, {"id": "v", "type": "integrator"}, {"id": "k", "type": "gain", "parameters": {"gain": -40}},
           {"id": "smooth", "type": "low-pass"}, {"id": "slow", "type": "gain", "every": 10}],
  "wires": [{"from": "v.out", "to": "x.in"}, {"from": "k.out", "to": "v.in"}, {"from": "x.out", "to": "k.in"}, {"from": "x.out", "to": "smooth.in"}, {"from": "smooth.out", "to": "slow.in"}]})";

TEST(Run, StateChangesTogetherAtTheTick) {
  // Two delays that exchange their values. The result is correct only if both read the old value of the other.
  auto i = build(
      R"({"version": 2, "name": "swap", "lsis": [{"id": "a", "type": "delay", "parameters": {"initial": 1}}, {"id": "b", "type": "delay", "parameters": {"initial": 2}}],
    "wires": [{"from": "a.out", "to": "b.in"}, {"from": "b.out", "to": "a.in"}]})");
  ASSERT_TRUE(i);
  for (int k = 0; k < 5; ++k) {
    EXPECT_EQ(value(*i, "a.out"), k % 2 ? 2 : 1);
    EXPECT_EQ(value(*i, "b.out"), k % 2 ? 1 : 2);
    ASSERT_TRUE(i->tick());
  }
}

TEST(Run, MatchesDirectCalculation) {
  auto i = build(oscillator);
  ASSERT_TRUE(i) << i.error().text();
  double x = 1, v = 0;
  for (int k = 0; k < 1000; ++k) {
    ASSERT_TRUE(i->tick());
    const double f = -40 * x;
    const double old_v = v;
    v += f * 0.01;
    x += old_v * 0.01;
    ASSERT_EQ(value(*i, "x.out"), x);
    ASSERT_EQ(value(*i, "v.out"), v);
  }
}

TEST(Run, EveryTenthTickHoldsOutputBetween) {
  auto i = build(oscillator);
  ASSERT_TRUE(i);
  double held = 0;
  for (int k = 0; k < 100; ++k) {
    ASSERT_TRUE(i->tick());
    if (k % 10 == 0) held = value(*i, "smooth.out");
    EXPECT_EQ(value(*i, "slow.out"), held);
  }
}

/// LSIs whose result depends on the time since their last run. Each runs in every `every`-th tick and reads the circuit's input x.
std::string timed_lsis(int every) {
  std::string lsis, ends;
  const auto add = [&](const std::string& id, const std::string& type, const std::string& input, const std::string& parameters) {
    lsis += (lsis.empty() ? "" : ", ") + std::string(R"({"id": ")") + id + R"(", "type": ")" + type + R"(", "every": )" +
            std::to_string(every) + R"(, "parameters": {)" + parameters + "}}";
    ends += (ends.empty() ? "\"" : ", \"") + id + "." + input + "\"";
  };
  add("integral", "integrator", "in", "");
  add("slope", "derivative", "in", "");
  add("low", "low-pass", "in", "");
  add("high", "high-pass", "in", "");
  add("limit", "rate limit", "in", R"("rate": 2)");
  add("timer", "timer", "run", "");
  add("states", "state machine", "a", R"("transitions": "low -> high when a > 0; high -> low when a < 0 after 0.4")");
  return R"({"version": 2, "name": "timed", "inputs": [{"name": "x", "type": "scalar", "to": [)" + ends + R"(]}], "lsis": [)" + lsis + "]}";
}

TEST(Run, EveryNthTickCalculatesWithNTimesTheTimeBetweenTicks) {
  const std::vector<std::string> pins{"integral.out", "slope.out",  "low.out",     "high.out",
                                      "limit.out",    "timer.time", "states.time", "states.state"};
  const double dt = 0.01;
  for (const std::uint32_t every : {2u, 5u, 10u}) {
    SCOPED_TRACE(every);
    const Circuit circuit = parse(timed_lsis(static_cast<int>(every)));
    auto fast = Interpreter::build(circuit, signal_library(), nullptr, {.dt = dt});
    auto reference = Interpreter::build(parse(timed_lsis(1)), signal_library(), nullptr, {.dt = dt * every});
    ASSERT_TRUE(fast && reference) << (fast ? reference : fast).error().text();
    for (int k = 0; k < 60; ++k) {
      const double x = std::sin(0.3 * k);
      std::memcpy(fast->find_circuit_input("x").data(), &x, sizeof x);
      std::memcpy(reference->find_circuit_input("x").data(), &x, sizeof x);
      if (k == 30) {  // continue with a restored interpreter
        std::vector<std::byte> saved;
        fast->save(saved);
        fast = Interpreter::build(circuit, signal_library(), nullptr, {.dt = dt});
        ASSERT_TRUE(fast->restore(saved));
      }
      ASSERT_EQ(fast->run(every), every);
      ASSERT_TRUE(reference->tick());
      for (const std::string& pin : pins) ASSERT_EQ(value(*fast, pin), value(*reference, pin)) << pin << " " << k;
    }
    EXPECT_EQ(fast->time(), 60 * every * dt);
  }
}

TEST(Run, OnDemandRunsOnlyWhenAsked) {
  auto i = build(
      R"({"version": 2, "name": "o", "lsis": [{"id": "c", "type": "clock"}, {"id": "show", "type": "gain", "every": 0, "parameters": {"gain": 2}}], "wires": [{"from": "c.time", "to": "show.in"}]})");
  ASSERT_TRUE(i);
  for (int k = 0; k < 6; ++k) ASSERT_TRUE(i->tick());
  EXPECT_EQ(value(*i, "show.out"), 0);
  ASSERT_TRUE(i->refresh());
  EXPECT_EQ(value(*i, "show.out"), 0.1);
}

TEST(Run, SameBitsAfterSaveAndRestore) {
  auto a = build(oscillator), b = build(oscillator);
  ASSERT_TRUE(a && b);
  for (int k = 0; k < 123; ++k) ASSERT_TRUE(a->tick());
  ASSERT_TRUE(a->set_parameter("k.gain", -41));
  std::vector<std::byte> saved;
  a->save(saved);
  for (int k = 0; k < 100; ++k) ASSERT_TRUE(a->tick());
  ASSERT_TRUE(b->restore(saved));
  EXPECT_EQ(b->ticks(), 123u);
  for (int k = 0; k < 100; ++k) ASSERT_TRUE(b->tick());
  for (const char* pin : {"x.out", "v.out", "smooth.out", "slow.out"})
    EXPECT_EQ(std::bit_cast<std::uint64_t>(value(*a, pin)), std::bit_cast<std::uint64_t>(value(*b, pin))) << pin;
  std::vector<std::byte> one, two;
  a->save(one);
  b->save(two);
  EXPECT_EQ(one, two);
}

TEST(Run, RestoreRefusesForeignOrDamagedBytesAndChangesNothing) {
  auto a = build(oscillator);
  auto other = build(R"({"version": 2, "name": "o", "lsis": [{"id": "c", "type": "clock"}]})");
  ASSERT_TRUE(a && other);
  ASSERT_TRUE(a->tick());
  std::vector<std::byte> good, foreign;
  a->save(good);
  other->save(foreign);
  EXPECT_FALSE(a->restore(foreign));
  EXPECT_FALSE(a->restore({}));
  EXPECT_FALSE(a->restore(std::span<const std::byte>(good).first(good.size() - 1)));
  for (const std::size_t at : {std::size_t{16}, std::size_t{60}, good.size() - 1}) {  // damages tick count, LSI state, parameters
    std::vector<std::byte> damaged = good;
    damaged[at] ^= std::byte{1};
    EXPECT_FALSE(a->restore(damaged)) << at;
  }
  std::vector<std::byte> after;
  a->save(after);
  EXPECT_EQ(after, good);
}

TEST(Run, ResetRestoresInitialState) {
  auto a = build(oscillator);
  ASSERT_TRUE(a);
  std::vector<std::byte> first, after_reset;
  a->save(first);
  for (int k = 0; k < 50; ++k) ASSERT_TRUE(a->tick());
  a->reset();
  a->save(after_reset);
  EXPECT_EQ(first, after_reset);
}

TEST(Run, AdoptCopiesStateOfUnchangedLsis) {
  auto a = build(oscillator);
  ASSERT_TRUE(a);
  for (int k = 0; k < 50; ++k) ASSERT_TRUE(a->tick());
  std::string changed = oscillator;
  changed.replace(changed.find("\"low-pass\""), 10, "\"integrator\"");  // an LSI of another type, with a state of the same size
  auto b = build(changed);
  ASSERT_TRUE(b) << b.error().text();
  EXPECT_EQ(b->adopt(*a), 4u);
  EXPECT_EQ(b->time(), a->time());
  EXPECT_EQ(value(*b, "x.out"), value(*a, "x.out"));
  ASSERT_TRUE(a->tick() && b->tick());
  EXPECT_EQ(value(*b, "v.out"), value(*a, "v.out"));
}

TEST(Run, FailureNamesLsiAndKeepsState) {
  auto i = build(R"({"version": 2, "name": "o",
    "lsis": [{"id": "n", "type": "delay", "parameters": {"initial": 3}}, {"id": "less", "type": "add", "values": {"b": -1}}, {"id": "inverse", "type": "divide", "values": {"a": 1}}],
    "wires": [{"from": "n.out", "to": "less.a"}, {"from": "less.out", "to": "n.in"}, {"from": "n.out", "to": "inverse.b"}]})");
  ASSERT_TRUE(i);
  for (int k = 0; k < 3; ++k) ASSERT_TRUE(i->tick());
  EXPECT_FALSE(i->tick());
  ASSERT_TRUE(i->stopped());
  EXPECT_EQ(i->stopped()->lsi, "inverse");
  EXPECT_EQ(i->stopped()->tick, 3u);
  EXPECT_NE(i->stopped()->text().find("zero"), std::string::npos);
  EXPECT_FALSE(i->tick());
  EXPECT_EQ(i->ticks(), 3u);
  EXPECT_EQ(value(*i, "n.out"), 0);
  i->reset();
  EXPECT_TRUE(i->tick());
}

TEST(Run, NumberThatIsNotFiniteStopsTheInterpreter) {
  auto i = build(
      R"({"version": 2, "name": "o", "lsis": [{"id": "x", "type": "integrator", "parameters": {"initial": 1}}, {"id": "k", "type": "gain", "parameters": {"gain": 1e200}}],
    "wires": [{"from": "x.out", "to": "k.in"}, {"from": "k.out", "to": "x.in"}]})");
  ASSERT_TRUE(i);
  int k = 0;
  while (i->tick() && k < 10) ++k;
  ASSERT_TRUE(i->stopped());
  EXPECT_EQ(i->stopped()->lsi, "k");
  EXPECT_NE(i->stopped()->reason.find("'out' is not finite"), std::string::npos);
  EXPECT_LT(value(*i, "x.out"), std::numeric_limits<double>::infinity());
}

TEST(Run, SetParameterTakesEffectAtTheNextTick) {
  auto i = build(
      R"({"version": 2, "name": "o", "lsis": [{"id": "c", "type": "constant", "parameters": {"value": 2}}, {"id": "f", "type": "low-pass"}], "wires": [{"from": "c.out", "to": "f.in"}]})");
  ASSERT_TRUE(i && i->tick());
  ASSERT_TRUE(i->set_parameter("c.value", 9));
  ASSERT_TRUE(i->tick());
  EXPECT_EQ(value(*i, "c.out"), 9);
  EXPECT_FALSE(i->set_parameter("c.valve", 9));
  EXPECT_FALSE(i->set_parameter("d.value", 9));
  EXPECT_FALSE(i->set_parameter("f.time", -9));
  EXPECT_FALSE(i->set_parameter("c.value", std::numeric_limits<double>::quiet_NaN()));
}

TEST(Run, TicksDoNotAllocate) {
  auto i = build(oscillator);
  ASSERT_TRUE(i);
  ASSERT_TRUE(i->tick());
  std::vector<std::byte> saved;
  i->save(saved);
  const long before = allocations_so_far();
  for (int k = 0; k < 1000; ++k) i->tick();
  i->refresh();
  i->save(saved);
  EXPECT_EQ(allocations_so_far(), before);
}

TEST(Run, TimingCountsEachLsi) {
  auto i = build(oscillator);
  ASSERT_TRUE(i);
  i->set_timing([]() -> std::uint64_t {
    static std::uint64_t now = 0;
    return now += 3;
  });
  for (int k = 0; k < 20; ++k) ASSERT_TRUE(i->tick());
  const auto timings = i->timings();
  ASSERT_EQ(timings.size(), 5u);
  for (const Timing& t : timings) {
    EXPECT_EQ(t.runs, t.lsi == "slow" ? 2u : t.lsi == "smooth" ? 40u : 20u) << t.lsi;  // `smooth` has a step and an advance function
    EXPECT_EQ(t.total, 3 * t.runs);
  }
}

TEST(Run, SampledTimingIsUnbiasedForAllRates) {
  auto i = build(oscillator);
  ASSERT_TRUE(i);
  i->set_timing(
      []() -> std::uint64_t {
        static std::uint64_t now = 0;
        return now += 3;
      },
      4);
  constexpr double ticks = 40000;
  ASSERT_EQ(i->run(static_cast<std::uint64_t>(ticks)), 40000u);
  EXPECT_NEAR(static_cast<double>(i->timed_ticks()), ticks / 4, 0.01 * ticks / 4);
  for (const Timing& t : i->timings()) {
    const double wanted = ticks / 4 * (t.lsi == "slow" ? 0.1 : t.lsi == "smooth" ? 2 : 1);
    EXPECT_NEAR(static_cast<double>(t.runs), wanted, 0.02 * wanted) << t.lsi;
    EXPECT_EQ(t.total, 3 * t.runs);
  }
}

TEST(Run, PayloadsOfDifferentSizesAreWiredCorrectly) {
  auto i = build(R"({"version": 2, "name": "o",
    "lsis": [{"id": "a", "type": "make vector", "values": {"x": 1, "y": 2, "z": 3}}, {"id": "b", "type": "make vector", "values": {"x": 10, "y": 20, "z": 30}},
             {"id": "sum", "type": "add vectors"}, {"id": "late", "type": "delay vector"}, {"id": "twice", "type": "scale vector", "values": {"factor": 2}},
             {"id": "parts", "type": "split vector"}, {"id": "turn", "type": "delay rotation", "values": {"in": [0, 1, 0, 0]}},
             {"id": "place", "type": "delay pose", "values": {"in": [1, 2, 3, 0, 0, 1, 0]}}],
    "wires": [{"from": "a.out", "to": "sum.a"}, {"from": "b.out", "to": "sum.b"}, {"from": "sum.out", "to": "late.in"}, {"from": "late.out", "to": "twice.in"},
              {"from": "twice.out", "to": "parts.in"}]})");
  ASSERT_TRUE(i) << i.error().text();
  EXPECT_EQ(i->find_output("turn.out")->numbers()[0], 1);  // the identity rotation at first
  EXPECT_EQ(i->find_output("place.out")->numbers()[3], 1);
  ASSERT_TRUE(i->tick());
  EXPECT_EQ(value(*i, "parts.y"), 0);
  ASSERT_TRUE(i->tick());
  const auto expect_numbers = [&](const char* pin, std::vector<double> wanted) {
    const auto numbers = i->find_output(pin)->numbers();
    EXPECT_EQ(std::vector<double>(numbers.begin(), numbers.end()), wanted) << pin;
  };
  expect_numbers("a.out", {1, 2, 3});
  expect_numbers("sum.out", {11, 22, 33});
  expect_numbers("late.out", {11, 22, 33});
  expect_numbers("twice.out", {22, 44, 66});
  expect_numbers("parts.x", {22});
  expect_numbers("parts.y", {44});
  expect_numbers("parts.z", {66});
  expect_numbers("turn.out", {0, 1, 0, 0});
  expect_numbers("place.out", {1, 2, 3, 0, 0, 1, 0});
}

TEST(Run, DelayedOutputMayFeedDirectInputOfTheSameLsi) {
  // The LSI `both`: y = a + 1 in the same tick, and z is y of the previous tick. Its output z is wired to its input a.
  Library library;
  LsiClass c;
  c.name = "both";
  c.inputs.resize(1);
  c.inputs[0].name = "a";
  c.outputs.resize(2);
  c.outputs[0].name = "y";
  c.outputs[1].name = "z";
  c.outputs[1].delayed = true;
  c.step = [](const Call* call) -> std::int32_t {
    *output(call, 0) = *input(call, 0) + 1;
    return 0;
  };
  c.advance = [](const Call* call) -> std::int32_t {
    *output(call, 1) = *output(call, 0);
    return 0;
  };
  library.add(c);
  auto i = Interpreter::build(
      parse(R"({"version": 2, "name": "o", "lsis": [{"id": "b", "type": "both"}], "wires": [{"from": "b.z", "to": "b.a"}]})"), library,
      nullptr, {});
  ASSERT_TRUE(i) << i.error().text();
  for (int k = 0; k < 4; ++k) ASSERT_TRUE(i->tick());
  EXPECT_EQ(value(*i, "b.y"), 4);
  EXPECT_FALSE(Interpreter::build(
      parse(R"({"version": 2, "name": "o", "lsis": [{"id": "b", "type": "both"}], "wires": [{"from": "b.y", "to": "b.a"}]})"), library,
      nullptr, {}));
}

// A library with the LSI "tank". Its state is in an object; it uses a resource and a subject; its input accepts several wires of any size.
struct Tank {
  static constexpr const char* resource_kind = "tank";
  std::uint32_t size;
};
struct Tanks : Resources {
  Tank small{3};
  [[nodiscard]] const void* find(std::string_view kind, std::string_view name) const override {
    return kind == "tank" && name == "small" ? &small : nullptr;
  }
};
int objects = 0;

Library tank_library() {
  Library library;
  add_signal_lsis(library);
  LsiClass c;
  c.name = "tank";
  InputPin pin;
  pin.name = "in";
  pin.type = PinTypeId::joint_values;
  pin.multiple = true;
  pin.required = false;
  pin.direct = false;
  c.inputs = {pin};
  OutputPin level;
  level.name = "level";
  level.type = PinTypeId::joint_values;
  level.delayed = true;
  c.outputs = {level};
  Parameter name;
  name.name = "name";
  name.kind = ParameterKind::text;
  name.initial = std::string("small");
  c.parameters = {name};
  c.configure = [](Setup& s) {
    if (const Tank* t = s.resource<Tank>(s.text("name"))) {
      s.set_out(0, t->size, 42);
      s.set_state(sizeof(double));
    }
  };
  c.make = [](Setup& s) -> void* {
    ++objects;
    return new double(static_cast<double>(s.wires(0)));
  };
  c.destroy = [](void* p) {
    --objects;
    delete static_cast<double*>(p);
  };
  c.init = [](const Call* call) -> std::int32_t {
    *static_cast<double*>(call->object) = 0;
    return 0;
  };
  c.advance = [](const Call* call) -> std::int32_t {
    auto& level_now = *static_cast<double*>(call->object);
    level_now += 1;
    for (std::uint32_t k = 0; k < call->in_first[1]; ++k) level_now += input(call, k)[call->in_count[k] - 1];
    for (std::uint32_t k = 0; k < call->out_count[0]; ++k) output(call, 0)[k] = level_now * (k + 1);
    return 0;
  };
  c.store = [](const Call* call) { *static_cast<double*>(call->state) = *static_cast<double*>(call->object); };
  c.recall = [](const Call* call) { *static_cast<double*>(call->object) = *static_cast<double*>(call->state); };
  library.add(c);
  return library;
}

TEST(Run, ObjectStateIsSavedAndRestored) {
  const Library library = tank_library();
  const Tanks tanks;
  const Circuit circuit = parse(R"({"version": 2, "name": "o", "lsis": [{"id": "a", "type": "tank"}, {"id": "b", "type": "tank"}],
    "wires": [{"from": "a.level", "to": "b.in"}, {"from": "b.level", "to": "b.in"}]})");
  {
    auto i = Interpreter::build(circuit, library, &tanks, {});
    ASSERT_TRUE(i) << i.error().text();
    EXPECT_EQ(objects, 2);
    for (int k = 0; k < 4; ++k) ASSERT_TRUE(i->tick());
    std::vector<std::byte> saved;
    i->save(saved);
    for (int k = 0; k < 4; ++k) ASSERT_TRUE(i->tick());
    const double end = value(*i, "b.level");
    ASSERT_TRUE(i->restore(saved));
    for (int k = 0; k < 4; ++k) ASSERT_TRUE(i->tick());
    EXPECT_EQ(value(*i, "b.level"), end);
    auto moved = std::move(*i);
    EXPECT_TRUE(moved.tick());
  }
  EXPECT_EQ(objects, 0);
  const auto refused = Interpreter::build(
      parse(R"({"version": 2, "name": "o", "lsis": [{"id": "a", "type": "tank", "parameters": {"name": "huge"}}]})"), library, &tanks, {});
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().text().find("There is no tank 'huge'"), std::string::npos);
}

}  // namespace
}  // namespace ugoki::circuit
