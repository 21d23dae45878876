#pragma once
// Point of a simplex nearest to the origin, for Gilbert's method. Each feature (corner, edge, face) is tested by its barycentric
// coordinates. Results are computed from differences of the corners, so that small distances keep their relative accuracy.
// Source of the idea to compare all features instead of trusting signs: Montanari, Petrinic, Barbieri, Improving the GJK algorithm for
// faster and more reliable distance queries between convex objects (2017).

#include <cstdint>

#include "ugoki/collision/lanes_of_four.h"
#include "ugoki/spatial/vec3.h"

namespace ugoki::collision {

/// A point of the Minkowski difference of two shapes a and b, with the points of the shapes from which it was computed.
struct Corner {
  Vec3 w, a;            ///< m, frame of a: the point of the difference (w = a - b), and the point on shape a
  std::int32_t ia, ib;  ///< vertex indices of the two shapes (SupportPoint::vertex)
};

/// Up to four corners; after reduce() only those that span the nearest point, with their weights.
struct Simplex {
  Corner corner[4];
  double weight[4];  ///< barycentric coordinates of the nearest point
  int count = 0;
};

/// Reduces the simplex to the corners that span its point nearest to the origin, and returns this point [m]. Only features that contain the
/// newest corner (the last) are considered: the other corners were reduced before, so that no other feature can be nearer. The
/// points of all these features are computed, and the nearest is selected. Hence the result does not depend on the sign of a volume that
/// may be only a rounding error.
/// @param noise m: rounding error of the origin's distance from a plane
/// @param inside [out] the origin is inside the tetrahedron; the weights are then its barycentric coordinates
static inline Vec3 reduce(Simplex& s, double noise, bool& inside) {
  inside = false;
  const int last = s.count - 1;
  const Vec3 p = s.corner[last].w;
  if (last == 0) {
    s.weight[0] = 1;
    return p;
  }
  // Lane k: edge e from p to corner k, and the face between e and the next edge f. Lanes without a corner repeat another corner.
  const int index[4] = {0, last > 1 ? 1 : 0, last > 2 ? 2 : last > 1 ? 1 : 0, 0};
  const Vec3 e0 = s.corner[index[0]].w - p, e1 = s.corner[index[1]].w - p, e2 = s.corner[index[2]].w - p;
  const Four ex = {e0.x, e1.x, e2.x, e0.x}, ey = {e0.y, e1.y, e2.y, e0.y}, ez = {e0.z, e1.z, e2.z, e0.z};
  const Four fx = {e1.x, e2.x, e0.x, e1.x}, fy = {e1.y, e2.y, e0.y, e1.y}, fz = {e1.z, e2.z, e0.z, e1.z};
  const Four nx = ey * fz - ez * fy, ny = ez * fx - ex * fz, nz = ex * fy - ey * fx;
  const Four nn = nx * nx + ny * ny + nz * nz, height = nx * p.x + ny * p.y + nz * p.z;
  if (last == 3) {
    const double volume = nx[0] * e2.x + ny[0] * e2.y + nz[0] * e2.z;
    const Four side = height * volume, known = height * height - noise * noise * nn;
    if (side[0] < 0 && side[1] < 0 && side[2] < 0 && known[0] > 0 && known[1] > 0 && known[2] > 0) {
      inside = true;
      s.weight[2] = -height[0] / volume;
      s.weight[0] = -height[1] / volume;
      s.weight[1] = -height[2] / volume;
      s.weight[3] = 1 - s.weight[0] - s.weight[1] - s.weight[2];
      return {};
    }
  }
  // Faces: barycentric coordinates of the projected origin, times n . n. A face is skipped if the sine of the angle between its edges is
  // below 1e-14.
  const Four mx = ny * p.z - nz * p.y, my = nz * p.x - nx * p.z, mz = nx * p.y - ny * p.x;
  const Four wr = ex * mx + ey * my + ez * mz, wq = -(fx * mx + fy * my + fz * mz), wp = nn - wq - wr;
  const Four ee = ex * ex + ey * ey + ez * ez, ff = fx * fx + fy * fy + fz * fz;
  const Four none = {1e300, 1e300, 1e300, 1e300}, zero = {0, 0, 0, 0}, one = {1, 1, 1, 1};
  const Four scale = one / nn;
  const Four min_weight = wp < wq ? (wp < wr ? wp : wr) : (wq < wr ? wq : wr);
  Four face_vv = height * height * scale;
  face_vv = min_weight >= zero ? face_vv : none;
  face_vv = nn > 1e-28 * ee * ff ? face_vv : none;
  // Edges.
  const Four along = -(ex * p.x + ey * p.y + ez * p.z);
  Four t = along / ee;
  t = along > zero ? t : zero;
  t = along < ee ? t : (along > zero ? one : zero);
  const Four px = p.x + ex * t, py = p.y + ey * t, pz = p.z + ez * t;
  const Four edge_vv = px * px + py * py + pz * pz;
  const Four vv = face_vv < edge_vv ? face_vv : edge_vv;
  const int k01 = vv[1] < vv[0] ? 1 : 0, k = vv[2] < vv[k01] ? 2 : k01;

  const Corner newest = s.corner[last], q = s.corner[index[k]];
  Vec3 v;
  if (face_vv[k] < edge_vv[k]) {
    const Corner r = s.corner[index[k == 2 ? 0 : k + 1]];
    v = Vec3{nx[k], ny[k], nz[k]} * (height[k] * scale[k]);
    const double weight[3] = {wp[k] * scale[k], wq[k] * scale[k], wr[k] * scale[k]};
    s.corner[0] = q;
    s.corner[1] = r;
    s.corner[2] = newest;
    s.weight[0] = weight[1];
    s.weight[1] = weight[2];
    s.weight[2] = weight[0];
    s.count = 3;
    return v;
  }
  v = {px[k], py[k], pz[k]};
  const double w = t[k];
  s.count = 0;
  if (w > 0) {
    s.corner[s.count] = q;
    s.weight[s.count++] = w;
  }
  if (w < 1) {
    if (w > 0) {  // makes v perpendicular to the edge, even if v is short compared with the corners' position vectors
      const Vec3 e{ex[k], ey[k], ez[k]};
      v -= e * (dot(v, e) / ee[k]);
    }
    s.corner[s.count] = newest;
    s.weight[s.count++] = 1 - w;
  }
  return v;
}

}  // namespace ugoki::collision
