// Building circuits: the problems that are reported, and the order in which LSIs run.

#include <cstring>

#include "circuit_test.h"

namespace ugoki::circuit {
namespace {

std::string problems_of(const std::string& text) {
  const auto built = build(text);
  return built ? std::string() : built.error().text();
}

void expect_refused(const std::string& text, std::initializer_list<const char*> words) {
  const std::string problems = problems_of(text);
  EXPECT_FALSE(problems.empty());
  for (const char* w : words) EXPECT_NE(problems.find(w), std::string::npos) << "'" << w << "' is not in: " << problems;
}

TEST(Build, ReportsAllProblemsWithNames) {
  expect_refused(R"({"version": 2, "name": "bad",
    "lsis": [{"id": "a", "type": "add"}, {"id": "g", "type": "gain", "parameters": {"gian": 2}}, {"id": "v", "type": "make vector", "values": {"x": 1, "y": 2, "z": 3}},
             {"id": "gone", "type": "magic"}, {"id": "a", "type": "clock"}],
    "wires": [{"from": "v.out", "to": "a.a"}, {"from": "g.out", "to": "a.b"}, {"from": "g.out", "to": "a.b"}, {"from": "a.sum", "to": "g.in"},
              {"from": "nobody.out", "to": "g.in"}, {"from": "gone.out", "to": "g.in"}]})",
                 {"'v.out' (vector) does not fit 'a.a' (scalar)", "Two wires end at 'a.b': from 'g.out' and from 'g.out'",
                  "'a' has no output 'sum'", "There is no LSI 'nobody'", "'magic' (used as 'gone') is missing", "Two LSIs have the id 'a'",
                  "Nothing is wired to 'g.in'", "'g' has no parameter 'gian'", "circuit/wires/3/from"});
}

TEST(Build, UnwiredOutputOfTheCircuitIsReported) {
  expect_refused(R"({"version": 2, "name": "o", "outputs": [{"name": "speed", "type": "scalar", "from": []}],
    "lsis": [{"id": "c", "type": "clock"}]})",
                 {"circuit/outputs/0/from", "Nothing is wired to the circuit's output 'speed'"});
}

TEST(Build, ChecksParametersAndValues) {
  const auto with = [](const char* lsi) { return std::string(R"({"version": 2, "name": "p", "lsis": [)") + lsi + "]}"; };
  expect_refused(with(R"({"id": "g", "type": "gain", "parameters": {"gain": "much"}, "values": {"in": 1}})"),
                 {"The value of the parameter 'g.gain' is not allowed", "Give a number"});
  expect_refused(with(R"({"id": "f", "type": "low-pass", "parameters": {"time": -1}, "values": {"in": 1}})"), {"'f.time'", "from 0"});
  expect_refused(with(R"({"id": "g", "type": "gain", "values": {"in": [1, 2]}})"), {"'g.in' needs 1 finite numbers"});
  expect_refused(with(R"({"id": "g", "type": "gain", "values": {"out": 1}})"), {"'g' has no input 'out'"});
  expect_refused(with(R"({"id": "d", "type": "delay joint values"})"), {"Nothing is wired to 'd.in'"});
}

TEST(Build, RefusesAlgebraicLoopAndNamesItsWires) {
  const char* loop = R"({"version": 2, "name": "loop",
    "lsis": [{"id": "s", "type": "add", "values": {"b": 1}}, {"id": "g", "type": "gain"}, {"id": "h", "type": "gain"}, {"id": "after", "type": "gain"}],
    "wires": [{"from": "s.out", "to": "g.in"}, {"from": "g.out", "to": "h.in"}, {"from": "h.out", "to": "s.a"}, {"from": "h.out", "to": "after.in"}]})";
  expect_refused(loop, {"within one tick: g.out -> h.in, h.out -> s.a, s.out -> g.in", "Insert a delay after 's.out'"});
}

TEST(Build, AcceptsCycleThroughDelay) {
  auto i = build(R"({"version": 2, "name": "count",
    "lsis": [{"id": "d", "type": "delay", "parameters": {"initial": 5}}, {"id": "s", "type": "add", "values": {"b": 1}}],
    "wires": [{"from": "s.out", "to": "d.in"}, {"from": "d.out", "to": "s.a"}]})");
  ASSERT_TRUE(i) << i.error().text();
  EXPECT_EQ(value(*i, "d.out"), 5);
  for (int k = 0; k < 3; ++k) ASSERT_TRUE(i->tick());
  EXPECT_EQ(value(*i, "d.out"), 8);
  EXPECT_EQ(value(*i, "s.out"), 8);
}

