#include "ugoki/content/prop.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <utility>
#include <vector>

#include "ugoki/base/number.h"
#include "ugoki/content/prop_json.h"
#include "ugoki/mechanism/geometry.h"

namespace ugoki::content {
namespace {

constexpr std::array<std::pair<PropShape, std::string_view>, 6> names = {{{PropShape::box, "box"},
                                                                          {PropShape::ramp, "ramp"},
                                                                          {PropShape::stairs, "stairs"},
                                                                          {PropShape::cylinder, "cylinder"},
                                                                          {PropShape::sphere, "sphere"},
                                                                          {PropShape::bar, "bar"}}};
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
  }
  return out;
}

}  // namespace

std::string_view name_of(PropShape shape) { return names[static_cast<std::size_t>(shape)].second; }

void read_prop(Fields& f, Prop& out) {
  std::string shape(name_of(out.shape));
  f.text("shape", shape);
  bool known = false;
  for (const auto& [value, name] : names)
    if (name == shape) out.shape = value, known = true;
  if (!known)
    f.report(ErrorCode::unknown, f.path("shape"), "There is no prop '" + shape + "'.",
             "Use \"box\", \"ramp\", \"stairs\", \"cylinder\", \"sphere\" or \"bar\".");
  f.vec3("size", out.size);
  f.integer("steps", out.steps);
  f.vec3("tilt", out.tilt);
  f.number("mass", out.mass);
  f.number("friction", out.friction);
  f.number("restitution", out.restitution);
}

Json to_json(const Prop& p) {
  Json json = {{"shape", name_of(p.shape)}, {"size", to_json(p.size)}};
  if (p.shape == PropShape::stairs) json["steps"] = p.steps;
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
  }
  range("steps", p.steps, 1, Prop::max_steps, "");
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

MechanismPtr make_prop(const Prop& p) {
  LinkSpec link;
  link.name = "body";
  link.shapes = shapes_of(p);
  const Mat3 R = rotation_about({1, 0, 0}, p.tilt.x * (pi / 180)) * rotation_about({0, 1, 0}, p.tilt.y * (pi / 180)) *
                 rotation_about({0, 0, 1}, p.tilt.z * (pi / 180));
  double volumes = 0;
  for (Shape& shape : link.shapes) {
    shape.X_BS = Pose{R, {}} * shape.X_BS;
    shape.friction = p.friction;
    shape.restitution = p.restitution;
    volumes += volume(shape);
  }
  if (p.mass > 0) {
    link.joint.type = JointType::floating;
    for (const Shape& shape : link.shapes) link.inertia = link.inertia + solid_inertia(shape, p.mass / volumes);
  }
  MechanismSpec spec;
  spec.name = std::string(name_of(p.shape));
  spec.links.push_back(std::move(link));
  return Mechanism::make(std::move(spec)).value();
}

}  // namespace ugoki::content
