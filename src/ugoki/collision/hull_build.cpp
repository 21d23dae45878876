// assemble_hull(): checks that vertices and faces are those of a convex hull, and derives the hull's other arrays.

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "ugoki/base/hash.h"
#include "ugoki/collision/hull.h"
#include "ugoki/collision/hull_walk.h"

namespace ugoki::collision {
namespace {

constexpr std::size_t max_scanned = 16;  ///< hulls of at most this many vertices are scanned (two nodes of eight), without hill climbing
constexpr double slack = 1e-9;           ///< relative to the radius: how far a vertex may be outside a face's plane

/// Directed edge from one corner of a face to the next. from, to: vertices; corner: index into Hull::corners.
struct HalfEdge {
  std::int32_t from, to;
  std::int32_t face, corner;
};

std::string vertex_name(std::size_t i) { return "vertex " + std::to_string(i); }

/// Returns the errors in the arrays of a hull: empty, out of range, not finite.
Error find_bad_arrays(const Hull& h) {
  Error error;
  const auto n = static_cast<std::int64_t>(h.vertices.size());
  if (n == 0) error.add(ErrorCode::structure, "hull", "The hull has no vertices.", "Provide at least one vertex.");
  if (n > 1'000'000'000)
    error.add(ErrorCode::range, "hull", "The hull has " + std::to_string(n) + " vertices; at most 1000000000 are allowed.",
              "Simplify the shape.");
  for (std::size_t i = 0; i < h.vertices.size(); ++i)
    if (!is_finite(h.vertices[i])) {
      error.add(ErrorCode::range, vertex_name(i), "A coordinate is not a finite number.", "Replace the coordinate by a finite value.");
      break;
    }
  for (std::size_t f = 0; f + 1 < h.first_corner.size(); ++f)
    if (h.first_corner[f] < 0 || h.first_corner[f + 1] - std::int64_t{h.first_corner[f]} < 3) {
      error.add(ErrorCode::structure, "face " + std::to_string(f), "The face has fewer than three corners.",
                "Remove the face, or give it three corners or more.");
      break;
    }
  const std::int64_t last = h.first_corner.empty() ? 0 : h.first_corner.back();
  if ((!h.first_corner.empty() && h.first_corner.front() != 0) || last != static_cast<std::int64_t>(h.corners.size()))
    error.add(ErrorCode::structure, "hull",
              "The faces end at corner " + std::to_string(last) + ", but the list has " + std::to_string(h.corners.size()) + " corners.",
              "Build the hull from its vertices again.");
  for (const std::int32_t c : h.corners)
    if (c < 0 || c >= n) {
      error.add(
          ErrorCode::range, "corner",
          "A corner refers to vertex " + std::to_string(c) + ", but the hull has " + std::to_string(n) + " vertices (counted from 0).",
          "Build the hull from its vertices again.");
      break;
    }
  return error;
}

/// All directed edges, sorted by (from, to).
std::vector<HalfEdge> half_edges(const Hull& h) {
  std::vector<HalfEdge> edges;
  edges.reserve(h.corners.size());
  for (std::size_t f = 0; f + 1 < h.first_corner.size(); ++f)
    for (std::int32_t c = h.first_corner[f]; c < h.first_corner[f + 1]; ++c) {
      const std::int32_t next = c + 1 < h.first_corner[f + 1] ? c + 1 : h.first_corner[f];
      edges.push_back({h.corners[static_cast<std::size_t>(c)], h.corners[static_cast<std::size_t>(next)], static_cast<std::int32_t>(f), c});
    }
  std::sort(edges.begin(), edges.end(),
            [](const HalfEdge& a, const HalfEdge& b) { return a.from != b.from ? a.from < b.from : a.to < b.to; });
  return edges;
}

/// Makes the list of the neighbours of each vertex. @return false if the faces do not form one closed surface (Euler characteristic 2) of
/// all vertices
bool make_neighbours(Hull& h, const std::vector<HalfEdge>& edges, const std::vector<HalfEdge>& opposite) {
  const std::size_t n = h.vertices.size();
  h.first_neighbour.assign(n + 1, 0);
  h.neighbours.clear();
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const HalfEdge &e = edges[i], &o = opposite[i];
    if (e.from != o.to || e.to != o.from || e.from == e.to) return false;
    if (i > 0 && e.from == edges[i - 1].from && e.to == edges[i - 1].to) return false;
    ++h.first_neighbour[static_cast<std::size_t>(e.from) + 1];
    h.neighbours.push_back(e.to);
  }
  for (std::size_t v = 0; v < n; ++v) {
    if (h.first_neighbour[v + 1] == 0 && !edges.empty()) return false;
    h.first_neighbour[v + 1] += h.first_neighbour[v];
  }
  if (edges.empty()) return true;
  const auto faces = static_cast<std::int64_t>(h.first_corner.size()) - 1;
  return static_cast<std::int64_t>(n) - static_cast<std::int64_t>(edges.size() / 2) + faces == 2;
}

/// Outward normal of face f with the face's area [m^2] as length: the sum over the triangles of a fan at the face's first corner.
Vec3 face_area_vector(const Hull& h, std::size_t f) {
  Vec3 sum;
  const auto corner = [&](std::int32_t c) { return h.vertices[static_cast<std::size_t>(h.corners[static_cast<std::size_t>(c)])]; };
  const Vec3 o = corner(h.first_corner[f]);
  for (std::int32_t c = h.first_corner[f] + 1; c + 1 < h.first_corner[f + 1]; ++c) sum += cross(corner(c) - o, corner(c + 1) - o);
  return sum * 0.5;
}

/// Computes `normals` and `offsets` of the faces.
void make_planes(Hull& h) {
  const std::size_t count = h.first_corner.size() - 1;
  h.normals.resize(count);
  h.offsets.resize(count);
  for (std::size_t f = 0; f < count; ++f) {
    h.normals[f] = normalized(face_area_vector(h, f));
    double offset = -1e308;
    for (const std::int32_t c : h.face(static_cast<int>(f)))
      offset = std::max(offset, dot(h.normals[f], h.vertices[static_cast<std::size_t>(c)]));
    h.offsets[f] = offset;
  }
}

/// Computes `volume`, `centre` and `radius`.
void make_measures(Hull& h) {
  Vec3 mean;
  for (const Vec3& v : h.vertices) mean += v;
  mean = mean / static_cast<double>(h.vertices.size());
  Vec3 moment;
  double weight = 0;
  h.volume = 0;
  for (std::size_t f = 0; f < h.normals.size(); ++f) {
    const std::int32_t first = h.first_corner[f];
    const auto corner = [&](std::int32_t c) { return h.vertices[static_cast<std::size_t>(h.corners[static_cast<std::size_t>(c)])] - mean; };
    for (std::int32_t c = first + 1; c + 1 < h.first_corner[f + 1]; ++c) {
      const Vec3 p = corner(first), q = corner(c), r = corner(c + 1), area = cross(q - p, r - p);
      // Weight w. Solid: six times the volume of the tetrahedron with apex `mean`. Flat: twice the area of the triangle.
      const double w = h.dimension == 3 ? dot(p, area) : norm(area);
      weight += w;
      moment += (p + q + r) * (h.dimension == 3 ? 0.25 * w : w / 3);
      if (h.dimension == 3) h.volume += w / 6;
    }
  }
  h.centre = weight > 0 ? mean + moment / weight : mean;
  if (!is_finite(h.centre)) h.centre = mean;
  double r2 = 0;
  for (const Vec3& v : h.vertices) r2 = std::max(r2, dot(v - h.centre, v - h.centre));
  h.radius = std::sqrt(r2);
}

/// True if, at each edge of each face, the adjacent face is below the plane of the face, and the hull's centre is below all planes.
bool is_convex(const Hull& h, const std::vector<HalfEdge>& edges, const std::vector<HalfEdge>& opposite) {
  const double allowed = slack * h.radius;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const auto f = static_cast<std::size_t>(edges[i].face), g = static_cast<std::size_t>(opposite[i].face);
    // c: the corner of the adjacent face that follows the edge's two corners.
    std::int32_t c = opposite[i].corner + 2;
    const std::int32_t first = h.first_corner[g], last = h.first_corner[g + 1];
    if (c >= last) c = first + (c - last);
    if (dot(h.normals[f], h.vertices[static_cast<std::size_t>(h.corners[static_cast<std::size_t>(c)])]) > h.offsets[f] + allowed)
      return false;
  }
  for (std::size_t f = 0; f < h.normals.size(); ++f)
    if (dot(h.normals[f], h.centre) > h.offsets[f] + allowed) return false;
  return true;
}

/// Makes the node of vertex `own`, with the first eight of `list` as neighbours.
HullWalk::Node make_node(const std::vector<Vec3>& vertices, std::size_t own, std::span<const std::int32_t> list) {
  HullWalk::Node node{};
  const Vec3& p = vertices[own];
  node.own[0] = p.x, node.own[1] = p.y, node.own[2] = p.z;
  for (std::size_t k = 0; k < 8; ++k) {
    const std::size_t v = k < list.size() ? static_cast<std::size_t>(list[k]) : own;
    node.x[k] = vertices[v].x, node.y[k] = vertices[v].y, node.z[k] = vertices[v].z;
    node.vertex[k] = static_cast<std::int32_t>(v);
  }
  return node;
}

/// Direction through the centre of a cell of the cube map; the inverse of direction_cell.
Vec3 cell_direction(std::int32_t side, std::int32_t i, std::int32_t j, std::int32_t cells) {
  const double u = (2.0 * i + 1) / cells - 1, v = (2.0 * j + 1) / cells - 1, m = side % 2 == 0 ? 1 : -1;
  return side < 2 ? Vec3{m, u, v} : side < 4 ? Vec3{v, m, u} : Vec3{u, v, m};
}

/// Makes Hull::walk: nodes, overflow, and either the scan or the table of seeds.
void make_walk(Hull& h) {
  HullWalk& walk = h.walk;
  const std::size_t n = h.vertices.size();
  walk = {};
  if (n <= max_scanned) {
    std::vector<std::int32_t> all(n);
    for (std::size_t v = 0; v < n; ++v) all[v] = static_cast<std::int32_t>(v);
    for (std::size_t v = 0; v < n; v += 8) walk.scan.push_back(make_node(h.vertices, v, std::span(all).subspan(v)));
  }
  walk.nodes.reserve(n);
  for (std::size_t v = 0; v < n; ++v) {
    const std::span<const std::int32_t> list = h.neighbours_of(static_cast<int>(v));
    HullWalk::Node node = make_node(h.vertices, v, list);
    node.more = static_cast<std::int32_t>(walk.overflow.size());
    if (list.size() > 8) {
      node.more_count = static_cast<std::int32_t>(list.size() - 8);
      walk.overflow.insert(walk.overflow.end(), list.begin() + 8, list.end());
    }
    walk.nodes.push_back(node);
  }
  if (n <= max_scanned) return;
  const auto cells = std::clamp(static_cast<std::int32_t>(std::sqrt(static_cast<double>(n) / 6)), 2, 64);
  std::int32_t v = 0;
  for (std::int32_t side = 0; side < 6; ++side)
    for (std::int32_t i = 0; i < cells; ++i)
      for (std::int32_t k = 0; k < cells; ++k) {
        const std::int32_t j =
            i % 2 == 0 ? k : cells - 1 - k;  // boustrophedon order: consecutive cells are adjacent, so that each climb is short
        v = walk_to_extreme(h, cell_direction(side, i, j, cells), v);
        walk.seeds.resize(static_cast<std::size_t>(6 * cells * cells));
        walk.seeds[static_cast<std::size_t>((side * cells + i) * cells + j)] = v;
      }
  walk.cells = cells;
}

/// Hash of vertices and faces.
std::uint64_t hash_of(const Hull& h) {
  Hash64 hash;
  for (const Vec3& v : h.vertices) hash.add(v.x), hash.add(v.y), hash.add(v.z);
  hash.add_bytes(h.first_corner.data(), h.first_corner.size() * sizeof(std::int32_t));
  hash.add_bytes(h.corners.data(), h.corners.size() * sizeof(std::int32_t));
  return hash.value();
}

/// True for two opposite faces that both contain all vertices.
bool is_flat(const Hull& h) {
  if (h.first_corner.size() != 3 || h.corners.size() != 2 * h.vertices.size()) return false;
  return dot(h.normals[0], h.normals[1]) < 0;
}

}  // namespace