TEST(Build, UndefinedSizeIsRefused) {
  expect_refused(
      R"({"version": 2, "name": "size", "lsis": [{"id": "a", "type": "delay joint values"}, {"id": "b", "type": "delay joint values"}],
    "wires": [{"from": "a.out", "to": "b.in"}, {"from": "b.out", "to": "a.in"}]})",
      {"The size of 'a.out' is undefined"});
  auto sized = build(
      R"({"version": 2, "name": "size", "lsis": [{"id": "a", "type": "delay joint values", "parameters": {"count": 7}}, {"id": "b", "type": "delay joint values"}],
    "wires": [{"from": "a.out", "to": "b.in"}, {"from": "b.out", "to": "a.in"}]})");
  ASSERT_TRUE(sized) << sized.error().text();
  EXPECT_EQ(sized->find_output("b.out")->count, 7u);
}

TEST(Build, OrderDoesNotDependOnTheOrderInTheFile) {
  const char* one =
      R"({"version": 2, "name": "o", "lsis": [{"id": "b", "type": "clock"}, {"id": "a", "type": "gain"}, {"id": "c", "type": "clock"}, {"id": "z", "type": "sum"}],
    "wires": [{"from": "c.time", "to": "a.in"}, {"from": "b.time", "to": "z.in"}, {"from": "a.out", "to": "z.in"}]})";
  const char* two =
      R"({"version": 2, "name": "o", "lsis": [{"id": "z", "type": "sum"}, {"id": "c", "type": "clock"}, {"id": "a", "type": "gain"}, {"id": "b", "type": "clock"}],
    "wires": [{"from": "a.out", "to": "z.in"}, {"from": "b.time", "to": "z.in"}, {"from": "c.time", "to": "a.in"}]})";
  auto x = build(one), y = build(two);
  ASSERT_TRUE(x && y);
  EXPECT_EQ(x->schedule(), (std::vector<std::string>{"b", "c", "a", "z"}));
  EXPECT_EQ(x->schedule(), y->schedule());
}

const char* const nested = R"({"version": 2, "name": "outer",
  "inputs": [{"name": "x", "type": "scalar", "to": "twice.in"}],
  "outputs": [{"name": "y", "type": "scalar", "from": "twice.out"}],
  "lsis": [{"id": "twice", "type": "two gains", "parameters": {"factor": 3}}],
  "circuits": [
    {"name": "two gains",
     "inputs": [{"name": "in", "type": "scalar", "to": "first.in"}], "outputs": [{"name": "out", "type": "scalar", "from": "second.out"}],
     "parameters": [{"name": "factor", "to": ["first.factor", "second.gain"]}],
     "lsis": [{"id": "first", "type": "wrapped gain"}, {"id": "second", "type": "gain"}],
     "wires": [{"from": "first.out", "to": "second.in"}]},
    {"name": "wrapped gain",
     "inputs": [{"name": "in", "type": "scalar", "to": "g.in"}], "outputs": [{"name": "out", "type": "scalar", "from": "g.out"}],
     "parameters": [{"name": "factor", "to": "g.gain"}],
     "lsis": [{"id": "g", "type": "gain"}]}
  ]})";

TEST(Build, ExpandsNestedCircuits) {
  auto i = build(nested);
  ASSERT_TRUE(i) << i.error().text();
  const auto x = i->find_circuit_input("x");
  ASSERT_EQ(x.size(), 8u);
  const double seven = 7;
  std::memcpy(x.data(), &seven, 8);
  ASSERT_TRUE(i->tick());
  EXPECT_EQ(i->find_circuit_output("y")->numbers()[0], 63);
  EXPECT_EQ(value(*i, "twice/first/g.out"), 21);
  EXPECT_EQ(value(*i, "twice/second.out"), 63);
}

TEST(Build, WireBetweenIndependentPinsOfNestedCircuitIsNoLoop) {
  // The nested circuit has two independent paths. A wire from the output of one to the input of the other makes no algebraic loop.
  auto i = build(R"({"version": 2, "name": "o", "outputs": [{"name": "y", "type": "scalar", "from": "p.y2"}],
    "lsis": [{"id": "p", "type": "pair"}, {"id": "c", "type": "constant", "parameters": {"value": 4}}],
    "wires": [{"from": "c.out", "to": "p.x1"}, {"from": "p.y1", "to": "p.x2"}],
    "circuits": [{"name": "pair", "inputs": [{"name": "x1", "type": "scalar", "to": "a.in"}, {"name": "x2", "type": "scalar", "to": "b.in"}],
      "outputs": [{"name": "y1", "type": "scalar", "from": "a.out"}, {"name": "y2", "type": "scalar", "from": "b.out"}],
      "lsis": [{"id": "a", "type": "gain", "parameters": {"gain": 2}}, {"id": "b", "type": "gain", "parameters": {"gain": 5}}]}]})");
  ASSERT_TRUE(i) << i.error().text();
  ASSERT_TRUE(i->tick());
  EXPECT_EQ(i->find_circuit_output("y")->numbers()[0], 40);
}

TEST(Build, RefusesCircuitThatContainsItself) {
  expect_refused(R"({"version": 2, "name": "o", "lsis": [{"id": "a", "type": "x"}],
    "circuits": [{"name": "x", "lsis": [{"id": "b", "type": "y"}]}, {"name": "y", "lsis": [{"id": "c", "type": "x"}]}]})",
                 {"The circuit 'x' contains itself", "Remove 'a/b/c'"});
}

