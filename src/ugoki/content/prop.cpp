#include "ugoki/content/prop.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <utility>
#include <vector>

#include "ugoki/base/check.h"
#include "ugoki/base/number.h"
#include "ugoki/collision/prepared_geometry.h"
#include "ugoki/content/prop_json.h"
#include "ugoki/content/scenario.h"
#include "ugoki/content/terrain.h"
#include "ugoki/mechanism/geometry.h"

namespace ugoki::content {
namespace {

constexpr std::array<std::pair<PropShape, std::string_view>, 8> names = {{{PropShape::box, "box"},
                                                                          {PropShape::ramp, "ramp"},
                                                                          {PropShape::stairs, "stairs"},
                                                                          {PropShape::cylinder, "cylinder"},
                                                                          {PropShape::sphere, "sphere"},
                                                                          {PropShape::bar, "bar"},
                                                                          {PropShape::mesh, "mesh"},
                                                                          {PropShape::terrain, "terrain"}}};
constexpr std::array<std::pair<MeshCollision, std::string_view>, 3> collisions = {
    {{MeshCollision::hull, "hull"}, {MeshCollision::parts, "parts"}, {MeshCollision::surface, "surface"}}};
constexpr double post = 0.03;  // m, radius of the posts of a bar, but at most a fifth of its width

/// Box with its bottom at z = 0, from x0 to x1.
Shape standing_box(double x0, double x1, double width, double height) {
  return Shape::box({0.5 * (x1 - x0), 0.5 * width, 0.5 * height}, {Mat3::identity(), {0.5 * (x0 + x1), 0, 0.5 * height}});
}

/// Wedge with a rectangular bottom, a slope that rises along x, and a vertical back.
Shape wedge(const Vec3& size) {
  const double a = 0.5 * size.x, b = 0.5 * size.y, h = size.z;
  const std::array<Vec3, 6> corners = {{{-a, -b, 0}, {a, -b, 0}, {a, b, 0}, {-a, b, 0}, {a, -b, h}, {a, b, h}}};
  constexpr std::array<Triangle, 8> sides = {{{0, 2, 1}, {0, 3, 2}, {0, 4, 5}, {0, 5, 3}, {1, 2, 5}, {1, 5, 4}, {0, 1, 4}, {3, 5, 2}}};
  return Shape::mesh(make_geometry(corners, sides, true, "ramp").value());
}

std::vector<Shape> shapes_of(const Prop& p) {
  const Vec3& s = p.size;
  std::vector<Shape> out;
  switch (p.shape) {
    case PropShape::box: return {standing_box(-0.5 * s.x, 0.5 * s.x, s.y, s.z)};
    case PropShape::ramp: return {wedge(s)};
    case PropShape::stairs:
      for (int i = 0; i < p.steps; ++i) {
        const double tread = s.x / p.steps;
        out.push_back(standing_box(i * tread - 0.5 * s.x, (i + 1) * tread - 0.5 * s.x, s.y, s.z * (i + 1) / p.steps));
      }
      return out;
    case PropShape::cylinder: return {Shape::cylinder(0.5 * s.x, 0.5 * s.z, {Mat3::identity(), {0, 0, 0.5 * s.z}})};
    case PropShape::sphere: return {Shape::sphere(0.5 * s.x, {Mat3::identity(), {0, 0, 0.5 * s.x}})};
    case PropShape::bar: {
      const double radius = std::min(post, 0.2 * s.y), y = 0.5 * s.y + radius, height = s.z + 0.5 * s.x;
      out.push_back(Shape::capsule(0.5 * s.x, {0, -0.5 * s.y, s.z}, {0, 0.5 * s.y, s.z}));
      for (const double side : {-y, y}) out.push_back(Shape::cylinder(radius, 0.5 * height, {Mat3::identity(), {0, side, 0.5 * height}}));
      return out;
    }
    case PropShape::mesh: return out;  // made from its mesh body
    case PropShape::terrain: return {Shape::height_field(make_terrain(s, p.grain, p.seed))};
  }
  return out;
}

Vec3 stretched(const Vec3& p, const Vec3& scale) { return {p.x * scale.x, p.y * scale.y, p.z * scale.z}; }

/// diag(scale) A.
Mat3 scaled_rows(const Mat3& A, const Vec3& scale) {
  return Mat3::columns(stretched(A.column(0), scale), stretched(A.column(1), scale), stretched(A.column(2), scale));
}

/// The geometry with its lengths multiplied by `scale`, with its hull. Its sphere tree is made again when it is needed.
GeometryPtr stretched(const GeometryPtr& geometry, const Vec3& scale) {
  if (scale == Vec3{1, 1, 1}) return geometry;
  std::vector<Vec3> points = geometry->vertices;
  for (Vec3& p : points) p = stretched(p, scale);
  Result<GeometryPtr> made = make_geometry(points, geometry->triangles, geometry->convex, "mesh");
  if (!made) return geometry;  // a triangle became too small; cannot happen within the limits of sizes
  if (!geometry->prepared || geometry->prepared->hull.vertices.empty()) return *made;
  collision::Hull hull = geometry->prepared->hull;
  for (Vec3& p : hull.vertices) p = stretched(p, scale);
  Result<collision::Hull> assembled =
      collision::assemble_hull(std::move(hull.vertices), std::move(hull.first_corner), std::move(hull.corners));
  if (!assembled) return *made;
  const Result<collision::PreparedPtr> prepared = collision::make_prepared(**made, std::move(*assembled), {}, "mesh");
  return prepared ? collision::with_prepared(**made, *prepared) : *made;
}

/// Inertia of a body of the same mass whose lengths are multiplied by `scale`: the second moments int x_i x_j dm grow with
/// scale_i scale_j, and I = tr(S) 1 - S.
Inertia stretched(const Inertia& body, const Vec3& s) {
  const Sym3& I = body.I;
  const double half = 0.5 * (I.xx + I.yy + I.zz);
  const double xx = (half - I.xx) * s.x * s.x, yy = (half - I.yy) * s.y * s.y, zz = (half - I.zz) * s.z * s.z;
  return {body.mass, stretched(body.h, s), {yy + zz, zz + xx, xx + yy, I.xy * s.x * s.y, I.xz * s.x * s.z, I.yz * s.y * s.z}};
}

/// Shapes of a mesh prop, in the frame of its mesh. With `surface`, the mesh itself collides; otherwise its hull, or the hulls of its
/// parts.
std::vector<Shape> mesh_shapes(const Prop& p, const Link& body) {
  const auto is_part = [](const Shape& s) { return !s.visible && !s.collides; };
  const bool by_parts = p.collision == MeshCollision::parts && std::any_of(body.shapes.begin(), body.shapes.end(), is_part);
  std::vector<Shape> out;
  for (Shape s : body.shapes) {
    if (!s.visible && (p.collision == MeshCollision::surface || is_part(s) != by_parts)) continue;
    s.collides = s.visible ? p.collision == MeshCollision::surface : true;
    s.geometry = stretched(s.geometry, p.scale);
    out.push_back(std::move(s));
  }
  return out;
}

/// Reads the name of a value of an enumeration. @param what begins the message  @param choices the names, for the remedy
template <class Value, std::size_t n>
void read_name(Fields& f, const char* field, const std::array<std::pair<Value, std::string_view>, n>& list, const char* what,
               const char* choices, Value& out) {
  std::string text;
  for (const auto& [value, name] : list)
    if (value == out) text = name;
  f.text(field, text);
  for (const auto& [value, name] : list)
    if (name == text) {
      out = value;
      return;
    }
  f.report(ErrorCode::unknown, f.path(field), "There is no " + std::string(what) + " '" + text + "'.", choices);
}

}  // namespace

std::string_view name_of(PropShape shape) { return names[static_cast<std::size_t>(shape)].second; }
std::string_view name_of(MeshCollision collision) { return collisions[static_cast<std::size_t>(collision)].second; }

void read_prop(Fields& f, Prop& out) {
  read_name(f, "shape", names, "prop", "Use \"box\", \"ramp\", \"stairs\", \"cylinder\", \"sphere\", \"bar\", \"mesh\" or \"terrain\".",
            out.shape);
  f.vec3("size", out.size);
  f.integer("steps", out.steps);
  f.number("grain", out.grain);
  f.integer("seed", out.seed);
  f.text("mesh", out.mesh);
  f.vec3("scale", out.scale);
  read_name(f, "collision", collisions, "kind of collision", "Use \"hull\", \"parts\" or \"surface\".", out.collision);
  f.vec3("tilt", out.tilt);
  f.number("mass", out.mass);
  f.number("friction", out.friction);
  f.number("restitution", out.restitution);
}

Json to_json(const Prop& p) {
  Json json = {{"shape", name_of(p.shape)}};
  if (p.shape == PropShape::mesh) {
    json["mesh"] = p.mesh;
    json["scale"] = to_json(p.scale);
    json["collision"] = name_of(p.collision);
  } else {
    json["size"] = to_json(p.size);
  }
  if (p.shape == PropShape::stairs) json["steps"] = p.steps;
  if (p.shape == PropShape::terrain) {
    json["grain"] = p.grain;
    json["seed"] = p.seed;
  }
  if (p.tilt != Vec3{}) json["tilt"] = to_json(p.tilt);
  json["mass"] = p.mass;
  json["friction"] = p.friction;
  json["restitution"] = p.restitution;
  return json;
}

void check_prop(const Prop& p, const std::string& location, Error& problems) {
  const auto range = [&](const std::string& field, double x, double low, double high, const char* unit) {
    if (x >= low && x <= high) return;
    problems.add(ErrorCode::range, location + "/" + field, "The value " + ugoki::to_text(x) + " is out of range.",
                 "Give a value from " + ugoki::to_text(low) + " to " + ugoki::to_text(high) + unit + ".");
  };
  for (int i = 0; i < 3; ++i) {
    range("size", p.size[i], Prop::min_size, Prop::max_size, " m");
    range("tilt", p.tilt[i], -180, 180, " degrees");
    range("scale", p.scale[i], Prop::min_scale, Prop::max_scale, "");
  }
  if (p.shape == PropShape::mesh && !is_id(p.mesh, max_resource_id))
    problems.add(ErrorCode::syntax, location + "/mesh", "'" + p.mesh + "' cannot be the id of a mesh.",
                 "Import a mesh file, and choose it.");
  range("steps", p.steps, 1, Prop::max_steps, "");
  range("grain", p.grain, Prop::min_grain, Prop::max_grain, " m");
  range("seed", p.seed, 0, Prop::max_seed, "");
  if (p.shape == PropShape::terrain && p.mass > 0)
    problems.add(ErrorCode::unsupported, location + "/mass", "A terrain cannot move.", "Give it the mass 0.");
  range("mass", p.mass, 0, Prop::max_mass, " kg");
  range("friction", p.friction, 0, 10, "");
  range("restitution", p.restitution, 0, 1, "");
}

std::string prop_mechanism_id(const Prop& prop) {
  std::uint64_t hash = 0xcbf29ce484222325;  // FNV-1a
  for (const char c : to_json(prop).dump()) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3;
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash));
  return "prop." + std::string(text);
}

