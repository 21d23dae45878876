#include "ugoki/content/look.h"

#include <algorithm>
#include <array>

#include "ugoki/base/number.h"
#include "ugoki/content/film_json.h"

namespace ugoki::content {
namespace {

constexpr std::array patterns = {"grid", "plain", "checker", "boards"};
constexpr std::size_t max_link_colors = 1'000, max_shape_colors = 1'000;

void check_color(const std::string& location, const std::string& value, Error& problems) {
  if (!is_color(value))
    problems.add(ErrorCode::syntax, location, "'" + value + "' is not a colour.", "Write it as #rrggbb, for example #e6e6ea.");
}

void check_range(const std::string& location, double value, double low, double high, Error& problems) {
  if (value >= low && value <= high) return;
  problems.add(ErrorCode::range, location, "The value " + ugoki::to_text(value) + " is out of range.",
               "Give a value from " + ugoki::to_text(low) + " to " + ugoki::to_text(high) + ".");
}

}  // namespace

bool is_color(std::string_view text) {
  return text.size() == 7 && text[0] == '#' && std::all_of(text.begin() + 1, text.end(), [](char c) {
           return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f') || (c >= 'A' && c <= 'F');
         });
}

void read_look(Fields& f, ScenarioLook& out) {
  f.number("light", out.light);
  f.number("ambient", out.ambient);
  f.text("floor", out.floor);
  f.text("pattern", out.pattern);
  if (const Json* sun = f.find("sun")) {
    Fields g(*sun, f.path("sun"), f.problems());
    g.number("azimuth", out.sun.azimuth);
    g.number("elevation", out.sun.elevation);
    g.number("intensity", out.sun.intensity);
    g.text("color", out.sun.color);
    g.refuse_others();
  }
  const Json* sky = f.find("sky");
  if (!sky) return;
  out.zenith.clear();
  out.horizon.clear();
  if (sky->is_null()) return;
  Fields g(*sky, f.path("sky"), f.problems());
  g.require("zenith", "the colour of the sky above, for example \"#4a7ab8\"");
  g.require("horizon", "the colour of the sky at the horizon, for example \"#c9d6e4\"");
  g.text("zenith", out.zenith);
  g.text("horizon", out.horizon);
  g.refuse_others();
}

Json to_json(const ScenarioLook& look) {
  const ScenarioLook normal;
  Json json;
  json["light"] = look.light;
  json["floor"] = look.floor;
  if (look.ambient != normal.ambient) json["ambient"] = look.ambient;
  if (look.pattern != normal.pattern) json["pattern"] = look.pattern;
  if (!(look.sun == normal.sun)) {
    Json& sun = json["sun"];
    sun["azimuth"] = look.sun.azimuth;
    sun["elevation"] = look.sun.elevation;
    sun["intensity"] = look.sun.intensity;
    sun["color"] = look.sun.color;
  }
  if (!look.zenith.empty()) {
    json["sky"]["zenith"] = look.zenith;
    json["sky"]["horizon"] = look.horizon;
  }
  return json;
}

void read_material(Fields& f, ScenarioMaterial& out) {
  f.number("roughness", out.roughness);
  f.number("metalness", out.metalness);
  f.text("shown", out.shown);
  if (const Json* list = f.list("shape_colors", max_shape_colors, "shape_colors")) {
    out.shape_colors.clear();
    for (const Json& color : *list) out.shape_colors.push_back(color.is_string() ? color.get<std::string>() : "none");
  }
  const Json* colors = f.find("link_colors");
  if (!colors) return;
  if (!colors->is_object() || colors->size() > max_link_colors) {
    f.report(ErrorCode::syntax, f.path("link_colors"), "The value must be an object with at most 1000 links and their colours.",
             "Write it as {\"link\": \"#rrggbb\"}.");
    return;
  }
  out.link_colors.clear();
  Fields g(*colors, f.path("link_colors"), f.problems());
  for (const auto& [link, color] : colors->items()) g.text(link, out.link_colors[link]);
}

void write_material(const ScenarioMaterial& material, Json& json) {
  const ScenarioMaterial normal;
  if (material.roughness != normal.roughness) json["roughness"] = material.roughness;
  if (material.metalness != normal.metalness) json["metalness"] = material.metalness;
  if (material.shown != normal.shown) json["shown"] = material.shown;
  for (const auto& [link, color] : material.link_colors) json["link_colors"][link] = color;
  if (!material.shape_colors.empty()) json["shape_colors"] = material.shape_colors;
}

void check_look(const ScenarioLook& look, const std::string& location, Error& problems) {
  check_range(location + "/light", look.light, 0, 2, problems);
  check_range(location + "/ambient", look.ambient, 0, 4, problems);
  check_range(location + "/sun/azimuth", look.sun.azimuth, -1000, 1000, problems);
  check_range(location + "/sun/elevation", look.sun.elevation, 0.1, 1.5708, problems);
  check_range(location + "/sun/intensity", look.sun.intensity, 0, 4, problems);
  check_color(location + "/sun/color", look.sun.color, problems);
  check_color(location + "/floor", look.floor, problems);
  if (std::find(patterns.begin(), patterns.end(), look.pattern) == patterns.end())
    problems.add(ErrorCode::unknown, location + "/pattern", "There is no ground pattern '" + look.pattern + "'.",
                 "Use \"grid\", \"plain\", \"checker\" or \"boards\".");
  if (look.zenith.empty() && look.horizon.empty()) return;
  check_color(location + "/sky/zenith", look.zenith, problems);
  check_color(location + "/sky/horizon", look.horizon, problems);
}

void check_material(const ScenarioMaterial& m, const MechanismFacts* mechanism, const std::string& location, Error& problems) {
  check_range(location + "/roughness", m.roughness, 0, 1, problems);
  check_range(location + "/metalness", m.metalness, 0, 1, problems);
  if (m.shown != "skin" && m.shown != "body" && m.shown != "both")
    problems.add(ErrorCode::unknown, location + "/shown", "There is nothing to show with the name '" + m.shown + "'.",
                 "Use \"skin\", \"body\" or \"both\".");
  for (std::size_t i = 0; i < m.shape_colors.size(); ++i)
    if (!m.shape_colors[i].empty()) check_color(location + "/shape_colors/" + std::to_string(i), m.shape_colors[i], problems);
  for (const auto& [link, color] : m.link_colors) {
    const std::string place = location + "/link_colors/" + link;
    check_color(place, color, problems);
    if (mechanism && std::find(mechanism->links.begin(), mechanism->links.end(), link) == mechanism->links.end())
      problems.add(ErrorCode::unknown, place, "Mechanism '" + mechanism->name + "' has no link '" + link + "'.", "Name one of its links.");
  }
}

}  // namespace ugoki::content