TEST(Build, RefusesTooManyNestedLsis) {
  std::string text = R"({"version": 2, "name": "o", "lsis": [{"id": "a", "type": "c0"}], "circuits": [)";
  for (int i = 0; i < 25; ++i) {
    text += R"({"name": "c)" + std::to_string(i) + R"(", "lsis": [)";
    for (const char* id : {"a", "b", "c"})
      text += R"({"id": ")" + std::string(id) + R"(", "type": ")" + (i < 24 ? "c" + std::to_string(i + 1) : "clock") + "\"}" +
              (*id != 'c' ? "," : "");
    text += i < 24 ? "]}," : "]}";
  }
  expect_refused(text + "]}", {"expands to more than"});
}

TEST(Build, RefusesTooManyInputsBehindNestedPins) {
  std::string text = R"({"version": 2, "name": "o", "lsis": [{"id": "t", "type": "clock"}, {"id": "a", "type": "c0"}],
    "wires": [{"from": "t.time", "to": "a.x"}], "circuits": [)";
  for (int i = 0; i < 28; ++i) {
    text += R"({"name": "c)" + std::to_string(i) + R"(", "inputs": [{"name": "x", "type": "scalar", "to": ["b.)";
    text += i < 27 ? R"(x", "b.x"]}], "lsis": [{"id": "b", "type": "c)" + std::to_string(i + 1) + R"("}]},)"
                   : R"(in", "b.in"]}], "lsis": [{"id": "b", "type": "gain"}]})";
  }
  expect_refused(text + "]}", {"The wires of nested circuits end at more than"});
}

TEST(Build, ChecksDeclaredTypesOfBoundaryPins) {
  expect_refused(R"({"version": 2, "name": "o", "outputs": [{"name": "y", "type": "vector", "from": "n.out"}],
    "lsis": [{"id": "n", "type": "inner"}, {"id": "v", "type": "make vector", "values": {"x": 1, "y": 2, "z": 3}}],
    "wires": [{"from": "v.out", "to": "n.in"}],
    "circuits": [{"name": "inner", "inputs": [{"name": "in", "type": "vector", "to": "g.in"}], "outputs": [{"name": "out", "type": "scalar", "from": "g.out"}],
                  "lsis": [{"id": "g", "type": "gain"}]}]})",
                 {"The circuit's pin 'in' is declared as vector, but 'n/g.in' inside is scalar",
                  "The circuit's pin 'y' is declared as vector, but 'n/g.out' inside is scalar", "Declare it as scalar"});
}

TEST(Build, DamagedTextIsRefusedOrRuns) {
  const std::string good = nested;
  std::uint64_t seed = 20260101;
  const auto random = [&seed](std::size_t below) {
    seed = seed * 6364136223846793005ULL + 1442695040888963407ULL;
    return static_cast<std::size_t>(seed >> 33) % below;
  };
  const std::string_view pieces[] = {"\"",    "{",      "}", "[", "]",     ",",  ":",    "gain",   "in",     "out",         "twice",
                                     "first", "second", ".", "/", "1e308", "-1", "null", "scalar", "vector", "wrapped gain"};
  int refused = 0, ran = 0;
  for (int k = 0; k < 5000; ++k) {
    std::string text = good;
    for (std::size_t n = 1 + random(3); n > 0; --n) {
      const std::size_t at = random(text.size()), length = random(8);
      text.replace(at, std::min(length, text.size() - at),
                   random(2) ? pieces[random(std::size(pieces))] : text.substr(random(text.size()), random(12)));
    }
    const auto circuit = read_circuit(text);
    if (!circuit) {
      EXPECT_FALSE(circuit.error().problems.empty());
      ++refused;
      continue;
    }
    auto built = Interpreter::build(*circuit, signal_library(), nullptr, {});
    if (!built) {
      for (const Problem& p : built.error().problems) EXPECT_FALSE(p.remedy.empty() || p.message.empty()) << text;
      ++refused;
      continue;
    }
    for (int t = 0; t < 3; ++t) built->tick();
    ++ran;
  }
  EXPECT_GT(refused, 1000);
  EXPECT_GT(ran, 5);
}

TEST(Build, OnDemandLsiMustNotFeedLsiThatRunsAtTicks) {
  expect_refused(R"({"version": 2, "name": "o", "lsis": [{"id": "c", "type": "clock", "every": 0}, {"id": "g", "type": "gain"}],
    "wires": [{"from": "c.time", "to": "g.in"}]})",
                 {"computed on demand only"});
  expect_refused(
      R"({"version": 2, "name": "o", "lsis": [{"id": "c", "type": "clock"}, {"id": "d", "type": "delay", "every": 0}], "wires": [{"from": "c.time", "to": "d.in"}]})",
      {"cannot run on demand"});
}

}  // namespace
}  // namespace ugoki::circuit
