#include "ugoki/robot_formats/urdf_shapes.h"

namespace ugoki::robot_formats {
namespace {

/// Reads the number [m] in a required attribute.
double size(XmlFields& xml, pugi::xml_node node, const char* name) {
  (void)xml.required_text(xml.attribute(node, name));
  return xml.number(xml.attribute(node, name), 0, not_negative);
}

std::optional<Shape> read_geometry(XmlFields& xml, pugi::xml_node node, const ShapeUse& use, const RobotOptions& options, Assets& assets) {
  const std::string_view kind = node.name();
  if (kind == "box") {
    (void)xml.required_text(xml.attribute(node, "size"));
    return primitive_shape(xml, Primitive::box, {.sides = xml.vec3(xml.attribute(node, "size"), {}, not_negative)}, use);
  }
  if (kind == "sphere") return primitive_shape(xml, Primitive::sphere, {.radius = size(xml, node, "radius")}, use);
  if (kind == "cylinder" || kind == "capsule")  // <capsule> is widely used, although URDF does not specify it
    return primitive_shape(xml, kind == "capsule" ? Primitive::capsule : Primitive::cylinder,
                           {.radius = size(xml, node, "radius"), .length = size(xml, node, "length")}, use);
  const std::string uri = xml.required_text(xml.attribute(node, "filename"));
  const Vec3 scale = xml.vec3(xml.attribute(node, "scale"), {1, 1, 1}, {-1e6, 1e6});
  return mesh_shape(xml, uri, scale, use, options, assets);
}

/// Reads the shape of one `<collision>` or `<visual>`. If it has no readable geometry, adds a note and returns std::nullopt.
std::optional<Shape> read_shape(XmlFields& xml, pugi::xml_node node, const RobotOptions& options, Assets& assets) {
  const ShapeUse use{node, std::string_view(node.name()) == "collision", urdf_origin(xml, node)};
  for (const pugi::xml_node geometry : node.child("geometry").children())
    for (const std::string_view known : {"box", "sphere", "cylinder", "capsule", "mesh"})
      if (known == geometry.name()) return read_geometry(xml, geometry, use, options, assets);
  xml.note(node, "A <" + std::string(node.name()) + "> without box, sphere, cylinder, capsule or mesh is left out.");
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

std::vector<Shape> read_urdf_shapes(XmlFields& xml, pugi::xml_node link, const RobotOptions& options, Assets& assets) {
  std::vector<Shape> out;
  for (const pugi::xml_node node : link.children("collision"))
    if (const std::optional<Shape> shape = read_shape(xml, node, options, assets)) out.push_back(*shape);
  if (link.child("collision")) return out;
  for (const pugi::xml_node node : link.children("visual")) {
    if (std::optional<Shape> shape = read_shape(xml, node, options, assets)) {
      shape->collides = false;
      out.push_back(*shape);
    }
  }
  return out;
}

}  // namespace ugoki::robot_formats
