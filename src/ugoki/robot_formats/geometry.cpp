#include "ugoki/robot_formats/geometry.h"

namespace ugoki::robot_formats {
namespace {

constexpr double min_size = 1e-9;  // m; smaller shapes count as empty and are left out

bool sized(const Vec3& v) { return v.x >= min_size && v.y >= min_size && v.z >= min_size; }

}  // namespace

std::optional<Shape> primitive_shape(XmlFields& xml, Primitive kind, const PrimitiveSize& size, const ShapeUse& use) {
  const Pose& X = use.X_BS;
  switch (kind) {
    case Primitive::box:
      if (sized(size.sides)) return Shape::box(size.sides * 0.5, X);
      break;
    case Primitive::sphere:
      if (size.radius >= min_size) return Shape::sphere(size.radius, X);
      break;
    case Primitive::capsule:
      if (size.radius >= min_size) {
        const Vec3 half = X.R.column(2) * (0.5 * size.length);
        return Shape::capsule(size.radius, X.p - half, X.p + half);
      }
      break;
    case Primitive::cylinder:
      if (size.radius >= min_size && size.length >= min_size) return Shape::cylinder(size.radius, 0.5 * size.length, X);
      break;
    case Primitive::ellipsoid:
      if (sized(size.radii)) return Shape::ellipsoid(size.radii, X);
      break;
  }
  xml.note(use.node, "A shape of zero size is left out.");
  return std::nullopt;
}

std::optional<Shape> mesh_shape(XmlFields& xml, const std::string& uri, const Vec3& scale, const ShapeUse& use, const RobotOptions& options,
                                Assets& assets) {
  if (options.meshes == Meshes::none || uri.empty()) return std::nullopt;
  const Result<std::optional<MeshShape>>& found = assets.mesh(uri, scale, options.meshes, use.collides);
  if (found && *found) {
    Shape shape = (*found)->shape;
    xml.note(use.node, describe_mesh_use(shape, use.collides));
    for (const std::string& sentence : (*found)->notes) xml.note(use.node, sentence);
    shape.X_BS = use.X_BS * shape.X_BS;
    return shape;
  }
  const bool required = use.collides && options.require_meshes;
  if (!found) {
    const Problem& why = found.error().problems.front();
    const std::string message = "A mesh cannot be used: " + why.location + ": " + why.message;
    if (required)
      xml.problem(use.node, why.code, message, why.remedy);
    else
      xml.note(use.node, message + (why.remedy.empty() ? "" : " " + why.remedy));
  } else if (required) {
    xml.problem(use.node, ErrorCode::io, "The mesh file " + formats::path_in_quotes(uri) + " was not found.",
                "Copy it to that path, or read without meshes.");
  } else {
    xml.note(use.node, use.collides ? "The files of some collision meshes were not found; these shapes are left out."
                                    : "The files of some visual meshes were not found; these shapes are left out.");
  }
  return std::nullopt;
}

}  // namespace ugoki::robot_formats
