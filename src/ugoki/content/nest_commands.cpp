#include "ugoki/content/nest_commands.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "ugoki/content/flatten.h"
#include "ugoki/content/nest_parts.h"
#include "ugoki/content/scenario_json.h"

namespace ugoki::content {
namespace {

/// Reads a list of ids, each of which one of the items has.
template <class List>
void read_ids(Fields& f, std::string_view key, std::string_view kind, const List& items, Ids& out) {
  const Json* list = f.list(key, 10'000, "ids");
  if (!list) return;
  for (std::size_t i = 0; i < list->size(); ++i) {
    const std::string id = (*list)[i].is_string() ? (*list)[i].template get<std::string>() : std::string();
    if (std::ranges::none_of(items, [&](const auto& item) { return item.id == id; }))
      f.report(ErrorCode::unknown, f.path(key) + "/" + std::to_string(i), "There is no " + std::string(kind) + " '" + id + "'.",
               "It may have been removed; reload the document.");
    out.insert(id);
  }
}

/// Id of a new inner scenario: the letters and digits of its name, and a number if another scenario has that id.
std::string scenario_id(const Scenario& document, const std::string& name) {
  constexpr std::size_t longest = 16;
  std::string base;
  for (const char c : name) {
    if (base.size() == longest) break;
    if (std::isalnum(static_cast<unsigned char>(c)))
      base += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    else if (!base.empty() && base.back() != '-')
      base += '-';
  }
  while (base.ends_with('-')) base.pop_back();
  if (base.empty()) base = "scenario";
  std::string id = base;
  for (int n = 2; document.find_scenario(id); ++n) id = base + "-" + std::to_string(n);
  return id;
}

/// End of the last clip, event and instance of a scenario, s; 0: there is none.
double end_of(const Scenario& document, const Scenario& s) {
  double end = 0;
  for (const ScenarioCharacter& c : s.characters)
    for (const ScenarioClip& clip : c.track) end = std::max(end, clip.start + clip.length);
  for (const ScenarioEvent& e : s.events) end = std::max(end, e.time + e.duration);
  for (const ScenarioInstance& i : s.instances)
    if (const Scenario* inner = document.find_scenario(i.scenario)) end = std::max(end, i.start + inner->duration);
  return end;
}

/// Moves the items of `from` that `moved` names to the end of `to`.
template <class List>
void move_items(List& from, List& to, const Ids& moved) {
  for (auto& item : from)
    if (moved.contains(item.id)) to.push_back(item);
  std::erase_if(from, [&](const auto& item) { return moved.contains(item.id); });
}

/// The rules, and the variables of these rules, that concern only the tracks: they name no other character, rule or variable, and no other
/// rule names them or their variables.
Ids private_rules(Scenario& s, const Ids& tracks) {
  struct Use {
    const Rule* rule;
    bool names_track = false, inside = true;
    Ids rules, variables;
  };
  std::vector<Use> uses;
  for (Rule& rule : s.rules) {
    Use& use = uses.emplace_back(Use{&rule, false, true, {}, {}});
    for_each_reference(rule, [&](std::string& reference) {
      if (tracks.contains(head_of(reference)))
        use.names_track = true;
      else if (std::ranges::find(s.rules, reference, &Rule::id) != s.rules.end())
        use.rules.insert(reference);
      else if (std::ranges::find(s.variables, reference, &ScenarioVariable::id) != s.variables.end())
        use.variables.insert(reference);
      else
        use.inside = false;
    });
    use.inside = use.inside && use.names_track;
  }
  // A rule that depends on a rule outside, or on which one depends, stays outside. So does a rule that shares a variable with one.
  for (bool changed = true; changed;) {
    changed = false;
    for (Use& a : uses)
      for (Use& b : uses) {
        const bool linked = a.rules.contains(b.rule->id) || b.rules.contains(a.rule->id) ||
                            std::ranges::any_of(a.variables, [&](const std::string& v) { return b.variables.contains(v); });
        if (a.inside && !b.inside && linked) {
          a.inside = false;
          changed = true;
        }
      }
  }
  Ids out;
  for (const Use& use : uses) {
    if (!use.inside) continue;
    out.insert(use.rule->id);
    out.insert(use.variables.begin(), use.variables.end());
  }
  return out;
}

}  // namespace

std::string nest_tracks(Fields& f, const NestTarget& target, const AssignId& assign_id) {
  Scenario& document = target.document;
  Scenario inner;
  Ids tracks;
  {
    const Scenario& host = target.scenario();
    f.require("name", "the name of the new scenario");
    f.text("name", inner.name);
    read_ids(f, "characters", "character", host.characters, tracks);
    read_ids(f, "instances", "instance", host.instances, tracks);
    if (!f.problems().empty() || has_own_circuit(f, document, "nesting")) return {};
    if (tracks.empty()) f.report(ErrorCode::structure, f.path("characters"), "No tracks are named.", "Name the characters to be nested.");
    for (const ScenarioCharacter& c : host.characters)
      if (c.locked && tracks.contains(c.id))
        f.report(ErrorCode::conflict, f.path("characters"), "The track of '" + c.name + "' is locked.", "Unlock the track first.");
    if (!f.problems().empty()) return {};
  }
  Scenario& host = target.scenario();
  const Order before = order_of(document, host);
  inner.id = scenario_id(document, inner.name);
  inner.duration = host.duration;

  Ids moved = private_rules(host, tracks);
  moved.insert(tracks.begin(), tracks.end());
  for (ScenarioEvent& e : host.events) {
    bool all = true;
    for_each_reference(e, [&](const std::string& reference) { all = all && tracks.contains(head_of(reference)); });
    if (all) moved.insert(e.id);
  }
  for (const FilmCamera& camera : host.cameras)
    if (tracks.contains(head_of(camera.follow))) moved.insert(camera.id);
  for (const FilmShot& shot : host.shots)
    if (moved.contains(shot.camera)) moved.insert(shot.id);
  ScenarioInstance instance = new_instance(document, inner);
  for (const ScenarioCharacter& c : host.characters) instance.solo = instance.solo || (c.solo && tracks.contains(c.id));
  for (const ScenarioInstance& i : host.instances) instance.solo = instance.solo || (i.solo && tracks.contains(i.id));
  move_items(host.characters, inner.characters, moved);
  move_items(host.instances, inner.instances, moved);
  move_items(host.events, inner.events, moved);
  move_items(host.rules, inner.rules, moved);
  move_items(host.variables, inner.variables, moved);
  move_items(host.cameras, inner.cameras, moved);
  move_items(host.shots, inner.shots, moved);
  for (const std::string& id : host.track_order)
    if (moved.contains(id)) inner.track_order.push_back(id);
  std::erase_if(host.track_order, [&](const std::string& id) { return moved.contains(id); });
  if (const double end = end_of(document, inner); end > 0) inner.duration = std::ceil(end * 10 - 1e-6) / 10;
  host.instances.push_back(instance);

  const auto rename = [&](std::string& reference) {
    if (moved.contains(head_of(reference))) reference = instance.id + "/" + reference;
  };
  change_references(host, rename);
  change_references_to(document, host.id, rename);
  Order wanted = before, wanted_inner;
  for (std::string& id : wanted) {
    if (moved.contains(head_of(id))) wanted_inner.push_back(id);
    rename(id);
  }
  assign_id(inner.id, 's');
  assign_id(instance.id, 'i');
  document.scenarios.push_back(std::move(inner));  // `host` may be invalid from here on
  set_order(document, document.scenarios.back(), wanted_inner);
  set_order(document, target.scenario(), wanted);
  return "Nest in a scenario";
}

}  // namespace ugoki::content
