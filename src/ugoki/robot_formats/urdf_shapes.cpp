#include "ugoki/robot_formats/urdf_shapes.h"

namespace ugoki::robot_formats {
namespace {

constexpr double smallest = 1e-9;  // m

/// The attribute, which must be there.
double size(XmlFields& xml, pugi::xml_node node, const char* name) {
  (void)xml.required_text(xml.attribute(node, name));
  return xml.number(xml.attribute(node, name), 0, not_negative);
}

std::optional<Shape> read_primitive(XmlFields& xml, pugi::xml_node node, pugi::xml_node primitive, const Pose& X_BS,
                                    const std::optional<SpinAxis>& spin) {
  const std::string_view kind = primitive.name();
  if (kind == "box") {
    (void)xml.required_text(xml.attribute(primitive, "size"));
    const Vec3 sides = xml.vec3(xml.attribute(primitive, "size"), {}, not_negative);
    if (sides.x >= smallest && sides.y >= smallest && sides.z >= smallest) return Shape::box(sides * 0.5, X_BS);
  } else {
    const double radius = size(xml, primitive, "radius");
    const double length = kind == "sphere" ? 0 : size(xml, primitive, "length");
    if (kind == "sphere" && radius >= smallest) return Shape::sphere(radius, X_BS);
    if (kind == "capsule" && radius >= smallest) {  // not in the specification, but in use: the length of its straight part
      const Vec3 half = X_BS.R.column(2) * (0.5 * length);
      return Shape::capsule(radius, X_BS.p - half, X_BS.p + half);
    }
    if (kind == "cylinder" && radius >= smallest && length >= smallest) {
      const FittedShape fitted = fit_cylinder(radius, length, X_BS, spin);
      if (std::string_view(node.name()) == "collision") xml.note(node, fitted.how);
      return fitted.shape;
    }
  }
  xml.note(node, "A shape without size is passed over.");
  return std::nullopt;
}

/// One `<collision>` or `<visual>`.
std::optional<Shape> read_shape(XmlFields& xml, pugi::xml_node node, const std::optional<SpinAxis>& spin, Meshes meshes, Assets& assets) {
  const Pose X_BS = urdf_origin(xml, node);
  for (const pugi::xml_node kind : node.child("geometry").children()) {
    const std::string_view name = kind.name();
    if (name == "box" || name == "sphere" || name == "cylinder" || name == "capsule") return read_primitive(xml, node, kind, X_BS, spin);
    if (name != "mesh") continue;
    const std::string uri = xml.required_text(xml.attribute(kind, "filename"));
    const Vec3 scale = xml.vec3(xml.attribute(kind, "scale"), {1, 1, 1}, {-1e6, 1e6});
    std::optional<Shape> shape = mesh_shape(xml, kind, uri, scale, std::string_view(node.name()) == "collision", meshes, assets);
    if (shape) shape->X_BS = X_BS * shape->X_BS;
    return shape;
  }
  xml.note(node, "A <" + std::string(node.name()) + "> without box, sphere, cylinder, capsule or mesh is passed over.");
  return std::nullopt;
}

}  // namespace

Pose urdf_origin(XmlFields& xml, pugi::xml_node node) {
  const pugi::xml_node origin = node.child("origin");
  Pose X;
  X.p = xml.vec3(xml.attribute(origin, "xyz"), {});
  const Vec3 rpy = xml.vec3(xml.attribute(origin, "rpy"), {}, {-1e6, 1e6});
  X.R = from_euler({rpy.z, rpy.y, rpy.x}, "ZYX");
  return X;
}

std::optional<Shape> mesh_shape(XmlFields& xml, pugi::xml_node mesh, const std::string& uri, const Vec3& scale, bool collides,
                                Meshes meshes, Assets& assets) {
  if (meshes == Meshes::none || uri.empty()) return std::nullopt;
  const Result<std::optional<Shape>>& found = assets.mesh_box(uri, scale);
  if (found && *found) {
    xml.note(mesh, collides ? "A mesh that collides is taken as the box around it." : "A mesh to be seen is shown as the box around it.");
    return *found;
  }
  const bool required = collides && meshes == Meshes::require;
  if (!found) {
    const std::string message = "a mesh cannot be used: " + found.error().problems.front().text();
    if (required)
      xml.problem(mesh, ErrorCode::structure, message, "");
    else
      xml.note(mesh, "A" + message.substr(1));
  } else if (required) {
    xml.problem(mesh, ErrorCode::io, "the mesh " + formats::in_quotes(uri) + " is not there.",
                "Put it where the file says, or read without meshes.");
  } else {
    xml.note(mesh,
             collides ? "Meshes that collide are not there; their links have no shape for them." : "Meshes to be seen are not there.");
  }
  return std::nullopt;
}

std::vector<Shape> read_urdf_shapes(XmlFields& xml, pugi::xml_node link, const std::optional<SpinAxis>& spin, Meshes meshes,
                                    Assets& assets) {
  std::vector<Shape> out;
  for (const pugi::xml_node node : link.children("collision"))
    if (const std::optional<Shape> shape = read_shape(xml, node, spin, meshes, assets)) out.push_back(*shape);
  if (link.child("collision")) return out;
  for (const pugi::xml_node node : link.children("visual")) {
    if (std::optional<Shape> shape = read_shape(xml, node, spin, meshes == Meshes::require ? Meshes::box : meshes, assets)) {
      shape->collides = false;
      out.push_back(*shape);
    }
  }
  return out;
}

}  // namespace ugoki::robot_formats
