#pragma once
// The JSON form of a scenario's parts. Internal to content.

#include "ugoki/content/json_fields.h"
#include "ugoki/content/scenario.h"

namespace ugoki::content {

// Each reads one object into `out`, on top of what `out` holds (so the same functions merge a command's fields).
void read_clip(Fields& fields, ScenarioClip& out);
void read_place(Fields& fields, ScenarioPlace& out);
void read_control(Fields& fields, ScenarioControl& out);
/// Everything but the track.
void read_character(Fields& fields, ScenarioCharacter& out);
void read_event(Fields& fields, ScenarioEvent& out);
/// name, duration, frame_rate, step, gravity, ground, camera, look.
void read_settings(Fields& fields, Scenario& out);
/// `circuit`: an object or null.
void read_circuit_field(Fields& fields, Scenario& out);

[[nodiscard]] Json to_json(const ScenarioClip& clip);
[[nodiscard]] Json to_json(const ScenarioCharacter& character);
[[nodiscard]] Json to_json(const ScenarioEvent& event);
[[nodiscard]] Json to_json(const Scenario& scenario);

}  // namespace ugoki::content
