#include "ugoki/collision/sphere_tree.h"

#include <algorithm>
#include <limits>
#include <string>

#include "ugoki/collision/sphere_tree_build.h"

namespace ugoki::collision {
namespace {

constexpr double max_coordinate = 1e6;  // m; larger coordinates are refused, as in make_geometry()

std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }
bool in_range(const Vec3& p) {
  return std::fabs(p.x) <= max_coordinate && std::fabs(p.y) <= max_coordinate && std::fabs(p.z) <= max_coordinate;
}

/// Copies the mesh to the tree: triangles in the order of tree.source, each with its longest side first; vertices relative to tree.centre
/// in the order of their first use.
void copy_surface(SphereTree& tree, std::span<const Vec3> vertices, std::span<const Triangle> triangles) {
  std::vector<std::int32_t> new_index(vertices.size(), -1);
  tree.triangles.reserve(triangles.size());
  for (const std::int32_t s : tree.source) {
    Triangle t = triangles[at(s)];
    const auto side = [&](std::size_t k) {
      const Vec3 e = vertices[at(t[(k + 1) % 3])] - vertices[at(t[k])];
      return dot(e, e);
    };
    const double l[3] = {side(0), side(1), side(2)};
    std::rotate(t.begin(), t.begin() + (l[0] >= l[1] && l[0] >= l[2] ? 0 : l[1] >= l[2] ? 1 : 2), t.end());
    for (std::int32_t& v : t) {
      if (new_index[at(v)] < 0) {
        new_index[at(v)] = static_cast<std::int32_t>(tree.vertices.size());
        tree.vertices.push_back(vertices[at(v)] - tree.centre);
        tree.vertex_source.push_back(v);
      }
      v = new_index[at(v)];
    }
    tree.triangles.push_back(t);
  }
}

/// Fills tree.across. @return true if every side has exactly one partner side of opposite direction; if not, tree.across is empty
bool find_partners(SphereTree& tree) {
  struct Side {
    std::uint64_t from_to;
    std::int32_t triangle, k;
  };
  const auto key = [](std::int32_t from, std::int32_t to) {
    return (static_cast<std::uint64_t>(static_cast<std::uint32_t>(from)) << 32) | static_cast<std::uint32_t>(to);
  };
  std::vector<Side> sides;
  sides.reserve(3 * tree.triangles.size());
  for (std::size_t i = 0; i < tree.triangles.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k)
      sides.push_back(
          {key(tree.triangles[i][k], tree.triangles[i][(k + 1) % 3]), static_cast<std::int32_t>(i), static_cast<std::int32_t>(k)});
  std::sort(sides.begin(), sides.end(), [](const Side& x, const Side& y) {
    return x.from_to != y.from_to ? x.from_to < y.from_to : x.triangle != y.triangle ? x.triangle < y.triangle : x.k < y.k;
  });
  for (std::size_t i = 1; i < sides.size(); ++i)
    if (sides[i].from_to == sides[i - 1].from_to) return false;
  tree.across.resize(tree.triangles.size());
  for (const Side& s : sides) {
    const std::uint64_t reversed = (s.from_to << 32) | (s.from_to >> 32);
    const auto partner =
        std::lower_bound(sides.begin(), sides.end(), reversed, [](const Side& x, std::uint64_t v) { return x.from_to < v; });
    if (partner == sides.end() || partner->from_to != reversed) {
      tree.across.clear();
      return false;
    }
    tree.across[at(s.triangle)][at(s.k)] = partner->triangle;
  }
  return true;
}

/// For a closed surface: reverses all triangles if they are oriented inwards (negative volume), and computes the angle-weighted normals of
/// the vertices.
void make_normals(SphereTree& tree) {
  double volume = 0;
  const auto count = static_cast<std::int32_t>(tree.triangles.size());
  for (std::int32_t i = 0; i < count; ++i) volume += dot(tree.corner(i, 0), cross(tree.corner(i, 1), tree.corner(i, 2)));
  if (volume < 0)
    for (std::size_t i = 0; i < tree.triangles.size(); ++i) {
      std::swap(tree.triangles[i][0], tree.triangles[i][1]);  // side 0 keeps its index, sides 1 and 2 are exchanged
      std::swap(tree.across[i][1], tree.across[i][2]);
    }
  tree.vertex_normals.assign(tree.vertices.size(), {});
  for (std::int32_t i = 0; i < count; ++i) {
    const Vec3 p[3] = {tree.corner(i, 0), tree.corner(i, 1), tree.corner(i, 2)};
    const Vec3 n = normalized(cross(p[1] - p[0], p[2] - p[0]), {});
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 u = p[(k + 1) % 3] - p[k], v = p[(k + 2) % 3] - p[k];
      tree.vertex_normals[at(tree.triangles[at(i)][k])] += n * atan2(norm(cross(u, v)), dot(u, v));
    }
  }
  for (Vec3& n : tree.vertex_normals) n = normalized(n, {});
}

}  // namespace

