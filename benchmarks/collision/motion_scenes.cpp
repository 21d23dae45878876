#include "motion_scenes.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>

#include "ugoki/geometry/make_hull.h"
#include "ugoki/mechanism/geometry.h"

namespace ugoki::benchmarks {
namespace {

constexpr int steps_of_a_round = 360;

/// Number of steps, limited so that all poses fit into a core's cache. The bodies move back and forth on a part of the circular path.
int steps_for(int bodies) { return std::clamp(8000 / bodies, 20, steps_of_a_round); }
int forth_and_back(int step, int steps) { return steps == steps_of_a_round || 2 * step < steps ? step : steps - step; }

struct Bone {
  int parent;
  Vec3 joint;    ///< m, position of the joint in the parent's frame
  Vec3 half;     ///< m, half extents of the link
  Vec3 centre;   ///< m, centre of the link's shape in the link's frame
  int rounds;    ///< number of oscillations of the joint while the character walks once around the circle
  double angle;  ///< rad, amplitude of the oscillations
};

/// Bones of a character: height 1.8 m, z up, facing x; the last link is a stick in the right hand.
std::vector<Bone> bones() {
  std::vector<Bone> b{{-1, {0, 0, 1.0}, {0.12, 0.17, 0.10}, {0, 0, 0}, 1, 0.1},
                      {0, {0, 0, 0.10}, {0.11, 0.14, 0.10}, {0, 0, 0.1}, 1, 0.2},
                      {1, {0, 0, 0.20}, {0.13, 0.18, 0.14}, {0, 0, 0.14}, 2, 0.2},
                      {2, {0, 0, 0.28}, {0.06, 0.06, 0.05}, {0, 0, 0.05}, 1, 0.2},
                      {3, {0, 0, 0.09}, {0.10, 0.08, 0.12}, {0, 0, 0.12}, 2, 0.3}};
  for (const double side : {1.0, -1.0}) {
    const int first = static_cast<int>(b.size());
    b.push_back({2, {0, side * 0.05, 0.22}, {0.05, 0.09, 0.05}, {0, side * 0.09, 0}, 1, 0.2});
    b.push_back({first, {0, side * 0.17, 0}, {0.05, 0.05, 0.15}, {0, 0, -0.15}, 2, 0.7});
    b.push_back({first + 1, {0, 0, -0.30}, {0.04, 0.04, 0.13}, {0, 0, -0.13}, 3, 0.6});
    b.push_back({first + 2, {0, 0, -0.26}, {0.02, 0.05, 0.10}, {0, 0, -0.10}, 2, 0.4});
  }
  for (const double side : {1.0, -1.0}) {
    const int first = static_cast<int>(b.size());
    b.push_back({0, {0, side * 0.10, -0.05}, {0.08, 0.08, 0.21}, {0, 0, -0.21}, 2, 0.6});
    b.push_back({first, {0, 0, -0.43}, {0.06, 0.06, 0.21}, {0, 0, -0.21}, 2, 0.5});
    b.push_back({first + 1, {0, 0, -0.43}, {0.13, 0.05, 0.04}, {0.06, 0, -0.03}, 3, 0.3});
  }
  b.push_back({12, {0, 0, -0.12}, {0.25, 0.015, 0.015}, {0.2, 0, 0}, 1, 0.3});
  return b;
}

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double in(double low, double high) { return low + (high - low) * (static_cast<double>(engine_() >> 11) * 0x1p-53); }
  Vec3 vec(double size) {
    const double x = in(-size, size), y = in(-size, size), z = in(-size, size);
    return {x, y, z};
  }
  Vec3 unit() {
    for (;;) {
      const Vec3 v = vec(1);
      if (norm(v) > 0.1 && norm(v) < 1) return v / norm(v);
    }
  }

