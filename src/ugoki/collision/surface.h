#pragma once
// Triangles of a mesh or a height field, one by one, with their neighbours; internal to collision.

#include <array>
#include <cstdint>
#include <vector>

#include "ugoki/collision/collider.h"

namespace ugoki::collision {

/// A view of a collider whose triangles count; in the frame of its shape.
class Surface {
 public:
  explicit Surface(const Collider& collider)
      : prepared_(collider.prepared.get()), field_(collider.shape.type == ShapeType::height_field ? collider.shape.field.get() : nullptr) {}

  struct Facet {
    std::array<Vec3, 3> p;  ///< m, counter-clockwise seen from outside
    Vec3 n;                 ///< unit, outwards
    std::int32_t index;
  };
  [[nodiscard]] Facet facet(std::int32_t triangle) const;
  /// The triangle beyond side k, from corner k to k + 1; -1: none.
  [[nodiscard]] std::int32_t across(std::int32_t triangle, int k) const;
  /// There is an inside, into which nothing may be pushed.
  [[nodiscard]] bool closed() const { return field_ != nullptr || prepared_->spheres.closed; }

  /// Indices of all triangles that may reach into the box, and perhaps of some that do not.
  /// @param stack scratch
  void collect(const Bounds& box, std::vector<std::int32_t>& stack, std::vector<std::int32_t>& out) const;

 private:
  void collect_cells(const Bounds& box, std::vector<std::int32_t>& out) const;

  const PreparedGeometry* prepared_;
  const HeightField* field_;
};

/// May a body that lies in direction n (unit, out of the surface) touch the surface at point q of the facet? Not where a neighbouring
/// triangle would be touched in another direction: the sides between triangles in one plane, and of dents, are no edges.
/// Of several facets that share the point only the one with the least index says yes.
[[nodiscard]] bool touches_from(const Surface& surface, const Surface::Facet& facet, const Vec3& q, const Vec3& n);

}  // namespace ugoki::collision
