// Circuits with one error each: all are refused, with the JSON path of the error and a remedy.

#include <functional>
#include <nlohmann/json.hpp>
#include <random>
#include <set>

#include "circuit_test.h"

namespace ugoki::circuit {
namespace {

using Json = nlohmann::ordered_json;

const char* const good_circuit = R"({"version": 2, "name": "good", "doc": "Everything once.",
  "inputs": [{"name": "x", "type": "scalar", "to": ["sum.a", "arm.in"]}],
  "outputs": [{"name": "y", "type": "scalar", "from": "limit.out"}, {"name": "z", "type": "vector", "from": "late.out"}],
  "parameters": [{"name": "top", "to": "limit.maximum"}],
  "lsis": [{"id": "sum", "type": "add", "at": [0, 10]}, {"id": "limit", "type": "clamp", "note": "n", "parameters": {"maximum": 10}},
           {"id": "last", "type": "delay", "parameters": {"initial": 1}}, {"id": "v", "type": "make vector", "values": {"y": 2, "z": 3}},
           {"id": "late", "type": "delay vector"}, {"id": "arm", "type": "arm", "parameters": {"factor": 2}},
           {"id": "slow", "type": "low-pass", "every": 10, "parameters": {"time": 0.5}}, {"id": "turn", "type": "delay rotation", "values": {"in": [1, 0, 0, 0]}}],
  "wires": [{"from": "last.out", "to": "sum.b"}, {"from": "sum.out", "to": "limit.in"}, {"from": "limit.out", "to": "last.in"},
            {"from": "arm.out", "to": "v.x"}, {"from": "v.out", "to": "late.in"}, {"from": "sum.out", "to": "slow.in"}],
  "circuits": [{"name": "arm", "inputs": [{"name": "in", "type": "scalar", "to": "g.in"}], "outputs": [{"name": "out", "type": "scalar", "from": "g.out"}],
                "parameters": [{"name": "factor", "to": "g.gain"}], "lsis": [{"id": "g", "type": "gain"}]}]})";

/// The problems of reading and building the circuit; empty: none.
Error refuse(const std::string& text) {
  const Result<Circuit> circuit = read_circuit(text);
  if (!circuit) return circuit.error();
  const Result<Interpreter> made = Interpreter::build(*circuit, signal_library(), nullptr, {});
  return made ? Error{} : made.error();
}

/// Whether the document contains the path, for example "circuit/lsis/5(arm)/lsis/0/type"; " 'arm/g'" may follow the path. Its last part may
/// be the name of a missing field.
bool path_exists(const Json& top, std::string path) {
  if (path.starts_with("circuit:")) return true;  // location "circuit:line" in a text that is not JSON
  if (const auto name = path.find(" '"); name != std::string::npos) path.resize(name);
  if (path == "circuit") return true;
  if (!path.starts_with("circuit/")) return false;
  path.erase(0, 8);
  const Json* at = &top;
  while (!path.empty()) {
    const auto slash = path.find('/');
    std::string part = path.substr(0, slash), circuit;
    path = slash == std::string::npos ? "" : path.substr(slash + 1);
    if (const auto bracket = part.find('('); bracket != std::string::npos) {
      circuit = part.substr(bracket + 1, part.size() - bracket - 2);
      part.resize(bracket);
    }
    if (at->is_array()) {
      const std::size_t i = std::stoul(part);
      if (i >= at->size()) return false;
      at = &(*at)[i];
    } else if (at->is_object()) {
      const auto found = at->find(part);
      if (found == at->end()) return path.empty();
      at = &*found;
    } else {
      return false;
    }
    if (circuit.empty()) continue;
    const Json* inner = nullptr;
    for (const Json& c : top["circuits"])
      if (c["name"] == circuit) inner = &c;
    if (!inner) return false;
    at = inner;
  }
  return true;
}

void expect_refused(const Json& circuit, const std::string& text, const std::string& how) {
  const Error error = refuse(text);
  ASSERT_FALSE(error.empty()) << how << " was accepted:\n" << text;
  for (const Problem& p : error.problems) {
    EXPECT_TRUE(path_exists(circuit, p.location)) << how << ": '" << p.location << "' does not exist in\n" << text;
    EXPECT_FALSE(p.message.empty()) << how;
    EXPECT_GT(p.remedy.size(), 6u) << how << ": no remedy for: " << p.message;
  }
}

/// Calls visit(key, object) for every object of the document; `key` is the field that contains it.
void each_object(Json& json, const std::string& key, const std::function<void(const std::string&, Json&)>& visit) {
  if (json.is_object()) visit(key, json);
  if (json.is_object())
    for (auto it = json.begin(); it != json.end(); ++it) each_object(it.value(), it.key(), visit);
  else if (json.is_array())
    for (Json& item : json) each_object(item, key, visit);
}

