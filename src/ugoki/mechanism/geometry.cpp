#include "ugoki/mechanism/geometry.h"

#include <algorithm>
#include <string>
#include <utility>

#include "ugoki/base/hash.h"

namespace ugoki {
namespace {

constexpr double max_coordinate = 1e6;  // m. Doubles resolve 1e-10 m at this distance; larger values are usually a wrong unit.

bool within_reach(double x) { return std::fabs(x) <= max_coordinate; }
bool within_reach(const Vec3& p) { return within_reach(p.x) && within_reach(p.y) && within_reach(p.z); }

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }

bool before(const Vec3& a, const Vec3& b) { return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z; }

/// A directed side of a triangle packed into one integer, so that sides can be sorted.
std::uint64_t side(std::int32_t from, std::int32_t to) {
  return (static_cast<std::uint64_t>(static_cast<std::uint32_t>(from)) << 32) | static_cast<std::uint32_t>(to);
}

/// Number of sides without a partner in the opposite direction. A side used n times needs n partners.
std::size_t count_open_edges(std::span<const Triangle> triangles) {
  std::vector<std::uint64_t> sides, turned;
  sides.reserve(3 * triangles.size());
  turned.reserve(3 * triangles.size());
  for (const Triangle& t : triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      sides.push_back(side(t[k], t[(k + 1) % 3]));
      turned.push_back(side(t[(k + 1) % 3], t[k]));
    }
  std::sort(sides.begin(), sides.end());
  std::sort(turned.begin(), turned.end());
  std::size_t open = 0;
  for (auto a = sides.begin(), b = turned.begin(); a != sides.end();) {
    if (b == turned.end() || *a < *b) {
      ++open;
      ++a;
    } else if (*b < *a) {
      ++b;
    } else {
      ++a;
      ++b;
    }
  }
  return open;
}

std::uint64_t content_hash(const Geometry& g) {
  Hash64 hash;
  hash.add(static_cast<std::uint64_t>(g.vertices.size()));
  hash.add(static_cast<std::uint64_t>(g.triangles.size()));
  hash.add(static_cast<std::uint64_t>(g.convex ? 1 : 0));
  hash.add_bytes(g.vertices.data(), g.vertices.size() * sizeof(Vec3));
  hash.add_bytes(g.triangles.data(), g.triangles.size() * sizeof(Triangle));
  return hash.value();
}
static_assert(sizeof(Vec3) == 3 * sizeof(double) && sizeof(Triangle) == 12);

/// Returns for each vertex the lowest index of a vertex with equal coordinates. Replaces -0 by 0 in all coordinates.
std::vector<std::int32_t> weld(std::vector<Vec3>& vertices) {
  std::vector<std::int32_t> order(vertices.size()), first(vertices.size());
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    vertices[i] += Vec3{0, 0, 0};  // -0 becomes 0
    order[i] = static_cast<std::int32_t>(i);
  }
  std::sort(order.begin(), order.end(), [&](std::int32_t a, std::int32_t b) {
    const Vec3 &p = vertices[at(a)], &q = vertices[at(b)];
    return p == q ? a < b : before(p, q);
  });
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && vertices[at(order[i])] == vertices[at(order[i - 1])];
    first[at(order[i])] = same ? first[at(order[i - 1])] : order[i];
  }
  return first;
}

/// True if the triangle has no area: two corners coincide, or the corners are collinear within rounding. Limit: the triangle's height is
/// 1e-13 of its longest side, which is above the rounding errors of the cross product.
bool is_flat(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 u = b - a, v = c - a, w = c - b;
  const double longest = std::max({dot(u, u), dot(v, v), dot(w, w)});
  const Vec3 n = cross(u, v);
  return !(dot(n, n) > 1e-26 * longest * longest);
}