Result<Hull> assemble_hull(std::vector<Vec3> vertices, std::vector<std::int32_t> first_corner, std::vector<std::int32_t> corners) {
  Hull h;
  h.vertices = std::move(vertices);
  h.first_corner = std::move(first_corner);
  h.corners = std::move(corners);
  if (h.first_corner.empty()) h.first_corner.push_back(0);
  if (Error error = find_bad_arrays(h); !error.empty()) return fail(std::move(error));

  const std::vector<HalfEdge> edges = half_edges(h);
  std::vector<HalfEdge> opposite = edges;
  std::sort(opposite.begin(), opposite.end(),
            [](const HalfEdge& a, const HalfEdge& b) { return a.to != b.to ? a.to < b.to : a.from < b.from; });
  if (!make_neighbours(h, edges, opposite) || (edges.empty() && h.vertices.size() > 2))
    return fail(ErrorCode::structure, "hull", "The faces do not form one closed surface of all vertices.",
                "Each edge must belong to two faces, in opposite directions.");
  make_planes(h);
  h.dimension = edges.empty() ? static_cast<int>(h.vertices.size()) - 1 : is_flat(h) ? 2 : 3;
  if (h.dimension == 1) {
    h.neighbours = {1, 0};
    h.first_neighbour = {0, 1, 2};
  }
  make_measures(h);
  if (!is_convex(h, edges, opposite))
    return fail(ErrorCode::structure, "hull", "The faces are not those of a convex solid.", "Build the hull from its vertices again.");
  make_walk(h);
  h.hash = hash_of(h);
  return h;
}

}  // namespace ugoki::collision
