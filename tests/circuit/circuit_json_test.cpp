#include <cstring>
#include <fstream>
#include <iterator>

#include "circuit_test.h"

namespace ugoki::circuit {
namespace {

const char* const everything = R"({
  "version": 2,
  "name": "everything",
  "doc": "Every field of the form, with \"quotes\" and umlauts: \u00e4.",
  "inputs_at": [-220, 0.5],
  "outputs_at": [640, 8],
  "inputs": [
    {"name": "x", "type": "scalar", "unit": "m", "doc": "In.", "to": ["a.a", "a.b"]}
  ],
  "outputs": [
    {"name": "y", "type": "scalar", "from": "half.out"}
  ],
  "parameters": [
    {"name": "factor", "doc": "Of the gain.", "to": "half.gain"}
  ],
  "lsis": [
    {"id": "a", "type": "add", "label": "A", "note": "adds", "at": [10.5, -20]},
    {"id": "half", "type": "gain", "every": 4, "parameters": {"gain": 0.1}},
    {"id": "v", "type": "add vectors", "values": {"a": [1, 2, 3], "b": [0, 0, 0.30000000000000004]}},
    {"id": "lost", "type": "somebody else's LSI", "parameters": {"word": "x", "on": true}}
  ],
  "wires": [
    {"from": "a.out", "to": "half.in"}
  ],
  "notes": [
    {"id": "n1", "text": "look\n\"here\"", "at": [3, -4], "size": [160, 80]},
    {"id": "n2", "text": "", "at": [0, 0]}
  ],
  "probes": [
    {"pin": "half.out", "at": [400, 20], "components": [0, 2]},
    {"pin": "v.out", "at": [0, 0]}
  ],
  "circuits": [
    {
      "name": "inner",
      "lsis": [
        {"id": "c", "type": "clock"}
      ]
    }
  ]
})";

TEST(CircuitJson, WriteAndReadKeepAllFields) {
  const Circuit first = parse(everything);
  const std::string text = write_circuit(first);
  const Circuit second = parse(text);
  EXPECT_TRUE(first == second);
  EXPECT_EQ(write_circuit(second), text);
  EXPECT_EQ(first.lsis[3].type, "somebody else's LSI");  // unknown LSIs are kept
  EXPECT_EQ(first.lsis[0].at.x, 10.5);
  EXPECT_EQ(first.notes[0].text, "look\n\"here\"");
  EXPECT_EQ(first.probes[0].components, (std::vector<std::uint32_t>{0, 2}));
  EXPECT_EQ(first.inputs_at->x, -220);
  EXPECT_EQ(std::get<std::vector<double>>(first.lsis[2].values[1].second)[2], 0.30000000000000004);
  EXPECT_NE(text.find("    {\"id\": \"half\", \"type\": \"gain\", \"every\": 4, \"parameters\": {\"gain\": 0.1}},\n"), std::string::npos)
      << text;
}

struct Bad {
  const char* text;
  const char* location;
};

class BadCircuitText : public testing::TestWithParam<Bad> {};

TEST_P(BadCircuitText, IsRefusedWithLocationAndRemedy) {
  const auto circuit = read_circuit(GetParam().text);
  ASSERT_FALSE(circuit);
  bool found = false;
  for (const Problem& p : circuit.error().problems) {
    found = found || p.location == GetParam().location;
    EXPECT_FALSE(p.remedy.empty());
    EXPECT_FALSE(p.message.empty());
  }
  EXPECT_TRUE(found) << circuit.error().text();
}

