#include "ugoki/mechanism/shape.h"

#include <algorithm>

namespace ugoki {
namespace {

/// Inertia of a height field at density 1 kg/m^3, in the field's frame: the sum of one prism for each triangle of the surface.
Inertia field_inertia(const HeightField& f) {
  Inertia sum;
  const auto prism = [&](const Vec3& a, const Vec3& b, const Vec3& c) {
    const auto down = [&](const Vec3& p) { return Vec3{p.x, p.y, -f.base}; };
    const Vec3 corners[6] = {a, b, c, down(a), down(b), down(c)};
    constexpr Triangle faces[8] = {{0, 1, 2}, {3, 5, 4}, {0, 3, 4}, {0, 4, 1}, {1, 4, 5}, {1, 5, 2}, {2, 5, 3}, {2, 3, 0}};
    sum += enclosed_inertia(corners, faces);
  };
  for (int row = 0; row + 1 < f.rows; ++row)
    for (int column = 0; column + 1 < f.columns; ++column) {
      const Vec3 a = f.point(column, row), b = f.point(column + 1, row), c = f.point(column + 1, row + 1), d = f.point(column, row + 1);
      prism(a, b, c);
      prism(a, c, d);
    }
  return sum;
}

/// Rotational inertia of a sphere, capsule, box, cylinder or ellipsoid about its centre [kg m^2], in the shape's axes.
Sym3 about_origin(const Shape& s, double density) {
  const double mass = density * volume(s), r = s.radius, L = 2 * s.half_length;
  const Vec3 h = s.half_extents;
  switch (s.type) {
    case ShapeType::sphere: {
      const double i = 0.4 * mass * r * r;
      return {i, i, i, 0, 0, 0};
    }
    case ShapeType::capsule: {  // cylinder of length L and two hemispheres
      const double m_cylinder = density * pi * r * r * L;
      const double m_balls = density * 4.0 / 3.0 * pi * r * r * r;
      const double along = m_cylinder * 0.5 * r * r + m_balls * 0.4 * r * r;
      const double across = m_cylinder * (L * L / 12.0 + r * r / 4.0) + m_balls * (0.4 * r * r + L * L / 4.0 + 0.375 * L * r);
      return {across, across, along, 0, 0, 0};
    }
    case ShapeType::box:
      return {mass / 3 * (h.y * h.y + h.z * h.z), mass / 3 * (h.x * h.x + h.z * h.z), mass / 3 * (h.x * h.x + h.y * h.y), 0, 0, 0};
    case ShapeType::cylinder: {
      const double across = mass * (r * r / 4 + L * L / 12);
      return {across, across, mass * r * r / 2, 0, 0, 0};
    }
    case ShapeType::ellipsoid:
      return {mass / 5 * (h.y * h.y + h.z * h.z), mass / 5 * (h.x * h.x + h.z * h.z), mass / 5 * (h.x * h.x + h.y * h.y), 0, 0, 0};
    case ShapeType::mesh:
    case ShapeType::height_field: break;
  }
  return {};
}

}  // namespace

std::string_view name_of(ShapeType type) {
  switch (type) {
    case ShapeType::sphere: return "sphere";
    case ShapeType::capsule: return "capsule";
    case ShapeType::box: return "box";
    case ShapeType::cylinder: return "cylinder";
    case ShapeType::ellipsoid: return "ellipsoid";
    case ShapeType::mesh: return "mesh";
    case ShapeType::height_field: return "height_field";
  }
  return "sphere";
}

double reach(const Shape& s, const Vec3& d) {
  const Vec3 h = s.half_extents;
  switch (s.type) {
    case ShapeType::sphere: return s.radius;
    case ShapeType::capsule: return s.radius + s.half_length * std::fabs(d.z);
    case ShapeType::box: return h.x * std::fabs(d.x) + h.y * std::fabs(d.y) + h.z * std::fabs(d.z);
    case ShapeType::cylinder: return s.radius * std::sqrt(d.x * d.x + d.y * d.y) + s.half_length * std::fabs(d.z);
    case ShapeType::ellipsoid: return norm(Vec3{h.x * d.x, h.y * d.y, h.z * d.z});
    case ShapeType::mesh: {
      double maximum = -1e300;
      for (const Vec3& p : s.geometry->vertices) maximum = std::max(maximum, dot(p, d));
      return maximum;
    }
    case ShapeType::height_field: {
      const HeightField& f = *s.field;
      double maximum = -1e300;
      for (int row = 0; row < f.rows; ++row)
        for (int column = 0; column < f.columns; ++column) maximum = std::max(maximum, dot(f.point(column, row), d));
      const Vec3 below{f.half_x, f.half_y, f.base};
      return std::max(maximum, below.x * std::fabs(d.x) + below.y * std::fabs(d.y) - below.z * d.z);
    }
  }
  return 0;
}

Bounds bounds(const Shape& s) {
  switch (s.type) {
    case ShapeType::mesh: {
      Bounds out{s.geometry->vertices.front(), s.geometry->vertices.front()};
      for (const Vec3& p : s.geometry->vertices)
        for (int i = 0; i < 3; ++i) {
          out.low[i] = std::min(out.low[i], p[i]);
          out.high[i] = std::max(out.high[i], p[i]);
        }
      return out;
    }
    case ShapeType::height_field:
      return {{-s.field->half_x, -s.field->half_y, -s.field->base}, {s.field->half_x, s.field->half_y, s.field->highest}};
    default: {
      const Vec3 h{reach(s, {1, 0, 0}), reach(s, {0, 1, 0}), reach(s, {0, 0, 1})};
      return {-h, h};
    }
  }
}

bool can_collide(const Shape& a, const Shape& b) {
  return a.collides && b.collides && ((a.groups & b.partners) != 0 || (b.groups & a.partners) != 0);
}

double pair_friction(const Shape& a, const Shape& b) { return a.smooth && b.smooth ? 0 : std::sqrt(a.friction * b.friction); }

double volume(const Shape& s) {
  switch (s.type) {
    case ShapeType::sphere: return 4.0 / 3.0 * pi * s.radius * s.radius * s.radius;
    case ShapeType::capsule: return pi * s.radius * s.radius * (4.0 / 3.0 * s.radius + 2.0 * s.half_length);
    case ShapeType::box: return 8.0 * s.half_extents.x * s.half_extents.y * s.half_extents.z;
    case ShapeType::cylinder: return pi * s.radius * s.radius * 2.0 * s.half_length;
    case ShapeType::ellipsoid: return 4.0 / 3.0 * pi * s.half_extents.x * s.half_extents.y * s.half_extents.z;
    case ShapeType::mesh: return s.geometry->solid.mass;
    case ShapeType::height_field: return field_inertia(*s.field).mass;
  }
  return 0;
}

Inertia solid_inertia(const Shape& s, double density) {
  if (s.type == ShapeType::mesh || s.type == ShapeType::height_field) {
    const Inertia unit = s.type == ShapeType::mesh ? s.geometry->solid : field_inertia(*s.field);
    return Inertia{unit.mass * density, unit.h * density, unit.I * density}.in_parent(s.X_BS);
  }
  return Inertia::from_centre(density * volume(s), s.X_BS.p, rotated(about_origin(s, density), s.X_BS.R));
}

}  // namespace ugoki
