#include "ugoki/collision/box_box.h"

#include <algorithm>

#include "ugoki/collision/four_points.h"
#include "ugoki/collision/segment_box.h"

namespace ugoki::collision {
namespace {

double smallest(const Vec3& e) { return std::min({e.x, e.y, e.z}); }

/// The best separating axes of two boxes: the best face normal and the best cross product of edges. The separation along a unit vector
/// is never above the true signed distance. The maximum of all 15 separations is the negative depth of overlapping boxes. Lengths in m.
/// Source: Gottschalk, Lin, Manocha, OBBTree (1996).
struct Axes {
  double face = -1e300;        // separation along the best face normal
  int face_axis = 0;           // axis of the best face normal: 0 ... 2 of a, 3 ... 5 of b
  bool face_out = true;        // true: the face's outward normal is +axis; false: -axis
  double edge = -1e300;        // separation along the best cross product
  int edge_a = 0, edge_b = 0;  // axes (0 ... 2) of a and of b with the best cross product
  Vec3 edge_n;                 // unit, a's frame: best cross product, from b towards a

  [[nodiscard]] double best() const { return std::max(face, edge); }
};

/// Computes the separations of two boxes along their face normals and the cross products of their edges.
/// @param stop m: return as soon as a separation is at least this
/// @param bias m: a face of b is used only if its separation exceeds that of a's best face by the bias, so that contacts do not alternate
Axes calc_axes(const Box& a, const Box& b, double stop, double bias) {
  const Mat3 R = a.X.R.transposed() * b.X.R;  // b's axes in a's frame, as columns
  const Vec3 p = transpose_times(a.X.R, b.X.p - a.X.p);
  Axes out;
  for (int i = 0; i < 3; ++i) {
    const Vec3 r = R.row(i);
    const double s = std::fabs(p[i]) - (a.e[i] + b.e.x * std::fabs(r.x) + b.e.y * std::fabs(r.y) + b.e.z * std::fabs(r.z));
    if (s > out.face) {
      out.face = s;
      out.face_axis = i;
      out.face_out = p[i] >= 0;
    }
  }
  if (out.face >= stop) return out;
  double threshold = out.face + bias;
  for (int j = 0; j < 3; ++j) {
    const Vec3 c = R.column(j);
    const double along = dot(p, c);
    const double s = std::fabs(along) - (b.e[j] + a.e.x * std::fabs(c.x) + a.e.y * std::fabs(c.y) + a.e.z * std::fabs(c.z));
    if (s > threshold) {
      out.face = threshold = s;
      out.face_axis = 3 + j;
      out.face_out = along < 0;
    }
  }
  if (out.face >= stop) return out;
  for (int i = 0; i < 3; ++i) {
    Vec3 unit;
    unit[i] = 1;
    for (int j = 0; j < 3; ++j) {
      Vec3 n = cross(unit, R.column(j));
      const double length = norm(n);
      if (length < 1e-9) continue;  // parallel edges (sine below 1e-9): the direction is that of a face normal, which is tested above
      n = n / length;
      if (dot(n, p) > 0) n = -n;
      double s = -dot(n, p);
      for (int k = 0; k < 3; ++k) s -= a.e[k] * std::fabs(n[k]) + b.e[k] * std::fabs(dot(n, R.column(k)));
      if (s > out.edge) {
        out.edge = s;
        out.edge_a = i;
        out.edge_b = j;
        out.edge_n = n;
      }
    }
  }
  return out;
}

/// Edge of the box along its axis i that is farthest in direction n (frame of the poses).
/// @param index [out] 0 ... 3: which of the four edges along axis i
Round support_edge(const Box& box, int i, const Vec3& n, std::uint32_t& index) {
  Vec3 corner;
  const Vec3 local = transpose_times(box.X.R, n);
  index = 0;
  for (int k = 0; k < 3; ++k) {
    if (k == i) continue;
    const bool positive = local[k] >= 0;
    corner[k] = positive ? box.e[k] : -box.e[k];
    index = index * 2 + (positive ? 1U : 0U);
  }
  return {box.X * corner, box.X.R.column(i), box.e[i], 0};
}

BoxPair nearest_on_edges(const Box& a, const Box& b, const Axes& axes, std::uint32_t& feature) {
  BoxPair out;
  out.n = a.X.R * axes.edge_n;
  std::uint32_t index_a = 0, index_b = 0;
  const Round edge_a = support_edge(a, axes.edge_a, -out.n, index_a), edge_b = support_edge(b, axes.edge_b, out.n, index_b);
  const SegmentPair pair = nearest_on_segments(edge_a, edge_b);
  out.pa = edge_a.at(pair.s);
  out.pb = edge_b.at(pair.t);
  out.distance = axes.edge;
  feature = 8192U + static_cast<std::uint32_t>((axes.edge_a * 3 + axes.edge_b) * 16) + index_a * 4 + index_b;
  return out;
}

/// Closest points of two separate boxes. Either the point of a is on an edge of a, or the point of b is a corner of b.
/// @param feature [out] identifies the edge or corner
BoxPair nearest_apart(const Box& a, const Box& b, std::uint32_t& feature) {
  BoxPair out;
  out.distance = 1e300;
  const double size = a.e.x + a.e.y + a.e.z + b.e.x + b.e.y + b.e.z;
  const auto nearer = [&](double d) {
    return d < out.distance - 1e-9 * std::min(out.distance, size);
  };  // if distances are equal, the first feature is used
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    for (std::uint32_t c = 0; c < 4; ++c) {
      Vec3 corner;
      corner[j] = (c & 1) != 0 ? a.e[j] : -a.e[j];
      corner[k] = (c & 2) != 0 ? a.e[k] : -a.e[k];
      const Round edge{a.X * corner, a.X.R.column(i), a.e[i], 0};
      const SegmentBox near = nearest_on_segment_and_box(in_box(edge, b.X), b.e);
      if (nearer(near.distance)) {
        out = {edge.at(near.t), b.X * near.on_box, b.X.R * near.n, near.distance};
        feature = 16384U + static_cast<std::uint32_t>(i) * 4 + c;
      }
    }
  }
  for (std::uint32_t c = 0; c < 8; ++c) {
    const Vec3 corner = b.X * Vec3{(c & 1) != 0 ? b.e.x : -b.e.x, (c & 2) != 0 ? b.e.y : -b.e.y, (c & 4) != 0 ? b.e.z : -b.e.z};
    const Vec3 local = transpose_times(a.X.R, corner - a.X.p);
    const Vec3 on_a = clamp_to(local, a.e);
    const double d = norm(local - on_a);
    if (nearer(d)) {
      out = {a.X * on_a, corner, a.X.R * normalized(on_a - local), d};
      feature = 16384U + 32 + c;
    }
  }
  return out;
}

/// A corner of the clipped face. u, v: m, coordinates along the reference face's axes; h: m, height above the reference face; in, out:
/// labels of the two lines that meet at the corner (0 ... 3: edges of the incident face, 4 ... 7: sides of the reference face).
struct Corner {
  double u, v, h;
  std::uint8_t in, out;
};
struct Polygon {
  std::array<Corner, 8> corners;
  int count = 0;
  void add(const Corner& c) {
    if (count < 8) corners[static_cast<std::size_t>(count++)] = c;
  }
};

/// Clips the polygon to the half-plane side * (u or v) <= limit.
/// @param label label of the clipping line
void clip(const Polygon& from, bool along_u, double side, double limit, std::uint8_t label, Polygon& to) {
  to.count = 0;
  for (int i = 0; i < from.count; ++i) {
    const Corner& c = from.corners[static_cast<std::size_t>(i)];
    const Corner& d = from.corners[static_cast<std::size_t>((i + 1) % from.count)];
    const double beyond_c = side * (along_u ? c.u : c.v) - limit, beyond_d = side * (along_u ? d.u : d.v) - limit;
    if (beyond_c <= 0) to.add(c);
    if ((beyond_c <= 0) == (beyond_d <= 0)) continue;
    const double f = beyond_c / (beyond_c - beyond_d);
    Corner cut{c.u + f * (d.u - c.u), c.v + f * (d.v - c.v), c.h + f * (d.h - c.h), c.out, label};
    if (beyond_c > 0) std::swap(cut.in, cut.out);
    to.add(cut);
  }
}

/// Reduces the polygon to the four corners of choose_four().
void keep_four(Polygon& polygon) {
  if (polygon.count <= 4) return;
  std::array<FlatPoint, 8> points;
  for (std::size_t i = 0; i < static_cast<std::size_t>(polygon.count); ++i)
    points[i] = {polygon.corners[i].u, polygon.corners[i].v, polygon.corners[i].h};
  int chosen[4];
  choose_four({points.data(), static_cast<std::size_t>(polygon.count)}, chosen);
  Polygon kept;
  for (const int i : chosen)
    if (i >= 0) kept.add(polygon.corners[static_cast<std::size_t>(i)]);
  polygon = kept;
}

/// Clips the incident face of one box against the best face of the other box. Adds the corners below `margin` [m] to `out`.
/// @return minimum height [m] of the clipped corners above the best face; 1e300 if none is left
double add_face(const Box& a, const Box& b, const Axes& axes, double margin, Manifold& out) {
  const bool of_a = axes.face_axis < 3;
  const Box& reference = of_a ? a : b;
  const Box& incident = of_a ? b : a;
  const int w = axes.face_axis % 3, u = (w + 1) % 3, v = (w + 2) % 3;
  const double up = axes.face_out ? 1.0 : -1.0;
  const Vec3 normal = reference.X.R.column(w) * up;

  // The incident face is the one whose outward normal is most opposed to the reference normal.
  const Vec3 m = transpose_times(incident.X.R, normal);
  const int k = std::fabs(m.x) >= std::fabs(m.y) && std::fabs(m.x) >= std::fabs(m.z) ? 0 : std::fabs(m.y) >= std::fabs(m.z) ? 1 : 2;
  const bool k_out = m[k] < 0;
  const int k1 = (k + 1) % 3, k2 = (k + 2) % 3;

  Polygon one, two;
  for (std::uint8_t i = 0; i < 4; ++i) {
    Vec3 corner;
    corner[k] = k_out ? incident.e[k] : -incident.e[k];
    corner[k1] = i == 1 || i == 2 ? incident.e[k1] : -incident.e[k1];
    corner[k2] = i >= 2 ? incident.e[k2] : -incident.e[k2];
    const Vec3 local = transpose_times(reference.X.R, incident.X * corner - reference.X.p);
    one.add({local[u], local[v], up * local[w] - reference.e[w], static_cast<std::uint8_t>((i + 3) & 3), i});
  }
  const double slack = 1 + 1e-6;  // widens the reference face, so that stacked boxes of equal size keep their own corners
  clip(one, true, 1, reference.e[u] * slack, 4, two);
  clip(two, true, -1, reference.e[u] * slack, 5, one);
  clip(one, false, 1, reference.e[v] * slack, 6, two);
  clip(two, false, -1, reference.e[v] * slack, 7, one);

  double minimum = 1e300;
  Polygon near;
  for (int i = 0; i < one.count; ++i) {
    const Corner& c = one.corners[static_cast<std::size_t>(i)];
    minimum = std::min(minimum, c.h);
    if (c.h < margin) near.add(c);
  }
  keep_four(near);
  const auto faces = static_cast<std::uint32_t>(((axes.face_axis * 2 + (axes.face_out ? 1 : 0)) * 3 + k) * 2 + (k_out ? 1 : 0));
  for (int i = 0; i < near.count; ++i) {
    const Corner& c = near.corners[static_cast<std::size_t>(i)];
    Vec3 local;
    local[u] = clamp_to(c.u, reference.e[u]);
    local[v] = clamp_to(c.v, reference.e[v]);
    local[w] = up * (reference.e[w] + 0.5 * c.h);
    out.add(reference.X * local, of_a ? -normal : normal, c.h, faces * 64 + c.in * 8U + c.out);
  }
  return minimum;
}

BoxPair nearest(const Box& a, const Box& b, std::uint32_t& feature) {
  const double size = a.e.x + a.e.y + a.e.z + b.e.x + b.e.y + b.e.z;
  const Axes axes = calc_axes(a, b, 1e300, 0);
  if (axes.best() > 0) {
    const BoxPair apart = nearest_apart(a, b, feature);
    if (apart.distance > 1e-12 * size) return apart;
  }
  if (axes.edge > axes.face + 1e-12 * size) return nearest_on_edges(a, b, axes, feature);

  // The shortest separating translation is along a face normal. The deepest points are at the mean of the deepest corners.
  feature = 16384U + 64 + static_cast<std::uint32_t>(axes.face_axis);
  Manifold manifold;
  const double minimum = add_face(a, b, axes, 1e300, manifold);
  Vec3 sum;
  double weight = 0;
  for (int i = 0; i < manifold.count; ++i) {
    const ManifoldPoint& point = manifold.points[static_cast<std::size_t>(i)];
    if (point.distance > minimum + 1e-9 * size) continue;
    sum += point.p;
    weight += 1;
  }
  const bool of_a = axes.face_axis < 3;
  const Vec3 middle = weight > 0 ? sum / weight : (a.X.p + b.X.p) * 0.5;
  BoxPair out;
  out.n = (of_a ? a : b).X.R.column(axes.face_axis % 3) * (axes.face_out == of_a ? -1.0 : 1.0);
  out.distance = axes.face;
  out.pa = middle + out.n * (0.5 * out.distance);
  out.pb = middle - out.n * (0.5 * out.distance);
  return out;
}

}  // namespace

