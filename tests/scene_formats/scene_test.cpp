#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <span>
#include <string>

#include "made_scene.h"
#include "ugoki/scene_formats/fbx_core.h"
#include "ugoki/scene_formats/scene_file.h"

namespace ugoki::scene_formats {
namespace {

std::span<const std::byte> bytes_of(const std::string& text) { return std::as_bytes(std::span(text.data(), text.size())); }

int joint_named(const MeasuredMotion& m, const std::string& name) {
  for (int i = 0; i < m.joint_count(); ++i)
    if (m.skeleton.joints[static_cast<std::size_t>(i)].name == name) return i;
  return -1;
}

/// Expects equal joint positions (to `tolerance`, m) and rotations relative to the rest pose (to 3 * `tolerance`) in all frames.
void expect_same(const MeasuredMotion& m, const MeasuredMotion& back, double tolerance) {
  ASSERT_EQ(back.frames, m.frames);
  EXPECT_NEAR(back.rate, m.rate, 1e-6);
  std::vector<Pose> X(static_cast<std::size_t>(m.joint_count())), Y(static_cast<std::size_t>(back.joint_count()));
  double distance = 0, turn = 0;
  for (int f = 0; f < m.frames; ++f) {
    m.calc_joint_poses(f, X);
    back.calc_joint_poses(f, Y);
    for (int i = 0; i < m.joint_count(); ++i) {
      const int at = joint_named(back, m.skeleton.joints[static_cast<std::size_t>(i)].name);
      ASSERT_GE(at, 0) << m.skeleton.joints[static_cast<std::size_t>(i)].name;
      const Pose &a = X[static_cast<std::size_t>(i)], &b = Y[static_cast<std::size_t>(at)];
      distance = std::max(distance, norm(a.p - b.p));
      for (int r = 0; r < 3; ++r) turn = std::max(turn, norm(a.R.row(r) - b.R.row(r)));
    }
  }
  EXPECT_LT(distance, tolerance);
  EXPECT_LT(turn, 3 * tolerance);
}

TEST(Scene, FbxReadsBackEqual) {
  for (const char* format : {"fbxa"})
    for (unsigned seed = 1; seed <= 3; ++seed) {
      SCOPED_TRACE(std::string(format) + " " + std::to_string(seed));
      const MeasuredMotion m = random_motion(seed);
      const std::string file = make_scene_file(m, {.format = format, .units_per_metre = 100});
      formats::ReadNotes notes;
      const auto back = read_scene(bytes_of(file), "made.fbx", {}, &notes);
      ASSERT_TRUE(back.has_value()) << back.error().text();
      ASSERT_EQ(back->size(), 1u);
      EXPECT_EQ(notes.metres_per_unit, 0.01);
      expect_same(m, back->front(), 2e-5);  // tolerance: the file has single precision and Euler angles in degrees
    }
}

TEST(Scene, FbxBonesOfASkinMayHaveEqualNames) {
  const MeasuredMotion m = random_motion(3);
  std::string file = make_scene_file(m, {});
  const std::string from = "Model::" + m.skeleton.joints.back().name + "\"", to = "Model::" + m.skeleton.joints[1].name + "\"";
  ASSERT_NE(file.find(from), std::string::npos);
  for (std::size_t at = file.find(from); at != std::string::npos; at = file.find(from)) file.replace(at, from.size(), to);
  const auto read = read_scene(bytes_of(file), "equal.fbx");
  ASSERT_TRUE(read) << read.error().text();
  EXPECT_GE(read->front().joint_count(), 2);
}

// The mesh has a triangle for each joint: the joint, and points 0.1 file units along x and y of the file, so that the mean of the far
// points is (0.05, 0.05, 0) in the file's axes whatever the rest rotation of the bone is. File units are cm; y is up.
TEST(Scene, FbxMeshesGiveTheEndsOfBones) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const MeasuredMotion m = random_motion(seed);
    const std::string file = make_scene_file(m, {.format = "fbxa", .units_per_metre = 100});
    const auto without = read_scene(bytes_of(file), "made.fbx"), with = read_scene(bytes_of(file), "made.fbx", {.mesh_ends = true});
    ASSERT_TRUE(without && with);
    std::vector<char> carries(with->front().skeleton.joints.size(), 0);
    for (const SkeletonJoint& j : with->front().skeleton.joints)
      if (j.parent >= 0) carries[static_cast<std::size_t>(j.parent)] = 1;
    for (std::size_t j = 0; j < carries.size(); ++j) {
      const std::vector<Vec3>& ends = with->front().skeleton.joints[j].end_sites;
      EXPECT_TRUE(without->front().skeleton.joints[j].end_sites.empty());
      ASSERT_EQ(ends.size(), carries[j] != 0 || joint_named(m, with->front().skeleton.joints[j].name) < 0 ? 0u : 1u);
      if (!ends.empty()) EXPECT_LT(norm(ends[0] - Vec3{0, 0.0005, 0.0005}), 1e-6);
    }
  }
}