class Malformed : public ::testing::Test {
 protected:
  void refuse_changed(const std::string& how, const std::function<void(Json&)>& change) {
    Json circuit = Json::parse(good_circuit);
    change(circuit);
    const std::string text = circuit.dump();
    if (!seen_.insert(text).second) return;
    expect_refused(circuit, text, how);
  }
  /// Changes each field of each object in turn, and expects each changed circuit to be refused.
  /// @param change  changes `field` of `object`; returns false to skip it
  void each_field(const std::string& how,
                  const std::function<bool(const std::string& where, Json& object, const std::string& field)>& change) {
    Json probe = Json::parse(good_circuit);
    std::vector<std::pair<std::size_t, std::string>> fields;
    std::size_t n = 0;
    each_object(probe, "circuit", [&](const std::string&, Json& o) {
      for (auto it = o.begin(); it != o.end(); ++it) fields.emplace_back(n, it.key());
      ++n;
    });
    for (const auto& [object, field] : fields) {
      Json circuit = Json::parse(good_circuit);
      std::size_t i = 0;
      bool changed = false;
      each_object(circuit, "circuit", [&, f = field, wanted = object](const std::string& where, Json& o) {
        if (i++ == wanted && o.contains(f)) changed = change(where, o, f);
      });
      const std::string text = circuit.dump();
      if (changed && seen_.insert(text).second) expect_refused(circuit, text, how + " " + field);
    }
  }
  std::set<std::string> seen_;
};

TEST_F(Malformed, UnchangedCircuitIsAccepted) { EXPECT_TRUE(refuse(good_circuit).empty()) << refuse(good_circuit).text(); }