BoxPair nearest_on_boxes(const Box& a, const Box& b) {
  std::uint32_t feature = 0;
  return nearest(a, b, feature);
}

void add_box_box(const Box& a, const Box& b, double margin, Manifold& out) {
  const double bias = 1e-4 * std::min(smallest(a.e), smallest(b.e));
  const Axes axes = calc_axes(a, b, margin, bias);
  if (!(axes.best() < margin)) return;
  std::uint32_t feature = 0;
  if (axes.edge > axes.face + bias) {
    const BoxPair pair = nearest_on_edges(a, b, axes, feature);
    // If a closest point is an end of its edge, the points are farther apart than axes.edge, and other features may be closer.
    if (axes.edge <= 0 || norm(pair.pa - pair.pb) <= axes.edge * (1 + 1e-9)) {
      out.add((pair.pa + pair.pb) * 0.5, pair.n, pair.distance, feature);
      return;
    }
  } else {
    const int before = out.count;
    if (add_face(a, b, axes, margin, out) <= axes.best() + bias) return;
    out.count = before;
  }
  // Neither the chosen pair of edges nor the clipped faces contain the closest points: all corners and edges are searched.
  const BoxPair pair = nearest(a, b, feature);
  if (pair.distance < margin) out.add((pair.pa + pair.pb) * 0.5, pair.n, pair.distance, feature);
}

}  // namespace ugoki::collision
