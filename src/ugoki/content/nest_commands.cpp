#include "ugoki/content/nest_commands.h"

#include <cctype>
#include <cmath>
#include <set>

#include "ugoki/content/flatten.h"
#include "ugoki/content/scenario_json.h"

namespace ugoki::content {
namespace {

using Ids = std::set<std::string, std::less<>>;
using Order = std::vector<std::string>;

std::string_view head_of(std::string_view reference) { return reference.substr(0, reference.find('/')); }
bool is_path(std::string_view reference) { return reference.find('/') != std::string_view::npos; }

/// A scenario of the document as a document of its own, flattened.
Scenario flat_of(const Scenario& document, const Scenario& s) { return flatten(s.id.empty() ? document : open_scenario(document, s.id)); }

/// Ids of the characters, rules and variables of a scenario in their flattened order.
Order order_of(const Scenario& document, const Scenario& s) {
  const Scenario flat = flat_of(document, s);
  Order out;
  for (const ScenarioCharacter& c : flat.characters) out.push_back(c.id);
  for (const Rule& rule : flat.rules) out.push_back(rule.id);
  for (const ScenarioVariable& v : flat.variables) out.push_back(v.id);
  return out;
}

/// Gives a scenario the flattened order `wanted`, with a list `order` only if it is needed.
void set_order(Scenario& document, Scenario& s, const Order& wanted) {
  s.order.clear();
  if (order_of(document, s) != wanted) s.order = wanted;
}

/// Applies `change` to all references and lists of ids of a scenario.
template <class Change>
void change_references(Scenario& s, Change change) {
  for_each_reference(s, change);
  for (std::string& id : s.track_order) change(id);
  for (std::string& id : s.order) change(id);
}

/// Applies `change` to the references to items of the scenario `host` that other scenarios make by way of instances ("i/human": "human").
template <class Change>
void change_references_to(Scenario& document, const std::string& host, Change change) {
  if (host.empty()) return;  // nothing places the document
  for_each_scenario(document, [&](Scenario& from) {
    change_references(from, [&](std::string& reference) {
      const Scenario* at = &from;
      std::string before, rest = reference;
      while (at && (at == &from || at->id != host) && is_path(rest)) {
        const std::string_view head = head_of(rest);
        const auto instance = std::ranges::find(at->instances, head, &ScenarioInstance::id);
        at = instance == at->instances.end() ? nullptr : std::as_const(document).find_scenario(instance->scenario);
        before += std::string(head) + "/";
        rest.erase(0, head.size() + 1);
      }
      if (!at || at == &from || at->id != host) return;
      change(rest);
      reference = before + rest;
    });
  });
}

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

ScenarioInstance* instance_in(Fields& f, Scenario& s) {
  std::string id;
  f.require("id", "the instance's id");
  f.text("id", id);
  if (!f.problems().empty()) return nullptr;
  const auto found = std::ranges::find(s.instances, id, &ScenarioInstance::id);
  if (found != s.instances.end()) return &*found;
  f.report(ErrorCode::unknown, f.path("id"), "There is no instance '" + id + "'.", "It may have been removed; reload the document.");
  return nullptr;
}

bool has_own_circuit(Fields& f, const Scenario& document) {
  if (document.circuit.empty()) return false;
  f.report(ErrorCode::conflict, f.path("type"),
           "The content has a circuit of its own, which names the characters; nesting would change their names.",
           "Choose \"Reset to generated\" in the wiring editor first.");
  return true;
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

/// A new instance of an inner scenario, with the first free number.
ScenarioInstance new_instance(const Scenario& document, const Scenario& inner) {
  ScenarioInstance out;
  out.scenario = inner.id;
  const auto used = [&] {
    bool found = false;
    for_each_scenario(document, [&](const Scenario& s) {
      found = found || std::ranges::any_of(s.instances, [&](const ScenarioInstance& i) { return i.id == out.id; });
    });
    return found;
  };
  int n = 0;
  do out.id = inner.id + "." + std::to_string(++n);
  while (used());
  out.name = inner.name.substr(0, 190) + " " + std::to_string(n);
  return out;
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
    if (!f.problems().empty() || has_own_circuit(f, document)) return {};
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

std::string unnest_instance(Fields& f, const NestTarget& target, const AssignId& assign_id) {
  Scenario& document = target.document;
  Scenario& host = target.scenario();
  const ScenarioInstance* const found = instance_in(f, host);
  if (!found || has_own_circuit(f, document)) return {};
  const ScenarioInstance instance = *found;
  const Order before = order_of(document, host);
  Scenario part = *document.find_scenario(instance.scenario);

  // Ids that the host uses already are replaced.
  Ids used;
  const auto note = [&](const auto& list) {
    for (const auto& item : list) used.insert(item.id);
  };
  for (const ScenarioCharacter& c : host.characters) note(c.track);
  note(host.characters), note(host.events), note(host.markers), note(host.rules), note(host.variables), note(host.poses);
  note(host.cameras), note(host.shots), note(host.instances);
  std::map<std::string, std::string, std::less<>> names;
  const auto rename_items = [&](auto& list, char letter) {
    for (auto& item : list) {
      const std::string old = item.id;
      if (!used.insert(old).second) {
        item.id.clear();
        assign_id(item.id, letter);
        used.insert(item.id);
      }
      names[old] = item.id;
    }
  };
  for (ScenarioCharacter& c : part.characters) rename_items(c.track, 'k');
  rename_items(part.characters, 'c');
  rename_items(part.instances, 'i');
  rename_items(part.events, 'e');
  rename_items(part.markers, 'm');
  rename_items(part.rules, 'r');
  rename_items(part.variables, 'x');
  rename_items(part.cameras, 'v');
  rename_items(part.shots, 'h');
  const auto rename = [&](std::string& reference) {
    const std::string_view head = head_of(reference);
    if (const auto name = names.find(head); name != names.end()) reference = name->second + reference.substr(head.size());
  };
  for_each_reference(part, rename);
  for (FilmShot& shot : part.shots) rename(shot.camera);

  const auto solo = [](const auto& track) { return track.solo; };
  const bool any_solo = std::ranges::any_of(part.characters, solo) || std::ranges::any_of(part.instances, solo);
  if (!instance.solo || !any_solo) {  // otherwise the solo tracks of the part stay solo among those of the host
    resolve_solo(part);
    for (ScenarioCharacter& c : part.characters) c.solo = instance.solo;
    for (ScenarioInstance& i : part.instances) i.solo = instance.solo;
  }
  for (ScenarioCharacter& c : part.characters) c.muted = c.muted || instance.muted;
  for (ScenarioInstance& i : part.instances) i.muted = i.muted || instance.muted;
  displace(part, instance.start, instance.place);
  std::erase_if(part.shots, [&](const FilmShot& shot) {  // as in flatten()
    return std::ranges::any_of(host.shots, [&](const FilmShot& s) { return s.start == shot.start; });
  });

  const auto inside = [&](std::string& reference) {
    if (!is_path(reference) || head_of(reference) != instance.id) return;
    reference.erase(0, instance.id.size() + 1);
    rename(reference);
  };
  change_references_to(document, host.id, inside);
  change_references(host, inside);
  std::erase_if(host.instances, [&](const ScenarioInstance& i) { return i.id == instance.id; });
  const auto append = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
  append(host.characters, part.characters), append(host.instances, part.instances), append(host.events, part.events);
  append(host.markers, part.markers), append(host.rules, part.rules), append(host.variables, part.variables);
  append(host.cameras, part.cameras), append(host.shots, part.shots);
  Order wanted = before;
  for (std::string& id : wanted) inside(id);
  sort_by(wanted, host.characters);
  sort_by(wanted, host.rules);
  sort_by(wanted, host.variables);
  set_order(document, host, wanted);

  bool placed = false;
  for_each_scenario(document, [&](const Scenario& s) {
    placed = placed || std::ranges::any_of(s.instances, [&](const ScenarioInstance& i) { return i.scenario == instance.scenario; });
  });
  if (!placed) std::erase_if(document.scenarios, [&](const Scenario& s) { return s.id == instance.scenario; });
  return "Unnest";
}

std::string add_instance(Fields& f, const NestTarget& target, const AssignId& assign_id) {
  ScenarioInstance given;
  f.require("scenario", "the id of an inner scenario");
  read_instance(f, given);
  if (!f.problems().empty() || has_own_circuit(f, target.document)) return {};
  const Scenario* const inner = target.document.find_scenario(given.scenario);
  if (!inner) {
    f.report(ErrorCode::unknown, f.path("scenario"), "There is no scenario '" + given.scenario + "'.",
             "Name one of the inner scenarios of the document.");
    return {};
  }
  const ScenarioInstance fresh = new_instance(target.document, *inner);
  if (given.id.empty()) given.id = fresh.id;
  if (given.name.empty()) given.name = fresh.name;
  assign_id(given.id, 'i');
  target.scenario().instances.push_back(std::move(given));
  return "Place scenario";
}

std::string set_instance(Fields& f, const NestTarget& target) {
  ScenarioInstance* const instance = instance_in(f, target.scenario());
  if (!instance) return {};
  const ScenarioInstance before = *instance;
  read_instance(f, *instance);
  instance->id = before.id;
  if (instance->scenario != before.scenario) {
    f.report(ErrorCode::structure, f.path("scenario"), "An instance cannot change its scenario.", "Remove it and place another one.");
    return {};
  }
  if (instance->start != before.start) return "Move scenario in time";
  if (!(instance->place == before.place)) return "Place scenario";
  if (instance->name != before.name) return "Rename instance";
  if (instance->muted != before.muted) return instance->muted ? "Mute track" : "Unmute track";
  if (instance->solo != before.solo) return instance->solo ? "Solo track" : "End solo of track";
  return "Change instance";
}

std::string remove_instance(Fields& f, const NestTarget& target) {
  Scenario& s = target.scenario();
  const ScenarioInstance* const instance = instance_in(f, s);
  if (!instance || has_own_circuit(f, target.document)) return {};
  s.instances.erase(s.instances.begin() + (instance - s.instances.data()));
  remove_dangling(target.document);
  return "Remove scenario";
}

std::string remove_scenario(Fields& f, const NestTarget& target) {
  std::string id, placed;
  f.require("id", "the id of an inner scenario");
  f.text("id", id);
  if (!f.problems().empty()) return {};
  for_each_scenario(target.document, [&](const Scenario& s) {
    for (const ScenarioInstance& i : s.instances)
      if (i.scenario == id) placed += (placed.empty() ? "'" : ", '") + i.name + "' in '" + s.name + "'";
  });
  if (!placed.empty())
    f.report(ErrorCode::conflict, f.path("id"), "The scenario is still placed: " + placed + ".", "Remove these instances first.");
  else if (!target.document.find_scenario(id))
    f.report(ErrorCode::unknown, f.path("id"), "There is no scenario '" + id + "'.", "It may have been removed; reload the document.");
  else
    std::erase_if(target.document.scenarios, [&](const Scenario& s) { return s.id == id; });
  return "Remove unused scenario";
}

void remove_dangling(Scenario& document) {
  for (bool changed = true; changed;) {  // another scenario may name an item that was just removed
    changed = false;
    for_each_scenario(document, [&](Scenario& s) {
      const Order order = order_of(document, s);
      const Ids known(order.begin(), order.end());
      const auto gone = [&](const std::string& id) { return is_path(id) && !known.contains(id); };
      const std::size_t count = s.events.size() + s.rules.size();
      std::erase_if(s.events, [&](ScenarioEvent& e) {
        bool dangling = false;
        for_each_reference(e, [&](const std::string& id) { dangling = dangling || gone(id); });
        return dangling;
      });
      Ids rules;
      for (Rule& rule : s.rules)
        for_each_reference(rule, [&](const std::string& id) {
          if (gone(id)) rules.insert(rule.id);
        });
      for (const std::string& id : rules) remove_rule(s, id);
      for (FilmCamera& camera : s.cameras)
        if (gone(camera.follow)) camera.follow.clear();
      if (gone(s.camera.follow)) s.camera.follow.clear();
      changed = changed || s.events.size() + s.rules.size() != count;
    });
  }
  for_each_scenario(document, [&](Scenario& s) {
    if (s.order.empty()) return;
    const Order order = order_of(document, s);
    const Ids known(order.begin(), order.end());
    std::erase_if(s.order, [&](const std::string& id) { return !known.contains(id); });
  });
}

}  // namespace ugoki::content
