#include "ugoki/publish/shape_surface.h"

#include <algorithm>
#include <cmath>

#include "ugoki/spatial/elementary.h"

namespace ugoki::publish {
namespace {

constexpr int around = 24;  // vertices around a round shape: the triangles deviate by 1 - cos(pi / 24) = 0.86 % of the radius
constexpr int rings = 12;   // intervals between the rings of vertices from pole to pole

std::uint32_t index(std::size_t i) { return static_cast<std::uint32_t>(i); }

/// A point of the profile of a surface of revolution about z: radius, height, and the same components of the normal. A profile goes from
/// the lowest to the highest point. A point with radius 0 is a pole.
struct ProfilePoint {
  double r, z, nr, nz;
};
void revolve(const std::vector<ProfilePoint>& profile, Surface& out) {
  const std::size_t first = out.points.size();
  for (const ProfilePoint& p : profile)
    for (int k = 0; k <= around; ++k) {
      const SinCos a = sin_cos(2 * pi * (k % around) / around);
      out.points.push_back({p.r * a.cos, p.r * a.sin, p.z});
      out.normals.push_back({p.nr * a.cos, p.nr * a.sin, p.nz});
    }
  const std::size_t row = around + 1;
  for (std::size_t i = 0; i + 1 < profile.size(); ++i) {
    if (profile[i].r == profile[i + 1].r && profile[i].z == profile[i + 1].z) continue;  // an edge: the same circle with another normal
    for (std::size_t k = 0; k < around; ++k) {
      const std::size_t a = first + i * row + k, b = a + 1, c = a + row, d = c + 1;
      if (profile[i].r > 0) out.triangles.push_back({index(a), index(b), index(d)});
      if (profile[i + 1].r > 0) out.triangles.push_back({index(a), index(d), index(c)});
    }
  }
}

/// The profile of a sphere whose upper half is moved up by `gap` and whose lower half is moved down by `gap`.
std::vector<ProfilePoint> round_profile(double r, double gap) {
  std::vector<ProfilePoint> profile;
  for (int i = 0; i <= rings; ++i) {
    const SinCos a = sin_cos(pi * i / rings - pi / 2);  // latitude
    const double c = i == 0 || i == rings ? 0 : a.cos;
    if (gap > 0 && 2 * i == rings) profile.push_back({r, -gap, 1, 0});
    profile.push_back({r * c, r * a.sin + (2 * i >= rings ? gap : -gap), c, a.sin});
  }
  return profile;
}

/// Adds a triangle that shares no vertex with other triangles, with a flat normal.
void add_flat(const Vec3& a, const Vec3& b, const Vec3& c, Surface& out) {
  const Vec3 n = cross(b - a, c - a);
  const double length = norm(n);
  if (!(length > 0)) return;
  const std::size_t first = out.points.size();
  for (const Vec3& p : {a, b, c}) {
    out.points.push_back(p);
    out.normals.push_back(n / length);
  }
  out.triangles.push_back({index(first), index(first + 1), index(first + 2)});
}

void add_quad(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d, Surface& out) {
  add_flat(a, b, c, out);
  add_flat(a, c, d, out);
}

void add_box(const Vec3& h, Surface& out) {
  const auto corner = [&](int x, int y, int z) { return Vec3{x * h.x, y * h.y, z * h.z}; };
  add_quad(corner(1, -1, -1), corner(1, 1, -1), corner(1, 1, 1), corner(1, -1, 1), out);
  add_quad(corner(-1, 1, -1), corner(-1, -1, -1), corner(-1, -1, 1), corner(-1, 1, 1), out);
  add_quad(corner(1, 1, -1), corner(-1, 1, -1), corner(-1, 1, 1), corner(1, 1, 1), out);
  add_quad(corner(-1, -1, -1), corner(1, -1, -1), corner(1, -1, 1), corner(-1, -1, 1), out);
  add_quad(corner(-1, -1, 1), corner(1, -1, 1), corner(1, 1, 1), corner(-1, 1, 1), out);
  add_quad(corner(-1, 1, -1), corner(1, 1, -1), corner(1, -1, -1), corner(-1, -1, -1), out);
}

void add_field(const HeightField& f, Surface& out) {
  const auto at = [&](int c, int r) {
    return Vec3{
        f.half_x * (2.0 * c / (f.columns - 1) - 1), f.half_y * (2.0 * r / (f.rows - 1) - 1),
        static_cast<double>(f.heights[static_cast<std::size_t>(r) * static_cast<std::size_t>(f.columns) + static_cast<std::size_t>(c)])};
  };
  for (int r = 0; r + 1 < f.rows; ++r)
    for (int c = 0; c + 1 < f.columns; ++c) add_quad(at(c, r), at(c + 1, r), at(c + 1, r + 1), at(c, r + 1), out);
}

}  // namespace

void add_surface(const Shape& s, Surface& out) {
  const std::size_t first = out.points.size();
  switch (s.type) {
    case ShapeType::sphere: revolve(round_profile(s.radius, 0), out); break;
    case ShapeType::capsule: revolve(round_profile(s.radius, s.half_length), out); break;
    case ShapeType::cylinder: {
      const double r = s.radius, h = s.half_length;
      revolve({{0, -h, 0, -1}, {r, -h, 0, -1}, {r, -h, 1, 0}, {r, h, 1, 0}, {r, h, 0, 1}, {0, h, 0, 1}}, out);
      break;
    }
    case ShapeType::ellipsoid: {
      revolve(round_profile(1, 0), out);
      const Vec3 h = s.half_extents;
      for (std::size_t i = first; i < out.points.size(); ++i) {
        const Vec3 p = out.points[i];
        out.points[i] = {p.x * h.x, p.y * h.y, p.z * h.z};
        const Vec3 n = {p.x / std::max(h.x, 1e-9), p.y / std::max(h.y, 1e-9), p.z / std::max(h.z, 1e-9)};
        out.normals[i] = normalized(n);
      }
      break;
    }
    case ShapeType::box: add_box(s.half_extents, out); break;
    case ShapeType::mesh:
      if (s.geometry)
        for (const auto& t : s.geometry->triangles)
          add_flat(s.geometry->vertices[static_cast<std::size_t>(t[0])], s.geometry->vertices[static_cast<std::size_t>(t[1])],
                   s.geometry->vertices[static_cast<std::size_t>(t[2])], out);
      break;
    case ShapeType::height_field:
      if (s.field) add_field(*s.field, out);
      break;
  }
  for (std::size_t i = first; i < out.points.size(); ++i) {
    out.points[i] = s.X_BS.R * out.points[i] + s.X_BS.p;
    out.normals[i] = s.X_BS.R * out.normals[i];
  }
}

Surface link_surface(const Link& link) {
  Surface out;
  for (const Shape& s : link.shapes)
    if (s.visible) add_surface(s, out);
  return out;
}

}  // namespace ugoki::publish
