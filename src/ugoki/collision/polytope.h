#pragma once
// The expanding polytope: the convex hull of points of a difference of shapes, grown a point at a time, its faces' planes known.

#include <cstdint>
#include <vector>

#include "ugoki/collision/simplex.h"

namespace ugoki::collision {

/// A triangle, counter-clockwise seen from outside: n . w = d. d < 0: the origin is outside of it.
struct PolytopeFace {
  std::int32_t corner[3];
  std::int32_t across[3];  ///< face beyond the edge corner[k], corner[k + 1]
  Vec3 n;                  ///< unit
  double d = 0;            ///< m
  bool alive = true;
};

class Polytope {
 public:
  static constexpr int most_corners = 512;

  /// Starts from a tetrahedron; false where its corners lie in a plane.
  bool start(const Corner& a, const Corner& b, const Corner& c, const Corner& e);
  /// Adds a point that may lie anywhere; nothing happens where it is inside. False where rounding leaves no consistent surface, or
  /// there is no room: then the polytope is as it was.
  bool add(const Corner& c);
  /// The same for a point outside of `face`.
  bool add_beyond(const Corner& c, std::int32_t face);

  /// Face with the least d.
  [[nodiscard]] std::int32_t nearest() const;
  /// Faces 0 ... face_count() - 1; those that are not alive are gone.
  [[nodiscard]] std::int32_t face_count() const { return static_cast<std::int32_t>(faces_.size()); }
  [[nodiscard]] const PolytopeFace& face(std::int32_t f) const { return faces_[static_cast<std::size_t>(f)]; }
  [[nodiscard]] const Corner& corner(std::int32_t c) const { return corners_[static_cast<std::size_t>(c)]; }

 private:
  struct HorizonEdge {
    std::int32_t from, to, outside;
  };
  [[nodiscard]] bool sees(std::int32_t face, const Vec3& p) const;
  void set_plane(PolytopeFace& f) const;
  bool find_horizon(const Vec3& p, std::int32_t seed);

  std::vector<Corner> corners_;
  std::vector<PolytopeFace> faces_;
  std::vector<std::int32_t> visible_, starts_;  ///< starts_: new face that begins at a corner, or -1
  std::vector<std::int8_t> seen_;               ///< 1 visible, 2 not; 0 not asked
  std::vector<HorizonEdge> horizon_;
  std::vector<std::int32_t> free_;
};

}  // namespace ugoki::collision