// A mesh without a skin belongs to the model that carries it, with the model's geometric transform: scale 2, a quarter turn about z, then a
// shift of 3 along z. Its far points (0.1, -1, 0) and (-0.1, -1, 0) are then at (2, 0.2, 3) and (2, -0.2, 3).
TEST(Scene, FbxRigidMeshesGiveTheEndsOfBones) {
  const std::string file = R"(; FBX 7.4.0 project file
FBXHeaderExtension:  {
	FBXVersion: 7400
}
Objects:  {
	Geometry: 1, "Geometry::", "Mesh" {
		Vertices: *9 {
			a: 0,0,0,0.1,-1,0,-0.1,-1,0
		}
		PolygonVertexIndex: *3 {
			a: 0,1,-3
		}
	}
	Model: 2, "Model::leg", "Mesh" {
		Properties70:  {
			P: "GeometricTranslation", "Vector3D", "Vector", "",0,0,3
			P: "GeometricRotation", "Vector3D", "Vector", "",0,0,90
			P: "GeometricScaling", "Vector3D", "Vector", "",2,2,2
		}
	}
}
Connections:  {
	C: "OO",1,2
	C: "OO",2,0
}
)";
  std::map<std::string, Vec3> ends;
  const auto core = fbx_core(std::as_bytes(std::span(file)), "leg.fbx", &ends);
  ASSERT_TRUE(core) << core.error().text();
  ASSERT_TRUE(ends.contains("leg"));
  EXPECT_LT(norm(ends["leg"] - Vec3{2, 0, 3}), 1e-12);
}

// ASCII files of version 6 have fields of curves that are no records of version 7.
TEST(Scene, AnOldAsciiFbxIsRefusedByItsVersion) {
  const std::string file = "; FBX 6.1.0 project file\nFBXHeaderExtension:  {\n\tFBXVersion: 6100\n}\nKey:\n\t0,1.5,L,\n\t10,2.5,L\n";
  const auto read = read_scene(bytes_of(file), "old.fbx");
  ASSERT_FALSE(read);
  EXPECT_NE(read.error().text().find("its version is 6100"), std::string::npos) << read.error().text();
}

