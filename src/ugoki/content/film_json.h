#pragma once
// Reads and writes the JSON form of cameras, shots and the look. Internal to content.

#include "ugoki/content/json_fields.h"
#include "ugoki/content/scenario.h"

namespace ugoki::content {

/// Reads the fields `cameras` and `shots` of a document.
void read_film(Fields& document, Scenario& out);
/// Sets the fields `cameras` and `shots` of `json`; empty lists are left out.
void write_film(const std::vector<FilmCamera>& cameras, const std::vector<FilmShot>& shots, Json& json);

/// Reads the given fields of a look; absent fields keep their value in `out`.
void read_look(Fields& fields, ScenarioLook& out);
/// Values that equal the default are left out, except `light` and `floor`.
[[nodiscard]] Json to_json(const ScenarioLook& look);
/// Reads the fields of a character that only change how it is drawn.
void read_material(Fields& fields, ScenarioMaterial& out);
/// Sets these fields of `json`; values that equal the default are left out.
void write_material(const ScenarioMaterial& material, Json& json);

/// Adds the problems of the look. @param location location of the look
void check_look(const ScenarioLook& look, const std::string& location, Error& problems);
/// @param mechanism null: the mechanism is unknown, so names of links are not checked
void check_material(const ScenarioMaterial& material, const MechanismFacts* mechanism, const std::string& location, Error& problems);

}  // namespace ugoki::content