void drop_doubled(std::vector<Triangle>& triangles, GeometryFindings& found) {
  std::vector<std::pair<Triangle, std::size_t>> sorted;
  sorted.reserve(triangles.size());
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    Triangle t = triangles[i];
    std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
    sorted.emplace_back(t, i);
  }
  std::sort(sorted.begin(), sorted.end());
  std::vector<char> keep(triangles.size(), 1);
  for (std::size_t i = 1; i < sorted.size(); ++i)
    if (sorted[i].first == sorted[i - 1].first) keep[sorted[i].second] = 0;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < triangles.size(); ++i)
    if (keep[i] != 0) triangles[kept++] = triangles[i];
  found.doubled_triangles = triangles.size() - kept;
  triangles.resize(kept);
}

}  // namespace

Inertia enclosed_inertia(std::span<const Vec3> vertices, std::span<const Triangle> triangles) {
  if (triangles.empty()) return {};
  // Tetrahedra from a corner of the surface keep more digits than tetrahedra from an origin that may be far away.
  const Vec3 apex = vertices[at(triangles.front()[0])];
  double mass = 0;
  Vec3 first;
  Mat3 second = Mat3::diagonal(0, 0, 0);  // integral of r r^T
  for (const Triangle& t : triangles) {
    const Vec3 a = vertices[at(t[0])] - apex, b = vertices[at(t[1])] - apex, c = vertices[at(t[2])] - apex, sum = a + b + c;
    const double m = dot(a, cross(b, c)) / 6;
    mass += m;
    first += sum * (m / 4);
    second += (Mat3::outer(a, a) + Mat3::outer(b, b) + Mat3::outer(c, c) + Mat3::outer(sum, sum)) * (m / 20);
  }
  const double trace = second.trace();
  const Inertia about_apex{mass, first, symmetric_part(Mat3::diagonal(trace, trace, trace) - second)};
  return about_apex.in_parent({Mat3::identity(), apex});
}

GeometryFindings inspect(const Geometry& geometry) {
  GeometryFindings found;
  found.open_edges = count_open_edges(geometry.triangles);
  found.inside_out = found.open_edges == 0 && enclosed_inertia(geometry.vertices, geometry.triangles).mass < 0;
  return found;
}

Result<GeometryPtr> make_geometry(std::span<const Vec3> vertices, std::span<const Triangle> triangles, bool convex,
                                  std::string_view location, GeometryFindings* findings) {
  const auto refuse = [&](ErrorCode code, std::string message, const char* remedy) {
    return fail(code, std::string(location), std::move(message), remedy);
  };
  if (triangles.size() > max_triangles || vertices.size() > 3 * max_triangles)
    return refuse(ErrorCode::range,
                  "The mesh has " + std::to_string(triangles.size()) + " triangles and " + std::to_string(vertices.size()) +
                      " vertices; at most " + std::to_string(max_triangles) + " triangles and three times as many vertices are allowed.",
                  "Simplify the mesh, or use its convex hull.");
  for (const Vec3& p : vertices)
    if (!within_reach(p))
      return refuse(ErrorCode::range, "A vertex of the mesh has a coordinate that is not finite or is beyond 1e6 m.",
                    "Check the unit of length and export the mesh again.");
  const auto count = static_cast<std::int32_t>(vertices.size());
  for (const Triangle& t : triangles)
    for (const std::int32_t i : t)
      if (i < 0 || i >= count)
        return refuse(ErrorCode::range,
                      "A triangle refers to vertex " + std::to_string(i) + ", but the mesh has " + std::to_string(count) +
                          " vertices (the first is 0).",
                      "Export the mesh again.");

  GeometryFindings found;
  Geometry out;
  out.convex = convex;
  std::vector<Vec3> points(vertices.begin(), vertices.end());
  const std::vector<std::int32_t> first = weld(points);
  for (std::size_t i = 0; i < first.size(); ++i) found.doubled_vertices += at(first[i]) != i ? 1 : 0;
  for (const Triangle& t : triangles) {
    const Triangle welded{first[at(t[0])], first[at(t[1])], first[at(t[2])]};
    // Degenerate triangles (area zero within rounding) are removed. A convex body keeps degenerate triangles with three distinct corners:
    // they close the surface where three vertices of a face are collinear.
    const bool flat = convex ? welded[0] == welded[1] || welded[1] == welded[2] || welded[2] == welded[0]
                             : is_flat(points[at(welded[0])], points[at(welded[1])], points[at(welded[2])]);
    if (flat)
      ++found.flat_triangles;
    else
      out.triangles.push_back(welded);
  }
  drop_doubled(out.triangles, found);
  std::vector<std::int32_t> new_index(points.size(), -1);
  for (const Triangle& t : out.triangles)
    for (const std::int32_t i : t) new_index[at(i)] = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (new_index[i] < 0) continue;
    new_index[i] = static_cast<std::int32_t>(out.vertices.size());
    out.vertices.push_back(points[i]);
  }
  found.unused_vertices = points.size() - found.doubled_vertices - out.vertices.size();
  for (Triangle& t : out.triangles)
    for (std::int32_t& i : t) i = new_index[at(i)];

  if (out.triangles.empty())
    return refuse(ErrorCode::structure, "The mesh has no triangle with an area: the corners of each triangle coincide or lie on lines.",
                  "Provide a mesh with a surface.");
  found.open_edges = count_open_edges(out.triangles);
  const Inertia enclosed = enclosed_inertia(out.vertices, out.triangles);
  found.inside_out = found.open_edges == 0 && enclosed.mass < 0;
  if (found.open_edges == 0 && enclosed.mass > 0) out.solid = enclosed;
  if (findings) *findings = found;
  if (convex && !(out.solid.mass > 0))
    return refuse(ErrorCode::structure, "The surface of a convex body must be closed, have outward normals and enclose a volume.",
                  "List all triangles, with corners counter-clockwise as seen from outside.");
  out.hash = content_hash(out);
  return std::make_shared<const Geometry>(std::move(out));
}

