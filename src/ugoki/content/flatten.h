#pragma once
// Nested scenarios: expands the inner scenarios that a scenario places to ordinary characters, events, rules, variables, cameras and shots.
// Nothing below the document (circuit, executable data, player, export) knows of nesting. See docs/design/nested-scenarios.md.

#include <algorithm>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "ugoki/base/result.h"
#include "ugoki/content/scenario.h"

namespace ugoki::content {

/// Maximum number of characters, clips, events, rules, variables, cameras and shots of a flattened document.
inline constexpr std::size_t max_flattened = 20'000;

/// Returns the document with each instance replaced by the content of its inner scenario: ids and names get the instance's as prefix
/// ("duet.1/human"), times are shifted by `start`, places, directions and views are moved by `place`. A document without instances is
/// returned unchanged, except for its list of inner scenarios. An instance that check_instances() refuses is left out.
[[nodiscard]] Scenario flatten(const Scenario& document);

/// Returns an inner scenario as a document of its own, with the settings, poses and inner scenarios of the document, for opening it in the
/// studio. `id` is an inner scenario's id.
[[nodiscard]] Scenario open_scenario(const Scenario& document, std::string_view id);

/// Adds the problems of inner scenarios and instances: missing or repeated scenarios, a scenario that contains itself (the message names
/// the chain), too many items, torque-oriented motions that are moved. @param root location of the document
void check_instances(const Scenario& document, const std::string& root, Error& problems);

/// Returns the place in the world of an item whose place in its scenario is `p`. @param frame place of the scenario
[[nodiscard]] ScenarioPlace compose(const ScenarioPlace& frame, const ScenarioPlace& p);

/// Shifts the times of a scenario's own items and instances by `start` [s] and moves them by `place`.
void displace(Scenario& scenario, double start, const ScenarioPlace& place);

/// Mutes the characters and instances that are left out because others of the scenario are solo, and ends solo.
void resolve_solo(Scenario& scenario);

/// Sorts the items of the list that `order` names by their position in it; the others follow in their order.
template <class List>
void sort_by(const std::vector<std::string>& order, List& list) {
  if (order.empty()) return;
  std::map<std::string_view, std::size_t> ranks;
  for (const std::string& id : order) ranks.emplace(id, ranks.size());
  std::vector<std::pair<std::size_t, std::size_t>> places;  // rank and old index of each item
  for (const auto& item : list) {
    const auto found = ranks.find(item.id);
    places.emplace_back(found == ranks.end() ? ranks.size() : found->second, places.size());
  }
  std::sort(places.begin(), places.end());
  List sorted;
  for (const auto& [rank, index] : places) sorted.push_back(std::move(list[index]));
  list = std::move(sorted);
}

/// Calls visit(reference) for each reference of the scenario's events, rules, cameras and view to a character, rule or variable. Empty
/// references and "ground" are left out.
template <class Visit>
void for_each_reference(ScenarioEvent& e, Visit visit) {
  visit(e.character);
  if (e.type == EventType::grab && !e.grip.other.empty()) visit(e.grip.other);
}
template <class Visit>
void for_each_reference(Rule& rule, Visit visit) {
  for (RuleCondition& c : rule.conditions) {
    using enum ConditionType;
    if (c.type == variable) visit(c.variable);
    if (c.type == touch || c.type == near || c.type == playing || c.type == released) visit(c.character);
    if ((c.type == touch || c.type == near) && !c.other.empty() && !(c.type == touch && c.other == "ground")) visit(c.other);
    if (c.type == playing && !c.rule.empty()) visit(c.rule);
  }
  RuleAction& a = rule.action;
  if (a.type == ActionType::set)
    visit(a.variable);
  else
    visit(a.character);
  if (a.type == ActionType::grab && !a.other.empty()) visit(a.other);
}
template <class Visit>
void for_each_reference(Scenario& s, Visit visit) {
  for (ScenarioEvent& e : s.events) for_each_reference(e, visit);
  for (Rule& rule : s.rules) for_each_reference(rule, visit);
  for (FilmCamera& camera : s.cameras)
    if (!camera.follow.empty()) visit(camera.follow);
  if (!s.camera.follow.empty()) visit(s.camera.follow);
}

/// Calls visit(scenario) for the document and for each of its inner scenarios.
template <class Document, class Visit>
void for_each_scenario(Document& document, Visit visit) {
  visit(document);
  for (auto& inner : document.scenarios) visit(inner);
}

}  // namespace ugoki::content