TEST(Scene, FbxAxesAndUnitAreRead) {
  const MeasuredMotion m = random_motion(4);
  std::string file = make_scene_file(m, {.format = "fbxa", .units_per_metre = 100});
  const auto set = [&](const std::string& property, const std::string& value) {
    const std::size_t at = file.find("\"" + property + "\"");
    ASSERT_NE(at, std::string::npos) << property;
    const std::size_t end = file.find('\n', at), comma = file.rfind(',', end);
    file.replace(comma + 1, end - comma - 1, value);
  };
  set("UpAxis", "2");
  set("UnitScaleFactor", "2.54");
  formats::ReadNotes notes;
  const auto back = read_scene(bytes_of(file), "made.fbx", {}, &notes);
  ASSERT_TRUE(back.has_value()) << back.error().text();
  EXPECT_TRUE(notes.z_up);
  EXPECT_NEAR(notes.metres_per_unit, 0.0254, 1e-9);
  std::vector<Pose> X(12), Y(static_cast<std::size_t>(back->front().joint_count()));
  m.calc_joint_poses(7, X);
  back->front().calc_joint_poses(7, Y);
  for (int i = 0; i < 12; ++i) {
    const Vec3 p = X[static_cast<std::size_t>(i)].p,
               q = Y[static_cast<std::size_t>(joint_named(back->front(), m.skeleton.joints[static_cast<std::size_t>(i)].name))].p;
    // The file was written with Y up: (x, y, z) as (y, z, x). With UpAxis = 2 its coordinates are used unchanged.
    EXPECT_LT(norm(q - Vec3{p.y, p.z, p.x} * 2.54), 1e-4);
  }
}

TEST(Scene, ColladaReadsBackEqual) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const MeasuredMotion m = random_motion(seed);
    const std::string file = make_scene_file(m, {.format = "collada"});
    const auto back = read_scene(bytes_of(file), "made.dae");
    ASSERT_TRUE(back.has_value()) << back.error().text();
    ASSERT_EQ(back->size(), 1u);
    expect_same(m, back->front(), 2e-5);
  }
}

/// Expected positions, calculated by hand: the hip at (1, 2, 3), the arm 4 units along y from the hip, the tip 5 units along z from the
/// arm. The arm rotates about x by 90 degrees.
TEST(Scene, ColladaAxesAndUnitAreRead) {
  for (const std::string& up : {std::string("Y_UP"), std::string("Z_UP")}) {
    SCOPED_TRACE(up);
    const std::string text = collada_text(up, 0.1);
    const auto back = read_scene(bytes_of(text), "hand.dae", {.rate = 10});
    ASSERT_TRUE(back.has_value()) << back.error().text();
    const MeasuredMotion& m = back->front();
    ASSERT_EQ(m.frames, 11);
    std::vector<Pose> X(static_cast<std::size_t>(m.joint_count()));
    const auto file = [&](const Vec3& p) { return (up == "Y_UP" ? Vec3{p.z, p.x, p.y} : p) * 0.1; };
    m.calc_joint_poses(0, X);
    const auto at = [&](const char* name) { return X[static_cast<std::size_t>(joint_named(m, name))].p; };
    EXPECT_LT(norm(at("arm") - file({1, 6, 3})), 1e-5);
    EXPECT_LT(norm(at("tip") - file({1, 6, 8})), 1e-5);
    m.calc_joint_poses(10, X);
    EXPECT_LT(norm(at("tip") - file({1, 1, 3})), 1e-5);  // rotation about x maps z to -y
  }
}

TEST(Scene, FilesWithoutSkinGiveAnimatedNodes) {
  const MeasuredMotion m = random_motion(6);
  const std::string file = make_scene_file(m, {.format = "fbxa", .units_per_metre = 100, .skin = false});
  const auto back = read_scene(bytes_of(file), "bare.fbx");
  ASSERT_TRUE(back.has_value()) << back.error().text();
  expect_same(m, back->front(), 2e-5);
}

TEST(Scene, UnreadableFilesAreRefused) {
  const auto refused = [](const std::string& text, const char* name) {
    const auto r = read_scene(bytes_of(text), name);
    EXPECT_FALSE(r.has_value());
    return r ? std::string() : r.error().text();
  };
  EXPECT_NE(refused("", "x.fbx").find("empty"), std::string::npos);
  EXPECT_NE(refused("hello", "x.fbx").find("cannot be read"), std::string::npos);
  EXPECT_NE(refused("<COLLADA/>", "x.dae").find("x.dae"), std::string::npos);
  EXPECT_NE(refused("hello", "x.blend").find("neither"), std::string::npos);
}

