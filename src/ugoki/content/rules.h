#pragma once
// Rules of a scenario: "when the ball touches the chest of Anna, play the fall". A rule has conditions, which must all be true, and an
// action. rule_circuit.h describes the LSIs that are generated from rules. docs/scenario.md describes the JSON form.

#include <string>
#include <string_view>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/spatial/vec3.h"

namespace ugoki::content {

class Fields;
struct Scenario;
struct Catalogue;

enum class RuleMode {
  when,   ///< the action is done each time the conditions become true
  while_  ///< the action lasts as long as the conditions are true
};

enum class ConditionType {
  key,       ///< a key of the keyboard is down
  touch,     ///< a link touches another link or the ground
  near,      ///< the distance of two characters, or of their links, is below a bound
  time,      ///< the scenario has reached a time
  playing,   ///< the motion of another rule plays; or the track, if no rule is named
  released,  ///< motion control has released a character, because it fell
  variable,  ///< comparison of a variable with a value
};

/// Comparison of a variable with a value.
enum class Comparison { at_least, at_most, above, below, equal };

struct RuleCondition {
  ConditionType type = ConditionType::key;
  bool negated = false;           ///< the condition is true if what it names is false
  std::string key = "Space";      ///< KeyboardEvent.code (key)
  std::string character, link;    ///< the first body (touch, near, playing, released); an empty link: every link (touch, near)
  std::string other, other_link;  ///< the second body; "ground": the ground; empty: everything (touch, near)
  double distance = 0.5;          ///< m (near)
  double time = 1;                ///< s (time)
  std::string rule;               ///< id of a rule that plays a motion of `character`; empty: its track (playing)
  std::string variable;           ///< id of a variable (variable)
  Comparison compare = Comparison::at_least;
  double value = 1;  ///< right side of the comparison; a switch is 1 if it is on (variable)
  friend bool operator==(const RuleCondition&, const RuleCondition&) = default;
};

enum class ActionType {
  play,
  push,
  grab,     ///< a link grips a link of another character, or the world
  release,  ///< a link releases what it grips
  set       ///< a variable gets another value
};

/// How the action `set` changes a variable.
enum class VariableChange {
  set,    ///< the variable gets the value
  add,    ///< the value is added: once in the mode `when`, per second in the mode `while`
  toggle  ///< the variable changes between 0 and 1
};

/// Axes in which the force of a push is given: those of the world, or those of the pushed link, with which the force turns.
enum class PushAxes { world, body };
[[nodiscard]] std::string_view name_of(PushAxes axes);

struct RuleAction {
  ActionType type = ActionType::play;
  std::string character;
  std::string motion;               ///< id of a motion (play)
  double speed = 1;                 ///< s of motion per s (play)
  double blend = 0.2;               ///< s, duration of the transitions to and from the motion (play)
  bool loop = false;                ///< repeat the motion (play)
  std::string link;                 ///< name or label of the link (push, grab, release)
  Vec3 force;                       ///< N (push)
  PushAxes axes = PushAxes::world;  ///< of `force` (push)
  double duration = 0.2;            ///< s, of a push in the mode `when`
  std::string other;                ///< id of the character that is gripped; empty: the world (grab)
  std::string other_link;           ///< name or label of its link; empty: the root (grab)
  bool rigid = false;               ///< the orientation of the link relative to the other one is held as well (grab)
  double limit = 450;               ///< N, a larger force opens the grip (grab)
  std::string variable;             ///< id of a variable (set)
  VariableChange change = VariableChange::add;
  double value = 1;  ///< (set)
  friend bool operator==(const RuleAction&, const RuleAction&) = default;
};

struct Rule {
  std::string id;
  bool on = true;
  RuleMode mode = RuleMode::when;
  std::vector<RuleCondition> conditions;  ///< all must be true; not empty
  RuleAction action;
  friend bool operator==(const Rule&, const Rule&) = default;
};

/// The rules that play motions of a character, in the order of the document. A rule that is off is left out.
[[nodiscard]] std::vector<const Rule*> play_rules(const Scenario& scenario, std::string_view character);

/// Reads the JSON form. Absent fields keep their value in `rule`.
void read_rule(Fields& fields, Rule& rule);
/// Adds the problems of the rule: values out of range, and characters, links, motions and rules that do not exist.
/// @param catalogue null: references to mechanisms and motions are not checked
void check_rule(const Rule& rule, const Scenario& scenario, const Catalogue* catalogue, const std::string& location, Error& problems);

/// Removes the rules that name a character in their action or in a condition, and the rules that depend on removed rules.
void remove_rules_of(Scenario& scenario, std::string_view character);
/// Removes a rule, and the rules that depend on it.
void remove_rule(Scenario& scenario, const std::string& id);

}  // namespace ugoki::content
