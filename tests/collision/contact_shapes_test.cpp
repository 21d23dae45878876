// Contacts of cylinders, ellipsoids, hulls, meshes and height fields.

#include <gtest/gtest.h>

#include <set>

#include "allocation_count.h"
#include "meshes.h"
#include "random_shapes.h"
#include "ugoki/base/hash.h"
#include "ugoki/collision/distance.h"
#include "ugoki/collision/pair_distance.h"
#include "ugoki/collision/scene.h"

namespace ugoki::collision {
namespace {

using test::Random;

Pose at(double x, double y, double z) { return {Mat3::identity(), {x, y, z}}; }

std::vector<Triangle> box_triangles() {
  return {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
          {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
}
std::vector<Vec3> box_corners(const Vec3& h) {
  std::vector<Vec3> p;
  for (int i = 0; i < 8; ++i) p.push_back({(i & 1) != 0 ? h.x : -h.x, (i & 2) != 0 ? h.y : -h.y, (i & 4) != 0 ? h.z : -h.z});
  return p;
}
Hull hull_of_box(const Vec3& h) {
  return assemble_hull(box_corners(h), {0, 4, 8, 12, 16, 20, 24}, {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5})
      .value();
}
/// A box as a hull with square faces.
Shape box_hull(const Vec3& h, const Pose& X = {}) {
  const GeometryPtr g = make_geometry(box_corners(h), box_triangles(), true, "box").value();
  return Shape::mesh(with_prepared(*g, make_prepared(*g, hull_of_box(h), {}, "box").value()), X);
}
/// The surface of a box, each face as n x n squares.
Shape box_surface(const Vec3& h, int n = 1, const Pose& X = {}) {
  std::vector<Vec3> p;
  std::vector<Triangle> t;
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-1.0, 1.0}) {
      const int u = (axis + 1) % 3, v = (axis + 2) % 3, first = static_cast<int>(p.size());
      for (int j = 0; j <= n; ++j)
        for (int i = 0; i <= n; ++i) {
          Vec3 q;
          q[axis] = side * h[axis];
          q[u] = h[u] * (2.0 * i / n - 1);
          q[v] = h[v] * (2.0 * j / n - 1);
          p.push_back(q);
        }
      for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
          const int a = first + j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
          if (side > 0)
            t.insert(t.end(), {{a, b, d}, {a, d, c}});
          else
            t.insert(t.end(), {{a, d, b}, {a, c, d}});
        }
    }
  const GeometryPtr g = make_geometry(p, t, false, "box").value();
  return Shape::mesh(with_prepared(*g, make_prepared(*g, hull_of_box(h), {}, "box").value()), X);
}
Shape plain(double half, int n, double height = 0) {
  HeightField f;
  f.columns = f.rows = n;
  f.half_x = f.half_y = half;
  f.base = 1;
  f.heights.assign(static_cast<std::size_t>(n * n), height);
  return Shape::height_field(make_height_field(std::move(f), "plain").value());
}

struct Pair {
  Collider a, b;
  GilbertCache cache;
  ManifoldWorkspace work;
  Manifold out;
  Pair(const Shape& s, const Shape& t) : a(make_collider(s)), b(make_collider(t)) {}
  const Manifold& find(const Pose& A, const Pose& B, double margin) {
    find_manifold(a, A * a.shape.X_BS, b, B * b.shape.X_BS, margin, cache, work, out);
    return out;
  }
};
std::span<const ManifoldPoint> points(const Manifold& m) { return {m.points.data(), static_cast<std::size_t>(m.count)}; }
double minimum(const Manifold& m) {
  double d = 1e300;
  for (const ManifoldPoint& p : points(m)) d = std::min(d, p.distance);
  return d;
}
/// True if the polygon of the contact points, seen from above, contains the origin: the contacts can carry a weight above the origin.
bool carries(const Manifold& m, double margin = 1e-6) {
  for (int i = 0; i < 64; ++i) {
    const double angle = 2 * pi * i / 64;
    double maximum = -1e300;
    for (const ManifoldPoint& p : points(m)) maximum = std::max(maximum, p.p.x * std::cos(angle) + p.p.y * std::sin(angle));
    if (maximum < margin) return false;
  }
  return true;
}

Shape random_convex(Random& r, int kind) {
  const auto size = [&] { return r.in(0.05, 0.5); };
  switch (kind) {
    case 0: return r.shape(ShapeType::sphere);
    case 1: return r.shape(ShapeType::capsule);
    case 2: return r.shape(ShapeType::box);
    case 3: return Shape::cylinder(size(), size(), r.pose(0.2));
    case 4: return Shape::ellipsoid({size(), size(), size()}, r.pose(0.2));
    default: return box_hull({size(), size(), size()}, r.pose(0.2));
  }
}

TEST(ContactShapes, MinimumDistanceOfConvexPairsMatchesSignedDistance) {
  Random r(71);
  int found = 0, lying = 0;
  for (int i = 0; i < 6000 && !testing::Test::HasFailure(); ++i) {
    const int ka = r.below(6), kb = r.below(6);
    if (ka < 3 && kb < 3) continue;
    Pair pair(random_convex(r, ka), random_convex(r, kb));
    const Pose A = r.pose(0.6), B = r.pose(0.6);
    const double margin = r.in(0.01, 0.3);
    GilbertCache cache;
    PenetrationWorkspace work;
    const SignedDistance d = signed_distance(pair.a.support, A * pair.a.shape.X_BS, pair.b.support, B * pair.b.shape.X_BS, cache, work);
    const Manifold& m = pair.find(A, B, margin);
    const double bias = 1e-4 * std::min(pair.a.thickness, pair.b.thickness);
    SCOPED_TRACE(testing::Message() << "case " << i << " kinds " << ka << " " << kb << " distance " << d.distance);
    if (d.upper < margin - bias - 1e-9) {
      ASSERT_GT(m.count, 0);
      EXPECT_NEAR(minimum(m), d.distance, bias + 1e-8);
      ++found;
      lying += m.count > 1 ? 1 : 0;
    } else if (d.lower > margin + 1e-9) {
      EXPECT_EQ(m.count, 0);
    }
    std::set<std::uint32_t> features;
    for (const ManifoldPoint& p : points(m)) {
      EXPECT_NEAR(norm(p.n), 1, 1e-9);
      EXPECT_LT(p.distance, margin);
      EXPECT_LT(p.feature, 1U << 24);
      EXPECT_TRUE(features.insert(p.feature).second);
      EXPECT_GE(p.distance, d.lower - bias - 1e-8);
    }
  }
  EXPECT_GT(found, 1500);
  EXPECT_GT(lying, 100);
}

TEST(ContactShapes, BoxHullHasTheManifoldOfABox) {
  Random r(73);
  int several = 0;
  for (int i = 0; i < 4000 && !testing::Test::HasFailure(); ++i) {
    const Vec3 h{r.in(0.1, 0.3), r.in(0.1, 0.3), r.in(0.1, 0.3)}, k{r.in(0.6, 0.9), r.in(0.6, 0.9), r.in(0.1, 0.5)};
    // One box rests on the other, turned and slightly tilted.
    const Pose A{rotation_about({0, 0, 1}, r.in(-pi, pi)) * rotation_about(r.unit(), i % 4 == 0 ? 0.0 : r.in(0.002, 0.02)),
                 {r.in(-0.1, 0.1), r.in(-0.1, 0.1), h.z + k.z + r.in(-0.004, 0.004)}};
    Pair boxes(Shape::box(h), Shape::box(k)), hulls(box_hull(h), box_hull(k)), mixed(box_hull(h), Shape::box(k));
    const Manifold m = boxes.find(A, {}, 0.02);
    for (Pair* other : {&hulls, &mixed}) {
      const Manifold& o = other->find(A, {}, 0.02);
      SCOPED_TRACE(testing::Message() << "case " << i);
      ASSERT_EQ(m.count, o.count);
      for (const ManifoldPoint& p : points(m)) {
        const auto same = [&](const ManifoldPoint& q) {
          return norm(p.p - q.p) < 1e-6 && norm(p.n - q.n) < 1e-6 && std::fabs(p.distance - q.distance) < 1e-7;
        };
        EXPECT_TRUE(std::any_of(points(o).begin(), points(o).end(), same)) << p.p.x << " " << p.p.y << " " << p.distance;
      }
      several += o.count > 2 ? 1 : 0;
    }
  }
  EXPECT_GT(several, 2000);
}

TEST(ContactShapes, EveryShapeRestsOnEveryOther) {
  const double z = 0.2;
  const Shape upper[] = {Shape::cylinder(0.3, z), box_hull({0.3, 0.25, z}), box_surface({0.3, 0.25, z}), box_surface({0.3, 0.25, z}, 5),
                         Shape::box({0.3, 0.25, z})};
  const Shape lower[] = {Shape::cylinder(1, 0.5, at(0, 0, -0.5)),
                         box_hull({1, 1, 0.5}, at(0, 0, -0.5)),
                         box_surface({1, 1, 0.5}, 1, at(0, 0, -0.5)),
                         box_surface({1, 1, 0.5}, 8, at(0, 0, -0.5)),
                         Shape::box({1, 1, 0.5}, at(0, 0, -0.5)),
                         plain(1, 2),
                         plain(1, 30)};
  for (const Shape& a : upper)
    for (const Shape& b : lower) {
      if (is_simple(a.type) && is_simple(b.type)) continue;
      for (const double gap : {-0.002, 0.0, 0.003})
        for (const double turn : {0.0, 0.3})
          for (const bool exchanged : {false, true}) {
            Pair pair(exchanged ? b : a, exchanged ? a : b);
            const Pose X{rotation_about({0, 0, 1}, turn), {0.013, 0.021, z + gap}};
            const Manifold& m = exchanged ? pair.find({}, X, 0.01) : pair.find(X, {}, 0.01);
            SCOPED_TRACE(testing::Message() << int(a.type) << " on " << int(b.type) << (b.geometry ? b.geometry->triangles.size() : 0)
                                            << " gap " << gap << " turn " << turn << " exchanged " << exchanged << " points " << m.count);
            EXPECT_GE(m.count, 3);
            EXPECT_LE(m.count, 16);
            EXPECT_TRUE(carries(m, 0.15));
            EXPECT_NEAR(minimum(m), gap, 1e-6);
            for (const ManifoldPoint& p : points(m)) {
              EXPECT_LT(norm(p.n - Vec3{0, 0, exchanged ? -1.0 : 1.0}), 1e-6);
              EXPECT_NEAR(p.distance, gap, 1e-6);
              EXPECT_NEAR(p.p.z, 0.5 * gap, 1e-6);
            }
          }
    }
}

TEST(ContactShapes, RoundShapesTouchSurfacesAtTheirLowestPoint) {
  for (const Shape& b : {box_surface({1, 1, 0.5}, 8, at(0, 0, -0.5)), plain(1, 30), box_surface({1, 1, 0.5}, 1, at(0, 0, -0.5))})
    for (const Shape& a : {Shape::sphere(0.2), Shape::ellipsoid({0.3, 0.25, 0.2})})
      for (const double gap : {-0.004, 0.005})
        for (const double x : {0.0, 0.0345, 0.123, 1.0 / 8}) {
          Pair pair(a, b);
          const Manifold& m = pair.find(at(x, 0.07, 0.2 + gap), {}, 0.01);
          SCOPED_TRACE(testing::Message() << int(a.type) << " on " << int(b.type) << " at " << x << " gap " << gap);
          ASSERT_GE(m.count, 1);
          EXPECT_NEAR(minimum(m), gap, 1e-7);
          for (const ManifoldPoint& p : points(m)) {
            EXPECT_LT(norm(p.n - Vec3{0, 0, 1}), 0.05);
            EXPECT_LT(std::hypot(p.p.x - x, p.p.y - 0.07), 0.08);
          }
        }
}

TEST(ContactShapes, CoplanarTrianglesGiveNoEdgeContacts) {
  for (const Shape& b : {box_surface({1, 1, 0.5}, 8, at(0, 0, -0.5)), plain(1, 17)})
    for (const Shape& a : {Shape::box({0.1, 0.1, 0.05}), Shape::cylinder(0.1, 0.05), box_hull({0.1, 0.1, 0.05}),
                           Shape::capsule(0.05, {-0.1, 0, 0}, {0.1, 0, 0}), Shape::sphere(0.05)}) {
      Pair pair(a, b);
      for (int i = 0; i < 400; ++i) {
        const Manifold& m = pair.find(at(-0.6 + 0.003 * i, 0.02, 0.05 - 0.0007), {}, 0.02);
        ASSERT_GE(m.count, 1) << i;
        for (const ManifoldPoint& p : points(m))
          ASSERT_GT(p.n.z, 0.999) << "shape " << int(a.type) << " step " << i << " distance " << p.distance;
      }
    }
}

TEST(ContactShapes, HoleOfAMeshIsFreeOfContacts) {
  // Four walls around a shaft of 0.4 m x 0.4 m.
  std::vector<Vec3> p;
  std::vector<Triangle> t;
  const double in = 0.2, wide = 0.5;
  const double xy[8][2] = {{-wide, -wide}, {wide, -wide}, {wide, wide}, {-wide, wide}, {-in, -in}, {in, -in}, {in, in}, {-in, in}};
  for (const double z : {-0.3, 0.3})
    for (const auto& q : xy) p.push_back({q[0], q[1], z});
  for (int i = 0; i < 4; ++i) {
    const int j = (i + 1) % 4;
    t.insert(t.end(), {{i, j, 8 + j}, {i, 8 + j, 8 + i}});                                                   // outer faces
    t.insert(t.end(), {{4 + i, 12 + j, 4 + j}, {4 + i, 12 + i, 12 + j}});                                    // inner faces
    t.insert(t.end(), {{8 + i, 8 + j, 12 + j}, {8 + i, 12 + j, 12 + i}, {i, 4 + j, j}, {i, 4 + i, 4 + j}});  // top and bottom
  }
  const GeometryPtr g = make_geometry(p, t, false, "frame").value();
  ASSERT_GT(g->solid.mass, 0);
  EXPECT_NEAR(g->solid.mass, (1.0 - 0.16) * 0.6, 1e-12);
  Pair pair(Shape::cylinder(0.15, 0.1), Shape::mesh(g));
  EXPECT_EQ(pair.find({}, {}, 0.01).count, 0);
  const Manifold& wall = pair.find(at(0.055, 0, 0), {}, 0.01);
  ASSERT_GE(wall.count, 1);
  EXPECT_NEAR(minimum(wall), -0.005, 1e-6);
  for (const ManifoldPoint& q : points(wall)) EXPECT_LT(norm(q.n - Vec3{-1, 0, 0}), 1e-6);
}

/// A body touches a curved mesh at a random point, which may be on the side or corner of a triangle. The body is then moved slightly
/// outwards or inwards.
TEST(ContactShapes, ClosestPointOfACurvedMeshIsAContact) {
  Random random(11);
  const test::Mesh torus = test::bumpy_torus(1500);
  const Collider mesh = make_collider(Shape::mesh(make_geometry(torus.vertices, torus.triangles, false, "torus").value()));
  ManifoldWorkspace workspace;
  DistanceWorkspace distances;
  for (int i = 0; i < 3000; ++i) {
    const double r = random.in(0.02, 0.2);
    const Shape shapes[] = {Shape::sphere(r),
                            Shape::box({r, 0.5 * r, 1.5 * r}),
                            Shape::capsule(0.5 * r, {0, 0, -r}, {0, 0, r}),
                            Shape::cylinder(r, 0.5 * r),
                            Shape::ellipsoid({r, 0.6 * r, 0.8 * r}),
                            box_hull({r, 0.7 * r, 0.4 * r})};
    const Collider body = make_collider(shapes[i % 6]);
    const Vec3 direction = random.unit();
    Pose X{random.pose(1).R, random.vec(0.5) - direction * 3};
    PairCache cache;
    const double farthest = 1e9;
    double distance = 1;
    for (int k = 0; k < 200 && distance > 1e-6; ++k) {  // move the body until it touches the mesh
      distance = find_pair_distance(body, X, mesh, Pose{}, farthest, cache, distances).distance;
      X.p += direction * distance;
    }
    if (distance > 1e-6) continue;  // the body misses the mesh
    const double in = r * random.in(-0.05, 0.02);
    X.p += direction * in;
    distance = find_pair_distance(body, X, mesh, Pose{}, farthest, cache, distances).distance;
    GilbertCache gilbert;
    Manifold found;
    find_manifold(body, X, mesh, Pose{}, 0.1, gilbert, workspace, found);
    double minimum = 1e9;
    for (int k = 0; k < found.count; ++k) minimum = std::min(minimum, found.points[static_cast<std::size_t>(k)].distance);
    if (distance > 1e-9)
      ASSERT_NEAR(minimum, distance, 1e-4 * r) << "case " << i << ", shape " << i % 6;
    else
      ASSERT_LE(minimum, 1e-9) << "case " << i << ", shape " << i % 6;
  }
}

TEST(ContactShapes, GroundContactsHaveKnownDistances) {
  struct Case {
    Shape shape;
    Pose X;
    double distance;
    int min_points;
  };
  const Pose tilted{rotation_about({1, 0, 0}, 0.3), {0, 0, 1}};
  const Case cases[] = {
      {Shape::cylinder(0.3, 0.2), at(0, 0, 0.2), 0, 4},
      {Shape::cylinder(0.3, 0.2), {rotation_about({1, 0, 0}, pi / 2), {0, 0, 0.3}}, 0, 2},
      {Shape::cylinder(0.3, 0.2), tilted, 1 - 0.3 * std::sin(0.3) - 0.2 * std::cos(0.3), 1},
      {Shape::ellipsoid({0.1, 0.2, 0.3}), {rotation_about({1, 0, 0}, pi / 2), {0, 0, 0.2}}, 0, 1},
      {box_hull({0.3, 0.2, 0.1}), at(0, 0, 0.1), 0, 4},
      {box_surface({0.3, 0.2, 0.1}, 4), at(0, 0, 0.1), 0, 4},
      {plain(1, 5, 0.3), at(0, 0, 1.001), 0.001, 4},
  };
  for (const Case& c : cases) {
    const Collider a = make_collider(c.shape);
    ManifoldWorkspace work;
    Manifold m;
    std::int32_t hint = 0;
    find_ground_manifold(a, c.X * c.shape.X_BS, 0.0, c.distance + 0.01, hint, work, m);
    SCOPED_TRACE(testing::Message() << int(c.shape.type));
    EXPECT_GE(m.count, c.min_points);
    EXPECT_NEAR(minimum(m), c.distance, 1e-9);
    EXPECT_NEAR(distance_to_ground(c.shape, c.X, 0), c.distance, 1e-9);
    if (c.min_points >= 4) {
      EXPECT_TRUE(carries(m));
    }
  }
}

TEST(ContactShapes, CoherentStepsAllocateNothingAndAreReproducible) {
  std::vector<MechanismPtr> systems;
  const Shape shapes[] = {Shape::cylinder(0.2, 0.3),
                          Shape::ellipsoid({0.2, 0.3, 0.25}),
                          box_hull({0.2, 0.2, 0.3}),
                          box_surface({0.25, 0.2, 0.3}, 3),
                          plain(3, 40),
                          Shape::capsule(0.1, {0, 0, -0.2}, {0, 0, 0.2})};
  for (const Shape& s : shapes) {
    MechanismSpec spec;
    spec.name = "one";
    LinkSpec link;
    link.name = "body";
    link.joint.type = JointType::floating;
    link.inertia = Inertia::from_centre(1, {}, {1, 1, 1, 0, 0, 0});
    link.shapes = {s};
    spec.links.push_back(link);
    systems.push_back(Mechanism::make(std::move(spec)).value());
  }
  const Scene scene(systems, {.height = -0.3});
  const auto run = [&](bool count) {
    Workspace work(scene);
    std::vector<ContactPoint> out;
    std::vector<Pose> X(systems.size());
    std::vector<std::span<const Pose>> spans;
    for (const Pose& p : X) spans.emplace_back(&p, 1);
    Hash64 hash;
    std::size_t contacts = 0;
    for (int step = 0; step < 300; ++step) {
      for (std::size_t i = 0; i < X.size(); ++i) {
        const double s = 0.01 * (step % 150), k = static_cast<double>(i);
        X[i] = {rotation_about(normalized(Vec3{1, k, 2}), s), {0.3 * k + 0.1 * s, 0.05 * k, i == 4 ? -0.2 : 0.1 * s}};
      }
      const auto before = allocations_so_far();
      find_contacts(scene, spans, 0.02, work, out);
      if (count && step >= 150) EXPECT_EQ(allocations_so_far(), before) << step;
      contacts += out.size();
      for (const ContactPoint& c : out) {
        hash.add(c.p.x);
        hash.add(c.distance);
        hash.add(c.n.z);
        hash.add(c.key);
      }
    }
    EXPECT_GT(contacts, 300U);
    return hash.value();
  };
  EXPECT_EQ(run(true), run(false));
}

}  // namespace
}  // namespace ugoki::collision
