// The command circuit.edit, which changes a stored circuit.

#include <gtest/gtest.h>

#include "fixture.h"
#include "ugoki/circuit/circuit.h"
#include "ugoki/content/commands.h"
#include "ugoki/content/default_circuit.h"
#include "ugoki/content/delta.h"

namespace ugoki::content {
namespace {

using testing::make_resources;
using testing::make_scenario;

const char* const nested =
    R"({"version":1,"name":"mine","lsis":[{"id":"a","type":"clock"},{"id":"lost","type":"somebody else's LSI","parameters":{"word":"x","on":true}},{"id":"b","type":"arm"}],)"
    R"("wires":[{"from":"a.time","to":"b.in"}],"circuits":[{"name":"arm","inputs":[{"name":"in","type":"scalar","to":"g.in"}],)"
    R"("lsis":[{"id":"g","type":"gain"}],"circuits":[{"name":"elbow","lsis":[{"id":"deep","type":"clock"}]}]}]})";

class CircuitEditTest : public ::testing::Test {
 protected:
  /// Runs circuit.edit. @param more further fields of the command, beginning with a comma
  Result<CommandEffect> edit(const std::string& changes, const std::string& more = {}) {
    return apply_command(document, R"({"type": "circuit.edit", "changes": )" + changes + more + "}", catalogue, next_id);
  }
  /// Expects success and keeps the result. @return the label
  std::string good(const std::string& changes, const std::string& more = {}) {
    auto effect = edit(changes, more);
    EXPECT_TRUE(effect) << changes << "\n" << (effect ? "" : effect.error().text());
    if (effect) document = std::move(effect->scenario);
    return effect ? effect->label : std::string();
  }
  /// Expects that the command is refused with this location.
  void bad(const std::string& changes, const std::string& location) {
    const auto effect = edit(changes);
    ASSERT_FALSE(effect) << changes;
    EXPECT_EQ(effect.error().problems.front().location, location) << effect.error().text();
    EXPECT_FALSE(effect.error().problems.front().remedy.empty());
  }

