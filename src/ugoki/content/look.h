#pragma once
// How a scenario is drawn: light, sky, ground and materials. docs/scenario.md describes the JSON form. It has no effect on the motion.

#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace ugoki::content {

/// The light that casts shadows.
struct SunLight {
  double azimuth = 0.918, elevation = 1.009;  ///< rad: direction from the ground to the light
  double intensity = 1;                       ///< factor, 0 ... 4
  std::string color = "#fff3e4";              ///< "#rrggbb"
  friend bool operator==(const SunLight&, const SunLight&) = default;
};

struct ScenarioLook {
  double light = 0.9;  ///< brightness of all lights, 0 ... 2
  double ambient = 1;  ///< factor on the light from all sides, 0 ... 4
  SunLight sun;
  std::string floor = "#2a2c31";  ///< colour of the ground, "#rrggbb"
  std::string pattern = "grid";   ///< of the ground: "grid", "plain", "checker", "boards"
  std::string zenith, horizon;    ///< colours of the sky, "#rrggbb"; both empty: the background of the page's theme
  friend bool operator==(const ScenarioLook&, const ScenarioLook&) = default;
};

struct ScenarioMaterial {
  double roughness = 0.6;                                       ///< 0: mirror-like highlights, 1: matt
  double metalness = 0;                                         ///< 0: plastic, skin, wood; 1: metal
  std::map<std::string, std::string, std::less<>> link_colors;  ///< colour "#rrggbb" of a link by its name; others have the character's
  /// Colours "#rrggbb" of the visible shapes, link by link; shapes without one, or with an empty one, have the colour of their link.
  std::vector<std::string> shape_colors = {};
  std::string shown = "skin";  ///< of a mechanism with a skin: "skin", "body" (its shapes) or "both" (the skin is transparent)
  friend bool operator==(const ScenarioMaterial&, const ScenarioMaterial&) = default;
};

/// True if `text` is a colour "#rrggbb".
[[nodiscard]] bool is_color(std::string_view text);

}  // namespace ugoki::content
