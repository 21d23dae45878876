// Meshes and height fields: cleaning of the input, refused input, volume and inertia.

#include "ugoki/mechanism/geometry.h"

#include <gtest/gtest.h>

#include <limits>

#include "ugoki/mechanism/shape.h"

namespace ugoki {
namespace {

std::vector<Vec3> box_points(const Vec3& h, const Vec3& c = {}) {
  std::vector<Vec3> p;
  for (int i = 0; i < 8; ++i) p.push_back(c + Vec3{(i & 1) != 0 ? h.x : -h.x, (i & 2) != 0 ? h.y : -h.y, (i & 4) != 0 ? h.z : -h.z});
  return p;
}
std::vector<Triangle> box_triangles() {
  return {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
          {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
}
void expect_same(const Inertia& a, const Inertia& b, double tolerance) {
  EXPECT_NEAR(a.mass, b.mass, tolerance);
  EXPECT_LT(norm(a.h - b.h), tolerance);
  const Sym3 d = a.I - b.I;
  for (const double x : {d.xx, d.yy, d.zz, d.xy, d.xz, d.yz}) EXPECT_NEAR(x, 0, tolerance);
}

TEST(Geometry, ClosedMeshHasTheInertiaOfTheBox) {
  const Vec3 h{0.3, 0.2, 0.1};
  const Pose X{rotation_about(normalized(Vec3{1, 2, 3}), 0.7), {0.5, -0.2, 0.1}};
  const Shape mesh = Shape::mesh(make_geometry(box_points(h), box_triangles(), false, "box").value(), X);
  EXPECT_NEAR(volume(mesh), 8 * 0.3 * 0.2 * 0.1, 1e-15);
  expect_same(solid_inertia(mesh, 700), solid_inertia(Shape::box(h, X), 700), 1e-12);
  // Vertices far from the shape's origin must not cost accuracy.
  const Shape far =
      Shape::mesh(make_geometry(box_points(h, {1000, 0, 0}), box_triangles(), false, "box").value(), {Mat3::identity(), {-1000, 0, 0}});
  EXPECT_LT(norm(solid_inertia(far, 1).about_centre() * Vec3{1, 1, 1} - solid_inertia(Shape::box(h), 1).I * Vec3{1, 1, 1}), 1e-8);
}

TEST(Geometry, InertiaOfRoundShapesMatchesFineMeshes) {
  const double r = 0.2, half = 0.3;
  const int n = 400;
  std::vector<Vec3> p = {{0, 0, -half}, {0, 0, half}};
  std::vector<Triangle> t;
  for (int i = 0; i < n; ++i)
    for (const double z : {-half, half}) p.push_back({r * std::cos(2 * pi * i / n), r * std::sin(2 * pi * i / n), z});
  for (int i = 0; i < n; ++i) {
    const int a = 2 + 2 * i, b = 2 + 2 * ((i + 1) % n);
    t.insert(t.end(), {{0, b, a}, {1, a + 1, b + 1}, {a, b, b + 1}, {a, b + 1, a + 1}});
  }
  const Inertia mesh = solid_inertia(Shape::mesh(make_geometry(p, t, true, "cylinder").value()), 1000);
  expect_same(mesh, solid_inertia(Shape::cylinder(r, half), 1000), 75 * 2e-4);
  const Vec3 radii{0.1, 0.2, 0.3};
  for (Vec3& q : p) q = {q.x / r * radii.x, q.y / r * radii.y, q.z};
  // An ellipsoid is a sphere stretched along its axes; its second moments scale with the squared radii.
  const Inertia ball = solid_inertia(Shape::sphere(1), 1), stretched = solid_inertia(Shape::ellipsoid(radii), 1);
  const double share = radii.x * radii.y * radii.z * ball.mass / 5;
  EXPECT_NEAR(stretched.I.xx, share * (radii.y * radii.y + radii.z * radii.z), 1e-15);
  EXPECT_NEAR(stretched.mass, ball.mass * radii.x * radii.y * radii.z, 1e-15);
}

TEST(Geometry, HeightFieldInertiaIsTheSumOfPrisms) {
  HeightField f;
  f.columns = 4;
  f.rows = 3;
  f.half_x = 1.5;
  f.half_y = 1;
  f.base = 0.5;
  f.heights.assign(12, 0.25);
  const Shape flat = Shape::height_field(make_height_field(f, "flat").value());
  expect_same(solid_inertia(flat, 2), solid_inertia(Shape::box({1.5, 1, 0.375}, {Mat3::identity(), {0, 0, -0.125}}), 2), 1e-12);
  for (std::size_t i = 0; i < 12; ++i) f.heights[i] = 0.1 * static_cast<double>(i % 4);  // a ramp along x
  EXPECT_NEAR(volume(Shape::height_field(make_height_field(f, "ramp").value())), 3 * 2 * (0.5 + 0.15), 1e-12);
  EXPECT_NEAR(reach(Shape::height_field(make_height_field(f, "ramp").value()), {0, 0, 1}), 0.3, 1e-15);
}

TEST(Geometry, DefectsOfMeshesAreRepairedAndCounted) {
  std::vector<Vec3> p = box_points({1, 1, 1});
  std::vector<Triangle> t = box_triangles();
  p.push_back(p[3]);         // vertex 8: equal to vertex 3
  p.push_back({5, 5, 5});    // 9: unused
  p.push_back({0, -1, -1});  // vertex 10: on the edge from 0 to 1
  t[1] = {1, 2, 8};
  t.push_back({0, 10, 1});  // corners are collinear
  t.push_back({3, 8, 1});   // two corners are equal
  t.push_back({2, 1, 0});   // the first triangle again, starting at another corner
  GeometryFindings found;
  const GeometryPtr g = make_geometry(p, t, false, "box", &found).value();
  EXPECT_EQ(found.doubled_vertices, 1U);
  EXPECT_EQ(found.unused_vertices, 2U);
  EXPECT_EQ(found.flat_triangles, 2U);
  EXPECT_EQ(found.doubled_triangles, 1U);
  EXPECT_EQ(found.open_edges, 0U);
  EXPECT_FALSE(found.inside_out);
  EXPECT_EQ(g->vertices.size(), 8U);
  EXPECT_EQ(g->triangles.size(), 12U);
  EXPECT_NEAR(g->solid.mass, 8, 1e-14);
  EXPECT_EQ(make_geometry(g->vertices, g->triangles, false, "again").value()->hash, g->hash) << "a clean mesh is not changed";

  std::vector<Triangle> holed = box_triangles(), turned = holed;
  holed.pop_back();
  const GeometryPtr open = make_geometry(box_points({1, 1, 1}), holed, false, "box", &found).value();
  EXPECT_EQ(found.open_edges, 3U);
  EXPECT_EQ(inspect(*open).open_edges, 3U);
  EXPECT_EQ(volume(Shape::mesh(open)), 0);
  for (Triangle& x : turned) std::swap(x[1], x[2]);
  EXPECT_TRUE(inspect(*make_geometry(box_points({1, 1, 1}), turned, false, "box").value()).inside_out);
}

TEST(Geometry, UnusableMeshesAreRefusedWithMessageAndRemedy) {
  const auto message = [](std::vector<Vec3> p, std::vector<Triangle> t, bool convex = false) {
    const Result<GeometryPtr> g = make_geometry(p, t, convex, "here");
    EXPECT_FALSE(g.has_value());
    if (g) return std::string();
    EXPECT_EQ(g.error().problems[0].location, "here");
    EXPECT_FALSE(g.error().problems[0].remedy.empty());
    return g.error().problems[0].message;
  };
  const auto has = [](const std::string& text, const char* word) { return text.find(word) != std::string::npos; };
  EXPECT_TRUE(has(message({}, {}), "no triangle with an area"));
  EXPECT_TRUE(has(message({{0, 0, 0}, {1, 1, 1}, {2, 2, 2}}, {{0, 1, 2}}), "lie on lines"));
  EXPECT_TRUE(has(message({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 3}}), "vertex 3"));
  EXPECT_TRUE(has(message({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, -1}}), "vertex -1"));
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e7})
    EXPECT_TRUE(has(message({{0, 0, bad}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}), "not finite"));
  EXPECT_TRUE(has(message({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}, true), "must be closed"));
  EXPECT_TRUE(has(message({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, std::vector<Triangle>(5'000'000, {0, 1, 2})), "5000000 triangles"));
  EXPECT_TRUE(
      make_geometry(std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, std::vector<Triangle>{{0, 1, 2}}, false, "flat").has_value());
}

}  // namespace
}  // namespace ugoki
