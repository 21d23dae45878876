#pragma once
// Meshes and height fields in the JSON form of a mechanism. Each mesh and height field is written once, a mesh with its prepared collision
// data (convex hull, sphere tree). Internal to formats.

#include <map>
#include <string>

#include "ugoki/json/fields.h"
#include "ugoki/mechanism/mechanism.h"

namespace ugoki::formats {

/// The surfaces (meshes and height fields) of a document, by the names that shapes use for them.
struct SurfaceTables {
  std::map<std::string, GeometryPtr, std::less<>> geometries;
  std::map<std::string, HeightFieldPtr, std::less<>> height_fields;
};

/// Reads "geometries" and "height_fields" of the document. Problems are added to the document's list, with their JSON path.
[[nodiscard]] SurfaceTables read_surfaces(json::Fields& document);

/// Returns the name of a mesh or height field in the file: its hash as 16 hexadecimal digits.
[[nodiscard]] std::string surface_name(std::uint64_t hash);

/// Returns the JSON members "geometries" and "height_fields", each after a comma; empty if no shape has a mesh or height field.
[[nodiscard]] std::string surfaces_text(const MechanismSpec& spec);

}  // namespace ugoki::formats
