#include "ugoki/content/rules.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "ugoki/base/number.h"
#include "ugoki/content/scenario_json.h"

namespace ugoki::content {
namespace {

constexpr std::array<std::string_view, 6> condition_names = {"key", "touch", "near", "time", "playing", "released"};
constexpr std::array<std::string_view, 2> action_names = {"play", "push"};
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
  if (any(touch)) {
    f.text("link", c.link);
    f.text("other_link", c.other_link);
  }
  if (any(near)) f.number("distance", c.distance);
  if (any(time)) f.number("time", c.time);
  if (any(playing)) f.text("rule", c.rule);
}

void read_action(Fields& f, RuleAction& a) {
  read_word(f, "type", action_names, a.type);
  f.text("character", a.character);
  if (a.type == ActionType::play) {
    f.text("motion", a.motion);
    f.number("speed", a.speed);
    f.number("blend", a.blend);
    f.boolean("loop", a.loop);
  } else {
    f.text("link", a.link);
    f.vec3("force", a.force);
    f.number("duration", a.duration);
  }
}

/// Checks one rule.
class Checker {
 public:
  Checker(const Scenario& s, const Catalogue* catalogue, Error& problems) : s_(s), catalogue_(catalogue), problems_(problems) {}

  void check(const Rule& rule, const std::string& at) {
    constexpr std::size_t max_conditions = 16;  // more cannot be read as one sentence
    if (rule.conditions.empty() || rule.conditions.size() > max_conditions)
      problems_.add(ErrorCode::structure, at + "/if", "The rule has " + std::to_string(rule.conditions.size()) + " conditions.",
                    "Give 1 to " + std::to_string(max_conditions) + " conditions.");
    for (std::size_t i = 0; i < rule.conditions.size(); ++i) check(rule, rule.conditions[i], at + "/if/" + std::to_string(i));
    check(rule.action, at + "/do");
  }

 private:
  void range(const std::string& at, double value, double low, double high, std::string_view unit) {
    if (value >= low && value <= high) return;
    problems_.add(
        ErrorCode::range, at, "The value " + ugoki::to_text(value) + " is out of range.",
        "Give a value from " + ugoki::to_text(low) + " to " + ugoki::to_text(high) + (unit.empty() ? "." : " " + std::string(unit) + "."));
  }
  /// The character with this id; null and a problem if there is none.
  const ScenarioCharacter* character(const std::string& at, const std::string& id) {
    const ScenarioCharacter* found = s_.find_character(id);
    if (!found) problems_.add(ErrorCode::unknown, at, "There is no character '" + id + "'.", "Name a character of the document.");
    return found;
  }
  const MechanismFacts* mechanism_of(const ScenarioCharacter* c) {
    if (!c || !catalogue_) return nullptr;
    const auto it = catalogue_->mechanisms.find(c->mechanism);
    return it == catalogue_->mechanisms.end() ? nullptr : &it->second;
  }
  void link(const std::string& at, const ScenarioCharacter* c, const std::string& name) {
    const MechanismFacts* m = mechanism_of(c);
    if (name.empty() || !m) return;
    const auto has = [&](const std::vector<std::string>& names) { return std::find(names.begin(), names.end(), name) != names.end(); };
    if (!has(m->links) && !has(m->labels))
      problems_.add(ErrorCode::unknown, at, "Mechanism '" + m->name + "' has no link '" + name + "'.", "Name one of its links.");
  }

