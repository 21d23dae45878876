#include "ugoki/content/rule_circuit.h"

#include <algorithm>

#include "ugoki/base/hash.h"

namespace ugoki::content {
namespace {

using circuit::Circuit;
using circuit::Instance;

constexpr double column = 240, row = 130;  // spacing of LSIs in the editor, px
constexpr double top = -260;               // y of the lowest row of rules, above the other LSIs, px

/// Id of the LSI of a rule or a variable. '.' separates LSI and pin, and '/' the levels of circuits, so both are replaced. A long id of a
/// nested item is shortened: ids of LSIs have 64 bytes at most.
std::string lsi_id(std::string_view kind, std::string id) {
  constexpr std::size_t longest = 40, kept = 23;
  if (id.size() > longest) {
    Hash64 hash;
    hash.add_bytes(id.data(), id.size());
    id = id.substr(0, kept) + "-" + hash.hex();
  }
  for (char& c : id)
    if (c == '.' || c == '/') c = '_';
  return std::string(kind) + id;
}

class Maker {
 public:
  Maker(Circuit& circuit, const Scenario& scenario) : c_(circuit), s_(scenario) {}

  void make() {
    std::size_t left = 0;
    for (const Rule& rule : s_.rules) left += rule.on ? rule.conditions.size() : 0;
    y_ = top - row * static_cast<double>(left);
    std::string events = "event.events";
    add_variables();
    for (const Rule& rule : s_.rules) {
      if (!rule.on) continue;
      const std::string id = lsi_id("rule-", rule.id);
      if (rule.action.type == ActionType::set) {
        changes_.emplace_back(&rule, conditions(rule, id));
      } else if (rule.action.type == ActionType::grab || rule.action.type == ActionType::release) {
        grip(rule, id, conditions(rule, id));
        wire(events, id + ".events");
        events = id + ".events";
      } else if (rule.action.type == ActionType::push) {
        const std::string condition = conditions(rule, id);
        Instance& lsi = add(id, "push", 3, y_ - row);
        lsi.parameters = {{"character", rule.action.character},
                          {"link", rule.action.link},
                          {"duration", rule.mode == RuleMode::when ? rule.action.duration : 0.0}};
        if (rule.action.axes == PushAxes::body) lsi.parameters.push_back({"body axes", true});
        const Vec3& f = rule.action.force;
        lsi.values = {{"force", std::vector<double>{f.x, f.y, f.z}}};
        wire(events, id + ".events");
        wire(condition, id + ".when");
        events = id + ".events";
      } else if (!choice_of(rule.action.character).empty()) {
        play(rule, id);
      }
    }
    add_changes();
    if (events == "event.events") return;
    for (circuit::Wire& w : c_.wires)
      if (w.to == "dynamics.events") w.from = events;
    for (circuit::BoundaryPin& pin : c_.outputs)
      if (pin.name == "events") pin.ends = {events};
  }

 private:
  /// Id of the character's nested circuit if this contains an LSI `motion choice`; empty: there is none.
  [[nodiscard]] std::string choice_of(const std::string& character) const { return find("motion choice", character); }
  /// Id of the nested circuit that contains an LSI of this class for the character; empty: there is none.
  [[nodiscard]] std::string find(std::string_view type, const std::string& character) const {
    const auto holds = [&](const Instance& lsi) {
      return lsi.type == type && std::ranges::any_of(lsi.parameters, [&](const auto& p) {
               return p.first == "character" && p.second == circuit::Value(character);
             });
    };
    for (const Circuit& inner : c_.circuits) {
      if (std::ranges::none_of(inner.lsis, holds)) continue;
      const auto box = std::ranges::find(c_.lsis, inner.name, &Instance::type);
      if (box != c_.lsis.end()) return box->id;
    }
    return {};
  }

  /// Number of the rule's motion among the motions of its character, from 1.
  [[nodiscard]] double number_of(const Rule& rule) const {
    const std::vector<const Rule*> all = play_rules(s_, rule.action.character);
    return static_cast<double>(std::find_if(all.begin(), all.end(), [&](const Rule* r) { return r->id == rule.id; }) - all.begin()) + 1;
  }

  void play(const Rule& rule, const std::string& id) {
    const std::string choice = choice_of(rule.action.character), condition = conditions(rule, id);
    add(id, "play rule", 3, y_ - row).parameters = {{"number", number_of(rule)},
                                                    {"mode", std::string(rule.mode == RuleMode::when ? "when" : "while")}};
    wire(condition, id + ".condition");
    wire(choice + ".now", id + ".now");
    wire(choice + ".ended", id + ".ended");
    // The rules of the document have falling priority, so each next rule is wired below the previous one.
    const auto before = std::find_if(last_.begin(), last_.end(), [&](const auto& l) { return l.first == rule.action.character; });
    if (before == last_.end()) {
      wire(id + ".choice", choice + ".choice");
      last_.emplace_back(rule.action.character, id);
    } else {
      wire(id + ".choice", before->second + ".below");
      before->second = id;
    }
  }

