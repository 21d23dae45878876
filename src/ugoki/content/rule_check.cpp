// Checks of rules: values out of range, and references to items that do not exist.

#include <algorithm>
#include <cctype>

#include "ugoki/base/number.h"
#include "ugoki/content/rules.h"
#include "ugoki/content/scenario.h"

namespace ugoki::content {
namespace {

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
        link(at + "/link", character(at + "/character", c.character), c.link);
        link(at + "/other_link", character(at + "/other", c.other), c.other_link);
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
      case ConditionType::variable:
        (void)variable_of(at + "/variable", c.variable);
        range(at + "/value", c.value, -max_variable, max_variable, "");
        return;
    }
  }

  const ScenarioVariable* variable_of(const std::string& at, const std::string& id) {
    const ScenarioVariable* found = find_variable(s_, id);
    if (!found) problems_.add(ErrorCode::unknown, at, "There is no variable '" + id + "'.", "Add it, or name a variable of the document.");
    return found;
  }

  void check(const RuleAction& a, const std::string& at) {
    if (a.type == ActionType::set) {
      const ScenarioVariable* changed = variable_of(at + "/variable", a.variable);
      range(at + "/value", a.value, -max_variable, max_variable, "");
      if (a.change == VariableChange::toggle && changed && changed->kind != VariableKind::switch_)
        problems_.add(ErrorCode::structure, at + "/change", "The number '" + changed->name + "' cannot be toggled.",
                      "Set it, add to it, or name a switch.");
      return;
    }
    const ScenarioCharacter* who = character(at + "/character", a.character);
    if (a.type == ActionType::push) {
      range(at + "/duration", a.duration, 0.0005, 3600, "s");
      for (int i = 0; i < 3; ++i) range(at + "/force", a.force[i], -1e6, 1e6, "N");
      link(at + "/link", who, a.link);
      return;
    }
    if (a.type == ActionType::grab || a.type == ActionType::release) {
      link(at + "/link", who, a.link);
      if (a.link.empty())
        problems_.add(ErrorCode::structure, at + "/link", "The rule names no link that grips.", "Name a link, for example a hand.");
      if (a.type == ActionType::release) return;
      range(at + "/limit", a.limit, 1, 1e6, "N");
      if (a.other == a.character && a.other_link == a.link)
        problems_.add(ErrorCode::structure, at + "/other_link", "The link grips itself.", "Name another link.");
      if (!a.other.empty()) link(at + "/other_link", character(at + "/other", a.other), a.other_link);
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
      problems_.add(ErrorCode::unknown, at + "/motion", "The project has no motion '" + a.motion + "'.",
                    "Import it, or choose another one.");
    else if (m && motion->second.nq != m->nq)
      problems_.add(ErrorCode::structure, at + "/motion",
                    "Motion '" + motion->second.name + "' belongs to another mechanism than '" + m->name + "'.",
                    "Choose a motion of this character, or retarget it first.");
  }

  const Scenario& s_;
  const Catalogue* catalogue_;
  Error& problems_;
};

}  // namespace

void check_rule(const Rule& rule, const Scenario& scenario, const Catalogue* catalogue, const std::string& location, Error& problems) {
  Checker(scenario, catalogue, problems).check(rule, location);
}

}  // namespace ugoki::content