/// The text with the first `old` replaced by `now`.
std::string with(std::string text, const std::string& old, const std::string& now) {
  const std::size_t at = text.find(old);
  EXPECT_NE(at, std::string::npos) << old;
  return at == std::string::npos ? text : text.replace(at, old.size(), now);
}

TEST(Scene, ColladaWithInvalidReferencesIsRefused) {
  const std::string good = collada_text("Y_UP", 1);
  struct Case {
    const char *old, *now, *location, *words;
  };
  const Case cases[] = {
      {"count=\"2\">0 1<", "count=\"0\">0 1<", "<accessor>", "exceed its array of 0"},
      {"count=\"2\">0 1<", "count=\"3\">0 1<", "line 5, <float_array>", "declares 3 values, but has 2"},
      {"#times-a\" count=\"2\"", "#times-a\" count=\"2\" stride=\"9\"", "<accessor>", "exceed its array"},
      {"#times-a\" count=\"2\"", "#times-a\" count=\"2\" offset=\"99999999999\"", "<accessor>", "not an integer from"},
      {"#times-a\" count=\"2\"", "#times-a\" count=\"1\"", "<channel>", "1 times, but 2 values"},
      {"OUTPUT\" source=\"#angles\"", "OUTPUT\" source=\"#nothing\"", "<input>", "which does not exist"},
      {"OUTPUT\" source=\"#angles\"", "OUTPUT\" source=\"#how\"", "<channel>", "names, not numbers"},
      {">0 90<", ">0 ninety<", "<channel>", "not a valid number"},
      {">0 90<", ">0 9e8<", "<channel>", "too many turns"},
      {">0 1<", ">1 0<", "<channel>", "decrease"},
      {"ANGLE\" type=\"float\"", "ANGLE\" type=\"float4x4\"", "<accessor>", "exceed its array"},
      {">0 4 0<", ">0 4<", "line 13, <translate>", "2 of 3 numbers"},
      {"<instance_visual_scene url=\"#scene\"", "<instance_visual_scene url=\"#no\"", "<instance_visual_scene>", "which does not exist"},
      {">0 0 5</translate>", ">0 0 5</translate><instance_node url=\"#hip\"/>", "<", "is its own ancestor"},
      {"</COLLADA>", "", "line", "cannot be read"},
  };
  for (const Case& c : cases) {
    const auto r = read_scene(bytes_of(with(good, c.old, c.now)), "x.dae");
    ASSERT_FALSE(r.has_value()) << c.old << " -> " << c.now;
    const std::string text = r.error().text();
    EXPECT_NE(text.find(c.location), std::string::npos) << text;
    EXPECT_NE(text.find(c.words), std::string::npos) << text;
    EXPECT_NE(text.find("Export it again"), std::string::npos) << text;
  }
}

TEST(Scene, ColladaReadsSkeletonDespiteOtherDefects) {
  const std::string good = collada_text("Y_UP", 1);
  const auto plain = read_scene(bytes_of(good), "x.dae");
  ASSERT_TRUE(plain);
  const std::string broken =
      "<library_materials><material id=\"m\"><instance_effect url=\"nowhere\"/></material></library_materials>"
      "<library_geometries><geometry id=\"g\"><mesh><vertices id=\"v\"/><polylist count=\"7\"><vcount>3</vcount><p>99 x 7</p></polylist>"
      "</mesh></geometry></library_geometries><library_visual_scenes>";
  std::string text = with(good, "<library_visual_scenes>", broken);
  text = with(text, "<node id=\"tip\"", "<instance_camera url=\"#c\"/><instance_geometry url=\"#none\"/><node id=\"tip\"");
  text = with(text, "<channel ",
              "<channel source=\"#s\" target=\"lamp/colour.R\"/><channel source=\"#no\" target=\"arm/bend.ANGLE\"/><channel ");
  const auto more = read_scene(bytes_of(text), "x.dae");
  ASSERT_TRUE(more) << more.error().text();
  ASSERT_EQ(more->size(), 1u);
  expect_same(plain->front(), more->front(), 1e-12);
}

