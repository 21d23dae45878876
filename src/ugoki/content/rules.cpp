#include "ugoki/content/rules.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "ugoki/base/number.h"
#include "ugoki/content/scenario_json.h"

namespace ugoki::content {
namespace {

constexpr std::array<std::string_view, 7> condition_names = {"key", "touch", "near", "time", "playing", "released", "variable"};
constexpr std::array<std::string_view, 5> action_names = {"play", "push", "grab", "release", "set"};
constexpr std::array<std::string_view, 5> comparison_names = {"at_least", "at_most", "above", "below", "equal"};
constexpr std::array<std::string_view, 3> change_names = {"set", "add", "toggle"};
constexpr std::array<std::string_view, 2> mode_names = {"when", "while"};

/// Reads a field that contains one of several words.
template <class Enum, std::size_t N>
void read_word(Fields& f, std::string_view key, const std::array<std::string_view, N>& names, Enum& value) {
  std::string word(names[static_cast<std::size_t>(value)]);
  f.text(key, word);
  const auto found = std::find(names.begin(), names.end(), word);
  if (found != names.end()) {
    value = static_cast<Enum>(found - names.begin());
    return;
  }
  std::string remedy = "Use one of:";
  for (const std::string_view name : names) remedy += " \"" + std::string(name) + "\"";
  f.report(ErrorCode::unknown, f.path(key), "'" + word + "' is not a " + std::string(key) + " of a rule.", remedy + ".");
}

void read_condition(Fields& f, RuleCondition& c) {
  f.require("type", "the type of the condition, for example \"key\"");
  read_word(f, "type", condition_names, c.type);
  f.boolean("not", c.negated);
  const auto any = [&](auto... types) { return ((c.type == types) || ...); };
  using enum ConditionType;
  if (any(key)) f.text("key", c.key);
  if (any(touch, near, playing, released)) f.text("character", c.character);
  if (any(touch, near)) f.text("other", c.other);
  if (any(touch, near)) {
    f.text("link", c.link);
    f.text("other_link", c.other_link);
  }
  if (any(near)) f.number("distance", c.distance);
  if (any(time)) f.number("time", c.time);
  if (any(playing)) f.text("rule", c.rule);
  if (any(variable)) {
    f.text("variable", c.variable);
    read_word(f, "compare", comparison_names, c.compare);
    f.number("value", c.value);
  }
}

void read_action(Fields& f, RuleAction& a) {
  read_word(f, "type", action_names, a.type);
  if (a.type == ActionType::set) {
    f.text("variable", a.variable);
    read_word(f, "change", change_names, a.change);
    f.number("value", a.value);
    return;
  }
  f.text("character", a.character);
  if (a.type == ActionType::play) {
    f.text("motion", a.motion);
    f.number("speed", a.speed);
    f.number("blend", a.blend);
    f.boolean("loop", a.loop);
  } else if (a.type == ActionType::grab) {
    f.text("link", a.link);
    f.text("other", a.other);
    f.text("other_link", a.other_link);
    f.boolean("rigid", a.rigid);
    f.number("limit", a.limit);
  } else if (a.type == ActionType::release) {
    f.text("link", a.link);
  } else {
    f.text("link", a.link);
    f.vec3("force", a.force);
    read_axes(f, a.axes);
    f.number("duration", a.duration);
  }
}

Json to_json(const RuleCondition& c) {
  using enum ConditionType;
  Json json = {{"type", condition_names[static_cast<std::size_t>(c.type)]}};
  if (c.negated) json["not"] = true;
  switch (c.type) {
    case key: json["key"] = c.key; break;
    case touch:
      json["character"] = c.character;
      json["link"] = c.link;
      json["other"] = c.other;
      json["other_link"] = c.other_link;
      break;
    case near:
      json["character"] = c.character;
      json["other"] = c.other;
      if (!c.link.empty()) json["link"] = c.link;
      if (!c.other_link.empty()) json["other_link"] = c.other_link;
      json["distance"] = c.distance;
      break;
    case time: json["time"] = c.time; break;
    case playing:
      json["character"] = c.character;
      json["rule"] = c.rule;
      break;
    case released: json["character"] = c.character; break;
    case variable:
      json["variable"] = c.variable;
      json["compare"] = comparison_names[static_cast<std::size_t>(c.compare)];
      json["value"] = c.value;
      break;
  }
  return json;
}

Json to_json(const RuleAction& a) {
  Json json = {{"type", action_names[static_cast<std::size_t>(a.type)]}};
  if (a.type == ActionType::set) {
    json["variable"] = a.variable;
    json["change"] = change_names[static_cast<std::size_t>(a.change)];
    json["value"] = a.value;
    return json;
  }
  json["character"] = a.character;
  if (a.type == ActionType::play) {
    json["motion"] = a.motion;
    json["speed"] = a.speed;
    json["blend"] = a.blend;
    json["loop"] = a.loop;
  } else if (a.type == ActionType::grab) {
    json["link"] = a.link;
    json["other"] = a.other;
    json["other_link"] = a.other_link;
    json["rigid"] = a.rigid;
    json["limit"] = a.limit;
  } else if (a.type == ActionType::release) {
    json["link"] = a.link;
  } else {
    json["link"] = a.link;
    json["force"] = content::to_json(a.force);
    if (a.axes != PushAxes::world) json["axes"] = name_of(a.axes);
    json["duration"] = a.duration;
  }
  return json;
}

}  // namespace

std::vector<const Rule*> play_rules(const Scenario& scenario, std::string_view character) {
  std::vector<const Rule*> out;
  for (const Rule& r : scenario.rules)
    if (r.on && r.action.type == ActionType::play && r.action.character == character) out.push_back(&r);
  return out;
}

void read_rule(Fields& f, Rule& rule) {
  f.text("id", rule.id);
  f.boolean("on", rule.on);
  read_word(f, "mode", mode_names, rule.mode);
  if (const Json* list = f.list("if", 1000, "conditions")) {
    rule.conditions.clear();
    for (std::size_t i = 0; i < list->size(); ++i) {
      Fields g((*list)[i], f.path("if") + "/" + std::to_string(i), f.problems());
      read_condition(g, rule.conditions.emplace_back());
      g.refuse_others();
    }
  }
  if (const Json* object = f.find("do")) {
    Fields g(*object, f.path("do"), f.problems());
    rule.action = {};
    g.require("type", "\"play\", \"push\", \"grab\", \"release\" or \"set\"");
    read_action(g, rule.action);
    g.refuse_others();
  }
}

Json to_json(const Rule& rule) {
  Json conditions = Json::array();
  for (const RuleCondition& c : rule.conditions) conditions.push_back(to_json(c));
  return {{"id", rule.id},
          {"on", rule.on},
          {"mode", mode_names[static_cast<std::size_t>(rule.mode)]},
          {"if", std::move(conditions)},
          {"do", to_json(rule.action)}};
}

void remove_rule(Scenario& s, const std::string& id) {
  std::erase_if(s.rules, [&](const Rule& r) { return r.id == id; });
  const auto depends = [&](const Rule& r) {
    return std::any_of(r.conditions.begin(), r.conditions.end(),
                       [&](const RuleCondition& c) { return c.type == ConditionType::playing && c.rule == id; });
  };
  for (auto found = std::find_if(s.rules.begin(), s.rules.end(), depends); found != s.rules.end();
       found = std::find_if(s.rules.begin(), s.rules.end(), depends))
    remove_rule(s, std::string(found->id));
}

void remove_rules_of(Scenario& s, std::string_view character) {
  const auto names = [&](const RuleCondition& c) {
    using enum ConditionType;
    if (c.type == key || c.type == time || c.type == variable) return false;
    return c.character == character || ((c.type == touch || c.type == near) && c.other == character);
  };
  const auto names_it = [&](const Rule& r) {
    return r.action.character == character || (r.action.type == ActionType::grab && r.action.other == character) ||
           std::any_of(r.conditions.begin(), r.conditions.end(), names);
  };
  for (auto found = std::find_if(s.rules.begin(), s.rules.end(), names_it); found != s.rules.end();
       found = std::find_if(s.rules.begin(), s.rules.end(), names_it))
    remove_rule(s, std::string(found->id));
}

}  // namespace ugoki::content
