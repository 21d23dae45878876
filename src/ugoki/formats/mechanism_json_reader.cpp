#include <array>
#include <cmath>

#include "ugoki/formats/mechanism_json.h"
#include "ugoki/formats/mechanism_json_geometry.h"
#include "ugoki/formats/text.h"
#include "ugoki/json/fields.h"

namespace ugoki::formats {
namespace {

using json::Fields;
using json::Json;

constexpr std::size_t most_entries = 1'000'000;

void read_vector(Fields& f, std::string_view key, Vec3& value) {
  double x[3];
  if (f.numbers(key, x)) value = {x[0], x[1], x[2]};
}
void read_symmetric(Fields& f, std::string_view key, Sym3& value) {
  double x[6];
  if (f.numbers(key, x)) value = {x[0], x[1], x[2], x[3], x[4], x[5]};
}

/// Calls read(fields) with the object in `key`, if there is one.
template <class Read>
void read_object(Fields& parent, std::string_view key, Read read) {
  const Json* object = parent.find(key);
  if (!object) return;
  Fields f(*object, parent.path(key), parent.problems());
  if (!f.is_object()) return;
  read(f);
  f.refuse_others();
}

/// Calls read(fields, i) with every object of the list in `key`, if there is one.
template <class Read>
void read_list(Fields& parent, std::string_view key, std::size_t most, Read read) {
  const Json* list = parent.list(key, most, key);
  for (std::size_t i = 0; list && i < list->size() && parent.problems().problems.size() < json::most_problems; ++i) {
    Fields f((*list)[i], parent.path(key) + "/" + std::to_string(i), parent.problems());
    if (!f.is_object()) continue;
    read(f, i);
    f.refuse_others();
  }
}

/// "position": 3 numbers; "rotation": three rows, or a quaternion w x y z (made unit).
void read_pose(Fields& f, Pose& X) {
  read_vector(f, "position", X.p);
  const Json* r = f.find("rotation");
  if (!r) return;
  const std::string place = f.path("rotation");
  if (r->is_array() && r->size() == 4) {
    double q[4];
    if (!f.numbers(*r, place, q)) return;
    const double n = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    if (!(n > 1e-6 && n < 1e6))
      f.report(ErrorCode::range, place, "The quaternion has no usable length.", "Write a unit quaternion w x y z.");
    else
      X.R = to_matrix(normalized(Quat{q[0], q[1], q[2], q[3]}));
    return;
  }
  if (!r->is_array() || r->size() != 3) {
    f.report(ErrorCode::syntax, place, "A rotation is three rows of three numbers, or a quaternion of four.",
             "Write [w, x, y, z] or three rows.");
    return;
  }
  std::array<double, 9> m{};
  for (std::size_t i = 0; i < 3; ++i)
    if (!f.numbers((*r)[i], place + "/" + std::to_string(i), std::span(m).subspan(3 * i, 3))) return;
  X.R = {m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8]};
}

void read_freedom(Fields& f, Freedom& out) {
  f.number("lower", out.lower);
  f.number("upper", out.upper);
  f.number("damping", out.damping);
  f.number("stiffness", out.stiffness);
  f.number("rest", out.rest);
  f.number("armature", out.armature);
  f.number("friction", out.friction);
  f.number("effort", out.effort);
}

/// The word in "type" as one of an enumeration. @param known what else may stand there, a sentence
template <class Type, class Named>
void read_type(Fields& f, Type& value, Named named, std::string_view what, std::string_view known) {
  std::string word;
  f.text("type", word);
  if (const auto type = named(word))
    value = *type;
  else
    f.report(ErrorCode::unknown, f.path("type"), "There is no " + std::string(what) + " type " + in_quotes(word) + ".",
             "Types are " + std::string(known) + ".");
}

void read_joint(Fields& f, Joint& out) {
  read_type(f, out.type, joint_type_named, "joint",
            "fixed, revolute, prismatic, helical, cylindrical, planar, universal, spherical and floating");
  read_pose(f, out.X_PJ);
  read_vector(f, "axis", out.axis);
  read_vector(f, "axis2", out.axis2);
  f.number("pitch", out.pitch);
  read_list(f, "freedoms", static_cast<std::size_t>(out.nv()), [&](Fields& g, std::size_t i) { read_freedom(g, out.freedoms[i]); });
}

void read_inertia(Fields& f, Inertia& out) {
  f.number("mass", out.mass);
  Vec3 centre;
  Sym3 about_centre;
  read_vector(f, "centre", centre);
  read_symmetric(f, "about_centre", about_centre);
  read_vector(f, "first_moment", out.h);
  read_symmetric(f, "about_origin", out.I);
  const bool by_centre = f.has("centre") || f.has("about_centre"), about_origin = f.has("first_moment") || f.has("about_origin");
  if (by_centre && about_origin)
    f.report(ErrorCode::conflict, f.path(), "The inertia is given in two ways.",
             "Give centre and about_centre, or first_moment and about_origin.");
  else if (!about_origin)
    out = Inertia::from_centre(out.mass, centre, about_centre);
}

std::optional<ShapeType> shape_type_named(std::string_view word) {
  for (const ShapeType type : {ShapeType::sphere, ShapeType::capsule, ShapeType::box, ShapeType::cylinder, ShapeType::ellipsoid,
                               ShapeType::mesh, ShapeType::height_field})
    if (word == name_of(type)) return type;
  return std::nullopt;
}

/// The entry of the table that the field `key` names; null, with a problem, where there is none.
template <class Ptr>
Ptr read_surface(Fields& f, std::string_view key, const char* table_name, const std::map<std::string, Ptr, std::less<>>& table) {
  if (!f.has(key)) return nullptr;
  std::string name;
  f.text(key, name);
  if (const auto it = table.find(name); it != table.end()) return it->second;
  f.report(ErrorCode::unknown, f.path(key), "Nothing in \"" + std::string(table_name) + "\" has the name " + in_quotes(name) + ".",
           "Add it there, or correct the name.");
  return nullptr;
}

void read_shape(Fields& f, const SurfaceTables& surfaces, Shape& out) {
  read_type(f, out.type, shape_type_named, "shape", "sphere, capsule, box, cylinder, ellipsoid, mesh and height_field");
  f.number("radius", out.radius);
  f.number("half_length", out.half_length);
  read_vector(f, "half_extents", out.half_extents);
  out.geometry = read_surface(f, "geometry", "geometries", surfaces.geometries);
  out.field = read_surface(f, "height_field", "height_fields", surfaces.height_fields);
  read_pose(f, out.X_BS);
  f.number("friction", out.friction);
  f.number("restitution", out.restitution);
  f.boolean("collides", out.collides);
  f.boolean("visible", out.visible);
}

void read_link(Fields& f, const SurfaceTables& surfaces, LinkSpec& out) {
  f.text("name", out.name);
  f.text("label", out.label);
  f.text("parent", out.parent);
  read_object(f, "joint", [&](Fields& g) { read_joint(g, out.joint); });
  read_object(f, "inertia", [&](Fields& g) { read_inertia(g, out.inertia); });
  read_list(f, "shapes", most_entries, [&](Fields& g, std::size_t) { read_shape(g, surfaces, out.shapes.emplace_back()); });
  read_object(f, "virtual", [&](Fields& g) {
    g.text("real", out.real);
    read_pose(g, out.X_RV);
  });
}

void read_loop_end(Fields& f, std::string& link, Pose& X, int& freedom) {
  f.text("link", link);
  read_pose(f, X);
  double number = 0;
  f.number("freedom", number);
  if (number >= 0 && number <= 5 && number == std::floor(number))
    freedom = static_cast<int>(number);
  else
    f.report(ErrorCode::range, f.path("freedom"), "A freedom is counted from 0 to 5.", "Give the place of the freedom in its joint.");
}

void read_loop(Fields& f, LoopSpec& out) {
  f.text("name", out.name);
  read_type(f, out.type, loop_type_named, "loop", "weld, ball, revolute, prismatic, cylindrical, planar, universal, distance and gear");
  read_object(f, "a", [&](Fields& g) { read_loop_end(g, out.link_a, out.X_AJ, out.freedom_a); });
  read_object(f, "b", [&](Fields& g) { read_loop_end(g, out.link_b, out.X_BJ, out.freedom_b); });
  read_vector(f, "axis", out.axis);
  read_vector(f, "axis2", out.axis2);
  f.number("length", out.length);
  (void)f.numbers("polynomial", out.polynomial);
  f.boolean("closed", out.closed);
}

MechanismSpec read_document(Fields& f) {
  MechanismSpec spec;
  std::string format;
  double version = 0;
  f.text("format", format);
  if (format != "ugoki-mechanism")
    f.report(ErrorCode::syntax, f.path("format"), "This is not a mechanism of Ugoki.", "A mechanism has \"format\": \"ugoki-mechanism\".");
  f.number("version", version);
  if (version != 1)
    f.report(ErrorCode::unsupported, f.path("version"), "This version of the format is not known.", "Use version 1, or a newer Ugoki.");
  f.text("name", spec.name);
  f.require("links", "\"links\": [ ... ]");
  const SurfaceTables surfaces = read_surfaces(f);
  read_list(f, "links", most_entries, [&](Fields& g, std::size_t) { read_link(g, surfaces, spec.links.emplace_back()); });
  read_list(f, "loops", most_entries, [&](Fields& g, std::size_t) { read_loop(g, spec.loops.emplace_back()); });
  f.refuse_others();
  return spec;
}

}  // namespace

Result<MechanismPtr> read_mechanism(std::string_view text, std::string_view file_name) {
  const Result<Json> document = json::parse_json(text, file_name, text.size());
  if (!document) return fail(document.error());
  Error problems;
  Fields fields(*document, std::string(file_name) + ":", problems);
  MechanismSpec spec;
  if (fields.is_object()) spec = read_document(fields);
  if (!problems.empty()) return fail(std::move(problems));
  auto mechanism = Mechanism::make(std::move(spec));
  if (!mechanism)
    for (Problem& p : mechanism.error().problems) p.place = std::string(file_name) + ": " + p.place;
  return mechanism;
}

}  // namespace ugoki::formats
