#pragma once
// Commands on the keyed layers of one clip. docs/scenario.md lists them. Internal to content.

#include <string>

#include "ugoki/content/json_fields.h"
#include "ugoki/content/scenario.h"

namespace ugoki::content {

// Each of these functions reads the fields of one command and changes the clip; problems are added to the fields' list.
// @return the label for undo menus

/// `layer.add`: field `value` (fields of the layer), optional `at` (index). @param free_id id for a layer without one
/// @param id [out] the layer's id
std::string add_layer(Fields& f, ScenarioClip& clip, const std::string& free_id, std::string& id);
std::string set_layer(Fields& f, ScenarioClip& clip);
std::string remove_layer(Fields& f, ScenarioClip& clip);
std::string move_layer(Fields& f, ScenarioClip& clip);
/// `key.edit`: removes the keys in `take`, then sets the keys in `put`.
std::string edit_keys(Fields& f, ScenarioClip& clip);

}  // namespace ugoki::content
