#pragma once
// The geometry of a collision or visual element as Ugoki's shapes, common to URDF and SDF; internal to robot_formats.

#include <optional>
#include <string>

#include "ugoki/robot_formats/assets.h"
#include "ugoki/robot_formats/xml_fields.h"

namespace ugoki::robot_formats {

enum class Primitive { box, sphere, cylinder, capsule, ellipsoid };

/// Sizes [m] that the element gives; which of them count depends on the primitive.
struct PrimitiveSize {
  Vec3 sides = {};    ///< box
  double radius = 0;  ///< sphere, cylinder, capsule
  double length = 0;  ///< cylinder, capsule (its straight part)
  Vec3 radii = {};    ///< ellipsoid
};

/// Where an element stands and what it is for.
struct ShapeUse {
  pugi::xml_node node;
  bool collides = true;
  Pose X_BS;
};

/// Nothing, with a note, where a size is zero.
[[nodiscard]] std::optional<Shape> primitive_shape(XmlFields& xml, Primitive kind, const PrimitiveSize& size, const ShapeUse& use);

/// The mesh as the options want it; nothing, with a note or a problem, where it cannot be had.
[[nodiscard]] std::optional<Shape> mesh_shape(XmlFields& xml, const std::string& uri, const Vec3& scale, const ShapeUse& use,
                                              const RobotOptions& options, Assets& assets);

}  // namespace ugoki::robot_formats
