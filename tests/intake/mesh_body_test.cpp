// Meshes become mesh bodies: place, volume, inertia and hulls against closed forms; and mesh files become library entries.

#include "ugoki/intake/mesh_body.h"

#include <gtest/gtest.h>

#include <cmath>

#include "ugoki/base/base64.h"
#include "ugoki/content/prop.h"
#include "ugoki/formats/mechanism_json.h"
#include "ugoki/intake/intake.h"

namespace ugoki::intake {
namespace {

using scene_formats::MeshScene;

/// Appends a solid cylinder about z with a regular n-gon as its base.
void add_cylinder(MeshScene& scene, const Vec3& base, double radius, double height, int n, std::vector<Triangle>& out) {
  const auto first = static_cast<std::int32_t>(scene.vertices.size());
  for (int i = 0; i < n; ++i)
    for (const double z : {0.0, height})
      scene.vertices.push_back(base + Vec3{radius * std::cos(2 * pi * i / n), radius * std::sin(2 * pi * i / n), z});
  for (const double z : {0.0, height}) scene.vertices.push_back(base + Vec3{0, 0, z});
  const std::int32_t bottom = first + 2 * n, top = bottom + 1;
  for (int i = 0; i < n; ++i) {
    const std::int32_t a = first + 2 * i, b = first + 2 * ((i + 1) % n);
    out.push_back({a, b, b + 1});
    out.push_back({a, b + 1, a + 1});
    out.push_back({bottom, b, a});
    out.push_back({top, a + 1, b + 1});
  }
}

/// Area of a regular n-gon.
double gon_area(double radius, int n) { return 0.5 * n * radius * radius * std::sin(2 * pi / n); }

TEST(MeshBody, CylinderHasItsVolumeAndInertia) {
  MeshScene scene;
  scene.parts.push_back({"#102030", {}});
  constexpr int n = 96;
  const double r = 0.3, h = 0.8;
  add_cylinder(scene, {5, -2, 7}, r, h, n, scene.parts[0].triangles);
  const Result<MeshBody> body = make_mesh_body(scene, "drum", "drum.obj");
  ASSERT_TRUE(body) << body.error().text();
  EXPECT_TRUE(body->closed);
  EXPECT_TRUE(content::is_mesh_body(*body->mechanism));
  EXPECT_NEAR(body->volume, gon_area(r, n) * h, 1e-12);
  const Inertia& I = body->mechanism->link(0).inertia;
  EXPECT_NEAR(I.mass, 1000 * body->volume, 1e-9);
  EXPECT_NEAR(norm(I.centre() - Vec3{0, 0, h / 2}), 0, 1e-12) << "the origin is in the centre of the bottom";
  // second moment of a regular n-gon about its centre: A r^2 (2 + cos(2 pi / n)) / 6
  EXPECT_NEAR(I.about_centre().zz, I.mass * r * r * (2 + std::cos(2 * pi / n)) / 6, 1e-9);
  EXPECT_NEAR(I.about_centre().xx, 0.5 * I.about_centre().zz + I.mass * h * h / 12, 1e-9);
  EXPECT_EQ(body->colors, std::vector<std::string>{"#102030"});
  EXPECT_EQ(body->parts, 1U);
}

TEST(MeshBody, ConnectedPartsHaveTheirOwnHulls) {
  MeshScene scene;
  scene.parts.resize(2);
  add_cylinder(scene, {0, 0, 0}, 0.1, 1, 12, scene.parts[0].triangles);
  add_cylinder(scene, {1, 0, 0}, 0.1, 1, 12, scene.parts[1].triangles);
  add_cylinder(scene, {2, 0, 0}, 0.1, 1, 12, scene.parts[1].triangles);
  const Result<MeshBody> body = make_mesh_body(scene, "posts", "posts.obj");
  ASSERT_TRUE(body) << body.error().text();
  EXPECT_EQ(body->parts, 3U);
  const std::vector<Shape>& shapes = body->mechanism->link(0).shapes;
  ASSERT_EQ(shapes.size(), 2U + 1U + 3U);
  double hulls = 0;
  for (std::size_t i = 3; i < shapes.size(); ++i) hulls += volume(shapes[i]);
  EXPECT_NEAR(hulls, body->volume, 1e-9) << "cylinders are convex";
  EXPECT_GT(volume(shapes[2]), 3 * body->volume) << "the hull of all fills the gaps";
}

TEST(MeshBody, OpenAndFlatMeshesAreUsedWithACheck) {
  MeshScene scene;
  scene.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  scene.parts.push_back({"", {{0, 1, 2}, {0, 2, 3}}});
  const Result<MeshBody> body = make_mesh_body(scene, "sheet", "sheet.obj");
  ASSERT_TRUE(body) << body.error().text();
  EXPECT_FALSE(body->closed);
  ASSERT_EQ(body->checks.size(), 1U);
  EXPECT_NE(body->checks[0].find("convex hull"), std::string::npos);
  EXPECT_NEAR(body->volume, 1.002 * 1.002 * 0.002, 1e-9);
  scene.vertices = {{0, 0, 0}, {1e-5, 0, 0}, {0, 1e-5, 0}};
  scene.parts[0].triangles = {{0, 1, 2}};
  const Result<MeshBody> tiny = make_mesh_body(scene, "dot", "dot.obj");
  ASSERT_FALSE(tiny);
  EXPECT_EQ(tiny.error().problems[0].location, "dot.obj");
  EXPECT_NE(tiny.error().problems[0].remedy.find("unit"), std::string::npos);
}

/// Two rectangles that meet at a right angle along y, and a third one that continues the first one, with a texture.
MeshScene textured_corner() {
  MeshScene scene;
  scene.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {1, 0, 1}, {1, 1, 1}, {-1, 0, 0.2}, {-1, 1, 0.2}};
  scene.normals.assign(8, Vec3{});
  scene.uvs.assign(16, 0.5F);
  scene.textures.resize(1);
  scene.textures[0].type = "image/png";
  const std::vector<std::uint8_t> picture =
      from_base64("iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+M9QDwADhgGAWjR9awAAAABJRU5ErkJggg==").value();
  for (const std::uint8_t b : picture) scene.textures[0].data.push_back(static_cast<std::byte>(b));
  scene.parts.push_back({"#808080", {{0, 1, 2}, {0, 2, 3}, {1, 4, 5}, {1, 5, 2}, {6, 0, 3}, {6, 3, 7}}, 0});
  return scene;
}

TEST(MeshBody, TexturedSurfaceIsTheSkin) {
  const Result<MeshBody> body = make_mesh_body(textured_corner(), "corner", "corner.glb");
  ASSERT_TRUE(body) << body.error().text();
  EXPECT_TRUE(content::is_mesh_body(*body->mechanism));
  const SkinPtr skin = body->mechanism->skin();
  ASSERT_TRUE(skin);
  EXPECT_EQ(skin->triangle_count(), 6U);
  EXPECT_EQ(skin->parts.at(0).color, "#ffffff");
  // the skin is where the visible shape is
  const Pose here = Pose{};
  const std::vector<SkinBone> bones(body->mechanism->skin_bones().begin(), body->mechanism->skin_bones().end());
  for (std::size_t i = 0; i < skin->indices.size(); ++i) {
    const std::uint32_t v = skin->indices[i];
    const Vec3 p = skinned_point(*skin, bones, {&here, 1}, v);
    double nearest = 1;
    for (const Vec3& q : body->mechanism->link(0).shapes[0].geometry->vertices) nearest = std::min(nearest, norm(p - q));
    EXPECT_LT(nearest, 1e-6);
    // the flat rectangles have an edge between them, and the two that meet at 11 degrees are smooth
    const Vec3 n{static_cast<double>(skin->normals[3 * v]), static_cast<double>(skin->normals[3 * v + 1]),
                 static_cast<double>(skin->normals[3 * v + 2])};
    const std::size_t triangle = i / 3;
    if (triangle == 2 || triangle == 3) {
      EXPECT_NEAR(std::fabs(n.x), 1, 1e-6) << "the wall is flat up to its edge";
    } else {
      EXPECT_GT(std::fabs(n.z), 0.97);
    }
    if (triangle < 2 && p.x < 0.01) EXPECT_GT(std::fabs(n.x), 0.05) << "the floor bends towards its neighbour";
  }
  const Result<MechanismPtr> back = formats::read_mechanism(formats::write_mechanism(*body->mechanism), "corner");
  ASSERT_TRUE(back) << back.error().text();
  EXPECT_EQ((*back)->skin()->textures.at(0).data, skin->textures.at(0).data);
}

TEST(MeshBody, TooLargeTexturesAreLeftOutWithACheck) {
  MeshScene scene = textured_corner();
  scene.textures[0].data.assign(64, std::byte{1});  // not a picture
  const Result<MeshBody> body = make_mesh_body(scene, "corner", "corner.glb");
  ASSERT_TRUE(body) << body.error().text();
  EXPECT_FALSE(body->mechanism->skin());
  EXPECT_NE(body->checks.back().find("textures are left out"), std::string::npos);
}

TEST(MeshBody, MeshFilesBecomeEntries) {
  const std::string text =
      "v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nv -1 2 -1\nv 1 2 -1\nv 1 2 1\nv -1 2 1\n"
      "f 1 2 3 4\nf 5 8 7 6\nf 1 5 6 2\nf 2 6 7 3\nf 3 7 8 4\nf 5 1 4 8\n";
  const Result<Intake> in = take_in(text, "folder/Crate.obj", nullptr, {});
  ASSERT_TRUE(in) << in.error().text();
  ASSERT_TRUE(in->mesh);
  EXPECT_EQ(in->items.size(), 1U);
  EXPECT_EQ(in->items[0].name, "Crate");
  EXPECT_NE(in->items[0].summary.find("\"mesh\""), std::string::npos);
  EXPECT_NEAR(in->mesh->volume, 8, 1e-9);
  const std::string stored(reinterpret_cast<const char*>(in->items[0].data.data()), in->items[0].data.size());
  const Result<MechanismPtr> back = formats::read_mechanism(stored, "crate");
  ASSERT_TRUE(back) << back.error().text();
  EXPECT_TRUE(content::is_mesh_body(**back));
  // another up axis and unit
  IntakeOptions options;
  options.unit = 0.1;
  options.axes = usual_orientation(true);
  const Result<Intake> turned = take_in(text, "Crate.obj", nullptr, options);
  ASSERT_TRUE(turned) << turned.error().text();
  EXPECT_NEAR(turned->mesh->volume, 0.008, 1e-12);
  const Result<Intake> bad = take_in("v 0 0", "Crate.obj", nullptr, {});
  ASSERT_FALSE(bad);
  EXPECT_TRUE(bad.error().problems[0].location.starts_with("Crate.obj"));
}

}  // namespace
}  // namespace ugoki::intake
