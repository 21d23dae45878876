#pragma once
// Keyed layers of clips in the scenario document: reading, writing, checking. docs/scenario.md describes the JSON form. Internal to
// content.

#include "ugoki/content/json_fields.h"
#include "ugoki/content/scenario.h"

namespace ugoki::content {

/// Maximum number of keys of one curve, and of layers of one clip.
inline constexpr std::size_t max_keys = 10'000, max_layers = 100;

/// Reads the field `layers` of a clip, a list that replaces `out`.
void read_layers(Fields& clip, std::vector<ScenarioLayer>& out);
/// Reads the given fields of a layer except its keys; absent fields keep their value.
void read_layer(Fields& fields, ScenarioLayer& out);
/// Reads the fields `link` and `part` of a command on keys, or of a curve.
void read_joint(Fields& fields, motion_edit::JointKeys& out);
/// Reads the fields of a key; absent fields keep their value. @param components [in and out] number of components of a value; 0: any
void read_key(Fields& fields, int& components, motion_edit::LayerKey& out);

/// Adds the problems of the layers of a clip. @param mechanism null: the mechanism is unknown, so its joints are not checked
void check_layers(const std::vector<ScenarioLayer>& layers, const MechanismFacts* mechanism, const std::string& location, Error& problems);

/// Sorts joints by link and part, and keys by time.
void put_in_order(ScenarioLayer& layer);

[[nodiscard]] Json to_json(const ScenarioLayer& layer);

}  // namespace ugoki::content