/// A skin uses the joints that have a positive weight: here `arm`; `hip` only has a weight of zero.
TEST(Scene, ColladaSkinsUseWeightedJoints) {
  const auto source = [](const std::string& id, const std::string& array, const std::string& words, int count) {
    const std::string n = std::to_string(count);
    return "<source id=\"" + id + "\"><" + array + " id=\"" + id + "-a\" count=\"" + n + "\">" + words + "</" + array +
           "><technique_common><accessor source=\"#" + id + "-a\" count=\"" + n + "\"/></technique_common></source>";
  };
  const std::string skin =
      "<library_geometries><geometry id=\"g\"><mesh><triangles count=\"1\"><p>0 1 2</p></triangles></mesh></geometry></library_geometries>"
      "<library_controllers><controller id=\"c\"><skin source=\"#g\">" +
      source("names", "Name_array", "hip arm", 2) + source("weights", "float_array", "0 0.5", 2) +
      "<vertex_weights count=\"3\"><input semantic=\"JOINT\" source=\"#names\" offset=\"0\"/><input semantic=\"WEIGHT\" "
      "source=\"#weights\" "
      "offset=\"1\"/><vcount>2 1 0</vcount><v>0 0 1 1 1 1</v></vertex_weights></skin></controller></library_controllers>"
      "<library_visual_scenes>";
  std::string text = with(collada_text("Y_UP", 1), "<library_visual_scenes>", skin);
  text = with(text, "<node id=\"hip\"", "<node id=\"body\"><instance_controller url=\"#c\"/></node><node id=\"hip\"");
  const auto back = read_scene(bytes_of(text), "x.dae");
  ASSERT_TRUE(back) << back.error().text();
  ASSERT_EQ(back->front().joint_count(), 1);
  EXPECT_EQ(back->front().skeleton.joints[0].name, "arm");
  for (const auto& [old, now, words] : {std::tuple{"<v>0 0 1 1 1 1<", "<v>0 0 1 1 2 1<", "Pair 3 of <v> refers to a joint"},
                                        std::tuple{"<v>0 0 1 1 1 1<", "<v>0 0 1 1 1 2<", "Pair 3 of <v> refers to a joint"},
                                        std::tuple{"<vcount>2 1 0<", "<vcount>2 9 0<", "shorter than its <vcount>"},
                                        std::tuple{"JOINT\" source=\"#names\"", "JOINT\" source=\"#weights\"", "must be names"}}) {
    const auto r = read_scene(bytes_of(with(text, old, now)), "x.dae");
    ASSERT_FALSE(r) << now;
    EXPECT_NE(r.error().text().find(words), std::string::npos) << r.error().text();
  }
}

/// A handwritten file: a hip and a knee, which rotates about z from 0 to 30 degrees within one second.
constexpr const char* fbx_text = R"(; FBX 7.4.0 project file
FBXHeaderExtension:  {
  FBXVersion: 7400
}
Objects:  {
  Model: 10, "Model::hip", "LimbNode" {
    Properties70:  {
      P: "Lcl Translation", "Lcl Translation", "", "A", 0.0, 90.0, 0.0
    }
  }
  Model: 11, "Model::knee", "LimbNode" {
    Properties70:  {
      P: "Lcl Translation", "Lcl Translation", "", "A", 0.0, -40.0, 0.0
    }
  }
  AnimationStack: 20, "AnimStack::walk", "" {
  }
  AnimationLayer: 21, "AnimLayer::base", "" {
  }
  AnimationCurveNode: 23, "AnimCurveNode::R", "" {
    Properties70:  {
      P: "d|Z", "Number", "", "A", 0.0
    }
  }
  AnimationCurve: 24, "AnimCurve::", "" {
    KeyTime: *2 {
      a: 0,46186158000
    }
    KeyValueFloat: *2 {
      a: 0.0,30.0
    }
  }
}
Connections:  {
  C: "OO",10,0
  C: "OO",11,10
  C: "OO",21,20
  C: "OO",23,21
  C: "OP",23,11, "Lcl Rotation"
  C: "OP",24,23, "d|Z"
}
)";

