#pragma once
// Reads and writes the JSON form of clips, characters, events and settings. Internal to content.

#include "ugoki/content/json_fields.h"
#include "ugoki/content/scenario.h"

namespace ugoki::content {

// Each of these functions reads one JSON object into `out`. Absent fields keep their value in `out`, so commands can change single fields.
void read_clip(Fields& fields, ScenarioClip& out);
void read_place(Fields& fields, ScenarioPlace& out);
void read_control(Fields& fields, ScenarioControl& out);
/// Reads all fields of a character except the track.
void read_character(Fields& fields, ScenarioCharacter& out);
void read_event(Fields& fields, ScenarioEvent& out);
/// Reads the field `axes` of a push.
void read_axes(Fields& fields, PushAxes& out);
void read_marker(Fields& fields, ScenarioMarker& out);
void read_instance(Fields& fields, ScenarioInstance& out);
/// Reads the fields name, duration, camera and range, which an inner scenario has too.
void read_inner_settings(Fields& fields, Scenario& out);
/// Reads the fields frame_rate, step, gravity, ground and look, which only the document has.
void read_world_settings(Fields& fields, Scenario& out);
/// Reads the fields of both.
void read_settings(Fields& fields, Scenario& out);
/// Reads the field `circuit`, which is an object or null.
void read_circuit_field(Fields& fields, Scenario& out);

[[nodiscard]] Json to_json(const ScenarioClip& clip);
[[nodiscard]] Json to_json(const ScenarioCharacter& character);
[[nodiscard]] Json to_json(const ScenarioEvent& event);
[[nodiscard]] Json to_json(const Rule& rule);
[[nodiscard]] Json to_json(const ScenarioVariable& variable);
[[nodiscard]] Json to_json(const Scenario& scenario);

}  // namespace ugoki::content