 private:
  std::mt19937_64 engine_;
};

/// Adds a body: the hull of 32 random points on a surface between an ellipsoid and a box.
void add_hull(Motion& motion, const Vec3& half, const Vec3& centre, Random& random) {
  std::vector<Vec3> points;
  for (int i = 0; i < 32; ++i) {
    Vec3 u = random.unit();
    for (int k = 0; k < 3; ++k) u[k] = (u[k] < 0 ? -1 : 1) * std::sqrt(std::fabs(u[k])) * half[k];
    points.push_back(centre + u);
  }
  const auto hull = geometry::make_hull(points);
  if (!hull) throw std::runtime_error("the hull could not be made");
  PlainBody plain;
  for (const Vec3& v : hull->vertices) plain.vertices.insert(plain.vertices.end(), {v.x, v.y, v.z});
  std::vector<Triangle> triangles;
  for (int f = 0; f < hull->faces(); ++f) {
    const auto face = hull->face(f);
    plain.faces.emplace_back(face.begin(), face.end());
    for (std::size_t i = 2; i < face.size(); ++i) triangles.push_back({face[0], face[i - 1], face[i]});
  }
  motion.plain.bodies.push_back(std::move(plain));
  const auto surface = make_geometry(hull->vertices, triangles, true, "link");
  if (!surface) throw std::runtime_error("the geometry could not be made");
  motion.colliders.push_back(collision::make_collider(Shape::mesh(*surface)));
}

void finish(Motion& motion, int steps) {
  motion.plain.steps = steps;
  for (const Pose& X : motion.poses) {
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) motion.plain.rotations.push_back(X.R.row(i)[j]);
    motion.plain.translations.insert(motion.plain.translations.end(), {X.p.x, X.p.y, X.p.z});
  }
}

}  // namespace

Motion make_characters(int characters) {
  Motion out;
  Random random(4);
  const std::vector<Bone> skeleton = bones();
  std::vector<Vec3> axes;
  std::vector<double> phases;
  for (int f = 0; f < 2 * characters; ++f)
    for (const Bone& b : skeleton) {
      add_hull(out, b.half, b.centre, random);
      out.groups.push_back(f < characters ? 0 : 1);
      axes.push_back(random.unit());
      phases.push_back(random.in(-pi, pi));
    }
  out.plain.first_of_b = characters * static_cast<int>(skeleton.size());
  const int steps = steps_for(static_cast<int>(out.groups.size()));
  for (int step = 0; step < steps; ++step) {
    const double t = 2 * pi * forth_and_back(step, steps) / steps_of_a_round;
    std::size_t k = 0;
    for (int f = 0; f < 2 * characters; ++f) {
      const double side = f < characters ? -1 : 1, row = f % characters;
      const SinCos round = sin_cos(t + phases[k]);
      const std::size_t first = out.poses.size();
      for (const Bone& b : skeleton) {
        Pose X{rotation_about(axes[k], b.angle * sin_cos(b.rounds * t + phases[k]).sin), b.joint};
        if (b.parent >= 0)
          X = out.poses[first + static_cast<std::size_t>(b.parent)] * X;
        else
          X = Pose{rotation_about({0, 0, 1}, side > 0 ? pi : 0.0), {side * 0.72 + 0.2 * round.cos, 2.4 * row + 0.2 * round.sin, 0}} * X;
        out.poses.push_back(X);
        ++k;
      }
    }
  }
  finish(out, steps);
  return out;
}

Motion make_swarm(int bodies) {
  Motion out;
  Random random(9);
  const double side = 0.55 * std::cbrt(static_cast<double>(bodies));
  struct Path {
    Vec3 middle, across, along, axis;
    double phase, angle;
  };
  std::vector<Path> paths;
  for (int i = 0; i < bodies; ++i) {
    const double radius = random.in(0.04, 0.12), half = random.in(0.05, 0.25);
    out.colliders.push_back(collision::make_collider(Shape::capsule(radius, {0, 0, -half}, {0, 0, half})));
    out.plain.bodies.push_back({{}, {}, radius, half});
    out.groups.push_back(i);
    const Vec3 middle = random.vec(0.5 * side), across = random.vec(0.5), along = random.vec(0.5), axis = random.unit();
    const double phase = random.in(-pi, pi), angle = random.in(-pi, pi);
    paths.push_back({middle, across, along, axis, phase, angle});
  }
  out.plain.first_of_b = bodies;
  const int steps = steps_for(bodies);
  for (int step = 0; step < steps; ++step) {
    for (const Path& p : paths) {
      const SinCos t = sin_cos(2 * pi * forth_and_back(step, steps) / steps_of_a_round + p.phase);
      out.poses.push_back({rotation_about(p.axis, p.angle + t.sin), p.middle + p.across * t.cos + p.along * t.sin});
    }
  }
  finish(out, steps);
  return out;
}

}  // namespace ugoki::benchmarks