  void check(const Rule& rule, const RuleCondition& c, const std::string& at) {
    using enum ConditionType;
    switch (c.type) {
      case key:
        if (c.key.empty() || c.key.size() > 32 ||
            !std::all_of(c.key.begin(), c.key.end(), [](char x) { return std::isalnum(static_cast<unsigned char>(x)) != 0; }))
          problems_.add(ErrorCode::syntax, at + "/key", "'" + c.key + "' is not the name of a key.",
                        "Name keys by KeyboardEvent.code: Space, KeyW, ArrowUp.");
        return;
      case touch:
        link(at + "/link", character(at + "/character", c.character), c.link);
        if (!c.other.empty() && c.other != "ground") link(at + "/other_link", character(at + "/other", c.other), c.other_link);
        return;
      case near:
        (void)character(at + "/character", c.character);
        (void)character(at + "/other", c.other);
        range(at + "/distance", c.distance, 0, 1000, "m");
        if (c.other == c.character)
          problems_.add(ErrorCode::structure, at + "/other", "The distance of a character from itself is not defined.",
                        "Name another character.");
        return;
      case time: range(at + "/time", c.time, 0, 86400, "s"); return;
      case playing: {
        (void)character(at + "/character", c.character);
        if (c.rule.empty()) return;
        const auto found = std::find_if(s_.rules.begin(), s_.rules.end(), [&](const Rule& r) { return r.id == c.rule; });
        if (found == s_.rules.end() || found->action.type != ActionType::play || found->action.character != c.character)
          problems_.add(ErrorCode::unknown, at + "/rule", "There is no rule '" + c.rule + "' that plays a motion of '" + c.character + "'.",
                        "Name a rule of the character, or an empty text for its track.");
        else if (c.rule == rule.id)
          problems_.add(ErrorCode::structure, at + "/rule", "The rule depends on its own motion.", "Name another rule.");
        return;
      }
      case released: (void)character(at + "/character", c.character); return;
    }
  }

  void check(const RuleAction& a, const std::string& at) {
    const ScenarioCharacter* who = character(at + "/character", a.character);
    if (a.type == ActionType::push) {
      range(at + "/duration", a.duration, 0.0005, 3600, "s");
      for (int i = 0; i < 3; ++i) range(at + "/force", a.force[i], -1e6, 1e6, "N");
      link(at + "/link", who, a.link);
      return;
    }
    range(at + "/speed", a.speed, 0.01, 100, "");
    range(at + "/blend", a.blend, 0, 60, "s");
    if (!is_id(a.motion, max_resource_id)) {
      problems_.add(ErrorCode::syntax, at + "/motion", "'" + a.motion + "' cannot be the id of a motion.",
                    "Choose a motion from the library.");
      return;
    }
    if (!catalogue_) return;
    const auto motion = catalogue_->motions.find(a.motion);
    const MechanismFacts* m = mechanism_of(who);
    if (motion == catalogue_->motions.end())
      problems_.add(ErrorCode::unknown, at + "/motion", "The project has no motion '" + a.motion + "'.", "Import it, or choose another one.");
    else if (m && motion->second.nq != m->nq)
      problems_.add(ErrorCode::structure, at + "/motion",
                    "Motion '" + motion->second.name + "' belongs to another mechanism than '" + m->name + "'.",
                    "Choose a motion of this character, or retarget it first.");
  }

  const Scenario& s_;
  const Catalogue* catalogue_;
  Error& problems_;
};

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
      json["distance"] = c.distance;
      break;
    case time: json["time"] = c.time; break;
    case playing:
      json["character"] = c.character;
      json["rule"] = c.rule;
      break;
    case released: json["character"] = c.character; break;
  }
  return json;
}

Json to_json(const RuleAction& a) {
  Json json = {{"type", action_names[static_cast<std::size_t>(a.type)]}, {"character", a.character}};
  if (a.type == ActionType::play) {
    json["motion"] = a.motion;
    json["speed"] = a.speed;
    json["blend"] = a.blend;
    json["loop"] = a.loop;
  } else {
    json["link"] = a.link;
    json["force"] = content::to_json(a.force);
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
    g.require("type", "\"play\" or \"push\"");
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

void check_rule(const Rule& rule, const Scenario& scenario, const Catalogue* catalogue, const std::string& location, Error& problems) {
  Checker(scenario, catalogue, problems).check(rule, location);
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
    if (c.type == key || c.type == time) return false;
    return c.character == character || ((c.type == touch || c.type == near) && c.other == character);
  };
  const auto names_it = [&](const Rule& r) {
    return r.action.character == character || std::any_of(r.conditions.begin(), r.conditions.end(), names);
  };
  for (auto found = std::find_if(s.rules.begin(), s.rules.end(), names_it); found != s.rules.end();
       found = std::find_if(s.rules.begin(), s.rules.end(), names_it))
    remove_rule(s, std::string(found->id));
}

}  // namespace ugoki::content
