// Hot reload: a library is rebuilt while its circuit runs.

#include "plugin_test.h"

namespace ugoki::plugin {
namespace {

/// Source of a library "reload" with the LSI "count". @param step statements that change the state s
std::string counter(const std::string& fields, const std::string& step, const std::string& extra = {}) {
  return "/// @library reload\nstruct state { " + fields + " };\n/// Counts.\n" + extra + "double count(struct state* s, double x) { " +
         step + " return s->n + x; }\n";
}

class ReloadTest : public PluginTest {
 protected:
  const std::string circuit_ =
      R"({"version": 1, "name": "t", "lsis": [{"id": "n", "type": "reload/count", "values": {"x": 0.5}}, {"id": "d", "type": "delay"}],
    "wires": [{"from": "n.out", "to": "d.in"}]})";
};

TEST_F(ReloadTest, StateIsKeptWhereTheLayoutAllowsIt) {
  const std::string path = build("reload.c", counter("double n;", "s->n += 1;"));
  LiveLibrary live(signals_, {}, {path});
  std::shared_ptr<const circuit::Library> library = live.library();
  auto i = circuit::Interpreter::build(parse(circuit_), *library, nullptr, {});
  ASSERT_TRUE(i) << i.error().text();
  for (int k = 0; k < 5; ++k) ASSERT_TRUE(i->tick());
  EXPECT_EQ(value(*i, "n.out"), 5.5);
  EXPECT_FALSE(live.poll());

  const auto reload = [&](const std::string& text) {
    build("reload.c", text);
    EXPECT_TRUE(live.poll());
    EXPECT_TRUE(live.take_messages().empty());
    auto next = circuit::Interpreter::build(parse(circuit_), *live.library(), nullptr, {});
    EXPECT_TRUE(next) << next.error().text();
    const circuit::Interpreter::Adoption report = next->adopt_report(*i);
    *i = std::move(*next);
    library = live.library();
    EXPECT_TRUE(i->tick());
    return report;
  };
  // The layout is unchanged: the whole state is kept.
  circuit::Interpreter::Adoption report = reload(counter("double n;", "s->n += 10;"));
  EXPECT_EQ(report.kept, 2u);
  EXPECT_EQ(value(*i, "n.out"), 15.5);
  EXPECT_EQ(value(*i, "d.out"), 15.5);
  EXPECT_EQ(i->ticks(), 6u);
  // A field was added in front: the old field keeps its value by name.
  report = reload(counter("int calls; double n;", "s->n += 10; ++s->calls;"));
  EXPECT_EQ(value(*i, "n.out"), 25.5);
  ASSERT_EQ(report.partly.size(), 1u);
  EXPECT_EQ(report.partly[0], "'n' keeps 1 fields of its state; the field 'calls' is new.");
  // Another @version: the state starts from its initial values, and the report states it.
  report = reload(counter("int calls; double n;", "s->n += 1; ++s->calls;", "/// @version 2\n"));
  EXPECT_EQ(value(*i, "n.out"), 1.5);
  ASSERT_EQ(report.afresh.size(), 1u);
  EXPECT_EQ(report.afresh[0], "'n' starts from its initial state: its version was 1, now it is 2.");
}

TEST_F(ReloadTest, BrokenLibraryKeepsThePreviousOneRunning) {
  const std::string path = build("reload.c", counter("double n;", "s->n += 1;"));
  LiveLibrary live(signals_, {}, {path});
  const std::shared_ptr<const circuit::Library> library = live.library();
  auto i = circuit::Interpreter::build(parse(circuit_), *library, nullptr, {});
  ASSERT_TRUE(i && i->tick());
  write("reload.so", "broken");
  EXPECT_TRUE(live.poll());
  EXPECT_EQ(live.take_messages().size(), 1u);
  EXPECT_NE(live.library()->find("reload/count"), nullptr);
  ASSERT_TRUE(i->tick());
  EXPECT_EQ(value(*i, "n.out"), 2.5);
  auto again = circuit::Interpreter::build(parse(circuit_), *live.library(), nullptr, {});
  ASSERT_TRUE(again && again->tick());
}

}  // namespace
}  // namespace ugoki::plugin
