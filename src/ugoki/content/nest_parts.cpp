#include "ugoki/content/nest_parts.h"

#include <algorithm>

#include "ugoki/content/flatten.h"
#include "ugoki/content/scenario_json.h"

namespace ugoki::content {
namespace {

/// A scenario of the document as a document of its own, flattened.
Scenario flat_of(const Scenario& document, const Scenario& s) { return flatten(s.id.empty() ? document : open_scenario(document, s.id)); }

}  // namespace

Order order_of(const Scenario& document, const Scenario& s) {
  const Scenario flat = flat_of(document, s);
  Order out;
  for (const ScenarioCharacter& c : flat.characters) out.push_back(c.id);
  for (const Rule& rule : flat.rules) out.push_back(rule.id);
  for (const ScenarioVariable& v : flat.variables) out.push_back(v.id);
  return out;
}

void set_order(Scenario& document, Scenario& s, const Order& wanted) {
  s.order.clear();
  if (order_of(document, s) != wanted) s.order = wanted;
}

void change_references(Scenario& s, const ChangeReference& change) {
  for_each_reference(s, change);
  for (std::string& id : s.track_order) change(id);
  for (std::string& id : s.order) change(id);
}

void change_references_to(Scenario& document, const std::string& host, const ChangeReference& change) {
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

bool has_own_circuit(Fields& f, const Scenario& document, std::string_view change) {
  if (document.circuit.empty()) return false;
  f.report(ErrorCode::conflict, f.path("type"),
           "The content has a circuit of its own, which names the characters; " + std::string(change) + " would change these names.",
           "Choose \"Reset to generated\" in the wiring editor first.");
  return true;
}

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

}  // namespace ugoki::content
