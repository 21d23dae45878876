#include "ugoki/collision/segment_box.h"

#include <algorithm>

namespace ugoki::collision {
namespace {

/// Half the derivative of the squared distance to the box with respect to the segment's parameter t. This derivative never decreases with
/// t. It is linear between the parameters at which a coordinate crosses a face plane.
double half_slope(const Round& s, const Vec3& e, double t) {
  const Vec3 p = s.at(t);
  return dot(p - clamp_to(p, e), s.d);
}

/// Middle of the interval of parameters at which the segment is nearest to the box.
double nearest_parameter(const Round& s, const Vec3& e) {
  if (s.half == 0) return 0;
  double knots[8];
  int count = 0;
  knots[count++] = -s.half;
  for (int i = 0; i < 3; ++i) {
    if (s.d[i] == 0) continue;
    for (const double face : {-e[i], e[i]}) {
      const double t = (face - s.c[i]) / s.d[i];
      if (!(t > -s.half && t < s.half)) continue;
      int k = count++;
      for (; k > 1 && knots[k - 1] > t; --k) knots[k] = knots[k - 1];
      knots[k] = t;
    }
  }
  knots[count++] = s.half;

  // Slopes below this value are rounding errors. A segment parallel to a face has such a slope over the whole width of the box.
  const double zero = 1e-14 * (std::fabs(s.c.x) + std::fabs(s.c.y) + std::fabs(s.c.z) + s.half);
  double low = s.half, high = s.half;
  double before = 0;
  bool found = false;
  for (int k = 0; k < count; ++k) {
    const double g = half_slope(s, e, knots[k]);
    const auto crossing = [&](double level) {  // before < level <= g
      return knots[k - 1] + (knots[k] - knots[k - 1]) * ((level - before) / (g - before));
    };
    if (!found && g >= -zero) {
      low = k == 0 ? knots[0] : crossing(-zero);
      found = true;
    }
    if (g > zero) {
      high = k == 0 ? knots[0] : crossing(zero);
      break;
    }
    before = g;
  }
  return 0.5 * (low + high);
}

/// Shortest translation that takes a segment out of a box that it overlaps. The Minkowski sum of the box and the mirrored segment has
/// facets perpendicular to the box's axes and to (axis x segment); the facet nearest to the origin gives the translation.
SegmentBox minimum_translation(const Round& s, const Vec3& e) {
  SegmentBox out;
  out.distance = -1e300;
  for (int i = 0; i < 3; ++i) {
    const double sign = s.c[i] < 0 ? -1.0 : 1.0;
    const double d = sign * s.c[i] - e[i] - s.half * std::fabs(s.d[i]);
    if (d > out.distance) {
      out.distance = d;
      out.n = {};
      out.n[i] = sign;
      out.edge = -1;
    }
  }
  if (s.half > 0) {
    // The translation across an edge must be shorter by a margin, so that the result for a segment along a face does not alternate between
    // face and edge.
    double best = out.distance + 1e-9 * std::min({e.x, e.y, e.z});
    for (int i = 0; i < 3; ++i) {
      Vec3 a;
      a[i] = 1;
      a = cross(a, s.d);
      const double length = norm(a);
      if (length < 1e-12) continue;
      a = a / length;
      if (dot(a, s.c) < 0) a = -a;
      const double d = dot(a, s.c) - (e.x * std::fabs(a.x) + e.y * std::fabs(a.y) + e.z * std::fabs(a.z));
      if (d > best) {
        best = out.distance = d;
        out.n = a;
        out.edge = i;
      }
    }
  }
  if (out.edge < 0) {
    const int i = out.n.x != 0 ? 0 : out.n.y != 0 ? 1 : 2;
    // The deepest point is an end of the segment; if the segment is parallel to the face, the middle of its part over the face.
    const double tilt = s.d[i] * out.n[i];
    double low = -s.half, high = s.half;
    const bool over = cut_to_slab(s, e, (i + 1) % 3, low, high) && cut_to_slab(s, e, (i + 2) % 3, low, high);
    if (!over) {
      low = -s.half;
      high = s.half;
    }
    out.t = tilt > 1e-12 ? low : tilt < -1e-12 ? high : 0.5 * (low + high);
    out.on_box = s.at(out.t) - out.n * out.distance;
  } else {
    Round rim;
    rim.c = {out.n.x < 0 ? -e.x : e.x, out.n.y < 0 ? -e.y : e.y, out.n.z < 0 ? -e.z : e.z};
    rim.c[out.edge] = 0;
    rim.d[out.edge] = 1;
    rim.half = e[out.edge];
    const SegmentPair pair = nearest_on_segments(s, rim);
    out.t = pair.s;
    out.on_box = rim.at(pair.t);
  }
  return out;
}

}  // namespace

bool cut_to_slab(const Round& s, const Vec3& e, int i, double& low, double& high) {
  if (s.d[i] == 0) return std::fabs(s.c[i]) <= e[i] && low <= high;
  const double one = (-e[i] - s.c[i]) / s.d[i], two = (e[i] - s.c[i]) / s.d[i];
  low = std::max(low, std::min(one, two));
  high = std::min(high, std::max(one, two));
  return low <= high;
}

SegmentBox nearest_on_segment_and_box(const Round& s, const Vec3& e) {
  SegmentBox out;
  out.t = nearest_parameter(s, e);
  const Vec3 p = s.at(out.t);
  out.on_box = clamp_to(p, e);
  const Vec3 gap = p - out.on_box;
  out.distance = norm(gap);
  if (out.distance <= 1e-12 * (e.x + e.y + e.z)) return minimum_translation(s, e);
  out.n = gap / out.distance;
  return out;
}

}  // namespace ugoki::collision