  void grip(const Rule& rule, const std::string& id, const std::string& condition) {
    const RuleAction& a = rule.action;
    const bool grab = a.type == ActionType::grab;
    Instance& lsi = add(id, "grip rule", 3, y_ - row);
    lsi.parameters = {{"character", a.character}, {"link", a.link}};
    if (grab) {
      lsi.parameters.insert(lsi.parameters.end(),
                            {{"other", a.other}, {"other link", a.other_link}, {"rigid", a.rigid}, {"limit", a.limit}});
    }
    lsi.parameters.emplace_back("mode", std::string(!grab ? "release" : rule.mode == RuleMode::when ? "grab" : "hold"));
    wire(condition, id + ".when");
  }

  /// Adds an LSI for each variable, in a column left of the rules.
  void add_variables() {
    double y = y_;
    for (const ScenarioVariable& v : s_.variables) {
      Instance& lsi = add(variable_lsi(v.id), "variable", -1, y);
      const bool number = v.kind == VariableKind::number;
      lsi.parameters = {{"initial", v.initial}, {"minimum", number ? v.minimum : 0.0}, {"maximum", number ? v.maximum : 1.0}};
      y += row;
    }
  }
  /// Wires the changes of each variable in series. A rule has priority over the rules below it, so the first rule changes the value last.
  void add_changes() {
    for (const ScenarioVariable& v : s_.variables) {
      std::string value = variable_lsi(v.id) + ".value";
      const std::string first = value;
      for (auto change = changes_.rbegin(); change != changes_.rend(); ++change) {
        const auto& [rule, condition] = *change;
        if (rule->action.variable != v.id) continue;
        const std::string id = lsi_id("rule-", rule->id);
        Instance& lsi = add(id, "set variable", 3, row_of(condition));
        const char* const changes[] = {"set", "add", "toggle"};
        lsi.parameters = {{"mode", std::string(rule->mode == RuleMode::when ? "when" : "while")},
                          {"change", std::string(changes[static_cast<std::size_t>(rule->action.change)])}};
        lsi.values = {{"amount", rule->action.value}};
        wire(condition, id + ".condition");
        wire(value, id + ".value");
        value = id + ".value";
      }
      if (value != first) wire(value, variable_lsi(v.id) + ".next");
    }
  }
  /// y of the LSI with this output, px.
  [[nodiscard]] double row_of(const std::string& output) const {
    const std::string id = output.substr(0, output.find('.'));
    for (const Instance& lsi : c_.lsis)
      if (lsi.id == id) return lsi.at.y;
    return y_;
  }

  /// Adds the LSIs of all conditions of a rule. @return the output that is above 0 while all of them are true
  std::string conditions(const Rule& rule, const std::string& id) {
    std::string all;
    for (std::size_t i = 0; i < rule.conditions.size(); ++i) {
      const std::string one = condition(rule.conditions[i], id + "-" + std::to_string(i + 1));
      if (i == 0) {
        all = one;
      } else {
        const std::string both = id + "-and" + std::to_string(i + 1);
        add(both, "and", 2, y_);
        wire(all, both + ".a");
        wire(one, both + ".b");
        all = both + ".out";
      }
      y_ += row;
    }
    return all;
  }

  std::string condition(const RuleCondition& c, const std::string& id) {
    std::string out = plain_condition(c, id);
    if (!c.negated) return out;
    add(id + "-not", "not", 1, y_ + row / 2);
    wire(out, id + "-not.in");
    return id + "-not.out";
  }

