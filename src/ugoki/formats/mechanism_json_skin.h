#pragma once
// The skin in the JSON form of a mechanism: its lists as packed numbers (little-endian, Base64). Internal to formats.

#include <span>
#include <string>

#include "ugoki/json/fields.h"
#include "ugoki/mechanism/mechanism.h"

namespace ugoki::formats {

/// Reads "skin" of the document into spec.skin and spec.skin_bones. Mechanism::make() checks the values.
void read_skin(json::Fields& document, MechanismSpec& spec);

/// Returns the JSON member "skin", after a comma.
[[nodiscard]] std::string skin_text(const Skin& skin, std::span<const SkinBone> bones);

}  // namespace ugoki::formats
