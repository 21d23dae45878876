#pragma once
// Meshes and height fields in the JSON form of a mechanism, each written once with what was prepared for it; internal to formats.

#include <map>
#include <string>

#include "ugoki/json/fields.h"
#include "ugoki/mechanism/mechanism.h"

namespace ugoki::formats {

/// By the names under which shapes refer to them.
struct SurfaceTables {
  std::map<std::string, GeometryPtr, std::less<>> geometries;
  std::map<std::string, HeightFieldPtr, std::less<>> height_fields;
};

/// Reads "geometries" and "height_fields" of the document; problems have their JSON path.
[[nodiscard]] SurfaceTables read_surfaces(json::Fields& document);

/// The name under which a shape's mesh or height field is written: its hash.
[[nodiscard]] std::string surface_name(std::uint64_t hash);

/// The members "geometries" and "height_fields" of the document, with a comma in front; empty where no shape has any.
[[nodiscard]] std::string surfaces_text(const MechanismSpec& spec);

}  // namespace ugoki::formats
