// Meshes and height fields in the JSON form of a mechanism.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <random>

#include "ugoki/base/base64.h"
#include "ugoki/collision/prepared_geometry.h"
#include "ugoki/formats/mechanism_json.h"

namespace ugoki::formats {
namespace {

/// A tetrahedron; if it is not convex, one face is dented.
GeometryPtr tetrahedron(bool convex) {
  std::vector<Vec3> p = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  std::vector<Triangle> t = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  if (!convex) {
    p.push_back({0.1, 0.1, 0.1});
    t = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 4}, {2, 3, 4}, {3, 1, 4}};
  }
  return make_geometry(p, t, convex, "test").value();
}

/// The geometry with its prepared collision data.
GeometryPtr prepared(const GeometryPtr& g) {
  collision::Hull hull;
  if (!g->convex)
    hull = collision::assemble_hull({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {0, 3, 6, 9, 12}, {0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2})
               .value();
  return collision::with_prepared(*g, collision::make_prepared(*g, std::move(hull), {}, "test").value());
}

HeightFieldPtr hills() {
  HeightField f{.columns = 3, .rows = 2, .half_x = 1, .half_y = 0.1, .base = 0.5, .heights = {0, 0.1, 0.3, -0.2, 1.0 / 3, 0}};
  return make_height_field(std::move(f), "test").value();
}

MechanismPtr scene() {
  MechanismSpec spec{"surfaces", {}};
  LinkSpec link;
  link.name = "one";
  link.inertia = Inertia::from_centre(1, {}, {1, 1, 1, 0, 0, 0});
  link.shapes = {Shape::mesh(prepared(tetrahedron(true))),
                 Shape::mesh(prepared(tetrahedron(false))),
                 Shape::mesh(tetrahedron(false)),
                 Shape::height_field(hills()),
                 Shape::cylinder(0.1, 0.2),
                 Shape::ellipsoid({1, 2, 3})};
  spec.links.push_back(link);
  return Mechanism::make(std::move(spec)).value();
}

template <class T>
bool same_bytes(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

TEST(MechanismSurfaces, RoundTripKeepsSurfacesAndPreparedDataBitForBit) {
  const MechanismPtr made = scene();
  const std::string text = write_mechanism(*made);
  const auto back = read_mechanism(text, "s.json");
  ASSERT_TRUE(back.has_value()) << back.error().text();
  const std::vector<Shape>&a = made->link(0).shapes, &b = (*back)->link(0).shapes;
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].type, b[i].type);
    EXPECT_EQ(a[i].radius, b[i].radius);
    EXPECT_EQ(a[i].half_extents, b[i].half_extents);
  }
  for (std::size_t i = 0; i < 3; ++i) {
    const Geometry &x = *a[i].geometry, &y = *b[i].geometry;
    EXPECT_EQ(x.hash, y.hash);
    EXPECT_EQ(x.convex, y.convex);
    EXPECT_TRUE(same_bytes(x.vertices, y.vertices) && same_bytes(x.triangles, y.triangles));
    ASSERT_NE(y.prepared, nullptr);
    const collision::PreparedGeometry& p = *a[i == 2 ? 1 : i].geometry->prepared;
    EXPECT_EQ(p.hull.hash, y.prepared->hull.hash);
    EXPECT_TRUE(same_bytes(p.hull.neighbours, y.prepared->hull.neighbours));
    EXPECT_TRUE(same_bytes(p.spheres.blocks, y.prepared->spheres.blocks));
    EXPECT_TRUE(same_bytes(p.spheres.vertices, y.prepared->spheres.vertices));
  }
  EXPECT_EQ(b[1].geometry, b[2].geometry) << "equal meshes are stored, and kept in memory, once";
  EXPECT_TRUE(same_bytes(a[3].field->heights, b[3].field->heights));
  EXPECT_EQ(a[3].field->hash, b[3].field->hash);
  EXPECT_EQ(write_mechanism(**back), text);
}