TEST(Scene, FbxReadsSkeletonDespiteOtherDefects) {
  const auto plain = read_scene(bytes_of(fbx_text), "x.fbx");
  ASSERT_TRUE(plain) << plain.error().text();
  ASSERT_EQ(plain->size(), 1u);
  const MeasuredMotion& m = plain->front();
  ASSERT_EQ(m.frames, 2);
  std::vector<Pose> X(static_cast<std::size_t>(m.joint_count()));
  m.calc_joint_poses(1, X);
  const Pose& knee = X[static_cast<std::size_t>(joint_named(m, "knee"))];
  EXPECT_LT(norm(knee.p - Vec3{0, 0, 0.5}), 1e-6);  // Y up, centimetres
  EXPECT_NEAR(std::fabs(knee.R.row(2).y), 0.5, 1e-6);
  const std::string broken =
      "Objects:  {\n  Material: 5, \"Material::m\" {\n }\n  Video: 6, \"Video::v\", \"Clip\" {\n Content: , \"AAAA\"\n }\n"
      "  Geometry: 7, \"Geometry::g\", \"Mesh\" {\n    PolygonVertexIndex: *9 {\n      a: 5,6,x\n    }\n  }\n"
      "  AnimationCurve: 8, \"AnimCurve::none\", \"\" {\n    KeyTime: *0 {\n a: \n }\n    KeyValueFloat: *0 {\n a: \n }\n  }\n";
  std::string text = with(fbx_text, "Objects:  {\n", broken);
  text =
      with(text, "Connections:  {\n", "Connections:  {\n  C: \"OO\",5,11\n  C: \"OO\",6,5\n  C: \"OP\",8,23, \"d|X\"\n  C: \"OO\",99,10\n");
  const auto more = read_scene(bytes_of(text), "x.fbx");
  ASSERT_TRUE(more) << more.error().text();
  expect_same(plain->front(), more->front(), 1e-12);
}

// A skin that weights the hip only, as in files in which the half of a body is mirrored: the knee, which turns, belongs to the skeleton;
// an end that does not turn, and a mesh that turns with the knee (a shoe), do not.
TEST(Scene, NodesBelowABoneThatTurnAreJointsWithoutWeights) {
  std::string text = with(fbx_text, "Objects:  {\n", R"(Objects:  {
  Geometry: 40, "Geometry::g", "Mesh" {
    Vertices: *9 {
      a: 0,0,0,1,0,0,0,1,0
    }
    PolygonVertexIndex: *3 {
      a: 0,1,-3
    }
  }
  Model: 41, "Model::body", "Mesh" {
  }
  Deformer: 42, "Deformer::", "Skin" {
  }
  Deformer: 43, "SubDeformer::", "Cluster" {
    Indexes: *3 {
      a: 0,1,2
    }
    Weights: *3 {
      a: 1,1,1
    }
  }
  Geometry: 44, "Geometry::s", "Mesh" {
    Vertices: *9 {
      a: 0,0,0,1,0,0,0,1,0
    }
    PolygonVertexIndex: *3 {
      a: 0,1,-3
    }
  }
  Model: 45, "Model::shoe", "Mesh" {
  }
  Model: 46, "Model::end", "LimbNode" {
  }
)");
  text = with(text, "Connections:  {\n", R"(Connections:  {
  C: "OO",40,41
  C: "OO",41,0
  C: "OO",42,40
  C: "OO",43,42
  C: "OO",10,43
  C: "OO",44,45
  C: "OO",45,11
  C: "OO",46,11
)");
  const auto read = read_scene(bytes_of(text), "x.fbx");
  ASSERT_TRUE(read) << read.error().text();
  const MeasuredMotion& m = read->front();
  EXPECT_EQ(m.joint_count(), 2);
  EXPECT_GE(joint_named(m, "hip"), 0);
  EXPECT_GE(joint_named(m, "knee"), 0);
}