TEST_F(Malformed, AllAreRefusedWithPathAndRemedy) {
  // Values of a wrong type, in every field.
  for (const Json& wrong : {Json(nullptr), Json::object({{"a", 1}}), Json("?"), Json(true), Json(-7.5), Json::array({Json::array()})})
    each_field("a wrong value for", [&](const std::string& where, Json& o, const std::string& f) {
      const bool free_text = f == "doc" || f == "note" || f == "label" || f == "name" || f == "unit";
      if (wrong.is_string() && free_text) return false;
      if (where == "values" && wrong.is_number() && f != "in") return false;
      if (f == "factor" || f == "initial" || f == "maximum" || f == "top") {
        if (wrong.is_number()) return false;
      }
      o[f] = wrong;
      return true;
    });
  // Unknown fields.
  each_field("an unknown field next to", [&](const std::string& where, Json& o, const std::string& f) {
    if (where == "parameters" && !o.contains("name")) {
      o["unknown parameter"] = 1;
      return true;
    }
    o[f + "s?"] = 1;
    return true;
  });
  // Missing required fields.
  each_field("without", [&](const std::string& where, Json& o, const std::string& f) {
    const bool pin = o.contains("to") || o.contains("from");
    const bool needed = f == "id" || (f == "type" && (o.contains("id") || pin)) || f == "to" || f == "from" || (pin && f == "name") ||
                        f == "version" || (where == "circuits" && f == "name") || where == "values";
    if (!needed) return false;
    if (f == "from" && !o.contains("to")) return false;  // an output of the circuit may be without a wire
    o.erase(f);
    return true;
  });
  // Wires from or to an LSI or pin that does not exist.
  each_field("an end of", [&](const std::string&, Json& o, const std::string& f) {
    if (f != "from" && f != "to") return false;
    o[f] = "nobody.out";
    return true;
  });
  each_field("a pin of", [&](const std::string&, Json& o, const std::string& f) {
    if ((f != "from" && f != "to") || !o[f].is_string()) return false;
    const std::string end = o[f];
    o[f] = end.substr(0, end.find('.')) + ".nothing";
    return true;
  });
  for (const char* end : {"", "sum", ".a", "sum.", "su m.a", "sum.a.b.", "\xc3\xa4.a"})
    refuse_changed("an end", [&](Json& c) { c["wires"][0]["to"] = end; });
  for (const char* id : {"", "a b", "a.b", "a/b", "\xc3\xa4", "0123456789012345678901234567890123456789012345678901234567890123456789"})
    refuse_changed("an id", [&](Json& c) { c["lsis"][0]["id"] = id; });
  for (const Json& every : {Json(-1), Json(1.5), Json(1000001), Json("2"), Json(1e300)})
    refuse_changed("every", [&](Json& c) { c["lsis"][6]["every"] = every; });
  for (const Json& version : {Json(0), Json(-1), Json(99), Json(1.5), Json("1")})
    refuse_changed("version", [&](Json& c) { c["version"] = version; });
  for (std::size_t i = 0; i < 8; ++i) {
    refuse_changed("two of an id", [&](Json& c) { c["lsis"].push_back(c["lsis"][i]); });
    refuse_changed("a type", [&](Json& c) { c["lsis"][i]["type"] = "no such LSI"; });
    refuse_changed("a library", [&](Json& c) { c["lsis"][i]["type"] = "springs/damper"; });
    refuse_changed("a value of no pin", [&](Json& c) { c["lsis"][i]["values"]["nothing"] = 1; });
    refuse_changed("a parameter", [&](Json& c) { c["lsis"][i]["parameters"]["nothing"] = 1; });
    refuse_changed("on demand", [&](Json& c) {
      c["lsis"][i]["every"] = i == 7 ? 5000000 : 0;
      if (i == 6) c["lsis"][i]["every"] = -3;
    });
  }
  for (std::size_t w = 0; w < 6; ++w) {
    refuse_changed("a second wire", [&](Json& c) { c["wires"].push_back(c["wires"][w]); });
    refuse_changed("a wire of another type", [&](Json& c) { c["wires"][w]["from"] = w == 4 ? "sum.out" : "v.out"; });
    refuse_changed("a wire backwards", [&](Json& c) {
      const Json from = c["wires"][w]["from"];
      c["wires"][w]["from"] = c["wires"][w]["to"];
      c["wires"][w]["to"] = from;
    });
  }
  refuse_changed("a cycle", [](Json& c) { c["wires"][0]["from"] = "limit.out"; });
  refuse_changed("a cycle of one LSI", [](Json& c) { c["wires"][0]["from"] = "sum.out"; });
  refuse_changed("a cycle through a circuit", [](Json& c) {
    c["inputs"][0]["to"] = "sum.a";
    c["wires"].push_back({{"from", "arm.out"}, {"to", "arm.in"}});
  });
  refuse_changed("a circuit in itself", [](Json& c) { c["circuits"][0]["lsis"].push_back({{"id", "again"}, {"type", "arm"}}); });
  for (const char* type : {"vector", "event", "state"}) {
    refuse_changed("a boundary type", [&](Json& c) { c["outputs"][0]["type"] = type; });
    refuse_changed("a boundary type", [&](Json& c) { c["inputs"][0]["type"] = type; });
    refuse_changed("a boundary type inside", [&](Json& c) { c["circuits"][0]["outputs"][0]["type"] = type; });
  }
  for (const Json& value : {Json(11), Json(-11), Json("1"), Json::array({1, 2, 3}), Json(1e301)})
    refuse_changed("a parameter's value",
                   [&](Json& c) { c["lsis"][6]["parameters"]["time"] = value.is_number() && value > 0 ? Json(1e7) : value; });
  for (const Json& value :
       {Json(1), Json::array({1, 2, 3}), Json::array({1, 2, 3, 4, 5}), Json::array(), Json("up"), Json::array({1, "a", 0, 0})})
    refuse_changed("a rotation's value", [&](Json& c) { c["lsis"][7]["values"]["in"] = value; });
  refuse_changed("a value and no class", [](Json& c) { c["lsis"][5]["values"]["in"] = 1; });
  refuse_changed("an output of two pins", [](Json& c) { c["outputs"][0]["from"] = Json::array({"limit.out", "sum.out"}); });
  refuse_changed("two outputs of a name",
                 [](Json& c) { c["outputs"].push_back({{"name", "y"}, {"type", "scalar"}, {"from", "sum.out"}}); });
  refuse_changed("two circuits of a name", [](Json& c) { c["circuits"].push_back(c["circuits"][0]); });
  refuse_changed("two parameters of a name", [](Json& c) { c["parameters"].push_back(c["parameters"][0]); });
  refuse_changed("a parameter of two kinds", [](Json& c) {
    c["lsis"].push_back({{"id", "turns"}, {"type", "state machine"}, {"parameters", {{"transitions", "a -> b when a > 1"}}}});
    c["parameters"][0]["to"] = Json::array({"limit.maximum", "turns.transitions"});
  });
  refuse_changed("two inputs of a name", [](Json& c) { c["inputs"].push_back({{"name", "x"}, {"type", "scalar"}, {"to", "slow.in"}}); });
  std::printf("refused so far: %zu\n", seen_.size());

  // Truncated texts.
  const std::string whole = good_circuit;
  const unsigned seed = 20261121;
  std::printf("seed %u\n", seed);
  std::mt19937 random(seed);
  for (int i = 0; i < 60; ++i) {
    const std::string text = whole.substr(0, random() % (whole.size() - 1));
    if (seen_.insert(text).second) expect_refused(Json::object(), text, "truncated");
  }
  EXPECT_GE(seen_.size(), 300u);
}

}  // namespace
}  // namespace ugoki::circuit
