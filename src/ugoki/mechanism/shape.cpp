#include "ugoki/mechanism/shape.h"

namespace ugoki {

double volume(const Shape& s) {
  switch (s.type) {
    case ShapeType::sphere: return 4.0 / 3.0 * pi * s.radius * s.radius * s.radius;
    case ShapeType::capsule: return pi * s.radius * s.radius * (4.0 / 3.0 * s.radius + 2.0 * s.half_length);
    case ShapeType::box: return 8.0 * s.half_extents.x * s.half_extents.y * s.half_extents.z;
  }
  return 0;
}

Inertia solid_inertia(const Shape& s, double density) {
  const double mass = density * volume(s);
  Sym3 about_centre;
  switch (s.type) {
    case ShapeType::sphere: {
      const double i = 0.4 * mass * s.radius * s.radius;
      about_centre = {i, i, i, 0, 0, 0};
      break;
    }
    case ShapeType::capsule: {
      // cylinder of length L and two half balls
      const double r = s.radius, L = 2 * s.half_length;
      const double m_cylinder = density * pi * r * r * L;
      const double m_balls = density * 4.0 / 3.0 * pi * r * r * r;
      const double along = m_cylinder * 0.5 * r * r + m_balls * 0.4 * r * r;
      const double across = m_cylinder * (L * L / 12.0 + r * r / 4.0) + m_balls * (0.4 * r * r + L * L / 4.0 + 0.375 * L * r);
      about_centre = {across, across, along, 0, 0, 0};
      break;
    }
    case ShapeType::box: {
      const Vec3 h = s.half_extents;
      about_centre = {mass / 3 * (h.y * h.y + h.z * h.z), mass / 3 * (h.x * h.x + h.z * h.z), mass / 3 * (h.x * h.x + h.y * h.y), 0, 0, 0};
      break;
    }
  }
  return Inertia::from_centre(mass, s.X_BS.p, rotated(about_centre, s.X_BS.R));
}

}  // namespace ugoki
