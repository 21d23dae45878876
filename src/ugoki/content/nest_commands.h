#pragma once
// Commands on nested scenarios. docs/scenario.md lists them, docs/design/nested-scenarios.md gives their reasons. Internal to content.

#include <string>

#include "ugoki/content/json_fields.h"
#include "ugoki/content/list_commands.h"
#include "ugoki/content/scenario.h"

namespace ugoki::content {

/// The document, and the scenario of it in which a command acts: the document itself, or one of its inner scenarios.
struct NestTarget {
  Scenario& document;
  std::string inner;  ///< id of the inner scenario; empty: the document
  [[nodiscard]] Scenario& scenario() const { return inner.empty() ? document : *document.find_scenario(inner); }
};

// Each of these functions reads the fields of one command and changes the document; problems are added to the fields' list.
// @return the label for undo menus

/// `scenario.nest`: moves characters and instances, with what concerns only them, to a new inner scenario that is placed once.
std::string nest_tracks(Fields& f, const NestTarget& target, const AssignId& assign_id);
/// `instance.unnest`: replaces an instance by a copy of the content of its inner scenario.
std::string unnest_instance(Fields& f, const NestTarget& target, const AssignId& assign_id);
std::string add_instance(Fields& f, const NestTarget& target, const AssignId& assign_id);
std::string set_instance(Fields& f, const NestTarget& target);
/// `instance.remove`: the inner scenario stays in the document.
std::string remove_instance(Fields& f, const NestTarget& target);
/// `scenario.remove`: removes an inner scenario that is not placed.
std::string remove_scenario(Fields& f, const NestTarget& target);

/// Removes events and rules that name an item of an instance that no longer exists, and lets cameras follow nothing instead. Items that
/// no longer exist are also removed from the lists `order`.
void remove_dangling(Scenario& document);

}  // namespace ugoki::content
