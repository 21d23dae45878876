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
  near,      ///< the distance of two characters is below a bound
  time,      ///< the scenario has reached a time
  playing,   ///< the motion of another rule plays; or the track, if no rule is named
  released,  ///< motion control has released a character, because it fell
};

struct RuleCondition {
  ConditionType type = ConditionType::key;
  bool negated = false;          ///< the condition is true if what it names is false
  std::string key = "Space";     ///< KeyboardEvent.code (key)
  std::string character, link;   ///< the first body; an empty link: every link (touch, near, playing, released)
  std::string other, other_link; ///< the second body; "ground": the ground; empty: everything (touch, near)
  double distance = 0.5;         ///< m (near)
  double time = 1;               ///< s (time)
  std::string rule;              ///< id of a rule that plays a motion of `character`; empty: its track (playing)
  friend bool operator==(const RuleCondition&, const RuleCondition&) = default;
};

enum class ActionType { play, push };

struct RuleAction {
  ActionType type = ActionType::play;
  std::string character;
  std::string motion;     ///< id of a motion (play)
  double speed = 1;       ///< s of motion per s (play)
  double blend = 0.2;     ///< s, duration of the transitions to and from the motion (play)
  bool loop = false;      ///< repeat the motion (play)
  std::string link;       ///< name or label of the link (push)
  Vec3 force;             ///< N, world (push)
  double duration = 0.2;  ///< s, of a push in the mode `when`
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