// A stack whose span of time is elsewhere than its keys: the library stops the process at a property without a key in the span.
TEST(Scene, AnFbxStackWithoutKeysInItsSpanLastsFromItsFirstToItsLastKey) {
  constexpr std::int64_t min_time = std::numeric_limits<std::int64_t>::min();
  for (const auto& [start, stop] :
       {std::pair<std::int64_t, std::int64_t>(92372316000, 138558474000), {-92372316000, -46186158000}, {min_time, min_time + 1}}) {
    const std::string span =
        "  AnimationStack: 20, \"AnimStack::walk\", \"\" {\n    Properties70:  {\n      P: \"LocalStart\", \"KTime\", \"Time\", \"\"," +
        std::to_string(start) + "\n      P: \"LocalStop\", \"KTime\", \"Time\", \"\"," + std::to_string(stop) + "\n    }\n";
    const auto read = read_scene(bytes_of(with(fbx_text, "  AnimationStack: 20, \"AnimStack::walk\", \"\" {\n", span)), "x.fbx");
    ASSERT_TRUE(read) << read.error().text();
    expect_same(read->front(), read_scene(bytes_of(fbx_text), "x.fbx")->front(), 1e-12);
  }
}

TEST(Scene, EachStackOfAnFbxFileIsAMotion) {
  // Stacks of a motion editor: a second one with its own keys, one without a layer, and one whose layer has no curves.
  std::string text = with(fbx_text, "  AnimationLayer: 21", R"(  AnimationStack: 30, "AnimStack::run", "" {
  }
  AnimationStack: 40, "AnimStack::empty", "" {
  }
  AnimationStack: 50, "AnimStack::still", "" {
  }
  AnimationLayer: 31, "AnimLayer::base", "" {
  }
  AnimationLayer: 51, "AnimLayer::base", "" {
  }
  AnimationCurveNode: 33, "AnimCurveNode::R", "" {
    Properties70:  {
      P: "d|Z", "Number", "", "A", 0.0
    }
  }
  AnimationCurve: 34, "AnimCurve::", "" {
    KeyTime: *2 {
      a: 0,46186158000
    }
    KeyValueFloat: *2 {
      a: 0.0,60.0
    }
  }
  AnimationLayer: 21)");
  text = with(text, "Connections:  {\n", R"(Connections:  {
  C: "OO",31,30
  C: "OO",33,31
  C: "OP",33,11, "Lcl Rotation"
  C: "OP",34,33, "d|Z"
  C: "OO",51,50
)");
  const auto read = read_scene(bytes_of(text), "x.fbx");
  ASSERT_TRUE(read) << read.error().text();
  ASSERT_GE(read->size(), 2u);
  const auto turn = [](const MeasuredMotion& m) {
    std::vector<Pose> X(static_cast<std::size_t>(m.joint_count()));
    m.calc_joint_poses(m.frames - 1, X);
    return std::fabs(X[static_cast<std::size_t>(joint_named(m, "knee"))].R.row(2).y);
  };
  int walk = 0, run = 0;
  for (const MeasuredMotion& m : *read) {
    walk += m.name.find("walk") != std::string::npos && std::fabs(turn(m) - 0.5) < 1e-6 ? 1 : 0;
    run += m.name.find("run") != std::string::npos && std::fabs(turn(m) - 0.8660254) < 1e-6 ? 1 : 0;
  }
  EXPECT_EQ(walk, 1);
  EXPECT_EQ(run, 1);
}