bool is_prop_mechanism(std::string_view id) { return id.starts_with("prop."); }

bool is_mesh_body(const Mechanism& m) {
  if (m.link_count() != 1 || m.link(0).name != "body" || m.nq() != 0 || !(m.link(0).inertia.mass > 0)) return false;
  const std::vector<Shape>& shapes = m.link(0).shapes;
  return std::any_of(shapes.begin(), shapes.end(), [](const Shape& s) { return s.visible; }) &&
         std::all_of(shapes.begin(), shapes.end(), [](const Shape& s) {
           return s.geometry != nullptr && norm(s.X_BS.p) == 0 && s.X_BS.R.column(0).x == 1 && s.X_BS.R.column(1).y == 1;
         });
}

MechanismPtr make_prop(const Prop& p, const MechanismPtr& mesh) {
  UGOKI_CHECK((p.shape == PropShape::mesh) == (mesh != nullptr));
  LinkSpec link;
  link.name = "body";
  link.shapes = mesh ? mesh_shapes(p, mesh->link(0)) : shapes_of(p);
  const Mat3 R = rotation_about({1, 0, 0}, p.tilt.x * (pi / 180)) * rotation_about({0, 1, 0}, p.tilt.y * (pi / 180)) *
                 rotation_about({0, 0, 1}, p.tilt.z * (pi / 180));
  double volumes = 0;
  for (Shape& shape : link.shapes) {
    shape.X_BS = Pose{R, {}} * shape.X_BS;
    shape.friction = p.friction;
    shape.restitution = p.restitution;
    volumes += volume(shape);
  }
  if (p.mass > 0) link.joint.type = JointType::floating;
  if (p.mass > 0 && mesh) {
    const Inertia body = stretched(mesh->link(0).inertia, p.scale);
    const double factor = p.mass / body.mass;
    link.inertia = Inertia{p.mass, body.h * factor, body.I * factor}.in_parent(Pose{R, {}});
  } else if (p.mass > 0) {
    for (const Shape& shape : link.shapes) link.inertia = link.inertia + solid_inertia(shape, p.mass / volumes);
  }
  MechanismSpec spec;
  spec.name = mesh ? mesh->name() : std::string(name_of(p.shape));
  spec.links.push_back(std::move(link));
  if (mesh && mesh->skin()) {
    spec.skin = mesh->skin();
    for (const SkinBone& bone : mesh->skin_bones())
      spec.skin_bones.push_back({"body", R * scaled_rows(bone.A, p.scale), R * stretched(bone.p, p.scale)});
  }
  return Mechanism::make(std::move(spec)).value();
}

}  // namespace ugoki::content
