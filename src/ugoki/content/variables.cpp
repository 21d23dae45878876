#include "ugoki/content/variables.h"

#include <algorithm>

#include "ugoki/base/number.h"
#include "ugoki/content/scenario_json.h"

namespace ugoki::content {
namespace {

constexpr std::size_t max_unit = 20;  // bytes; a longer text does not fit beside the value

/// Reads a number or null. @param none value for null
void read_bound(Fields& f, std::string_view key, double none, double& value) {
  if (const Json* json = f.find(key); json && json->is_null())
    value = none;
  else
    f.number(key, value);
}

}  // namespace

const ScenarioVariable* find_variable(const Scenario& s, std::string_view id) {
  const auto found = std::find_if(s.variables.begin(), s.variables.end(), [&](const ScenarioVariable& v) { return v.id == id; });
  return found == s.variables.end() ? nullptr : &*found;
}

void read_variable(Fields& f, ScenarioVariable& v) {
  f.text("id", v.id);
  f.text("name", v.name);
  std::string kind = v.kind == VariableKind::number ? "number" : "switch";
  f.text("kind", kind);
  v.kind = kind == "switch" ? VariableKind::switch_ : VariableKind::number;
  if (kind != "switch" && kind != "number")
    f.report(ErrorCode::unknown, f.path("kind"), "'" + kind + "' is not a kind of variable.", "Use \"number\" or \"switch\".");
  f.number("initial", v.initial);
  read_bound(f, "minimum", -max_variable, v.minimum);
  read_bound(f, "maximum", max_variable, v.maximum);
  f.text("unit", v.unit);
  f.boolean("shown", v.shown);
}

Json to_json(const ScenarioVariable& v) {
  Json json = {{"id", v.id}, {"name", v.name}, {"kind", v.kind == VariableKind::number ? "number" : "switch"}, {"initial", v.initial}};
  if (v.minimum != -max_variable) json["minimum"] = v.minimum;
  if (v.maximum != max_variable) json["maximum"] = v.maximum;
  if (!v.unit.empty()) json["unit"] = v.unit;
  if (!v.shown) json["shown"] = false;
  return json;
}

void check_variable(const ScenarioVariable& v, const std::string& at, Error& problems) {
  const auto range = [&](const char* field, double value, double low, double high) {
    if (value >= low && value <= high) return;
    problems.add(ErrorCode::range, at + field, "The value " + ugoki::to_text(value) + " is out of range.",
                 "Give a value from " + ugoki::to_text(low) + " to " + ugoki::to_text(high) + ".");
  };
  if (v.unit.size() > max_unit)
    problems.add(ErrorCode::range, at + "/unit", "The unit is longer than " + std::to_string(max_unit) + " bytes.",
                 "Give it a short unit.");
  if (v.kind == VariableKind::switch_) {
    if (v.initial != 0 && v.initial != 1)
      problems.add(ErrorCode::range, at + "/initial", "A switch cannot have the value " + ugoki::to_text(v.initial) + ".",
                   "Give 0 for off or 1 for on.");
    return;
  }
  range("/minimum", v.minimum, -max_variable, max_variable);
  range("/maximum", v.maximum, -max_variable, max_variable);
  if (v.minimum > v.maximum)
    problems.add(ErrorCode::range, at + "/minimum",
                 "The minimum " + ugoki::to_text(v.minimum) + " is above the maximum " + ugoki::to_text(v.maximum) + ".",
                 "Exchange them, or remove one of them with null.");
  else
    range("/initial", v.initial, v.minimum, v.maximum);
}

void remove_variable(Scenario& s, const std::string& id) {
  std::erase_if(s.variables, [&](const ScenarioVariable& v) { return v.id == id; });
  const auto names_it = [&](const Rule& r) {
    if (r.action.type == ActionType::set && r.action.variable == id) return true;
    return std::any_of(r.conditions.begin(), r.conditions.end(),
                       [&](const RuleCondition& c) { return c.type == ConditionType::variable && c.variable == id; });
  };
  for (auto found = std::find_if(s.rules.begin(), s.rules.end(), names_it); found != s.rules.end();
       found = std::find_if(s.rules.begin(), s.rules.end(), names_it))
    remove_rule(s, std::string(found->id));
}

}  // namespace ugoki::content
