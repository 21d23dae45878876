#include "ugoki/mechanism_edit/mesh_inertia.h"

#include <gtest/gtest.h>

#include <random>

#include "ugoki/mechanism/shape.h"
#include "whole.h"

namespace ugoki {
namespace {

struct Mesh {
  std::vector<Vec3> vertices;
  std::vector<Triangle> triangles;

  void add(const Mesh& other) {
    const auto first = static_cast<std::int32_t>(vertices.size());
    vertices.insert(vertices.end(), other.vertices.begin(), other.vertices.end());
    for (const Triangle& t : other.triangles) triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  }
  Mesh at(const Vec3& p) const {
    Mesh out = *this;
    for (Vec3& v : out.vertices) v = v + p;
    return out;
  }
  Mesh inside_out() const {
    Mesh out = *this;
    for (Triangle& t : out.triangles) std::swap(t[1], t[2]);
    return out;
  }
};

Mesh box(const Vec3& h) {
  Mesh m;
  for (int i = 0; i < 8; ++i) m.vertices.push_back({i & 1 ? h.x : -h.x, i & 2 ? h.y : -h.y, i & 4 ? h.z : -h.z});
  m.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                 {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return m;
}

/// A torus about z as a polyhedron: radius R of the centre line, radius r of the tube.
Mesh torus(double R, double r, int around, int across) {
  Mesh m;
  for (int i = 0; i < around; ++i)
    for (int j = 0; j < across; ++j) {
      const double a = 2 * pi * i / around, b = 2 * pi * j / across;
      m.vertices.push_back({(R + r * cos(b)) * cos(a), (R + r * cos(b)) * sin(a), r * sin(b)});
    }
  const auto at = [&](int i, int j) { return (i % around) * across + j % across; };
  for (int i = 0; i < around; ++i)
    for (int j = 0; j < across; ++j) {
      m.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      m.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return m;
}

Result<MeshInertia> run(const Mesh& m, const MeshInertiaOptions& options = {}) {
  return mesh_inertia(m.vertices, m.triangles, "mesh", options);
}

bool reports(const MeshInertia& m, std::string_view text) {
  for (const std::string& line : m.report)
    if (line.find(text) != std::string::npos) return true;
  return false;
}

TEST(MeshInertia, BoxMatchesTheClosedForm) {
  for (const Vec3& location : {Vec3{}, Vec3{0.3, -2, 5}, Vec3{1000, -3000, 500}}) {
    const auto m = run(box({0.1, 0.2, 0.3}).at(location), {.density = 700});
    ASSERT_TRUE(m.has_value()) << m.error().text();
    const Inertia exact = solid_inertia(Shape::box({0.1, 0.2, 0.3}, {Mat3::identity(), location}), 700);
    EXPECT_LT(testing::difference(exact, m->inertia), 1e-12);
    // Far from the origin, the rounding of the coordinates limits the accuracy.
    EXPECT_NEAR(m->volume, 0.048, 1e-12 * (1 + norm(location)));
    EXPECT_NEAR(m->area, 2 * (0.2 * 0.4 + 0.2 * 0.6 + 0.4 * 0.6), 1e-11);
    EXPECT_TRUE(m->report.empty());
  }
}

/// Closed forms of a solid torus (Mirtich's classic case): V = 2 pi^2 R r^2, I_z = m (R^2 + 3/4 r^2), I_x = m (R^2/2 + 5/8 r^2).
TEST(MeshInertia, TorusConvergesToItsClosedForm) {
  const double R = 0.5, r = 0.2;
  double before = 1;
  for (const int n : {40, 80, 160}) {
    const auto m = run(torus(R, r, 2 * n, n), {.mass = 3});
    ASSERT_TRUE(m.has_value());
    EXPECT_NEAR(m->inertia.mass, 3, 1e-12);
    const double error =
        std::max({std::fabs(m->volume / (2 * pi * pi * R * r * r) - 1), std::fabs(m->inertia.I.zz / (3 * (R * R + 0.75 * r * r)) - 1),
                  std::fabs(m->inertia.I.xx / (3 * (R * R / 2 + 0.625 * r * r)) - 1)});
    EXPECT_LT(error, 0.3 * before);  // the error is of second order in the size of the triangles
    before = error;
  }
  EXPECT_LT(before, 1e-3);
}

/// Compares with a Monte Carlo estimate: random points, tested for being inside by counting the crossings of a ray.
TEST(MeshInertia, AgreesWithMonteCarlo) {
  const Mesh mesh = torus(0.4, 0.15, 20, 9);
  const auto m = run(mesh, {.density = 1});
  ASSERT_TRUE(m.has_value());
  std::mt19937_64 engine(7);
  std::uniform_real_distribution<double> wide(-0.56, 0.56), flat(-0.16, 0.16);
  const int n = 60'000;
  int inside = 0;
  double zz = 0, xx = 0;
  for (int i = 0; i < n; ++i) {
    const Vec3 p{wide(engine), wide(engine), flat(engine)};
    int crossings = 0;
    for (const Triangle& t : mesh.triangles) {  // a ray along z
      const Vec3 a = mesh.vertices[static_cast<std::size_t>(t[0])] - p, b = mesh.vertices[static_cast<std::size_t>(t[1])] - p,
                 c = mesh.vertices[static_cast<std::size_t>(t[2])] - p;
      const double u = b.x * c.y - b.y * c.x, v = c.x * a.y - c.y * a.x, w = a.x * b.y - a.y * b.x;
      if ((u > 0) == (v > 0) && (v > 0) == (w > 0) && (u * a.z + v * b.z + w * c.z) / (u + v + w) > 0) ++crossings;
    }
    if (crossings % 2 == 0) continue;
    ++inside;
    zz += p.x * p.x + p.y * p.y;
    xx += p.y * p.y + p.z * p.z;
  }
  const double cell = 1.12 * 1.12 * 0.32 / n;
  EXPECT_NEAR(inside * cell / m->volume, 1, 0.02);  // tolerance: about four standard deviations
  EXPECT_NEAR(zz * cell / m->inertia.I.zz, 1, 0.02);
  EXPECT_NEAR(xx * cell / m->inertia.I.xx, 1, 0.03);
}

/// Compares with the sum of the tetrahedra between the triangles and the origin, each in closed form, for a randomly distorted torus.
TEST(MeshInertia, AgreesWithASumOfTetrahedra) {
  std::mt19937_64 engine(11);
  std::uniform_real_distribution<double> jitter(0.7, 1.3);
  Mesh mesh = torus(0.5, 0.2, 12, 8);
  for (Vec3& v : mesh.vertices) v = v * jitter(engine) + Vec3{2, 1, -1};
  const auto m = run(mesh, {.density = 1});
  ASSERT_TRUE(m.has_value());
  long double volume = 0, first[3] = {}, second[3][3] = {};
  for (const Triangle& t : mesh.triangles) {
    const Vec3 p[4] = {{},
                       mesh.vertices[static_cast<std::size_t>(t[0])],
                       mesh.vertices[static_cast<std::size_t>(t[1])],
                       mesh.vertices[static_cast<std::size_t>(t[2])]};
    const long double v = dot(p[1], cross(p[2], p[3])) / 6.0L;
    volume += v;
    for (int i = 0; i < 3; ++i) {
      long double s = 0;
      for (const Vec3& x : p) s += x[i];
      first[i] += v * s / 4;
      for (int j = 0; j < 3; ++j) {  // integral of x_i x_j = V/20 (sum x_i sum x_j + sum x_i x_j)
        long double sj = 0, both = 0;
        for (const Vec3& x : p) {
          sj += x[j];
          both += static_cast<long double>(x[i]) * x[j];
        }
        second[i][j] += v / 20 * (s * sj + both);
      }
    }
  }
  const auto d = [](long double x) { return static_cast<double>(x); };
  const Inertia sum{d(volume),
                    {d(first[0]), d(first[1]), d(first[2])},
                    {d(second[1][1] + second[2][2]), d(second[0][0] + second[2][2]), d(second[0][0] + second[1][1]), d(-second[0][1]),
                     d(-second[0][2]), d(-second[1][2])}};
  EXPECT_LT(testing::difference(sum, m->inertia), 1e-12);
}

TEST(MeshInertia, FlippedTrianglesAreReversedAndReported) {
  const Mesh good = torus(0.5, 0.2, 24, 12);
  const auto exact = run(good);
  Mesh bad = good;
  for (const std::size_t t : {std::size_t{0}, std::size_t{7}, std::size_t{100}}) std::swap(bad.triangles[t][0], bad.triangles[t][1]);
  const auto repaired = run(bad);
  ASSERT_TRUE(repaired.has_value()) << repaired.error().text();
  EXPECT_EQ(repaired->turned, 3u);
  EXPECT_TRUE(reports(*repaired, "3 triangles had the opposite orientation"));
  EXPECT_LT(testing::difference(exact->inertia, repaired->inertia), 1e-13);
  const auto turned = run(good.inside_out());
  ASSERT_TRUE(turned.has_value());
  EXPECT_TRUE(reports(*turned, "inward normals"));
  EXPECT_LT(testing::difference(exact->inertia, turned->inertia), 1e-13);
}

TEST(MeshInertia, CavitiesAreSubtractedAndNestedPartsReported) {
  Mesh hollow = box({0.2, 0.2, 0.2});
  hollow.add(box({0.1, 0.1, 0.1}).inside_out());
  const auto m = run(hollow);
  ASSERT_TRUE(m.has_value());
  EXPECT_EQ(m->parts, 2u);
  EXPECT_NEAR(m->volume, 0.064 - 0.008, 1e-15);
  EXPECT_TRUE(reports(*m, "cavity"));
  Mesh nested = box({0.2, 0.2, 0.2});
  nested.add(box({0.1, 0.1, 0.1}));
  const auto twice = run(nested);
  EXPECT_NEAR(twice->volume, 0.072, 1e-15);
  EXPECT_TRUE(reports(*twice, "twice"));
  Mesh beside = box({0.2, 0.2, 0.2});
  beside.add(box({0.1, 0.1, 0.1}).inside_out().at({1, 0, 0}));
  EXPECT_NEAR(run(beside)->volume, 0.072, 1e-15);
}

TEST(MeshInertia, OpenOneSidedAndFlatSurfacesAreRefused) {
  Mesh open = box({0.1, 0.2, 0.3}).at({1, 0, 0});
  open.triangles.pop_back();
  const auto m = run(open);
  ASSERT_FALSE(m.has_value());
  EXPECT_NE(m.error().text().find("1 hole"), std::string::npos) << m.error().text();
  EXPECT_NE(m.error().text().find("1.1000"), std::string::npos);
  // A Klein bottle is closed and one-sided.
  Mesh klein;
  const int n = 16, k = 8;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < k; ++j) klein.vertices.push_back({1.0 * i, 1.0 * j, 0.01 * ((i * 7 + j * 3) % 5)});
  const auto at = [&](int i, int j) { return i < n ? i * k + j % k : (2 * k - j) % k; };
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < k; ++j) {
      klein.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      klein.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  const auto one_sided = run(klein);
  ASSERT_FALSE(one_sided.has_value());
  EXPECT_NE(one_sided.error().text().find("one side"), std::string::npos) << one_sided.error().text();
  Mesh flat = box({0.1, 0.2, 0});
  EXPECT_FALSE(run(flat).has_value());
  EXPECT_FALSE(run(box({1, 1, 1}), {.density = -1}).has_value());
}

}  // namespace
}  // namespace ugoki