  std::string plain_condition(const RuleCondition& c, const std::string& id) {
    using enum ConditionType;
    switch (c.type) {
      case key: add(id, "keyboard", 0, y_).parameters = {{"key", c.key}}; return id + ".pressed";
      case touch:
        add(id, "touch", 0, y_).parameters = {
            {"character", c.character}, {"link", c.link}, {"other", c.other}, {"other link", c.other_link}};
        wire("dynamics.contacts", id + ".contacts");
        return id + ".touching";
      case near: {
        auto& pair = add(id + "-pair", "closest pair", 0, y_).parameters;
        pair = {{"character", c.character}, {"other", c.other}};
        if (!c.link.empty()) pair.emplace_back("link", c.link);
        if (!c.other_link.empty()) pair.emplace_back("other link", c.other_link);
        wire("status.state", id + "-pair.state");
        return compare(id, "a", c.distance, "b", id + "-pair.distance");
      }
      case time: add(id + "-clock", "clock", 0, y_); return compare(id, "b", c.time, "a", id + "-clock.time");
      case playing: {
        const std::string choice = choice_of(c.character);
        const auto rule = std::find_if(s_.rules.begin(), s_.rules.end(), [&](const Rule& r) { return r.id == c.rule; });
        if (choice.empty()) return constant(id, c.rule.empty() ? 1 : 0);
        if (!c.rule.empty() && (rule == s_.rules.end() || !rule->on)) return constant(id, 0);
        return c.rule.empty() ? is_choice(choice, 0, id) : plays_motion_of(*rule, choice, id);
      }
      case released: {
        std::string control = find("motion control", c.character);
        if (control.empty()) control = find("balance control", c.character);
        if (control.empty()) return constant(id, 0);
        add(id, "joint value", 0, y_).parameters = {{"index", 8.0}};  // lsi::report_released
        add(id + "-delay", "delay", 1, y_);                           // the report depends on the motion that plays
        wire(control + ".report", id + ".in");
        wire(id + ".out", id + "-delay.in");
        return id + "-delay.out";
      }
      case variable: return comparison(c, id);
    }
    return constant(id, 0);
  }

  /// Compares a variable with the value of a condition.
  std::string comparison(const RuleCondition& c, const std::string& id) {
    const std::string value = variable_lsi(c.variable) + ".value";
    if (c.compare == Comparison::equal) {
      add(id, "equal", 0, y_).values = {{"b", c.value}};
      wire(value, id + ".a");
      return id + ".out";
    }
    // "compare" is a > b; "at least" is the contrary of "below", and "at most" of "above"
    const bool contrary = c.compare == Comparison::at_least || c.compare == Comparison::at_most;
    const bool value_is_a = c.compare == Comparison::above || c.compare == Comparison::at_most;
    const std::string plain = contrary ? id + "-strict" : id;
    add(plain, "compare", 0, y_).values = {{value_is_a ? "b" : "a", c.value}};
    wire(value, plain + (value_is_a ? ".a" : ".b"));
    if (!contrary) return plain + ".out";
    add(id, "not", 1, y_);
    wire(plain + ".out", id + ".in");
    return id + ".out";
  }

  /// Compares the choice that plays with a number. @return the output
  std::string is_choice(const std::string& choice, double number, const std::string& id) {
    add(id, "equal", 0, y_).values = {{"b", number}};
    wire(choice + ".now", id + ".a");
    return id + ".out";
  }
  /// Whether the motion of a rule plays, also if another rule of the character has started the same motion. @return the output
  std::string plays_motion_of(const Rule& rule, const std::string& choice, const std::string& id) {
    std::string any = is_choice(choice, number_of(rule), id);
    int n = 1;
    for (const Rule* other : play_rules(s_, rule.action.character)) {
      const RuleAction &a = other->action, &b = rule.action;
      if (other->id == rule.id || a.motion != b.motion || a.speed != b.speed || a.loop != b.loop) continue;
      const std::string either = id + "-or" + std::to_string(++n);
      const std::string also = is_choice(choice, number_of(*other), id + "-same" + std::to_string(n));
      add(either, "or", 1, y_);
      wire(any, either + ".a");
      wire(also, either + ".b");
      any = either + ".out";
    }
    return any;
  }

  std::string constant(const std::string& id, double value) {
    add(id, "constant", 0, y_).parameters = {{"value", value}};
    return id + ".out";
  }
  /// Adds "a > b" with one fixed value. @return its output
  std::string compare(const std::string& id, const char* fixed, double value, const char* wired, const std::string& from) {
    add(id, "compare", 1, y_).values = {{fixed, value}};
    wire(from, id + "." + wired);
    return id + ".out";
  }

  Instance& add(std::string id, std::string type, int at_column, double y) {
    Instance lsi;
    lsi.id = std::move(id);
    lsi.type = std::move(type);
    lsi.at = {column * at_column, y};
    c_.lsis.push_back(std::move(lsi));
    return c_.lsis.back();
  }
  void wire(std::string from, std::string to) { c_.wires.push_back({std::move(from), std::move(to)}); }

  Circuit& c_;
  const Scenario& s_;
  double y_ = 0;
  std::vector<std::pair<const Rule*, std::string>> changes_;  // rules that change variables, and their conditions
  std::vector<std::pair<std::string, std::string>> last_;     // [characters] id, and the LSI of its last rule so far
};

}  // namespace

std::string variable_lsi(const std::string& variable) { return lsi_id("variable-", variable); }

void add_rules(Circuit& circuit, const Scenario& scenario) { Maker(circuit, scenario).make(); }

}  // namespace ugoki::content
