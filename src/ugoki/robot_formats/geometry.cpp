#include "ugoki/robot_formats/geometry.h"

namespace ugoki::robot_formats {
namespace {

constexpr double smallest = 1e-9;  // m

bool sized(const Vec3& v) { return v.x >= smallest && v.y >= smallest && v.z >= smallest; }

}  // namespace

std::optional<Shape> primitive_shape(XmlFields& xml, Primitive kind, const PrimitiveSize& size, const ShapeUse& use) {
  const Pose& X = use.X_BS;
  switch (kind) {
    case Primitive::box:
      if (sized(size.sides)) return Shape::box(size.sides * 0.5, X);
      break;
    case Primitive::sphere:
      if (size.radius >= smallest) return Shape::sphere(size.radius, X);
      break;
    case Primitive::capsule:
      if (size.radius >= smallest) {
        const Vec3 half = X.R.column(2) * (0.5 * size.length);
        return Shape::capsule(size.radius, X.p - half, X.p + half);
      }
      break;
    case Primitive::cylinder:
      if (size.radius >= smallest && size.length >= smallest) return Shape::cylinder(size.radius, 0.5 * size.length, X);
      break;
    case Primitive::ellipsoid:
      if (sized(size.radii)) return Shape::ellipsoid(size.radii, X);
      break;
  }
  xml.note(use.node, "A shape without size is passed over.");
  return std::nullopt;
}

std::optional<Shape> mesh_shape(XmlFields& xml, const std::string& uri, const Vec3& scale, const ShapeUse& use, const RobotOptions& options,
                                Assets& assets) {
  if (options.meshes == Meshes::none || uri.empty()) return std::nullopt;
  const Result<std::optional<MeshShape>>& found = assets.mesh(uri, scale, options.meshes, use.collides);
  if (found && *found) {
    Shape shape = (*found)->shape;
    xml.note(use.node, how_taken(shape, use.collides));
    for (const std::string& sentence : (*found)->notes) xml.note(use.node, sentence);
    shape.X_BS = use.X_BS * shape.X_BS;
    return shape;
  }
  const bool required = use.collides && options.require_meshes;
  if (!found) {
    const Problem& why = found.error().problems.front();
    const std::string message = "a mesh cannot be used: " + why.place + ": " + why.message;
    if (required)
      xml.problem(use.node, why.code, message, why.remedy);
    else
      xml.note(use.node, "A" + message.substr(1) + (why.remedy.empty() ? "" : " " + why.remedy));
  } else if (required) {
    xml.problem(use.node, ErrorCode::io, "the mesh " + formats::path_in_quotes(uri) + " is not there.",
                "Put it where the file says, or read without meshes.");
  } else {
    xml.note(use.node,
             use.collides ? "Meshes that collide are not there; their links have no shape for them." : "Meshes to be seen are not there.");
  }
  return std::nullopt;
}

}  // namespace ugoki::robot_formats
