#include "ugoki/circuit/migrate.h"

#include <array>
#include <set>
#include <string>

#include "ugoki/circuit/circuit.h"

namespace ugoki::circuit {
namespace {

using json::Json;

/// Returns the text of a string field; null if there is none.
std::string* find_text(Json& object, const char* key) {
  if (!object.is_object()) return nullptr;
  const auto it = object.find(key);
  return it != object.end() && it->is_string() ? it->get_ptr<Json::string_t*>() : nullptr;
}

/// Calls `visit` with each entry of a list field, if the object has that list.
template <class Visit>
void for_each_entry(Json& object, const char* key, Visit visit) {
  if (!object.is_object()) return;
  const auto it = object.find(key);
  if (it == object.end() || !it->is_array()) return;
  for (Json& entry : *it) visit(entry);
}

/// Version 2 renamed the LSI class "nearest pair" to "closest pair", the output "figures" of the class "display" to "characters", and the
/// circuit's output "figures" that the player reads to "characters".
void from_1_to_2(Json& circuit, int depth) {
  if (depth > json::max_depth) return;
  std::set<std::string, std::less<>> displays;  // the output "ID.figures" of each display LSI
  for_each_entry(circuit, "lsis", [&](Json& lsi) {
    std::string* type = find_text(lsi, "type");
    if (!type) return;
    if (*type == "nearest pair") *type = "closest pair";
    if (const std::string* id = find_text(lsi, "id"); id && *type == "display") displays.insert(*id + ".figures");
  });
  const auto rename_pin = [&](Json& object, const char* key) {
    std::string* pin = find_text(object, key);
    if (!pin || !displays.contains(*pin)) return false;
    *pin = pin->substr(0, pin->size() - std::string_view("figures").size()) + "characters";
    return true;
  };
  for_each_entry(circuit, "wires", [&](Json& wire) { rename_pin(wire, "from"); });
  for_each_entry(circuit, "probes", [&](Json& probe) { rename_pin(probe, "pin"); });
  for_each_entry(circuit, "outputs", [&](Json& output) {
    rename_pin(output, "from");
    if (std::string* name = find_text(output, "name"); depth == 0 && name && *name == "figures") *name = "characters";
  });
  for_each_entry(circuit, "circuits", [&](Json& inner) { from_1_to_2(inner, depth + 1); });
}

}  // namespace

std::span<const Migration> migrations() {
  static constexpr std::array<Migration, 1> steps = {[](Json& circuit) { from_1_to_2(circuit, 0); }};
  static_assert(steps.size() == circuit_version - 1, "add the migration from the former version");
  return steps;
}

void migrate(Json& circuit, std::int64_t version, std::span<const Migration> steps) {
  for (std::size_t k = static_cast<std::size_t>(version - 1); k < steps.size(); ++k) steps[k](circuit);
  circuit["version"] = steps.size() + 1;
}

void migrate(Json& circuit) {
  if (!circuit.is_object()) return;
  const auto field = circuit.find("version");
  if (field == circuit.end() || !field->is_number_integer()) return;
  if (const auto version = field->get<std::int64_t>(); version >= 1 && version < circuit_version) migrate(circuit, version, migrations());
}

}  // namespace ugoki::circuit