TEST(MechanismSurfaces, HandWrittenListsAreRead) {
  const auto m = read_mechanism(R"({"format": "ugoki-mechanism", "version": 1, "name": "m", "links": [{"name": "a", "shapes": [
      {"type": "mesh", "geometry": "roof"}, {"type": "height_field", "height_field": "hill"}]}],
    "geometries": [{"name": "roof", "vertices": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]],
                    "triangles": [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]], "convex": true}],
    "height_fields": [{"name": "hill", "columns": 2, "rows": 2, "half_x": 1, "half_y": 2, "base": 1, "heights": [0, 0.5, 0, 1]}]})",
                                "m.json");
  ASSERT_TRUE(m.has_value()) << m.error().text();
  EXPECT_NEAR(volume((*m)->link(0).shapes[0]), 1.0 / 6, 1e-15);
  EXPECT_NEAR(volume((*m)->link(0).shapes[1]), 8 + 4 * (0.5 + 1 + 0.5 + 1 + 0) / 6 * 2 - 0, 1);
  EXPECT_EQ((*m)->link(0).shapes[1].field->point(1, 1).z, 1);
}

TEST(MechanismSurfaces, BrokenSurfacesAreRejectedWithTheirPath) {
  const std::string text = write_mechanism(*scene());
  struct Case {
    const char *from, *to, *path;
  };
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string out = text;
    const std::size_t at = out.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    if (at != std::string::npos) out.replace(at, from.size(), to);
    return out;
  };
  const Case cases[] = {
      {"\"vertices\": \"AAAA", "\"vertices\": \"!!!!", "geometries/0/vertices"},
      {"\"vertices\": \"AAAA", "\"vertices\": \"AAAAAAAA", "geometries/0/vertices"},
      {"\"triangles\": \"AAAA", "\"triangles\": \"AQAA", "geometries/0/prepared/of"},
      {"\"triangles\": \"AAAA", "\"triangles\": \"/wAA", "geometries/0"},
      {"\"corners\": \"AAAA", "\"corners\": \"////", "geometries/0/prepared/hull"},
      {"\"first_corner\": \"AAAA", "\"first_corner\": \"AQAA", "geometries/0/prepared/hull"},
      {"\"spheres\": \"", "\"spheres\": \"AAAA", "geometries/"},
      {"\"prepared\": {\"of\": \"", "\"prepared\": {\"of\": \"0", "geometries/0/prepared/of"},
      {"\"prepared\": {", "\"prepared\": {\"more\": 1, ", "geometries/0/prepared/more"},
      {"\"columns\": 3", "\"columns\": 4", "height_fields/0"},
      {"\"columns\": 3", "\"columns\": 1e9", "height_fields/0"},
      {"\"base\": 0.5", "\"base\": 0.1", "height_fields/0"},
      {"\"heights\": \"", "\"heights\": \"AAAA", "height_fields/0/heights"},
      {"\"geometry\": \"", "\"geometry\": \"x", "links/0/shapes/0/geometry"},
      {"\"height_field\": \"", "\"height_field\": \"x", "links/0/shapes/3/height_field"},
  };
  for (const Case& c : cases) {
    const auto result = read_mechanism(changed(c.from, c.to), "a.json");
    ASSERT_FALSE(result.has_value()) << c.from << " -> " << c.to;
    const Problem& p = result.error().problems[0];
    EXPECT_TRUE(p.location.starts_with(std::string("a.json:") + c.path)) << p.location << " for " << c.from << " -> " << c.to;
    EXPECT_FALSE(p.message.empty());
  }
  // Random changes of the text give a mechanism or an error, never a crash.
  std::mt19937_64 random(7);
  for (int i = 0; i < 2000; ++i) {
    std::string damaged = text;
    for (int k = 0; k < 3; ++k) damaged[random() % damaged.size()] = "A/0\"{]z9,"[random() % 9];
    (void)read_mechanism(damaged, "a.json");
  }
}

TEST(Base64, RoundTripKeepsBytesAndInvalidTextIsRejected) {
  std::mt19937_64 random(3);
  for (std::size_t n = 0; n < 70; ++n) {
    std::vector<std::uint8_t> bytes(n);
    for (auto& b : bytes) b = static_cast<std::uint8_t>(random());
    EXPECT_EQ(from_base64(to_base64(bytes)), bytes);
  }
  EXPECT_EQ(to_base64(std::vector<std::uint8_t>{'f', 'o', 'o', 'b'}), "Zm9vYg==");  // RFC 4648, section 10
  for (const char* wrong : {"A", "AAA", "A===", "AA=A", "AB==", "AAB=", "AAAA=AAA", "AA A", "AA\nA", "=AAA"})
    EXPECT_FALSE(from_base64(wrong)) << wrong;
}

}  // namespace
}  // namespace ugoki::formats
