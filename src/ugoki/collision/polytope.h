#pragma once
// Expanding polytope of the EPA (penetration.h): the convex hull of points of the Minkowski difference of two shapes. It grows by one point
// at a time and stores the plane of each face.

#include <cstdint>
#include <vector>

#include "ugoki/collision/simplex.h"

namespace ugoki::collision {

/// A triangular face in the plane n . w = d, counter-clockwise seen from outside. d < 0: the origin is on the outer side of the plane.
struct PolytopeFace {
  std::int32_t corner[3];  ///< indices of the face's corners
  std::int32_t across[3];  ///< adjacent face at the edge from corner[k] to corner[k + 1]
  Vec3 n;                  ///< unit, outward, frame of shape a
  double d = 0;            ///< m, signed distance of the plane from the origin
  bool alive = true;       ///< false: no longer a face; its slot is reused
};

/// A closed convex surface of triangles. Side tests use double-double arithmetic if the rounding of doubles could change the result.
class Polytope {
 public:
  static constexpr int max_corners = 512;

  /// Starts from the tetrahedron with corners a, b, c, e. Returns false if the corners are coplanar.
  bool start(const Corner& a, const Corner& b, const Corner& c, const Corner& e);
  /// Adds a point. Returns true and changes nothing if the point is inside. Returns false and changes nothing if rounding leaves no
  /// consistent surface, or if there are max_corners corners already.
  bool add(const Corner& c);
  /// Adds a point that is on the outer side of `face`. Returns false in the same cases as add().
  bool add_beyond(const Corner& c, std::int32_t face);

  /// Index of the alive face with the minimum d. O(faces)
  [[nodiscard]] std::int32_t nearest() const;
  /// Count of face slots 0 ... face_count() - 1, including those that are not alive.
  [[nodiscard]] std::int32_t face_count() const { return static_cast<std::int32_t>(faces_.size()); }
  [[nodiscard]] const PolytopeFace& face(std::int32_t f) const { return faces_[static_cast<std::size_t>(f)]; }
  [[nodiscard]] const Corner& corner(std::int32_t c) const { return corners_[static_cast<std::size_t>(c)]; }

 private:
  /// Edge between a face that is visible from the new point and one that is not.
  struct HorizonEdge {
    std::int32_t from, to, outside;  // from, to: corners in the order of the visible face; outside: the other face
  };
  [[nodiscard]] bool sees(std::int32_t face, const Vec3& p) const;
  void set_plane(PolytopeFace& f) const;
  bool find_horizon(const Vec3& p, std::int32_t seed);

  std::vector<Corner> corners_;
  std::vector<PolytopeFace> faces_;
  // Scratch memory of add_beyond():
  std::vector<std::int32_t> visible_;  ///< faces visible from the new point
  std::vector<std::int32_t> starts_;   ///< [corners] new face whose horizon edge starts at this corner, or -1
  std::vector<std::int8_t> seen_;      ///< [faces] 0 not tested, 1 visible from the new point, 2 not visible
  std::vector<HorizonEdge> horizon_;
  std::vector<std::int32_t> free_;  ///< slots of faces that are not alive
};

}  // namespace ugoki::collision
