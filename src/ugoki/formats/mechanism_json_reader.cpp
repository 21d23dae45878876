#include <array>
#include <cmath>

#include "ugoki/formats/mechanism_json.h"
#include "ugoki/formats/mechanism_json_geometry.h"
#include "ugoki/formats/mechanism_json_skin.h"
#include "ugoki/formats/text.h"
#include "ugoki/json/fields.h"

namespace ugoki::formats {
namespace {

using json::Fields;
using json::Json;

constexpr std::size_t max_entries = 1'000'000;  // maximum length of a list

void read_vector(Fields& f, std::string_view key, Vec3& value) {
  double x[3];
  if (f.numbers(key, x)) value = {x[0], x[1], x[2]};
}
/// Reads a symmetric matrix, given as [xx, yy, zz, xy, xz, yz].
void read_symmetric(Fields& f, std::string_view key, Sym3& value) {
  double x[6];
  if (f.numbers(key, x)) value = {x[0], x[1], x[2], x[3], x[4], x[5]};
}

/// Calls read(fields) with the fields of the object `key`, if it exists.
template <class Read>
void read_object(Fields& parent, std::string_view key, Read read) {
  const Json* object = parent.find(key);
  if (!object) return;
  Fields f(*object, parent.path(key), parent.problems());
  if (!f.is_object()) return;
  read(f);
  f.refuse_others();
}

/// Calls read(fields, i) with the fields of every object i in the list `key`, if it exists.
template <class Read>
void read_list(Fields& parent, std::string_view key, std::size_t maximum, Read read) {
  const Json* list = parent.list(key, maximum, key);
  for (std::size_t i = 0; list && i < list->size() && parent.problems().problems.size() < json::max_problems; ++i) {
    Fields f((*list)[i], parent.path(key) + "/" + std::to_string(i), parent.problems());
    if (!f.is_object()) continue;
    read(f, i);
    f.refuse_others();
  }
}

/// Reads "position" (three numbers, m) and "rotation" (three rows of a matrix, or a quaternion w x y z, which is normalised).
void read_pose(Fields& f, Pose& X) {
  read_vector(f, "position", X.p);
  const Json* r = f.find("rotation");
  if (!r) return;
  const std::string location = f.path("rotation");
  if (r->is_array() && r->size() == 4) {
    double q[4];
    if (!f.numbers(*r, location, q)) return;
    const double n = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    if (!(n > 1e-6 && n < 1e6))
      f.report(ErrorCode::range, location, "The norm of the quaternion is not between 0.001 and 1000.",
               "Write a unit quaternion [w, x, y, z].");
    else
      X.R = to_matrix(normalized(Quat{q[0], q[1], q[2], q[3]}));
    return;
  }
  if (!r->is_array() || r->size() != 3) {
    f.report(ErrorCode::syntax, location, "The rotation is neither three rows nor a quaternion.",
             "Write three rows of three numbers, or [w, x, y, z].");
    return;
  }
  std::array<double, 9> m{};
  for (std::size_t i = 0; i < 3; ++i)
    if (!f.numbers((*r)[i], location + "/" + std::to_string(i), std::span(m).subspan(3 * i, 3))) return;
  X.R = {m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8]};
}

void read_dof(Fields& f, Dof& out) {
  f.number("lower", out.lower);
  f.number("upper", out.upper);
  f.number("damping", out.damping);
  f.number("stiffness", out.stiffness);
  f.number("rest", out.rest);
  f.number("armature", out.armature);
  f.number("friction", out.friction);
  f.number("effort", out.effort);
}

/// Reads the field "type" as an enumerator.
/// @param named function that returns the enumerator with a given name, or std::nullopt
/// @param kind  word for the message, for example "joint"
/// @param known list of the allowed names, for the message
template <class Type, class Named>
void read_type(Fields& f, Type& value, Named named, std::string_view kind, std::string_view known) {
  std::string word;
  f.text("type", word);
  if (const auto type = named(word))
    value = *type;
  else
    f.report(ErrorCode::unknown, f.path("type"), "There is no " + std::string(kind) + " type " + in_quotes(word) + ".",
             "Use one of: " + std::string(known) + ".");
}

void read_joint(Fields& f, Joint& out) {
  read_type(f, out.type, joint_type_named, "joint",
            "fixed, revolute, prismatic, helical, cylindrical, planar, universal, spherical, floating");
  read_pose(f, out.X_PJ);
  read_vector(f, "axis", out.axis);
  read_vector(f, "axis2", out.axis2);
  f.number("pitch", out.pitch);
  read_list(f, f.renamed("dofs", "freedoms"), static_cast<std::size_t>(out.nv()),
            [&](Fields& g, std::size_t i) { read_dof(g, out.dofs[i]); });
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
    f.report(ErrorCode::conflict, f.path(), "The inertia is given both about the centre of mass and about the origin.",
             "Use either centre and about_centre, or first_moment and about_origin.");
  else if (!about_origin)
    out = Inertia::from_centre(out.mass, centre, about_centre);
}

std::optional<ShapeType> shape_type_named(std::string_view word) {
  for (const ShapeType type : {ShapeType::sphere, ShapeType::capsule, ShapeType::box, ShapeType::cylinder, ShapeType::ellipsoid,
                               ShapeType::mesh, ShapeType::height_field})
    if (word == name_of(type)) return type;
  return std::nullopt;
}

/// Returns the entry of `table` named by the field `key`. Null if the field is missing, or if there is no such entry (adds a problem).
template <class Ptr>
Ptr read_surface(Fields& f, std::string_view key, const char* table_name, const std::map<std::string, Ptr, std::less<>>& table) {
  if (!f.has(key)) return nullptr;
  std::string name;
  f.text(key, name);
  if (const auto it = table.find(name); it != table.end()) return it->second;
  f.report(ErrorCode::unknown, f.path(key), "No entry of \"" + std::string(table_name) + "\" has the name " + in_quotes(name) + ".",
           "Add it there, or correct the name.");
  return nullptr;
}

/// Reads 32 bits, written as an integer.
void read_bits(Fields& f, const char* name, std::uint32_t& out) {
  double value = out;
  f.number(name, value);
  if (value >= 0 && value <= 4294967295.0 && value == std::floor(value))
    out = static_cast<std::uint32_t>(value);
  else
    f.report(ErrorCode::range, f.path(name), "The value is not an integer from 0 to 4294967295.", "Write the sum of the groups' bits.");
}

void read_shape(Fields& f, const SurfaceTables& surfaces, Shape& out) {
  read_type(f, out.type, shape_type_named, "shape", "sphere, capsule, box, cylinder, ellipsoid, mesh, height_field");
  f.number("radius", out.radius);
  f.number("half_length", out.half_length);
  read_vector(f, "half_extents", out.half_extents);
  out.geometry = read_surface(f, "geometry", "geometries", surfaces.geometries);
  out.field = read_surface(f, "height_field", "height_fields", surfaces.height_fields);
  read_pose(f, out.X_BS);
  f.number("friction", out.friction);
  f.number("restitution", out.restitution);
  f.boolean("collides", out.collides);
  read_bits(f, "groups", out.groups);
  read_bits(f, "partners", out.partners);
  f.boolean("smooth", out.smooth);
  f.boolean("visible", out.visible);
}

void read_link(Fields& f, const SurfaceTables& surfaces, LinkSpec& out) {
  f.text("name", out.name);
  f.text("label", out.label);
  f.text("parent", out.parent);
  read_object(f, "joint", [&](Fields& g) { read_joint(g, out.joint); });
  read_object(f, "inertia", [&](Fields& g) { read_inertia(g, out.inertia); });
  read_list(f, "shapes", max_entries, [&](Fields& g, std::size_t) { read_shape(g, surfaces, out.shapes.emplace_back()); });
  read_object(f, "virtual", [&](Fields& g) {
    g.text("real", out.real);
    read_pose(g, out.X_RV);
  });
}

void read_loop_end(Fields& f, std::string& link, Pose& X, int& dof) {
  f.text("link", link);
  read_pose(f, X);
  double index = 0;
  f.number(f.renamed("dof", "freedom"), index);
  if (index >= 0 && index <= 5 && index == std::floor(index))
    dof = static_cast<int>(index);
  else
    f.report(ErrorCode::range, f.path("dof"), "The index of the degree of freedom is not an integer from 0 to 5.",
             "Write the index of the degree of freedom within its joint, beginning with 0.");
}

void read_loop(Fields& f, LoopSpec& out) {
  f.text("name", out.name);
  read_type(f, out.type, loop_type_named, "loop", "weld, ball, revolute, prismatic, cylindrical, planar, universal, distance, gear");
  read_object(f, "a", [&](Fields& g) { read_loop_end(g, out.link_a, out.X_AJ, out.dof_a); });
  read_object(f, "b", [&](Fields& g) { read_loop_end(g, out.link_b, out.X_BJ, out.dof_b); });
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
    f.report(ErrorCode::syntax, f.path("format"), "The format is not \"ugoki-mechanism\".", "Check that the file is a mechanism of Ugoki.");
  f.number("version", version);
  if (version != 1)
    f.report(ErrorCode::unsupported, f.path("version"), "This version of the format is not supported.",
             "Use version 1, or a newer version of Ugoki.");
  f.text("name", spec.name);
  f.require("links", "\"links\": [ ... ]");
  const SurfaceTables surfaces = read_surfaces(f);
  read_list(f, "links", max_entries, [&](Fields& g, std::size_t) { read_link(g, surfaces, spec.links.emplace_back()); });
  read_list(f, "loops", max_entries, [&](Fields& g, std::size_t) { read_loop(g, spec.loops.emplace_back()); });
  read_list(f, "exclusions", max_entries, [&](Fields& g, std::size_t) {
    auto& [a, b] = spec.exclusions.emplace_back();
    g.text("a", a);
    g.text("b", b);
  });
  read_skin(f, spec);
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
    for (Problem& p : mechanism.error().problems) p.location = std::string(file_name) + ": " + p.location;
  return mechanism;
}

}  // namespace ugoki::formats
