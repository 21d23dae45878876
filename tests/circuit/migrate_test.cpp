// Migration of circuits of earlier versions, and byte-exact writing of large circuits.

#include "ugoki/circuit/migrate.h"

#include <fstream>
#include <iterator>
#include <string>

#include "circuit_test.h"

namespace ugoki::circuit {
namespace {

std::string file_of_version(int version) {
  std::ifstream in(std::string(UGOKI_SOURCE_DIR) + "/tests/circuit/versions/" + std::to_string(version) + ".json");
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST(Migration, FilesOfAllVersionsAreRead) {
  ASSERT_EQ(migrations().size(), static_cast<std::size_t>(circuit_version - 1));
  for (int version = 1; version <= circuit_version; ++version) {
    const std::string text = file_of_version(version);
    ASSERT_FALSE(text.empty()) << "tests/circuit/versions/" << version << ".json is missing";
    const Result<Circuit> c = read_circuit(text);
    ASSERT_TRUE(c) << version << ": " << c.error().text();
    EXPECT_EQ(c->lsis.size(), 4u);
    EXPECT_EQ(c->lsis[3].type, "somebody else's LSI") << "the type of an LSI that is not installed is kept";
    EXPECT_EQ(c->notes.size(), 2u);
    EXPECT_EQ(c->circuits.size(), 1u);
  }
}

TEST(Migration, FormerNamesOfVersionOneAreRenamed) {
  const Result<Circuit> c = read_circuit(R"({"version": 1, "name": "old",
    "outputs": [{"name": "figures", "type": "joint values", "from": "show.figures"}, {"name": "other", "type": "scalar", "from": "mine.figures"}],
    "lsis": [{"id": "show", "type": "display"}, {"id": "mine", "type": "own/class"}, {"id": "near", "type": "nearest pair"}],
    "wires": [{"from": "show.figures", "to": "mine.in"}, {"from": "mine.figures", "to": "near.a"}],
    "probes": [{"pin": "show.figures", "at": [0, 0]}],
    "circuits": [{"name": "inner", "outputs": [{"name": "figures", "type": "joint values", "from": "d.figures"}],
                  "lsis": [{"id": "d", "type": "display"}]}]})");
  ASSERT_TRUE(c) << c.error().text();
  EXPECT_EQ(c->outputs[0].name, "characters");
  EXPECT_EQ(c->outputs[0].ends, std::vector<std::string>{"show.characters"});
  EXPECT_EQ(c->outputs[1].ends, std::vector<std::string>{"mine.figures"}) << "a pin of another class keeps its name";
  EXPECT_EQ(c->lsis[2].type, "closest pair");
  EXPECT_EQ(c->wires[0].from, "show.characters");
  EXPECT_EQ(c->wires[1].from, "mine.figures");
  EXPECT_EQ(c->probes[0].pin, "show.characters");
  EXPECT_EQ(c->circuits[0].outputs[0].name, "figures") << "the name of an inner circuit's pin is its author's";
  EXPECT_EQ(c->circuits[0].outputs[0].ends, std::vector<std::string>{"d.characters"});
}

TEST(Migration, StepsRunInOrderFromTheVersionOfTheFile) {
  const Migration steps[] = {[](json::Json& c) { c["seen"] = c["seen"].get<std::string>() + "1>2 "; },
                             [](json::Json& c) { c["seen"] = c["seen"].get<std::string>() + "2>3 "; }};
  for (const auto& [version, seen] : {std::pair<int, const char*>(1, "1>2 2>3 "), {2, "2>3 "}, {3, ""}}) {
    json::Json c = {{"version", version}, {"seen", ""}};
    migrate(c, version, steps);
    EXPECT_EQ(c["version"], 3);
    EXPECT_EQ(c["seen"], seen);
  }
}

TEST(Migration, LaterVersionIsRefusedWithMessage) {
  const Result<Circuit> c = read_circuit(R"({"version": 99, "name": "t"})");
  ASSERT_FALSE(c);
  EXPECT_NE(c.error().text().find("up to version 2; this circuit has version 99"), std::string::npos) << c.error().text();
  EXPECT_FALSE(read_circuit(R"({"version": 0, "name": "t"})"));
  EXPECT_FALSE(read_circuit(R"({"version": -3, "name": "t"})"));
}

TEST(CircuitForm, CircuitOfTenThousandLsisIsWrittenByteExactly) {
  Circuit big;
  big.name = "big";
  for (int i = 0; i < 10'000; ++i) {
    Instance lsi;
    lsi.id = "g" + std::to_string(i);
    lsi.type = i % 7 == 0 ? "not/installed" : "gain";
    if (i % 3 == 0) lsi.label = "Gain \"" + std::to_string(i) + "\" \xC3\xA4";
    if (i % 5 == 0) lsi.note = "a note\nof two lines";
    lsi.at = {240.0 * (i % 100) + 0.1 * (i % 4), 110.0 * (i / 100)};
    lsi.parameters.push_back({"gain", 1.0 / (i + 1)});
    big.lsis.push_back(std::move(lsi));
    if (i > 0) big.wires.push_back({"g" + std::to_string(i - 1) + ".out", "g" + std::to_string(i) + ".in"});
  }
  const std::string text = write_circuit(big);
  const Result<Circuit> read = read_circuit(text);
  ASSERT_TRUE(read) << read.error().text();
  EXPECT_TRUE(write_circuit(*read) == text);
  EXPECT_EQ(read->lsis.size(), 10'000u);
  EXPECT_EQ(read->lsis[9999].parameters, big.lsis[9999].parameters);
  EXPECT_EQ(read->wires.size(), 9'999u);
}

}  // namespace
}  // namespace ugoki::circuit