TEST(Scene, DefectiveFbxIsRefused) {
  struct Case {
    const char *old, *now, *location, *words;
  };
  const Case cases[] = {
      {"a: 0.0,30.0", "a: 0.0", "line 29, 'KeyValueFloat'", "declares 2 numbers, but has 1"},
      {"KeyValueFloat: *2 {\n      a: 0.0,30.0", "KeyValueFloat: *1 {\n      a: 0.0", "AnimationCurve", "2 times, but 1 values"},
      {"a: 0.0,30.0", "a: 0.0,nan", "KeyValueFloat", "not a valid number"},
      {"a: 0,46186158000", "a: 46186158000,0", "KeyTime", "decrease"},
      {"a: 0,46186158000", "a: 0,91861580000000000", "KeyTime", "exceeds one million seconds"},
      {"a: 0.0,30.0", "a: 0.0,3e9", "AnimationCurve", "100,000 turns"},
      {"\"OO\",10,0", "\"OO\",10,0\n  C: \"OO\",10,11", "Model", "is its own ancestor"},
      {"FBXVersion: 7400", "FBXVersion: 6100", "x.fbx", "6100"},
      {"  AnimationStack: 20", "  } AnimationStack: 20", "line", "cannot be read"},
      {"23, \"d|Z\"", "23, \"d|Z", "line 40", "not closed"},
  };
  for (const Case& c : cases) {
    const auto r = read_scene(bytes_of(with(fbx_text, c.old, c.now)), "x.fbx");
    ASSERT_FALSE(r.has_value()) << c.old << " -> " << c.now;
    const std::string text = r.error().text();
    EXPECT_NE(text.find(c.location), std::string::npos) << text;
    EXPECT_NE(text.find(c.words), std::string::npos) << text;
    EXPECT_NE(text.find("Export it again"), std::string::npos) << text;
  }
}

/// A binary FBX file of one record with one array. The parameters set the fields of the headers, also to wrong values.
std::string binary_fbx(std::uint32_t count, std::uint32_t packed, std::uint32_t bytes, std::uint32_t end) {
  std::string out("Kaydara FBX Binary  \0\x1a\0", 23);
  const auto put = [&](std::uint32_t x) { out.append(reinterpret_cast<const char*>(&x), sizeof x); };
  for (const std::uint32_t x : {7400u, end, 1u, 21u}) put(x);
  out += "\7KeyTimel";
  for (const std::uint32_t x : {count, packed, bytes}) put(x);
  return out + std::string(8, '\0') + std::string(13, '\0');
}

TEST(Scene, BinaryFbxWithWrongSizesIsRefused) {
  const auto error_of = [](const std::string& file) {
    const auto r = read_scene(bytes_of(file), "x.fbx");
    EXPECT_FALSE(r.has_value());
    return r ? std::string() : r.error().text();
  };
  EXPECT_NE(error_of(binary_fbx(1, 0, 8, 68)).find("no objects"), std::string::npos) << "valid, but without objects";
  EXPECT_NE(error_of(binary_fbx(1, 0, 8, 69)).find("byte"), std::string::npos);
  EXPECT_NE(error_of(binary_fbx(1, 0, 9, 68)).find("longer than its record"), std::string::npos);
  EXPECT_NE(error_of(binary_fbx(1, 0, 8, 900)).find("exceeds its parent"), std::string::npos);
  for (const std::uint32_t end : {5u, 28u, 39u, 46u})
    EXPECT_NE(error_of(binary_fbx(1, 0, 8, end)).find("exceeds its parent"), std::string::npos) << end;
  EXPECT_NE(error_of(binary_fbx(1, 0, 8, 68).substr(0, 35)).find("truncated"), std::string::npos);
}

}  // namespace
}  // namespace ugoki::scene_formats
