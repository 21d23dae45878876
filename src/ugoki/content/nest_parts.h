#pragma once
// Parts that the commands on nested scenarios share: flattened order, references by path, instances. Internal to content.

#include <functional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/content/json_fields.h"
#include "ugoki/content/scenario.h"

namespace ugoki::content {

using Ids = std::set<std::string, std::less<>>;
using Order = std::vector<std::string>;

inline std::string_view head_of(std::string_view reference) { return reference.substr(0, reference.find('/')); }
inline bool is_path(std::string_view reference) { return reference.find('/') != std::string_view::npos; }

/// Ids of the characters, rules and variables of a scenario in their flattened order.
Order order_of(const Scenario& document, const Scenario& s);
/// Gives a scenario the flattened order `wanted`, with a list `order` only if it is needed.
void set_order(Scenario& document, Scenario& s, const Order& wanted);

using ChangeReference = std::function<void(std::string&)>;
/// Applies `change` to all references and lists of ids of a scenario.
void change_references(Scenario& s, const ChangeReference& change);
/// Applies `change` to the references to items of the scenario `host` that other scenarios make by way of instances ("i/human": "human").
void change_references_to(Scenario& document, const std::string& host, const ChangeReference& change);

/// The instance that the field `id` of a command names. If there is none, reports it and returns null.
ScenarioInstance* instance_in(Fields& f, Scenario& s);
/// A new instance of an inner scenario, with the first free number.
ScenarioInstance new_instance(const Scenario& document, const Scenario& inner);
/// True if the content has a circuit of its own, whose names of characters `change` (a noun phrase) would change; this is reported.
bool has_own_circuit(Fields& f, const Scenario& document, std::string_view change);

}  // namespace ugoki::content