INSTANTIATE_TEST_SUITE_P(
    Forms, BadCircuitText,
    testing::Values(Bad{"", "circuit:1:1"}, Bad{"{\n\"version\": 1,\n\"name\": }", "circuit:3:9"}, Bad{"{\"version\": 1", "circuit:1:14"},
                    Bad{"[]", "circuit"}, Bad{"\xff\xfe", "circuit:1:1"}, Bad{"{}", "circuit/version"},
                    Bad{R"({"version": 3})", "circuit/version"}, Bad{R"({"version": "1"})", "circuit/version"},
                    Bad{R"({"version": 2, "nam": "x"})", "circuit/nam"}, Bad{R"({"version": 2, "name": 3})", "circuit/name"},
                    Bad{R"({"version": 2, "lsis": {}})", "circuit/lsis"}, Bad{R"({"version": 2, "lsis": [3]})", "circuit/lsis/0"},
                    Bad{R"({"version": 2, "lsis": [{"type": "add"}]})", "circuit/lsis/0"},
                    Bad{R"({"version": 2, "lsis": [{"id": "a b", "type": "add"}]})", "circuit/lsis/0/id"},
                    Bad{R"({"version": 2, "lsis": [{"id": "a.b", "type": "add"}]})", "circuit/lsis/0/id"},
                    Bad{R"({"version": 2, "lsis": [{"id": "a", "type": null}]})", "circuit/lsis/0/type"},
                    Bad{R"({"version": 2, "lsis": [{"id": "a", "type": "add", "at": [1]}]})", "circuit/lsis/0/at"},
                    Bad{R"({"version": 2, "lsis": [{"id": "a", "type": "add", "every": -1}]})", "circuit/lsis/0/every"},
                    Bad{R"({"version": 2, "lsis": [{"id": "a", "type": "add", "every": 1.5}]})", "circuit/lsis/0/every"},
                    Bad{R"({"version": 2, "lsis": [{"id": "a", "type": "add", "parameters": [1]}]})", "circuit/lsis/0/parameters"},
                    Bad{R"({"version": 2, "lsis": [{"id": "a", "type": "add", "parameters": {"p": {}}}]})", "circuit/lsis/0/parameters/p"},
                    Bad{R"({"version": 2, "lsis": [{"id": "a", "type": "add", "values": {"p": [1, "2"]}}]})", "circuit/lsis/0/values/p"},
                    Bad{R"({"version": 2, "wires": [{"from": "a.x"}]})", "circuit/wires/0"},
                    Bad{R"({"version": 2, "wires": [{"from": "a", "to": "b.y"}]})", "circuit/wires/0/from"},
                    Bad{R"({"version": 2, "wires": [{"from": "a.", "to": "b.y"}]})", "circuit/wires/0/from"},
                    Bad{R"({"version": 2, "wires": [{"from": 1, "to": ".y"}]})", "circuit/wires/0/to"},
                    Bad{R"({"version": 2, "inputs": [{"name": "x", "type": "colour", "to": "a.b"}]})", "circuit/inputs/0/type"},
                    Bad{R"({"version": 2, "inputs": [{"name": "x", "type": "scalar"}]})", "circuit/inputs/0"},
                    Bad{R"({"version": 2, "outputs": [{"name": "x", "type": "scalar", "from": ["a.b", "a.c"]}]})",
                        "circuit/outputs/0/from"},
                    Bad{R"({"version": 2, "outputs": [{"name": "x.y", "type": "scalar", "from": "a.b"}]})", "circuit/outputs/0/name"},
                    Bad{R"({"version": 2, "notes": [{"text": "x"}]})", "circuit/notes/0"},
                    Bad{R"({"version": 2, "notes": [{"id": "n", "size": [1]}]})", "circuit/notes/0/size"},
                    Bad{R"({"version": 2, "probes": [{"at": [0, 0]}]})", "circuit/probes/0/pin"},
                    Bad{R"({"version": 2, "probes": [{"pin": "a.b", "components": [-1]}]})", "circuit/probes/0/components"},
                    Bad{R"({"version": 2, "inputs_at": 3})", "circuit/inputs_at"},
                    Bad{R"({"version": 2, "circuits": [{"lsis": []}]})", "circuit/circuits/0"}));

TEST(CircuitJson, DocumentationExampleBuildsAndRuns) {
  std::ifstream file(UGOKI_SOURCE_DIR "/docs/circuit.md");
  std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  const auto begin = text.find("```json\n") + 8;
  const auto end = text.find("```", begin);
  ASSERT_NE(end, std::string::npos);
  auto i = build(text.substr(begin, end - begin));
  ASSERT_TRUE(i) << i.error().text();
  const double step = 3;
  std::memcpy(i->find_circuit_input("step").data(), &step, sizeof step);
  for (int k = 0; k < 5; ++k) ASSERT_TRUE(i->tick());
  EXPECT_EQ(i->find_circuit_output("count")->numbers()[0], 10);
}

TEST(CircuitJson, RefusesDeepNesting) {
  std::string text = R"({"version": 2)";
  for (int i = 0; i < 200; ++i) text += R"(, "circuits": [{"name": "c")";
  for (int i = 0; i < 200; ++i) text += "}]";
  const auto circuit = read_circuit(text + "}");
  ASSERT_FALSE(circuit);
  EXPECT_NE(circuit.error().text().find("nested"), std::string::npos);
  EXPECT_FALSE(read_circuit(std::string(200000, '[')));
}

TEST(CircuitJson, TruncatedTextIsRefused) {
  const std::string text = everything;
  for (std::size_t n = 0; n < text.size(); ++n) EXPECT_FALSE(read_circuit(text.substr(0, n))) << n;
}

}  // namespace
}  // namespace ugoki::circuit
