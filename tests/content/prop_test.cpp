// Props: JSON form, commands, checks, and the dynamics of bodies on and among them.

#include <gtest/gtest.h>

#include <cmath>

#include "command_fixture.h"

namespace ugoki::content {
namespace {

class PropTest : public testing::CommandFixture {
 protected:
  static std::string adding(const std::string& fields) { return R"({"type": "character.add", )" + fields + "}"; }
  void add(const std::string& fields) { apply(adding(fields)); }
  void bad(const std::string& fields, ErrorCode code, const std::string& location) { refuses(adding(fields), code, location); }
  /// Position of the root of a character after `seconds`, m.
  Vec3 root_after(double seconds, int character) {
    Player player = open();
    while (player.time() < seconds) EXPECT_TRUE(player.step());
    const std::span<const double> q = player.q(character);
    return {q[0], q[1], q[2]};
  }
};

TEST_F(PropTest, DocumentKeepsThem) {
  add(R"("prop": {"shape": "stairs", "size": [1.5, 2, 0.6], "steps": 4, "tilt": [0, 0, 10], "friction": 0.5}, "place": {"x": 2, "heading": 30})");
  add(R"("prop": {"shape": "sphere", "size": [0.3, 0.3, 0.3], "mass": 2}, "name": "Ball", "mechanism": "m-ball")");
  const ScenarioCharacter& stairs = document.characters[0];
  EXPECT_EQ(stairs.name, "stairs");
  EXPECT_EQ(stairs.control.mode, ControlMode::passive);
  EXPECT_EQ(stairs.prop->steps, 4);
  EXPECT_EQ(document.characters[1].mechanism, prop_mechanism_id(*document.characters[1].prop)) << "the prop decides";
  const Result<Scenario> read = read_scenario(write_scenario(document), "scenario");
  ASSERT_TRUE(read) << read.error().text();
  EXPECT_EQ(*read, document);
  // a changed size is a changed mechanism, and one command
  const std::string before = stairs.mechanism, id = stairs.id;
  apply(R"({"type": "character.set", "id": ")" + id + R"(", "prop": {"steps": 6}})");
  EXPECT_EQ(label, "Change prop");
  EXPECT_EQ(document.characters[0].prop->size, (Vec3{1.5, 2, 0.6}));
  EXPECT_NE(document.characters[0].mechanism, before);
}

TEST_F(PropTest, RefusesFaultyOnes) {
  const std::string at = "scenario/characters/0";
  bad(R"("prop": {"shape": "cone"})", ErrorCode::unknown, "command/prop/shape");
  bad(R"("prop": {"size": [1, 1]})", ErrorCode::syntax, "command/prop/size");
  bad(R"("prop": {"size": [1, 0, 1]})", ErrorCode::range, at + "/prop/size");
  bad(R"("prop": {"shape": "stairs", "steps": 1000})", ErrorCode::range, at + "/prop/steps");
  bad(R"("prop": {"mass": -1})", ErrorCode::range, at + "/prop/mass");
  bad(R"("prop": {}, "control": {"mode": "track"})", ErrorCode::structure, at);
  bad(R"("prop": {"colour": 1})", ErrorCode::unknown, "command/prop/colour");
}

TEST_F(PropTest, RefusesAnotherMechanism) {
  add(R"("prop": {})");
  const std::string id = document.characters[0].id, mechanism = document.characters[0].mechanism;
  refuses(R"({"type": "character.set", "id": ")" + id + R"(", "mechanism": "m-ball"})", ErrorCode::structure, "command/mechanism");
  apply(R"({"type": "character.set", "id": ")" + id + R"(", "mechanism": ")" + mechanism + R"(", "name": "Box"})");
}

TEST_F(PropTest, MassesAreThoseOfSolids) {
  Prop p;
  p.shape = PropShape::cylinder;
  p.size = {0.4, 1, 0.6};
  p.mass = 12;
  const Inertia I = make_prop(p)->link(0).inertia;
  EXPECT_NEAR(I.mass, 12, 1e-12);
  EXPECT_NEAR(I.h.z, 12 * 0.3, 1e-12);
  EXPECT_NEAR(I.I.zz, 0.5 * 12 * 0.2 * 0.2, 1e-12);
  p.shape = PropShape::ramp;  // the centre of a wedge is a third of its length from its back, and at a third of its height
  const Inertia wedge = make_prop(p)->link(0).inertia;
  EXPECT_NEAR(wedge.mass, 12, 1e-9);
  EXPECT_NEAR(wedge.h.x / 12, 0.4 / 6, 1e-9);
  EXPECT_NEAR(wedge.h.z / 12, 0.6 / 3, 1e-9);
  p.mass = 0;
  EXPECT_EQ(make_prop(p)->nv(), 0);
}

/// Boxes come to rest on a platform, on the steps of stairs, and beside both on the ground.
TEST_F(PropTest, BodiesRestOnThem) {
  add(R"("id": "platform", "prop": {"shape": "box", "size": [2, 1, 0.7]}, "place": {"x": 10, "y": 5, "heading": 90})");
  add(R"("id": "stairs", "prop": {"shape": "stairs", "size": [2, 2, 0.8], "steps": 4}, "place": {"x": -5, "y": 1, "heading": 180})");
  const std::string box = R"("prop": {"shape": "box", "size": [0.2, 0.2, 0.2], "mass": 3}, "place": )";
  add(box + R"({"x": 10, "y": 5.8, "z": 1})");   // the platform is turned, so it reaches 1 m along y
  add(box + R"({"x": 10.8, "y": 5, "z": 1})");   // and only 0.5 m along x
  add(box + R"({"x": -5.75, "y": 1, "z": 1})");  // the last step of the turned stairs
  add(box + R"({"x": -4.25, "y": 1, "z": 1})");  // the first one
  EXPECT_NEAR(root_after(1.5, 2).z, 0.7, 1e-3);
  EXPECT_NEAR(root_after(1.5, 3).z, 0, 1e-3);
  EXPECT_NEAR(root_after(1.5, 4).z, 0.8, 1e-3);
  EXPECT_NEAR(root_after(1.5, 5).z, 0.2, 1e-3);
}

/// A box on a ramp of 20 degrees slides with the acceleration g (sin a - mu cos a), or stays if mu > tan a.
TEST_F(PropTest, RampHasCoulombFriction) {
  const double a = 20 * pi / 180, length = 10, mu = 0.2, g = 9.81;
  const auto slide = [&](double friction) {
    document = Scenario();
    const std::string number = std::to_string(friction);
    add(R"("prop": {"shape": "ramp", "size": [)" + std::to_string(length) + ", 2, " + std::to_string(length * std::tan(a)) +
        R"(], "friction": )" + number + "}");
    // the box lies on the slope 4 m above the middle
    const double x = 4 * std::cos(a), z = (0.5 * length + x) * std::tan(a);
    add(R"("prop": {"shape": "box", "size": [0.4, 0.4, 0.1], "mass": 5, "tilt": [0, -20, 0], "friction": )" + number +
        R"(}, "place": {"x": )" + std::to_string(x) + R"(, "z": )" + std::to_string(z) + "}");
    const Vec3 start{x, 0, z}, end = root_after(1, 1);
    return norm(end - start);
  };
  EXPECT_NEAR(slide(mu), 0.5 * g * (std::sin(a) - mu * std::cos(a)), 5e-3);
  EXPECT_NEAR(slide(0.5), 0, 1e-3);
}

TEST_F(PropTest, TerrainHasHillsOfItsSize) {
  Prop p;
  p.shape = PropShape::terrain;
  p.size = {8, 5, 0.6};
  p.grain = 1.5;
  const HeightFieldPtr a = make_prop(p)->link(0).shapes.at(0).field;
  ASSERT_TRUE(a);
  EXPECT_EQ(a->half_x, 4);
  EXPECT_EQ(a->lowest, 0);
  EXPECT_NEAR(a->highest, 0.6, 1e-15);
  for (int c = 0; c < a->columns; ++c) EXPECT_EQ(a->point(c, 0).z, 0) << "the border is at the height of the floor";
  for (int r = 0; r < a->rows; ++r) EXPECT_EQ(a->point(a->columns - 1, r).z, 0);
  // neighbouring hills are about a grain apart: the heights cross their mean about once in each grain
  double mean = 0, crossings = 0;
  for (const double h : a->heights) mean += h / static_cast<double>(a->heights.size());
  for (int r = 5; r < a->rows - 5; ++r)
    for (int c = 1; c < a->columns; ++c) crossings += (a->point(c, r).z > mean) != (a->point(c - 1, r).z > mean);
  const double in_grain = crossings / (a->rows - 10) / (p.size.x / p.grain);
  EXPECT_GT(in_grain, 0.3);
  EXPECT_LT(in_grain, 2);
  // the same numbers give the same hills, and another seed gives others
  EXPECT_EQ(make_prop(p)->link(0).shapes.at(0).field->hash, a->hash);
  p.seed = 2;
  EXPECT_NE(make_prop(p)->link(0).shapes.at(0).field->hash, a->hash);
  p.size = {0.005, 1000, 0.005};  // the limits
  p.grain = Prop::min_grain;
  EXPECT_EQ(make_prop(p)->link(0).shapes.at(0).field->rows, 257);
  EXPECT_NEAR(make_prop(p)->link(0).shapes.at(0).field->highest, 0.005, 1e-15);
  p.grain = Prop::max_grain;  // much longer than the terrain is wide: still a hill
  EXPECT_NEAR(make_prop(p)->link(0).shapes.at(0).field->highest, 0.005, 1e-15);
  bad(R"("prop": {"shape": "terrain", "mass": 3})", ErrorCode::unsupported, "scenario/characters/0/prop/mass");
  bad(R"("prop": {"shape": "terrain", "grain": 0})", ErrorCode::range, "scenario/characters/0/prop/grain");
  bad(R"("prop": {"shape": "terrain", "seed": -1})", ErrorCode::range, "scenario/characters/0/prop/seed");
  bad(R"("prop": {"shape": "terrain", "seed": 1.5})", ErrorCode::range, "command/prop/seed");
}

/// A box that falls onto a terrain comes to rest on it: its lowest corner touches the surface of the hills, and no corner is below it.
TEST_F(PropTest, BodiesRestOnTerrain) {
  document = Scenario();
  add(R"("id": "hills", "prop": {"shape": "terrain", "size": [6, 6, 0.8], "grain": 3, "seed": 4, "friction": 1})");
  add(R"("prop": {"shape": "box", "size": [0.2, 0.2, 0.1], "mass": 3, "friction": 1}, "place": {"x": 0.4, "y": -0.3, "z": 1.2})");
  const HeightFieldPtr field = make_prop(*document.characters[0].prop)->link(0).shapes.at(0).field;
  const auto height_at = [&](double x, double y) {  // bilinear between the grid points, close to the triangles
    const double u = 0.5 * (x / field->half_x + 1) * (field->columns - 1), v = 0.5 * (y / field->half_y + 1) * (field->rows - 1);
    const int c = static_cast<int>(u), r = static_cast<int>(v);
    const double low = field->point(c, r).z * (1 - (u - c)) + field->point(c + 1, r).z * (u - c);
    const double high = field->point(c, r + 1).z * (1 - (u - c)) + field->point(c + 1, r + 1).z * (u - c);
    return low * (1 - (v - r)) + high * (v - r);
  };
  Player player = open();
  Vec3 before;
  while (player.time() < 4) {
    EXPECT_TRUE(player.step());
    if (player.time() < 3.5) before = {player.q(1)[0], player.q(1)[1], player.q(1)[2]};
  }
  const std::span<const double> q = player.q(1);
  const Vec3 end{q[0], q[1], q[2]};
  EXPECT_LT(norm(end - before), 2e-3) << "at rest";
  EXPECT_GT(height_at(end.x, end.y), 0.02) << "not on the floor";
  double lowest = 1;
  for (int k = 0; k < 8; ++k) {
    const Vec3 corner = end + rotate({q[3], q[4], q[5], q[6]}, {k & 1 ? 0.1 : -0.1, k & 2 ? 0.1 : -0.1, k & 4 ? 0.1 : 0});
    lowest = std::min(lowest, corner.z - height_at(corner.x, corner.y));
  }
  EXPECT_NEAR(lowest, 0, 3e-3);
}

/// A mechanism that is bolted to the world stands at the character's place, and moves there as it does at the origin.
TEST_F(PropTest, FixedRootsHaveAPlace) {
  MechanismSpec spec;
  spec.name = "pendulum";
  LinkSpec arm;
  arm.name = "arm";
  arm.joint.type = JointType::revolute;
  arm.joint.X_PJ = {Mat3::identity(), {0, 0, 3}};
  arm.joint.axis = {0, 1, 0};
  arm.inertia = Inertia::from_centre(2, {0.5, 0, 0}, {0.02, 0.02, 0.01, 0, 0, 0});
  arm.shapes.push_back(Shape::capsule(0.05, {}, {0.5, 0, 0}));
  spec.links = {arm};
  resources.mechanisms["m-arm"] = Mechanism::make(spec).value();
  catalogue = catalogue_of(resources);
  const std::string passive = R"("mechanism": "m-arm", "control": {"mode": "passive"})";
  add(passive);
  add(passive + R"(, "place": {"x": 4, "y": -2, "z": 0.5, "heading": 70})");
  Player player = open();
  const auto joint_of = [&](std::size_t c) { return player.world().mechanisms()[c]->link(0).joint.X_PJ.p; };
  EXPECT_NEAR(norm(joint_of(1) - Vec3{4, -2, 3.5}), 0, 1e-12);
  EXPECT_NEAR(norm(joint_of(0) - Vec3{0, 0, 3}), 0, 1e-12);
  while (player.time() < 0.7) ASSERT_TRUE(player.step());
  EXPECT_GT(std::fabs(player.q(0)[0]), 0.5);
  EXPECT_NEAR(player.q(1)[0], player.q(0)[0], 1e-9);
}

}  // namespace
}  // namespace ugoki::content
