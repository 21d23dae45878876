// The LSI builder from source files to running LSIs.

#include <algorithm>

#include "plugin_test.h"

namespace ugoki::plugin {
namespace {

const char* const three = R"(/// @library tools
/// Three of them.

/// Doubles.
double twice(double x) { return 2 * x; }

/// Length and direction of a vector.
/// @in v [m]  Any vector but zero.
/// @out length [m] 0..1e6
void polar(const double v[3], double* length, double direction[3]) {
  double s = 0;
  for (int i = 0; i < 3; ++i) s += v[i] * v[i];
  double r = s > 0 ? s : 1;
  for (int i = 0; i < 40; ++i) r = 0.5 * (r + s / r);
  *length = r;
  for (int i = 0; i < 3; ++i) direction[i] = v[i] / r;
}

struct counter { int n; /* = 10 ticks so far */ double last; };
/// Counts how often x rises.
/// @lsi rise counter
/// @parameter step = 1, 1..100  What a rise adds.
int count(struct counter* c, double x, int step) {
  if (x > c->last) c->n += step;
  c->last = x;
  return c->n;
}
static double help(double x) { return x; }
char* text(double x) { return 0; }
double use(double x) { return help(x); }
)";

TEST_F(PluginTest, FunctionsBecomeLsis) {
  const Result<BuildReport> report = build_library({write("tools.c", three), {}, {}, {}});
  ASSERT_TRUE(report) << report.error().text();
  EXPECT_EQ(report->name, "tools");
  ASSERT_EQ(report->notes.size(), 1u);
  EXPECT_NE(report->notes[0].find("tools.c:29: 'text' does not become an LSI"), std::string::npos) << report->notes[0];
  const Result<LoadedLibrary> library = load_library(report->output);
  ASSERT_TRUE(library) << library.error().text();
  EXPECT_EQ(library->doc, "Three of them.");
  ASSERT_EQ(library->classes.size(), 4u);
  const circuit::LsiClass& polar = library->classes[0];
  EXPECT_EQ(polar.name, "tools/polar");
  EXPECT_EQ(polar.doc, "Length and direction of a vector.");
  EXPECT_EQ(polar.inputs[0].type, circuit::PinTypeId::vector);
  EXPECT_EQ(polar.inputs[0].unit, "m");
  EXPECT_EQ(polar.inputs[0].doc, "Any vector but zero.");
  EXPECT_EQ(polar.outputs[0].name, "length");
  EXPECT_EQ(polar.outputs[0].maximum, 1e6);
  EXPECT_EQ(polar.outputs[1].type, circuit::PinTypeId::vector);
  const circuit::LsiClass& count = library->classes[1];
  EXPECT_EQ(count.name, "tools/rise counter");
  ASSERT_EQ(count.parameters.size(), 1u);
  EXPECT_EQ(count.parameters[0].kind, circuit::ParameterKind::integer);
  EXPECT_EQ(count.parameters[0].maximum, 100);
  ASSERT_EQ(count.fields.size(), 2u);
  EXPECT_EQ(count.fields[0].initial, 10);
  EXPECT_EQ(count.fields[0].doc, "ticks so far");

  LiveLibrary live(signals_, {}, {report->output});
  EXPECT_TRUE(live.take_messages().empty());
  auto i = circuit::Interpreter::build(parse(R"({"version": 1, "name": "t",
    "lsis": [{"id": "c", "type": "clock"}, {"id": "t", "type": "twice"}, {"id": "v", "type": "make vector", "values": {"y": 4, "z": 0}},
             {"id": "p", "type": "tools/polar"}, {"id": "n", "type": "tools/rise counter", "parameters": {"step": 3}}],
    "wires": [{"from": "c.time", "to": "t.x"}, {"from": "t.out", "to": "v.x"}, {"from": "v.out", "to": "p.v"}, {"from": "c.time", "to": "n.x"}]})"),
                                       *live.library(), nullptr, {.dt = 1.5});
  ASSERT_TRUE(i) << i.error().text();
  for (int k = 0; k < 2; ++k) ASSERT_TRUE(i->tick()) << i->stopped()->text();
  EXPECT_EQ(value(*i, "t.out"), 3);
  EXPECT_NEAR(value(*i, "p.length"), 5, 1e-12);
  EXPECT_NEAR(i->find_output("p.direction")->numbers()[1], 0.8, 1e-12);
  EXPECT_EQ(value(*i, "n.out"), 13);
  i->reset();
  ASSERT_TRUE(i->tick());
  EXPECT_EQ(value(*i, "n.out"), 10);
}