Result<SphereTree> make_sphere_tree(std::span<const Vec3> vertices, std::span<const Triangle> triangles, std::string_view location) {
  const auto refuse = [&](ErrorCode code, std::string message, const char* remedy) {
    return fail(code, std::string(location), std::move(message), remedy);
  };
  if (triangles.empty()) return refuse(ErrorCode::structure, "The mesh has no triangles.", "Use a mesh with at least one triangle.");
  if (triangles.size() > max_triangles || vertices.size() > 3 * max_triangles)
    return refuse(ErrorCode::range,
                  "The mesh has " + std::to_string(triangles.size()) + " triangles and " + std::to_string(vertices.size()) +
                      " vertices; at most " + std::to_string(max_triangles) + " triangles and three times as many vertices are allowed.",
                  "Simplify the mesh, or use its convex hull.");
  for (const Triangle& t : triangles)
    for (const std::int32_t i : t)
      if (i < 0 || at(i) >= vertices.size())
        return refuse(ErrorCode::range,
                      "A triangle refers to vertex " + std::to_string(i) + ", but the mesh has " + std::to_string(vertices.size()) +
                          " vertices (the first is 0).",
                      "Export the mesh again.");
  Vec3 low = vertices[at(triangles.front()[0])], high = low;
  for (const Triangle& t : triangles)
    for (const std::int32_t i : t) {
      const Vec3& p = vertices[at(i)];
      if (!in_range(p))
        return refuse(ErrorCode::range,
                      "Vertex " + std::to_string(i) + " of the mesh has a coordinate that is not finite or is beyond +-1e6 m.",
                      "Check the unit of length and export the mesh again.");
      for (int k = 0; k < 3; ++k) {
        low[k] = std::min(low[k], p[k]);
        high[k] = std::max(high[k], p[k]);
      }
    }
  SphereTree tree;
  tree.centre = (low + high) * 0.5;
  tree.source = build::order_triangles(vertices, triangles, tree.centre);
  copy_surface(tree, vertices, triangles);
  for (const Vec3& v : tree.vertices) tree.radius = std::max(tree.radius, norm(v));
  tree.radius *= 1 + 4 * std::numeric_limits<double>::epsilon();
  build::fit_bounds(tree);
  tree.closed = find_partners(tree);
  if (tree.closed) make_normals(tree);
  return tree;
}

SphereTreeReport report_of(const SphereTree& tree) {
  SphereTreeReport out;
  out.triangles = tree.triangles.size();
  out.bytes = tree.blocks.size() * sizeof(BoundBlock) + (tree.vertices.size() + tree.vertex_normals.size()) * sizeof(Vec3) +
              tree.triangles.size() * (sizeof(Triangle) + sizeof(std::int32_t)) + tree.vertex_source.size() * sizeof(std::int32_t) +
              tree.across.size() * sizeof(Triangle);
  std::vector<std::size_t> depth_of(tree.blocks.size(), 0), pairs;
  for (std::size_t b = 0; b < tree.blocks.size(); ++b) {
    const BoundBlock& block = tree.blocks[b];
    const std::size_t depth = depth_of[b];
    if (depth >= out.spheres_at.size()) {
      out.spheres_at.resize(depth + 1);
      out.mean_radius.resize(depth + 1);
      out.mean_overlap.resize(depth + 1);
      pairs.resize(depth + 1);
    }
    for (std::int32_t i = 0; i < block.count; ++i) {
      ++out.spheres;
      ++out.spheres_at[depth];
      out.mean_radius[depth] += static_cast<double>(block.radius[i]);
      if (block.child[i] >= 0) depth_of[at(block.child[i])] = depth + 1;
      for (std::int32_t j = 0; j < i; ++j) {
        const Vec3 apart{static_cast<double>(block.sphere[0][i] - block.sphere[0][j]),
                         static_cast<double>(block.sphere[1][i] - block.sphere[1][j]),
                         static_cast<double>(block.sphere[2][i] - block.sphere[2][j])};
        const double ri = static_cast<double>(block.radius[i]), rj = static_cast<double>(block.radius[j]);
        ++pairs[depth];
        if (std::min(ri, rj) > 0) out.mean_overlap[depth] += std::clamp((ri + rj - norm(apart)) / (2 * std::min(ri, rj)), 0.0, 1.0);
      }
    }
  }
  for (std::size_t d = 0; d < out.spheres_at.size(); ++d) {
    out.mean_radius[d] /= static_cast<double>(out.spheres_at[d]);
    if (pairs[d] > 0) out.mean_overlap[d] /= static_cast<double>(pairs[d]);
  }
  return out;
}

}  // namespace ugoki::collision
