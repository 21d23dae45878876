#pragma once
// Converts the geometry of a <collision> or <visual> element to an Ugoki shape. Used for URDF and SDF. Internal to robot_formats.

#include <optional>
#include <string>

#include "ugoki/robot_formats/assets.h"
#include "ugoki/robot_formats/xml_fields.h"

namespace ugoki::robot_formats {

enum class Primitive { box, sphere, cylinder, capsule, ellipsoid };

/// Sizes [m] of a primitive shape; the kind of primitive decides which of them are used.
struct PrimitiveSize {
  Vec3 sides = {};    ///< box
  double radius = 0;  ///< sphere, cylinder, capsule
  double length = 0;  ///< cylinder, capsule (without its hemispheres)
  Vec3 radii = {};    ///< ellipsoid
};

/// Element that defines a shape, and position and purpose of the shape.
struct ShapeUse {
  pugi::xml_node node;  ///< <collision> or <visual>, as the location of problems and notes
  bool collides = true;
  Pose X_BS;  ///< pose of the shape in the link frame
};

/// Returns the primitive as a shape. If a size is zero, adds a note and returns std::nullopt.
[[nodiscard]] std::optional<Shape> primitive_shape(XmlFields& xml, Primitive kind, const PrimitiveSize& size, const ShapeUse& use);

/// Returns the mesh as a shape, in the form that `options.meshes` selects. If the mesh cannot be read, adds a note or problem and returns
/// std::nullopt.
[[nodiscard]] std::optional<Shape> mesh_shape(XmlFields& xml, const std::string& uri, const Vec3& scale, const ShapeUse& use,
                                              const RobotOptions& options, Assets& assets);

}  // namespace ugoki::robot_formats