const char* const in_cpp = R"(// @library more
namespace signals {
struct Smooth { double y = 5; int calls = 0; };
/// @in x = 1
/// @parameter on: scalar = true
double smooth(Smooth& s, double x, double dt, bool on, double& slope) {
  slope = (x - s.y) / dt;
  if (on) s.y += 0.5 * (x - s.y);
  ++s.calls;
  return s.y;
}
/// @delayed
double late(double x) { return x; }
}
)";

TEST_F(PluginTest, CppStatesHaveTheInitialValuesOfTheirMembers) {
  LiveLibrary live(signals_, {}, {build("more.cpp", in_cpp)});
  auto i = circuit::Interpreter::build(
      parse(R"({"version": 1, "name": "t", "lsis": [{"id": "s", "type": "more/smooth"}, {"id": "l", "type": "late"}],
    "wires": [{"from": "s.out", "to": "l.x"}, {"from": "l.out", "to": "s.x"}]})"),
      *live.library(), nullptr, {.dt = 0.5});
  ASSERT_TRUE(i) << i.error().text();  // the feedback loop is allowed because `late` is delayed
  ASSERT_TRUE(i->tick());
  EXPECT_EQ(value(*i, "s.out"), 2.5);
  EXPECT_EQ(value(*i, "s.slope"), -10);
  EXPECT_EQ(value(*i, "l.out"), 2.5);
}

const char* const with_header = R"(#include <ugoki/lsi.hpp>
struct Spring {
  double x = 0.25, stiffness = 100, force = 0;
  std::array<double, 3> axis{0, 0, 1}, pull{};
  int steps = 0;
  const char* step(const ugoki::Tick& tick) {
    if (tick.dt <= 0) return "No time passes.";
    if (x > 5) throw std::exception();
    force = -stiffness * x;
    for (int i = 0; i < 3; ++i) pull[i] = force * axis[i];
    ++steps;
    return x > 3 ? "The spring broke." : nullptr;
  }
};
UGOKI_LSI(Spring, "spring", "Pulls back.", ugoki::in(&Spring::x, "x", "m", "Stretch.", {-1, 10}), ugoki::in(&Spring::axis, "axis"),
          ugoki::parameter(&Spring::stiffness, "stiffness", "N/m", "", {0, 1e6}), ugoki::out(&Spring::force, "force", "N"),
          ugoki::out(&Spring::pull, "pull", "N"), ugoki::state(&Spring::steps, "steps"))
UGOKI_LIBRARY("springs", "2.1", "Of steel.")
)";

TEST_F(PluginTest, HeaderMakesStructsLsis) {
  for (const char* compiler : {"clang++-19", "g++"}) {  // libraries may be built with another compiler than the program
    if (!find_compiler(true, compiler)) continue;
    LiveLibrary live(signals_, {}, {build("springs.cpp", with_header, compiler)});
    auto i = circuit::Interpreter::build(parse(R"({"version": 1, "name": "t", "inputs": [{"name": "x", "type": "scalar", "to": "s.x"}],
      "lsis": [{"id": "s", "type": "spring", "values": {"axis": [1, 0, 0]}}]})"),
                                         *live.library(), nullptr, {});
    ASSERT_TRUE(i) << i.error().text();
    auto* x = reinterpret_cast<double*>(i->find_circuit_input("x").data());
    *x = 2;
    ASSERT_TRUE(i->tick());
    EXPECT_EQ(value(*i, "s.force"), -200);
    EXPECT_EQ(i->find_output("s.pull")->numbers()[0], -200);
    *x = 4;
    EXPECT_FALSE(i->tick());
    EXPECT_EQ(i->stopped()->reason, "The spring broke.");
    EXPECT_NE(i->stopped()->text().find("'x' = 4"), std::string::npos) << i->stopped()->text();
    i->reset();
    *x = 6;
    EXPECT_FALSE(i->tick());  // the exception does not reach the host
    EXPECT_EQ(i->stopped()->lsi, "s");
  }
}

TEST_F(PluginTest, CompilerErrorsAreLocatedInTheUsersFile) {
  for (const char* name : {"bad.c", "bad.cpp"}) {
    const std::string path =
        write(name, "/// Fine.\ndouble good(double x) { return x; }\n\ndouble bad(double x) {\n  return x + missing;\n}\n");
    const Result<BuildReport> report = build_library({path, {}, {}, {}});
    ASSERT_FALSE(report);
    const Problem& p = report.error().problems[0];
    EXPECT_TRUE(p.location.starts_with(path + ":5:")) << p.location;
    EXPECT_NE(p.message.find("missing"), std::string::npos);
    EXPECT_NE(p.remedy.find("return x + missing;"), std::string::npos) << p.remedy;
  }
}

