#include "ugoki/content/nest_commands.h"

#include <algorithm>

#include "ugoki/content/flatten.h"
#include "ugoki/content/nest_parts.h"
#include "ugoki/content/scenario_json.h"

namespace ugoki::content {

std::string add_instance(Fields& f, const NestTarget& target, const AssignId& assign_id) {
  ScenarioInstance given;
  f.require("scenario", "the id of an inner scenario");
  read_instance(f, given);
  if (!f.problems().empty() || has_own_circuit(f, target.document, "placing a scenario")) return {};
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
  if (!instance || has_own_circuit(f, target.document, "removing a scenario")) return {};
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
