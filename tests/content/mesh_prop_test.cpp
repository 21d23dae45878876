// Props from meshes: JSON form, checks, mass properties against those of solids, and the dynamics of bodies on and in them.

#include <gtest/gtest.h>

#include <cmath>

#include "command_fixture.h"
#include "mesh_body.h"
#include "ugoki/content/mechanism_display.h"
#include "ugoki/geometry/prepare.h"

namespace ugoki::content {
namespace {

using testing::add_box;
using testing::body_of;

/// A table: a top of 1 m x 0.6 m at 0.7 to 0.75 m, on two panels of 5 cm.
MechanismPtr table() {
  return body_of({{{-0.5, -0.3, 0.7}, {0.5, 0.3, 0.75}}, {{-0.5, -0.3, 0}, {-0.45, 0.3, 0.7}}, {{0.45, -0.3, 0}, {0.5, 0.3, 0.7}}});
}

class MeshPropTest : public testing::CommandFixture {
 protected:
  void SetUp() override {
    resources.mechanisms["m-table"] = table();
    resources.mechanisms["m-block"] = body_of({{{-0.5, -0.5, 0}, {0.5, 0.5, 1}}});
    catalogue = catalogue_of(resources);
  }
  void add(const std::string& fields) { apply(R"({"type": "character.add", )" + fields + "}"); }
  void bad(const std::string& fields, ErrorCode code, const std::string& location) {
    refuses(R"({"type": "character.add", )" + fields + "}", code, location);
  }
  Vec3 root_after(double seconds, int character) {
    Player player = open();
    while (player.time() < seconds) EXPECT_TRUE(player.step());
    const std::span<const double> q = player.q(character);
    return {q[0], q[1], q[2]};
  }
};

TEST_F(MeshPropTest, DocumentKeepsThem) {
  add(R"("prop": {"shape": "mesh", "mesh": "m-table", "scale": [1, 2, 1], "collision": "parts"}, "shape_colors": ["#a0b0c0"])");
  EXPECT_EQ(document.characters[0].name, "table");
  EXPECT_EQ(document.characters[0].prop->collision, MeshCollision::parts);
  EXPECT_EQ(resources_named(R"({"type": "character.add", "prop": {"shape": "mesh", "mesh": "m-new"}})"), std::vector<std::string>{"m-new"});
  const Result<Scenario> read = read_scenario(write_scenario(document), "scenario");
  ASSERT_TRUE(read) << read.error().text();
  EXPECT_EQ(*read, document);
  EXPECT_EQ(read->characters[0].material.shape_colors, std::vector<std::string>{"#a0b0c0"});
  // the page receives the colours, and only the visible surface
  const Result<std::vector<std::byte>> ugx = generate(document, resources);
  ASSERT_TRUE(ugx) << ugx.error().text();
  const Result<Executable> content = read_executable(*ugx, "a.ugx");
  ASSERT_TRUE(content) << content.error().text();
  EXPECT_NE(scene_json(*content).find("#a0b0c0"), std::string::npos);
}

TEST_F(MeshPropTest, RefusesFaultyOnes) {
  const std::string at = "scenario/characters/0/prop";
  bad(R"("prop": {"shape": "mesh"})", ErrorCode::syntax, at + "/mesh");
  bad(R"("prop": {"shape": "mesh", "mesh": "m-none"})", ErrorCode::unknown, at + "/mesh");
  bad(R"("prop": {"shape": "mesh", "mesh": "m-walker"})", ErrorCode::unsupported, at + "/mesh");
  bad(R"("prop": {"shape": "mesh", "mesh": "m-table", "scale": [1, 0, 1]})", ErrorCode::range, at + "/scale");
  bad(R"("prop": {"shape": "mesh", "mesh": "m-table", "collision": "soft"})", ErrorCode::unknown, "command/prop/collision");
  bad(R"("prop": {"shape": "mesh", "mesh": "m-table"}, "shape_colors": ["red"])", ErrorCode::syntax,
      "scenario/characters/0/shape_colors/0");
}

/// A scaled and tilted mesh of a cube has the mass properties of a box of that size.
TEST_F(MeshPropTest, MassesAreThoseOfScaledSolids) {
  Prop mesh;
  mesh.shape = PropShape::mesh;
  mesh.mesh = "m-block";
  mesh.scale = {0.4, 0.9, 2};
  mesh.tilt = {20, -35, 60};
  mesh.mass = 7;
  Prop box = mesh;
  box.shape = PropShape::box;
  box.size = mesh.scale;
  const Inertia a = make_prop(mesh, resources.mechanisms["m-block"])->link(0).inertia, b = make_prop(box)->link(0).inertia;
  EXPECT_DOUBLE_EQ(a.mass, 7);
  EXPECT_NEAR(norm(a.h - b.h), 0, 1e-12);
  for (const auto& [x, y] :
       {std::pair{a.I.xx, b.I.xx}, {a.I.yy, b.I.yy}, {a.I.zz, b.I.zz}, {a.I.xy, b.I.xy}, {a.I.xz, b.I.xz}, {a.I.yz, b.I.yz}})
    EXPECT_NEAR(x, y, 1e-12);
}

/// The skin of a textured mesh is scaled and tilted as its surface is.
TEST_F(MeshPropTest, SkinFollowsScaleAndTilt) {
  MechanismSpec spec = resources.mechanisms["m-block"]->spec();
  auto skin = std::make_shared<Skin>();
  skin->positions = {0.5F, -0.5F, 1, 0, 0, 0, -0.5F, 0.5F, 0.25F};
  skin->normals = {0, 0, 1, 0, 0, 1, 0, 0, 1};
  skin->uvs.assign(6, 0);
  skin->bones.assign(12, 0);
  skin->weights = {65535, 0, 0, 0, 65535, 0, 0, 0, 65535, 0, 0, 0};
  skin->indices = {0, 1, 2};
  skin->parts = {{"#ffffff", -1, 0, 3, 0, false}};
  spec.skin = skin;
  spec.skin_bones = {{"body", Mat3::identity(), {0, 0, 0.1}}};
  const MechanismPtr mesh = Mechanism::make(spec).value();
  Prop prop;
  prop.shape = PropShape::mesh;
  prop.mesh = "m-block";
  prop.scale = {0.4, 0.9, 2};
  prop.tilt = {90, 0, 0};
  const MechanismPtr made = make_prop(prop, mesh);
  ASSERT_TRUE(made->skin());
  EXPECT_EQ(made->skin(), mesh->skin()) << "props share the lists of the skin";
  const std::vector<SkinBone> bones(made->skin_bones().begin(), made->skin_bones().end());
  const Pose X = Pose{};
  // (x, y, z + 0.1) is scaled, and turned by 90 degrees about x: y becomes z, z becomes -y
  EXPECT_NEAR(norm(skinned_point(*skin, bones, {&X, 1}, 0) - Vec3{0.4 * 0.5, -2 * 1.1, -0.9 * 0.5}), 0, 1e-7);
  EXPECT_NEAR(norm(skinned_point(*skin, bones, {&X, 1}, 2) - Vec3{-0.4 * 0.5, -2 * 0.35, 0.9 * 0.5}), 0, 1e-7);
  prop.shape = PropShape::box;
  EXPECT_FALSE(make_prop(prop)->skin());
}

/// What collides: nothing passes below the table with its hull; with its parts and with its surface a ball rolls below it.
TEST_F(MeshPropTest, CollisionIsThatOfHullPartsOrSurface) {
  for (const char* collision : {"hull", "parts", "surface"}) {
    document = Scenario();
    add(R"("prop": {"shape": "mesh", "mesh": "m-table", "collision": ")" + std::string(collision) +
        R"("}, "place": {"x": 3, "heading": 90})");
    add(R"("prop": {"shape": "sphere", "size": [0.2, 0.2, 0.2], "mass": 1, "friction": 0.8}, "place": {"x": 2, "z": 0})");
    apply(R"({"type": "event.add", "event": {"type": "throw", "time": 0, "character": ")" + document.characters[1].id +
          R"(", "from": [2, 0, 0.001], "velocity": [2, 0, 0]}})");
    const double x = root_after(1, 1).x;
    if (std::string_view(collision) == "hull")
      EXPECT_LT(x, 2.71) << "the hull begins at 2.7 m; the frame of the ball is 0.1 m below its centre, and rolls";
    else
      EXPECT_GT(x, 3.3) << collision << ": the ball rolls between the panels";
  }
}

/// A box comes to rest on the scaled table, whichever way the table collides; and the table itself rests on its panels.
TEST_F(MeshPropTest, BodiesRestOnThem) {
  for (const char* collision : {"hull", "parts", "surface"}) {
    document = Scenario();
    add(R"("prop": {"shape": "mesh", "mesh": "m-table", "scale": [2, 2, 0.8], "mass": 30, "collision": ")" + std::string(collision) +
        R"("}, "place": {"z": 0.02})");
    add(R"("prop": {"shape": "box", "size": [0.2, 0.2, 0.2], "mass": 3}, "place": {"x": 0.3, "y": 0.1, "z": 0.7})");
    EXPECT_NEAR(root_after(1.5, 0).z, 0, 2e-3) << collision;
    EXPECT_NEAR(root_after(1.5, 1).z, 0.6, 3e-3) << collision;
  }
}

}  // namespace
}  // namespace ugoki::content
