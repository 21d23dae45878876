#include "ugoki/mechanism_edit/mesh_inertia.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "ugoki/base/number.h"

namespace ugoki {
namespace {

/// A side of a triangle: its vertices in ascending order, and whether the triangle runs from `high` to `low`.
struct Side {
  std::int32_t low, high;
  std::int32_t triangle;
  bool backwards;

  [[nodiscard]] bool same_edge(const Side& o) const { return low == o.low && high == o.high; }
};

std::vector<Side> sides_of(std::span<const Triangle> triangles) {
  std::vector<Side> sides;
  sides.reserve(3 * triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t a = triangles[t][k], b = triangles[t][(k + 1) % 3];
      sides.push_back({std::min(a, b), std::max(a, b), static_cast<std::int32_t>(t), a > b});
    }
  std::sort(sides.begin(), sides.end(), [](const Side& x, const Side& y) {
    return x.low != y.low ? x.low < y.low : x.high != y.high ? x.high < y.high : x.triangle < y.triangle;
  });
  return sides;
}

/// Union-find over triangles that also stores relative orientation: whether two members of a set are oriented alike or oppositely.
class Orientation {
 public:
  explicit Orientation(std::size_t n) : up_(n), opposite_(n, 0) { std::iota(up_.begin(), up_.end(), 0); }

  /// @return representative of the set of `i`, and whether `i` is oriented oppositely to it
  std::pair<std::int32_t, bool> find(std::int32_t i) {
    bool odd = false;
    std::int32_t root = i;
    while (up_[at(root)] != root) {
      odd ^= opposite_[at(root)] != 0;
      root = up_[at(root)];
    }
    bool rest = odd;
    while (up_[at(i)] != i) {  // path compression
      const std::int32_t next = up_[at(i)];
      const bool step = opposite_[at(i)] != 0;
      up_[at(i)] = root;
      opposite_[at(i)] = rest;
      rest ^= step;
      i = next;
    }
    return {root, odd};
  }
  /// Joins the sets of a and b. @return false if the relation contradicts earlier ones: the surface is one-sided
  bool join(std::int32_t a, std::int32_t b, bool opposite) {
    const auto [ra, oa] = find(a);
    const auto [rb, ob] = find(b);
    if (ra == rb) return (oa != ob) == opposite;
    up_[at(rb)] = ra;
    opposite_[at(rb)] = (oa != ob) != opposite;
    return true;
  }