Result<HeightFieldPtr> make_height_field(HeightField field, std::string_view location) {
  const auto refuse = [&](ErrorCode code, std::string message, const char* remedy) {
    return fail(code, std::string(location), std::move(message), remedy);
  };
  if (field.columns < 2 || field.rows < 2)
    return refuse(ErrorCode::structure,
                  "The height field has " + std::to_string(field.columns) + " columns and " + std::to_string(field.rows) +
                      " rows; it needs at least 2 of each.",
                  "Add columns or rows.");
  const std::size_t wanted = static_cast<std::size_t>(field.columns) * static_cast<std::size_t>(field.rows);
  if (wanted > max_heights)
    return refuse(ErrorCode::range,
                  "The height field has " + std::to_string(wanted) + " points; at most " + std::to_string(max_heights) + " are allowed.",
                  "Use fewer rows or columns.");
  if (field.heights.size() != wanted)
    return refuse(ErrorCode::structure,
                  "The height field has " + std::to_string(field.heights.size()) + " heights, but rows times columns is " +
                      std::to_string(wanted) + ".",
                  "Provide one height for each grid point.");
  if (!(field.half_x > 0 && field.half_y > 0 && within_reach(field.half_x) && within_reach(field.half_y)))
    return refuse(ErrorCode::range, "The half sides of the height field must be above 0 and at most 1e6 m.", "Correct the half sides.");
  field.lowest = field.highest = field.heights.front();
  for (double& h : field.heights) {
    if (!within_reach(h))
      return refuse(ErrorCode::range, "A height of the height field is not finite or is beyond 1e6 m.", "Correct the heights.");
    h += 0.0;  // -0 becomes 0
    field.lowest = std::min(field.lowest, h);
    field.highest = std::max(field.highest, h);
  }
  if (!(within_reach(field.base) && -field.base < field.lowest))
    return refuse(ErrorCode::range, "The base of the height field is not below all its heights.", "Use a larger base.");
  Hash64 hash;
  hash.add(static_cast<std::uint64_t>(field.columns));
  hash.add(static_cast<std::uint64_t>(field.rows));
  for (const double x : {field.half_x, field.half_y, field.base}) hash.add(x);
  hash.add(field.heights);
  field.hash = hash.value();
  return std::make_shared<const HeightField>(std::move(field));
}

}  // namespace ugoki
