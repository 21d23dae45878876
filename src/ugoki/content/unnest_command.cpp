#include "ugoki/content/nest_commands.h"

#include <algorithm>
#include <map>

#include "ugoki/content/flatten.h"
#include "ugoki/content/nest_parts.h"
#include "ugoki/content/scenario_json.h"

namespace ugoki::content {

std::string unnest_instance(Fields& f, const NestTarget& target, const AssignId& assign_id) {
  Scenario& document = target.document;
  Scenario& host = target.scenario();
  const ScenarioInstance* const found = instance_in(f, host);
  if (!found || has_own_circuit(f, document, "splitting a scenario")) return {};
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

}  // namespace ugoki::content
