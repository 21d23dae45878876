#pragma once
// Surface: uniform access to the triangles of a mesh or a height field, with their neighbours. Internal to collision/.

#include <array>
#include <cstdint>
#include <vector>

#include "ugoki/collision/collider.h"

namespace ugoki::collision {

/// View of a collider that is a surface of triangles (a mesh or a height field), in the frame of its shape. The collider must outlive the
/// view.
class Surface {
 public:
  explicit Surface(const Collider& collider)
      : prepared_(collider.prepared.get()), field_(collider.shape.type == ShapeType::height_field ? collider.shape.field.get() : nullptr) {}

  /// One triangle.
  struct Facet {
    std::array<Vec3, 3> p;  ///< m, corners, counter-clockwise seen from outside
    Vec3 n;                 ///< unit, outwards
    std::int32_t index;     ///< index of the triangle
  };
  [[nodiscard]] Facet facet(std::int32_t triangle) const;
  /// Adjacent triangle at side k (from corner k to k + 1); -1: none.
  [[nodiscard]] std::int32_t across(std::int32_t triangle, int k) const;
  /// True if the surface encloses a solid: contacts must not push bodies into it. Height fields count as closed.
  [[nodiscard]] bool closed() const { return field_ != nullptr || prepared_->spheres.closed; }

  /// Appends the indices of all triangles that may intersect the box (in the shape's frame). Some of them may not intersect it.
  /// @param stack scratch
  void collect(const Bounds& box, std::vector<std::int32_t>& stack, std::vector<std::int32_t>& out) const;

 private:
  void collect_cells(const Bounds& box, std::vector<std::int32_t>& out) const;

  const PreparedGeometry* prepared_;
  const HeightField* field_;
};

/// True if a body can touch point q of the facet with the contact normal n (unit, from the surface towards the body). If q is on a side or
/// a corner, n must be in the range of the normals of the adjacent triangles. A body can touch neither a side between coplanar triangles
/// nor a concave side. If several facets share q, only the facet with the minimum index returns true.
[[nodiscard]] bool touches_from(const Surface& surface, const Surface::Facet& facet, const Vec3& q, const Vec3& n);

}  // namespace ugoki::collision