 private:
  static std::size_t at(std::int32_t i) { return static_cast<std::size_t>(i); }
  std::vector<std::int32_t> up_;
  std::vector<char> opposite_;
};

/// Solid angle of the triangle seen from the origin, divided by 4 pi (Van Oosterom, Strackee 1983).
double winding(const Vec3& a, const Vec3& b, const Vec3& c) {
  const double la = norm(a), lb = norm(b), lc = norm(c);
  const double up = dot(a, cross(b, c));
  const double down = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb;
  return atan2(up, down) / (2 * pi);
}

struct Part {
  std::vector<Triangle> triangles;
  double volume = 0;
};

std::string where(const Vec3& p) { return "(" + to_fixed(p.x, 4) + ", " + to_fixed(p.y, 4) + ", " + to_fixed(p.z, 4) + ") m"; }

/// Describes the holes in a sentence. @param open sides without a partner; connected sides form the rim of a hole
std::string describe_holes(const std::vector<Side>& open, const std::vector<Vec3>& vertices) {
  Orientation rims(vertices.size());
  for (const Side& s : open) (void)rims.join(s.low, s.high, false);
  struct Rim {
    Vec3 low{INFINITY, INFINITY, INFINITY}, high{-INFINITY, -INFINITY, -INFINITY};
    std::size_t sides = 0;
  };
  std::vector<std::pair<std::int32_t, Rim>> found;
  std::vector<std::int32_t> slot(vertices.size(), -1);
  for (const Side& s : open) {
    const std::int32_t root = rims.find(s.low).first;
    std::int32_t& at = slot[static_cast<std::size_t>(root)];
    if (at < 0) {
      at = static_cast<std::int32_t>(found.size());
      found.emplace_back(root, Rim{});
    }
    Rim& rim = found[static_cast<std::size_t>(at)].second;
    ++rim.sides;
    for (const std::int32_t v : {s.low, s.high})
      for (int i = 0; i < 3; ++i) {
        rim.low[i] = std::min(rim.low[i], vertices[static_cast<std::size_t>(v)][i]);
        rim.high[i] = std::max(rim.high[i], vertices[static_cast<std::size_t>(v)][i]);
      }
  }
  const auto widest = std::max_element(found.begin(), found.end(), [](const auto& a, const auto& b) {
    return norm(a.second.high - a.second.low) < norm(b.second.high - b.second.low);
  });
  const Rim& rim = widest->second;
  return "The surface is not closed: it has " + std::to_string(found.size()) + (found.size() == 1 ? " hole" : " holes") +
         "; the widest, of " + std::to_string(rim.sides) + " sides, is about " + where((rim.low + rim.high) * 0.5) + " and " +
         to_fixed(norm(rim.high - rim.low), 4) + " m wide.";
}

/// Reverses parts with inward normals that are not cavities, and reports reversed parts, cavities and nested parts.
void orient_outwards(std::vector<Part>& parts, const std::vector<Vec3>& vertices, MeshInertia& out) {
  const auto inside = [&](const Part& inner, const Part& outer) {
    // Test point: the centroid of a triangle of the inner surface. It is inside if the winding number of the outer surface is not 0.
    const Triangle& t = inner.triangles.front();
    const Vec3 p =
        (vertices[static_cast<std::size_t>(t[0])] + vertices[static_cast<std::size_t>(t[1])] + vertices[static_cast<std::size_t>(t[2])]) /
        3.0;
    double turns = 0;
    for (const Triangle& o : outer.triangles)
      turns += winding(vertices[static_cast<std::size_t>(o[0])] - p, vertices[static_cast<std::size_t>(o[1])] - p,
                       vertices[static_cast<std::size_t>(o[2])] - p);
    return std::fabs(turns) > 0.5;
  };
  std::size_t cavities = 0, doubled = 0, inside_out = 0;
  const bool few = parts.size() <= 1000;
  for (Part& part : parts) {
    std::size_t around = 0;
    for (const Part& other : parts)
      if (few && &other != &part && std::fabs(other.volume) > std::fabs(part.volume) && inside(part, other)) ++around;
    if (part.volume < 0 && around % 2 == 1) {
      ++cavities;
    } else if (part.volume < 0) {
      for (Triangle& t : part.triangles) std::swap(t[1], t[2]);
      out.turned += part.triangles.size();
      ++inside_out;
    } else if (around % 2 == 1) {
      ++doubled;
    }
  }
  const auto notify = [&](std::size_t n, const char* one, const char* many) {
    if (n > 0) out.report.push_back(n == 1 ? std::string("One part ") + one : std::to_string(n) + " parts " + many);
  };
  notify(inside_out, "had inward normals and was reversed.", "had inward normals and were reversed.");
  notify(cavities, "is a cavity inside another part and was subtracted.", "are cavities inside another part and were subtracted.");
  notify(doubled, "is inside another part and has outward normals: its mass counts twice.",
         "are inside another part and have outward normals: their mass counts twice.");
}

}  // namespace

Result<MeshInertia> mesh_inertia(std::span<const Vec3> points, std::span<const Triangle> faces, std::string_view location,
                                 const MeshInertiaOptions& options) {
  const std::string at(location);
  if (!(options.mass > 0) && !(options.density > 0 && std::isfinite(options.density)))
    return fail(ErrorCode::range, at, "The density is not finite and above 0.", "Specify a density in kg/m^3 or a mass in kg.");
  GeometryFindings findings;
  const Result<GeometryPtr> welded = make_geometry(points, faces, false, location, &findings);
  if (!welded) return fail(welded.error());
  // Compute relative to the centre of the bounding box, so that a mesh far from its origin loses no digits.
  std::vector<Vec3> vertices = (*welded)->vertices;
  Vec3 low = vertices[0], high = vertices[0];
  for (const Vec3& v : vertices)
    for (int i = 0; i < 3; ++i) {
      low[i] = std::min(low[i], v[i]);
      high[i] = std::max(high[i], v[i]);
    }
  const Vec3 middle = (low + high) * 0.5;

  std::vector<Triangle> triangles = (*welded)->triangles;
  const std::vector<Side> sides = sides_of(triangles);
  std::vector<Side> open;
  Orientation orientation(triangles.size());
  bool one_sided = false;
  for (std::size_t i = 0; i < sides.size();) {
    std::size_t end = i + 1;
    while (end < sides.size() && sides[end].same_edge(sides[i])) ++end;
    if (end - i == 2) {
      // Two triangles are oriented alike if they run through the shared side in opposite directions.
      if (!orientation.join(sides[i].triangle, sides[i + 1].triangle, sides[i].backwards == sides[i + 1].backwards)) one_sided = true;
    } else if ((end - i) % 2 == 1) {
      open.push_back(sides[i]);
    }
    i = end;
  }
  if (!open.empty())
    return fail(ErrorCode::structure, at, describe_holes(open, vertices),
                "Close the holes in the program that made the mesh, or use its convex hull.");
  if (one_sided)
    return fail(ErrorCode::structure, at, "The surface has only one side, like a Moebius strip.",
                "Repair the surface in the program that made the mesh.");
  for (Vec3& v : vertices) v = v - middle;

  MeshInertia out;
  std::vector<Part> parts;
  std::vector<std::int32_t> part_of(triangles.size(), -1);
  std::vector<std::size_t> opposed;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const auto [root, opposite] = orientation.find(static_cast<std::int32_t>(t));
    std::int32_t& part = part_of[static_cast<std::size_t>(root)];
    if (part < 0) {
      part = static_cast<std::int32_t>(parts.size());
      parts.emplace_back();
      opposed.push_back(0);
    }
    Triangle triangle = triangles[t];
    if (opposite) {
      std::swap(triangle[1], triangle[2]);
      ++opposed[static_cast<std::size_t>(part)];
    }
    parts[static_cast<std::size_t>(part)].triangles.push_back(triangle);
    const Vec3 a = vertices[static_cast<std::size_t>(triangle[0])], b = vertices[static_cast<std::size_t>(triangle[1])],
               c = vertices[static_cast<std::size_t>(triangle[2])];
    out.area += 0.5 * norm(cross(b - a, c - a));
  }
  for (std::size_t p = 0; p < parts.size(); ++p) {
    std::size_t wrong = opposed[p];
    if (2 * wrong > parts[p].triangles.size()) {  // most triangles are opposite to the representative: reverse all
      wrong = parts[p].triangles.size() - wrong;
      for (Triangle& t : parts[p].triangles) std::swap(t[1], t[2]);
    }
    out.turned += wrong;
    parts[p].volume = enclosed_inertia(vertices, parts[p].triangles).mass;
  }
  if (out.turned > 0)
    out.report.push_back(out.turned == 1 ? "One triangle had the opposite orientation of its neighbours and was reversed."
                                         : std::to_string(out.turned) +
                                               " triangles had the opposite orientation of their neighbours and were reversed.");
  if (findings.flat_triangles > 0) out.report.push_back(std::to_string(findings.flat_triangles) + " triangles without area were removed.");
  if (findings.doubled_triangles > 0)
    out.report.push_back(std::to_string(findings.doubled_triangles) + " duplicate triangles were removed.");
  orient_outwards(parts, vertices, out);

  Inertia unit;
  for (const Part& part : parts) unit += enclosed_inertia(vertices, part.triangles);
  const Vec3 size = high - low;
  if (!(unit.mass > 1e-12 * size.x * size.y * size.z) || !(unit.mass > 0))
    return fail(ErrorCode::structure, at, "The surface encloses no volume.", "Use a closed surface with outward normals.");
  out.parts = parts.size();
  out.volume = unit.mass;
  out.density = options.mass > 0 ? options.mass / out.volume : options.density;
  const Inertia in_place = unit.in_parent({Mat3::identity(), middle});
  out.inertia = {in_place.mass * out.density, in_place.h * out.density, in_place.I * out.density};
  return out;
}

}  // namespace ugoki