  Resources resources = make_resources();
  Catalogue catalogue = catalogue_of(resources);
  Scenario document = make_scenario();
  std::uint64_t next_id = 1;
};

TEST_F(CircuitEditTest, FirstEditStartsFromTheDefaultCircuit) {
  const Result<circuit::Circuit> before = circuit::read_circuit(default_circuit(document));
  EXPECT_EQ(good(R"([{"list": "lsis", "put": {"id": "k", "type": "constant", "at": [10, 20]}}])", R"(, "label": "Add constant")"),
            "Add constant");
  const Result<circuit::Circuit> after = circuit::read_circuit(document.circuit);
  ASSERT_TRUE(after);
  ASSERT_EQ(after->lsis.size(), before->lsis.size() + 1);
  EXPECT_EQ(after->lsis.back().at.y, 20);
  EXPECT_EQ(after->wires, before->wires);
}

TEST_F(CircuitEditTest, UnnamedItemsStayByteForByte) {
  document.circuit = nested;
  good(R"([{"list": "lsis", "put": {"id": "a", "type": "clock", "at": [1, 2]}}])");
  good(R"([{"list": "lsis", "put": {"id": "a", "type": "clock"}}])");
  EXPECT_EQ(document.circuit, nested);
}

TEST_F(CircuitEditTest, PutTakeAndSetWorkAtEveryDepth) {
  document.circuit = nested;
  good(R"([{"in": ["arm"], "list": "lsis", "put": {"id": "h", "type": "gain"}},
           {"in": ["arm"], "list": "wires", "put": {"from": "g.out", "to": "h.in"}},
           {"in": ["arm"], "list": "outputs", "put": {"name": "out", "type": "scalar", "from": "h.out"}},
           {"in": ["arm", "elbow"], "set": {"doc": "Bends.", "inputs_at": [1, 2]}},
           {"list": "wires", "take": {"from": "a.time", "to": "b.in"}},
           {"list": "notes", "put": {"id": "n1", "text": "hello", "at": [0, 0]}},
           {"list": "lsis", "take": "a"}])");
  const Result<circuit::Circuit> c = circuit::read_circuit(document.circuit);
  ASSERT_TRUE(c);
  ASSERT_EQ(c->lsis.size(), 2u);
  EXPECT_EQ(c->lsis[0].id, "lost");
  EXPECT_TRUE(c->wires.empty());
  EXPECT_EQ(c->notes[0].text, "hello");
  const circuit::Circuit& arm = c->circuits[0];
  ASSERT_EQ(arm.lsis.size(), 2u);
  EXPECT_EQ(arm.lsis[1].id, "h");
  EXPECT_EQ(arm.wires[0].to, "h.in");
  EXPECT_EQ(arm.outputs[0].ends[0], "h.out");
  EXPECT_EQ(arm.circuits[0].doc, "Bends.");
  EXPECT_EQ(arm.circuits[0].inputs_at->y, 2);
  EXPECT_EQ(arm.circuits[0].lsis[0].id, "deep");
  good(R"([{"in": ["arm", "elbow"], "set": {"doc": null, "inputs_at": null}}])");
  EXPECT_TRUE(circuit::read_circuit(document.circuit)->circuits[0].circuits[0].doc.empty());
}

TEST_F(CircuitEditTest, CircuitThatCannotRunCanBeStored) {
  good(R"([{"list": "lsis", "put": {"id": "s", "type": "add"}}, {"list": "wires", "put": {"from": "s.out", "to": "s.a"}}])");
  good(R"([{"list": "lsis", "put": {"id": "m", "type": "not installed"}}])");
  EXPECT_TRUE(generate(document, resources));
}

TEST_F(CircuitEditTest, RefusedEditsNameTheLocationAndChangeNothing) {
  document.circuit = nested;
  const Scenario before = document;
  bad("{}", "command/changes");
  bad("[3]", "command/changes/0");
  bad(R"([{"list": "lsis"}])", "command/changes/0");
  bad(R"([{"list": "lsis", "take": "a"}, {"list": "lsis", "take": "a"}])", "command/changes/1/take");
  bad(R"([{"list": "lsis", "put": "a"}])", "command/changes/0/put");
  bad(R"([{"list": "lsis", "put": {"type": "clock"}}])", "command/changes/0/put");
  bad(R"([{"list": "wires", "take": "a"}])", "command/changes/0/take");
  bad(R"([{"list": "legs", "take": "a"}])", "command/changes/0/list");
  bad(R"([{"in": ["leg"], "list": "lsis", "take": "a"}])", "command/changes/0/in");
  bad(R"([{"in": "arm", "list": "lsis", "take": "g"}])", "command/changes/0/in");
  bad(R"([{"set": {"lsis": []}}])", "command/changes/0/set/lsis");
  bad(R"([{"set": {"doc": "x"}, "sat": 1}])", "command/changes/0/sat");
  bad(R"([{"list": "lsis", "put": {"id": "bad id", "type": "clock"}}])", "circuit/lsis/3/id");
  bad(R"([{"list": "lsis", "put": {"id": "a", "type": "clock", "colour": 1}}])", "circuit/lsis/0/colour");
  EXPECT_EQ(document, before);
}

TEST_F(CircuitEditTest, StoredCircuitMustHaveAValidForm) {
  const auto effect =
      apply_command(document, R"({"type": "circuit.set", "circuit": {"version": 1, "name": "x", "legs": 4}})", catalogue, next_id);
  ASSERT_FALSE(effect);
  EXPECT_EQ(effect.error().problems[0].location, "circuit/legs");
}

/// 10,000 LSIs and almost as many wires, changed as the web page changes them. Moving one LSI gives a small undo delta. Moving all of them
/// in one command would take too long if its cost were quadratic.
TEST_F(CircuitEditTest, TenThousandLsisAreEditedInLinearTime) {
  circuit::Circuit big;
  big.name = "big";
  std::string moves = "[";
  constexpr int n = 10'000;
  for (int i = 0; i < n; ++i) {
    circuit::Instance lsi;
    lsi.id = "g" + std::to_string(i);
    lsi.type = "gain";
    lsi.at = {static_cast<double>(i % 100) * 240, static_cast<double>(i / 100) * 90};
    big.lsis.push_back(lsi);
    if (i > 0) big.wires.push_back({"g" + std::to_string(i - 1) + ".out", lsi.id + ".in"});
    moves += (i ? "," : "") + std::string(R"({"list": "lsis", "put": {"id": ")") + lsi.id + R"(", "type": "gain", "at": [1, 2]}})";
  }
  document.circuit = write_circuit(big);
  const std::string text = document.circuit;
  const auto before = parse_json(write_scenario(document), "before");
  good(R"([{"list": "lsis", "put": {"id": "g5000", "type": "gain", "at": [1, 2]}}])");
  const auto after = parse_json(write_scenario(document), "after");
  EXPECT_LT(to_text(make_delta(*after, *before)).size(), 200u);
  good(moves + "]");
  EXPECT_EQ(circuit::read_circuit(document.circuit)->lsis[9'999].at.y, 2);
  EXPECT_EQ(circuit::write_circuit(*circuit::read_circuit(text)), text) << "reading and writing preserve every byte";
}

}  // namespace
}  // namespace ugoki::content
