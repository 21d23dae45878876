#include "ugoki/formats/mechanism_json_geometry.h"

#include <bit>
#include <cmath>
#include <cstring>
#include <utility>

#include "ugoki/base/base64.h"
#include "ugoki/base/number.h"
#include "ugoki/collision/prepared_geometry.h"
#include "ugoki/formats/text.h"

namespace ugoki::formats {
namespace {

using json::Fields;
using json::Json;

constexpr std::size_t max_surfaces = 100'000;  // maximum number of entries in "geometries", and in "height_fields"

static_assert(std::endian::native == std::endian::little, "numbers are packed in little-endian byte order");

/// Encodes the bytes of values as base64 text ("packed"), in quotes.
template <class T>
std::string packed(const std::vector<T>& values) {
  return "\"" + to_base64({reinterpret_cast<const std::uint8_t*>(values.data()), values.size() * sizeof(T)}) + "\"";
}

/// Decodes packed values. Adds a problem and returns false if `text` is not base64 or does not contain whole values of type T.
template <class T>
bool unpack(Fields& f, const std::string& path, const std::string& text, std::vector<T>& out) {
  const std::optional<std::vector<std::uint8_t>> bytes = from_base64(text);
  if (!bytes || bytes->size() % sizeof(T) != 0) {
    f.report(ErrorCode::syntax, path, "The packed numbers are not valid base64 or are incomplete.",
             "Write the file again, or use lists of numbers.");
    return false;
  }
  out.resize(bytes->size() / sizeof(T));
  if (!out.empty()) std::memcpy(out.data(), bytes->data(), bytes->size());
  return true;
}

/// Reads the packed values of the field `key`. Returns false if the field is missing or invalid; an invalid field adds a problem.
template <class T>
bool read_packed(Fields& f, std::string_view key, std::vector<T>& out) {
  const Json* field = f.find(key);
  if (!field) return false;
  if (field->is_string()) return unpack(f, f.path(key), field->get_ref<const std::string&>(), out);
  f.report(ErrorCode::syntax, f.path(key), "The value must be packed numbers, a base64 text.",
           "Remove \"prepared\"; it will be computed again.");
  return false;
}

/// Reads the field `key`: packed values, or a list of lists of three numbers. @param number converts one number to the component type
template <class Three, class Number>
bool read_threes(Fields& f, std::string_view key, std::size_t maximum, std::vector<Three>& out, const Number& number) {
  const Json* field = f.find(key);
  if (field && field->is_string()) return unpack(f, f.path(key), field->get_ref<const std::string&>(), out);
  f.require(key, "three numbers for each entry");
  const Json* list = f.list(key, maximum, key);
  for (std::size_t i = 0; list && i < list->size(); ++i) {
    double x[3];
    if (!f.numbers((*list)[i], f.path(key) + "/" + std::to_string(i), x)) return false;
    out.push_back({number(x[0]), number(x[1]), number(x[2])});
  }
  return list != nullptr;
}

/// Adds the problems of `error` at the JSON path `path`.
void report_all(Fields& f, const std::string& path, const Error& error) {
  for (const Problem& p : error.problems) f.report(p.code, path, p.message, p.remedy);
}

/// Reads "prepared", the collision data of a mesh. Returns null, and adds problems, if the data are not valid.
collision::PreparedPtr read_prepared(Fields& g, const Geometry& geometry) {
  std::string of;
  g.text("of", of);
  if (of != surface_name(geometry.hash)) {
    g.report(ErrorCode::conflict, g.path("of"), "The prepared data belong to a different mesh.",
             "Remove \"prepared\"; it will be computed again.");
    return nullptr;
  }
  collision::Hull hull;
  if (const Json* object = g.find("hull")) {
    Fields h(*object, g.path("hull"), g.problems());
    std::vector<Vec3> vertices = geometry.vertices;
    std::vector<std::int32_t> first, corners;
    if (h.has("vertices") && !read_packed(h, "vertices", vertices)) return nullptr;
    if (!h.is_object() || !read_packed(h, "first_corner", first) || !read_packed(h, "corners", corners)) return nullptr;
    h.refuse_others();
    Result<collision::Hull> made = collision::assemble_hull(std::move(vertices), std::move(first), std::move(corners));
    if (!made) {
      report_all(h, h.path(), made.error());
      return nullptr;
    }
    hull = std::move(*made);
  }
  collision::SphereTree spheres;
  if (g.has("spheres")) {
    std::vector<std::uint8_t> bytes;
    if (!read_packed(g, "spheres", bytes)) return nullptr;
    Result<collision::SphereTree> made = collision::read_sphere_tree(bytes, g.path("spheres"));
    if (!made) {
      report_all(g, g.path("spheres"), made.error());
      return nullptr;
    }
    spheres = std::move(*made);
  }
  Result<collision::PreparedPtr> prepared = collision::make_prepared(geometry, std::move(hull), std::move(spheres), g.path());
  if (prepared) return std::move(*prepared);
  report_all(g, g.path(), prepared.error());
  return nullptr;
}

GeometryPtr read_geometry(Fields& f) {
  std::vector<Vec3> vertices;
  std::vector<Triangle> triangles;
  bool convex = false;
  f.boolean("convex", convex);
  bool complete = read_threes(f, "vertices", 3 * max_triangles, vertices, [](double x) { return x; });
  complete = read_threes(f, "triangles", max_triangles, triangles,
                         [](double x) { return x == std::floor(x) && x >= 0 && x < 2e9 ? static_cast<std::int32_t>(x) : -1; }) &&
             complete;
  const Json* prepared = f.find("prepared");
  if (!complete) return nullptr;
  Result<GeometryPtr> geometry = make_geometry(vertices, triangles, convex, f.path());
  if (!geometry) {
    report_all(f, f.path(), geometry.error());
    return nullptr;
  }
  if (!prepared) return std::move(*geometry);
  Fields g(*prepared, f.path("prepared"), f.problems());
  if (!g.is_object()) return nullptr;
  collision::PreparedPtr made = read_prepared(g, **geometry);
  g.refuse_others();
  return made ? collision::with_prepared(**geometry, std::move(made)) : nullptr;
}

HeightFieldPtr read_height_field(Fields& f) {
  HeightField field;
  const std::size_t before = f.problems().problems.size();
  f.integer("columns", field.columns);
  f.integer("rows", field.rows);
  if (f.problems().problems.size() > before) return nullptr;
  f.number("half_x", field.half_x);
  f.number("half_y", field.half_y);
  f.number("base", field.base);
  const Json* heights = f.find("heights");
  if (heights && heights->is_string()) {
    if (!unpack(f, f.path("heights"), heights->get_ref<const std::string&>(), field.heights)) return nullptr;
  } else {
    f.require("heights", "one number for each point, row by row");
    const Json* list = f.list("heights", max_heights, "heights");
    field.heights.resize(list ? list->size() : 0);
    if (!list || !f.numbers(*list, f.path("heights"), field.heights)) return nullptr;
  }
  Result<HeightFieldPtr> made = make_height_field(std::move(field), f.path());
  if (made) return std::move(*made);
  report_all(f, f.path(), made.error());
  return nullptr;
}

/// Reads all entries of the list `key` into `out`; the key in `out` is the entry's name.
template <class Ptr, class Read>
void read_table(Fields& document, std::string_view key, std::map<std::string, Ptr, std::less<>>& out, const Read& read) {
  const Json* list = document.list(key, max_surfaces, key);
  for (std::size_t i = 0; list && i < list->size() && document.problems().problems.size() < json::max_problems; ++i) {
    Fields f((*list)[i], document.path(key) + "/" + std::to_string(i), document.problems());
    if (!f.is_object()) continue;
    std::string name;
    f.require("name", "the name that shapes use to refer to it");
    f.text("name", name);
    Ptr surface = read(f);
    f.refuse_others();
    if (!out.emplace(name, std::move(surface)).second)
      f.report(ErrorCode::duplicate, f.path("name"), "Two entries have the name " + in_quotes(name) + ".", "Rename one of them.");
  }
}

std::string geometry_text(const Geometry& g) {
  std::string out = "    {\"name\": \"" + surface_name(g.hash) + "\"";
  if (g.convex) out += ", \"convex\": true";
  out += ",\n     \"vertices\": " + packed(g.vertices) + ",\n     \"triangles\": " + packed(g.triangles);
  if (g.prepared) {
    out += ",\n     \"prepared\": {\"of\": \"" + surface_name(g.hash) + "\"";
    if (const collision::Hull& hull = g.prepared->hull; !hull.vertices.empty()) {
      out += ", \"hull\": {";
      if (!(hull.vertices == g.vertices)) out += "\"vertices\": " + packed(hull.vertices) + ", ";
      out += "\"first_corner\": " + packed(hull.first_corner) + ", \"corners\": " + packed(hull.corners) + "}";
    }
    if (!g.prepared->spheres.empty()) out += ",\n      \"spheres\": " + packed(collision::write_bytes(g.prepared->spheres));
    out += "}";
  }
  return out + "}";
}

std::string field_text(const HeightField& h) {
  return "    {\"name\": \"" + surface_name(h.hash) + "\", \"columns\": " + std::to_string(h.columns) +
         ", \"rows\": " + std::to_string(h.rows) + ", \"half_x\": " + to_text(h.half_x) + ", \"half_y\": " + to_text(h.half_y) +
         ", \"base\": " + to_text(h.base) + ",\n     \"heights\": " + packed(h.heights) + "}";
}

template <class Ptr, class Text>
std::string table_text(const char* key, const std::map<std::uint64_t, Ptr>& table, const Text& text) {
  if (table.empty()) return {};
  std::string out;
  for (const auto& [hash, surface] : table) out += (out.empty() ? "\n" : ",\n") + text(*surface);
  return ",\n  \"" + std::string(key) + "\": [" + out + "\n  ]";
}

}  // namespace

SurfaceTables read_surfaces(Fields& document) {
  SurfaceTables out;
  read_table(document, "geometries", out.geometries, read_geometry);
  read_table(document, "height_fields", out.height_fields, read_height_field);
  return out;
}

std::string surface_name(std::uint64_t hash) {
  std::string out(16, '0');
  for (std::size_t i = 0; i < 16; ++i) out[i] = "0123456789abcdef"[(hash >> (60 - 4 * i)) & 15];
  return out;
}

std::string surfaces_text(const MechanismSpec& spec) {
  std::map<std::uint64_t, GeometryPtr> geometries;
  std::map<std::uint64_t, HeightFieldPtr> fields;
  for (const LinkSpec& link : spec.links)
    for (const Shape& s : link.shapes) {
      if (s.geometry) {
        GeometryPtr& kept = geometries[s.geometry->hash];
        if (!kept || (s.geometry->prepared && !kept->prepared)) kept = s.geometry;
      }
      if (s.field) fields[s.field->hash] = s.field;
    }
  return table_text("geometries", geometries, geometry_text) + table_text("height_fields", fields, field_text);
}

}  // namespace ugoki::formats