TEST_F(PluginTest, InvalidSourcesAreRefusedWithRemedy) {
  const auto refused = [&](const char* name, const char* text, const char* part, const std::string& compiler = {}) {
    const Result<BuildReport> report = build_library({write(name, text), {}, {}, compiler});
    ASSERT_FALSE(report) << part;
    EXPECT_NE(report.error().text().find(part), std::string::npos) << report.error().text();
    for (const Problem& p : report.error().problems) EXPECT_FALSE(p.remedy.empty());
  };
  refused("empty.c", "", "no function that can become an LSI");
  refused("only.c", "char* f(char* c) { return c; }", "no function that can become an LSI");
  refused("typo.c", "/// @in y [m]\ndouble f(double x) { return x; }", "The annotation 'in' names 'y'");
  refused("type.c", "/// @in x: vector\ndouble f(double x) { return x; }", "cannot be of the type 'vector'");
  refused("range.c", "/// @parameter k = 5, 0..1\ndouble f(double x, double k) { return k * x; }", "outside of its range 0..1");
  refused("program.py", "x = 1", "C and C++");
  refused("link.c", "double other(double);\ndouble f(double x) { return other(x); }\n#error here", "here");
  refused("none.c", "double f(double x) { return x; }", "The compiler 'no-such-compiler' was not found", "no-such-compiler");
  EXPECT_FALSE(build_library({folder_ + "/missing.c", {}, {}, {}}));
}

TEST_F(PluginTest, MissingCompilerNamesThePackageToInstall) {
  const std::string before = ::getenv("PATH");
  ::setenv("PATH", folder_.c_str(), 1);
  const Result<std::string> found = find_compiler(false);
  ::setenv("PATH", before.c_str(), 1);
  ASSERT_FALSE(found);
  EXPECT_NE(found.error().text().find("apt-get install clang-19"), std::string::npos);
}

TEST_F(PluginTest, PointerWithACountIsNoOutput) {
  for (const char* declaration : {"double mean(double* v, int n)", "double mean(double* v, size_t size)",
                                  "double mean(float* v, int v_count)", "double mean(double* v, const unsigned numValues)"}) {
    write("mean.c", std::string("#include <stddef.h>\n") + declaration + " { return v[0]; }\ndouble good(double x) { return x; }\n");
    const auto report = build_library({folder_ + "/mean.c", {}, {}, {}});
    ASSERT_TRUE(report) << report.error().text();
    ASSERT_EQ(report->notes.size(), 1u) << declaration;
    EXPECT_NE(report->notes[0].find("its parameter 'v' may be an array of"), std::string::npos) << report->notes[0];
  }
  for (const char* text : {"/// @out v\ndouble mean(double* v, int n) { *v = n; return 1; }\n",
                           "double mean(double* v, int mode) { *v = mode; return 1; }\n"}) {
    write("mean.c", text);
    const auto report = build_library({folder_ + "/mean.c", {}, {}, {}});
    ASSERT_TRUE(report) << report.error().text();
    EXPECT_TRUE(report->notes.empty()) << report->notes[0];
  }
}

TEST_F(PluginTest, WarningsPointIntoTheFile) {
  for (const char* name : {"few.c", "few.cpp"})
    for (const char* compiler : {"clang", "gcc"}) {
      const bool cpp = std::string(name).ends_with("cpp");
      write(name,
            "struct memory { float f; unsigned char c; long n; };\nlong f(struct memory* m, float a, unsigned b, long c, double y[2])\n"
            "{ y[0] = y[1] = a; m->n += b; return c; }\n");
      const std::string program = std::string(compiler) == "gcc" ? (cpp ? "g++" : "gcc") : "";
      const auto report = build_library({folder_ + "/" + name, {}, {}, program});
      if (!report && !program.empty()) continue;  // not installed
      ASSERT_TRUE(report) << report.error().text();
      for (const std::string& warning : report->warnings) {
        const auto colon = warning.find(':');
        EXPECT_LE(std::atoi(warning.c_str() + colon + 1), 3) << warning;
        EXPECT_TRUE(warning.starts_with(folder_ + "/" + name)) << warning;
      }
    }
}

}  // namespace
}  // namespace ugoki::plugin
