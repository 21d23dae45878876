#include "ugoki/robot_formats/sdf_links.h"

namespace ugoki::robot_formats {
namespace {

/// Reads the number [m] in a required child element.
double size(XmlFields& xml, pugi::xml_node node, const char* name) {
  (void)xml.required_text(xml.element(node, name));
  return xml.number(xml.element(node, name), 0, not_negative);
}

/// Reads the three numbers [m] in a required child element.
Vec3 sizes(XmlFields& xml, pugi::xml_node node, const char* name) {
  (void)xml.required_text(xml.element(node, name));
  return xml.vec3(xml.element(node, name), {}, not_negative);
}

std::optional<Shape> read_geometry(XmlFields& xml, pugi::xml_node node, const ShapeUse& use, const RobotOptions& options, Assets& assets) {
  const std::string_view kind = node.name();
  if (kind == "box") return primitive_shape(xml, Primitive::box, {.sides = sizes(xml, node, "size")}, use);
  if (kind == "sphere") return primitive_shape(xml, Primitive::sphere, {.radius = size(xml, node, "radius")}, use);
  if (kind == "ellipsoid") return primitive_shape(xml, Primitive::ellipsoid, {.radii = sizes(xml, node, "radii")}, use);
  if (kind == "cylinder" || kind == "capsule")
    return primitive_shape(xml, kind == "capsule" ? Primitive::capsule : Primitive::cylinder,
                           {.radius = size(xml, node, "radius"), .length = size(xml, node, "length")}, use);
  const std::string uri = xml.required_text(xml.element(node, "uri"));
  return mesh_shape(xml, uri, xml.vec3(xml.element(node, "scale"), {1, 1, 1}, {-1e6, 1e6}), use, options, assets);
}

/// Reads the shape of one `<collision>` or `<visual>`. If it has no readable geometry, adds a note and returns std::nullopt.
std::optional<Shape> read_shape(XmlFields& xml, pugi::xml_node node, const ShapeUse& use, const RobotOptions& options, Assets& assets) {
  for (const pugi::xml_node geometry : node.child("geometry").children())
    for (const std::string_view known : {"box", "sphere", "cylinder", "capsule", "ellipsoid", "mesh"})
      if (known == geometry.name()) return read_geometry(xml, geometry, use, options, assets);
  xml.note(node, "A <" + std::string(node.name()) + "> without box, sphere, cylinder, capsule, ellipsoid or mesh is left out.");
  return std::nullopt;
}

void read_surface(XmlFields& xml, pugi::xml_node collision, Shape& shape) {
  const pugi::xml_node surface = collision.child("surface");
  shape.friction = xml.number(xml.element(surface.child("friction").child("ode"), "mu"), shape.friction, not_negative);
  shape.restitution = xml.number(xml.element(surface.child("bounce"), "restitution_coefficient"), shape.restitution, {0, 1});
}

}  // namespace

Inertia read_sdf_inertia(XmlFields& xml, SdfFrames& frames, int link) {
  const pugi::xml_node node = frames.at(link).node;
  xml.note_unread(node,
                  {"pose", "inertial", "collision", "visual", "gravity", "enable_wind", "self_collide", "kinematic", "must_be_base_link"});
  const pugi::xml_node inertial = node.child("inertial");
  if (const pugi::xml_node second = inertial.next_sibling("inertial"))
    xml.problem(second, ErrorCode::duplicate, "The link has two <inertial> elements.", "Remove one of them.");
  if (!inertial.child("mass") || !inertial.child("inertia"))
    xml.note(node,
             "A link does not specify its full inertia; missing values are assumed to be the defaults of SDFormat, 1 kg and 1 kg m^2.");
  const double mass = xml.number(xml.element(inertial, "mass"), 1, not_negative);
  const pugi::xml_node moments = inertial.child("inertia");
  const auto moment = [&](const char* name, double otherwise) { return xml.number(xml.element(moments, name), otherwise); };
  const Sym3 I{moment("ixx", 1), moment("iyy", 1), moment("izz", 1), moment("ixy", 0), moment("ixz", 0), moment("iyz", 0)};
  const Pose X = frames.pose_in(link, inertial);
  return Inertia::from_centre(mass, X.p, rotated(I, X.R));
}

std::vector<Shape> read_sdf_shapes(XmlFields& xml, SdfFrames& frames, int link, const Pose& X_BF, const RobotOptions& options,
                                   Assets& assets) {
  const pugi::xml_node node = frames.at(link).node;
  const bool collides = static_cast<bool>(node.child("collision"));
  std::vector<Shape> out;
  for (const pugi::xml_node element : node.children(collides ? "collision" : "visual")) {
    const ShapeUse use{element, collides, X_BF * frames.pose_in(link, element)};
    std::optional<Shape> shape = read_shape(xml, element, use, options, assets);
    if (!shape) continue;
    shape->collides = collides;
    if (collides) read_surface(xml, element, *shape);
    out.push_back(*shape);
  }
  return out;
}

}  // namespace ugoki::robot_formats
