// Compares docs/schema/circuit.schema.json with the circuits that the program writes and refuses. The validator below supports only the
// JSON Schema keywords that this schema uses.

#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>

#include "circuit_test.h"

namespace ugoki::circuit {
namespace {

using Json = nlohmann::ordered_json;

Json load(const std::string& path) {
  std::ifstream in(std::string(UGOKI_SOURCE_DIR) + "/" + path);
  return Json::parse(in, nullptr, false);
}

class Validator {
 public:
  explicit Validator(const Json& schema) : top_(schema) {}
  /// Text of the first violation of the schema; empty: the value is valid.
  std::string check(const Json& value) { return check(value, top_, "circuit"); }

 private:
  static bool is(const Json& v, const std::string& type) {
    if (type == "integer") return v.is_number_integer();
    if (type == "number") return v.is_number();
    if (type == "string") return v.is_string();
    if (type == "boolean") return v.is_boolean();
    if (type == "array") return v.is_array();
    return type == "object" && v.is_object();
  }
  std::string check(const Json& v, const Json& s, const std::string& at) {
    static const std::set<std::string> known = {"$schema", "$id",      "$defs",      "$ref",       "title",    "description",
                                                "type",    "enum",     "const",      "minimum",    "maximum",  "pattern",
                                                "items",   "minItems", "maxItems",   "properties", "required", "additionalProperties",
                                                "anyOf",   "default",  "prefixItems"};
    for (auto it = s.begin(); it != s.end(); ++it) EXPECT_TRUE(known.contains(it.key())) << "the validator does not know " << it.key();
    if (s.contains("$ref")) {
      const std::string ref = s["$ref"];
      if (ref == "#") return check(v, top_, at);
      return check(v, top_["$defs"][ref.substr(8)], at);
    }
    if (s.contains("anyOf")) {
      std::string why;
      for (const Json& option : s["anyOf"]) {
        why = check(v, option, at);
        if (why.empty()) return {};
      }
      return why;
    }
    if (s.contains("type") && !is(v, s["type"])) return at + ": not of type " + s["type"].get<std::string>();
    if (s.contains("enum") && std::find(s["enum"].begin(), s["enum"].end(), v) == s["enum"].end()) return at + ": none of the words";
    if (s.contains("const") && v != s["const"]) return at + ": not " + s["const"].dump();
    if (v.is_number() && s.contains("minimum") && v < s["minimum"]) return at + ": too small";
    if (v.is_number() && s.contains("maximum") && v > s["maximum"]) return at + ": too large";
    if (v.is_string() && s.contains("pattern") && !std::regex_search(v.get<std::string>(), std::regex(s["pattern"].get<std::string>())))
      return at + ": does not match";
    if (v.is_array()) {
      if (s.contains("minItems") && v.size() < s["minItems"]) return at + ": too short";
      if (s.contains("maxItems") && v.size() > s["maxItems"]) return at + ": too long";
      for (std::size_t i = 0; s.contains("items") && i < v.size(); ++i)
        if (std::string why = check(v[i], s["items"], at + "/" + std::to_string(i)); !why.empty()) return why;
    }
    if (v.is_object()) {
      if (s.contains("required"))
        for (const Json& key : s["required"])
          if (!v.contains(key.get<std::string>())) return at + ": without " + key.get<std::string>();
      for (auto it = v.begin(); it != v.end(); ++it) {
        const std::string here = at + "/" + it.key();
        if (s.contains("properties") && s["properties"].contains(it.key())) {
          if (std::string why = check(it.value(), s["properties"][it.key()], here); !why.empty()) return why;
        } else if (s.contains("additionalProperties")) {
          if (s["additionalProperties"].is_boolean()) {
            if (!s["additionalProperties"].get<bool>()) return here + ": unknown";
          } else if (std::string why = check(it.value(), s["additionalProperties"], here); !why.empty()) {
            return why;
          }
        }
      }
    }
    return {};
  }
  const Json& top_;
};

TEST(Schema, AcceptsWrittenCircuits) {
  const Json schema = load("docs/schema/circuit.schema.json");
  ASSERT_FALSE(schema.is_discarded());
  Validator validator(schema);
  Circuit c;
  c.name = "full";
  c.doc = "doc";
  c.inputs_at = Position{1, 2};
  c.outputs_at = Position{3, 4.5};
  for (const PinType& t : pin_types()) c.inputs.push_back({std::string(t.name), t.id, "m", "doc", {"a.in", "b.in"}});
  c.outputs = {{"o", PinTypeId::scalar, "", "", {"a.out"}}, {"waiting", PinTypeId::vector, "", "", {}}};
  c.parameters = {{"p", "doc", {"a.gain"}}, {"q", "", {"a.x", "b.y"}}};
  Instance lsi;
  lsi.id = "a-1_B";
  lsi.type = "library/any name";
  lsi.label = "label";
  lsi.note = "note";
  lsi.at = {-10, 2e3};
  lsi.every = 0;
  lsi.parameters = {{"n", 1.5}, {"b", true}, {"t", std::string("text")}, {"v", std::vector<double>{1, 2, 3}}};
  lsi.values = {{"in", 2.0}};
  c.lsis = {lsi};
  c.wires = {{"a.out", "b.in"}};
  c.notes = {{"n1", "text", {1, 2}, {0, 0}}, {"n2", "text", {1, 2}, {100, 50}}};
  c.probes = {{"a.out", {1, 2}, {}}, {"a.out", {1, 2}, {0, 2}}};
  Circuit inner;
  inner.name = "inner";
  inner.circuits = {inner};
  c.circuits = {inner};
  EXPECT_EQ(validator.check(Json::parse(write_circuit(c))), "") << write_circuit(c);
  EXPECT_EQ(validator.check(Json::parse(write_circuit(Circuit{}))), "");
}

TEST(Schema, RefusesCircuitsThatTheReaderRefuses) {
  const Json schema = load("docs/schema/circuit.schema.json");
  Validator validator(schema);
  for (const char* text :
       {R"({"name": "x"})", R"({"version": 99, "name": "x"})", R"({"version": 2, "name": 3})", R"({"version": 2, "names": "x"})",
        R"({"version": 2, "lsis": {}})", R"({"version": 2, "lsis": [{"id": "a b", "type": "add"}]})",
        R"({"version": 2, "lsis": [{"id": "a"}]})", R"({"version": 2, "lsis": [{"id": "a", "type": "add", "every": -1}]})",
        R"({"version": 2, "lsis": [{"id": "a", "type": "add", "at": [1]}]})",
        R"({"version": 2, "lsis": [{"id": "a", "type": "add", "values": {"a": null}}]})",
        R"({"version": 2, "wires": [{"from": "a", "to": "b.c"}]})", R"({"version": 2, "wires": [{"from": "a.b"}]})",
        R"({"version": 2, "inputs": [{"name": "x", "type": "number", "to": "a.b"}]})",
        R"({"version": 2, "circuits": [{"doc": "no name"}]})"}) {
    EXPECT_NE(validator.check(Json::parse(text)), "") << text;
    EXPECT_FALSE(read_circuit(text)) << text;
  }
}

}  // namespace
}  // namespace ugoki::circuit
