// `ugoki convert`: from every kind of file to every format that can store it, and refused conversions.
#include <algorithm>
#include <filesystem>
#include <sstream>

#include "cli_fixture.h"
#include "ugoki/formats/asf.h"
#include "ugoki/formats/bvh.h"
#include "ugoki/formats/c3d.h"
#include "ugoki/formats/csv.h"
#include "ugoki/formats/gltf.h"
#include "ugoki/formats/mechanism_json.h"
#include "ugoki/formats/trc.h"
#include "ugoki/samples/samples.h"

namespace ugoki::cli {
namespace {

namespace fs = std::filesystem;

class ConvertCliTest : public CliTest {
 protected:
  /// Maximum distance [m], over all frames, between joints of the sample walk and joints of the same name in `m`.
  static double off(const MeasuredMotion& m) {
    const MeasuredMotion walk = samples::make_human_walk();
    EXPECT_EQ(m.frames, walk.frames);
    double worst = 0;
    std::vector<Pose> X, Y;
    for (int f = 0; f < std::min(m.frames, walk.frames); ++f) {
      walk.calc_joint_poses(f, X);
      m.calc_joint_poses(f, Y);
      for (std::size_t i = 0; i < X.size(); ++i) {
        std::size_t k = 0;
        while (k < Y.size() && m.skeleton.joints[k].name != walk.skeleton.joints[i].name && !(i == 0 && k == 0)) ++k;
        EXPECT_LT(k, Y.size()) << walk.skeleton.joints[i].name;
        if (k < Y.size()) worst = std::max(worst, norm(X[i].p - Y[k].p));
      }
    }
    return worst;
  }
  /// Writes a recording of three markers; one of them has a gap.
  std::string markers() const {
    return write("markers.trc",
                 "PathFileType\t4\t(X/Y/Z)\tmarkers.trc\nDataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\t"
                 "OrigDataStartFrame\tOrigNumFrames\n50\t50\t3\t3\tmm\t50\t1\t3\nFrame#\tTime\tHead\t\t\tHand\t\t\tHeel\t\t\n"
                 "\t\tX1\tY1\tZ1\tX2\tY2\tZ2\tX3\tY3\tZ3\n\n1\t0\t1\t1700\t3\t400\t900\t5\t7\t20\t9\n"
                 "2\t0.02\t2\t1701\t203\t\t\t\t7\t20\t209\n3\t0.04\t3\t1702\t403\t401\t901\t405\t7\t20\t409\n");
  }
};

TEST_F(ConvertCliTest, FillClosesGapsOfARecording) {
  const Json as_recorded = json({"convert", markers(), path("as-recorded.trc")});
  EXPECT_FALSE(formats::read_trc(read(path("as-recorded.trc")), "m")->seen(1, 1));
  const Json filled = json({"convert", markers(), path("filled.trc"), "--fill"});
  const auto back = formats::read_trc(read(path("filled.trc")), "m");
  ASSERT_TRUE(back && back->seen(1, 1));
  EXPECT_LT(norm(back->at(1, 1) - Vec3{0.205, 0.4005, 0.9005}), 1e-6);  // interpolated in the middle of the gap; z is up
  EXPECT_NE(filled["report"].dump().find("1 positions in short gaps"), std::string::npos) << filled;
}

TEST_F(ConvertCliTest, MotionConvertsToEveryFormat) {
  const std::string clip = walk();
  const Json bvh = json({"convert", clip, path("again.bvh")});
  EXPECT_EQ(bvh["file"], path("again.bvh"));
  EXPECT_LT(off(*formats::read_bvh(read(path("again.bvh")), "again.bvh")), 1e-6);

  const Json amc = json({"convert", clip, path("man_1.amc")});
  EXPECT_EQ(amc["beside"], Json::array({path("man.asf")}));
  const auto asf = formats::read_asf(read(path("man.asf")), "man.asf");
  ASSERT_TRUE(asf) << asf.error().text();
  const auto motion = formats::read_amc(read(path("man_1.amc")), "man_1.amc", *asf, {.rate = samples::make_human_walk().rate});
  ASSERT_TRUE(motion) << motion.error().text();
  EXPECT_LT(off(*motion), 1e-6);
  EXPECT_LT(off(*formats::read_bvh((does({"convert", path("man_1.amc"), path("back.bvh"), "--rate", "100"}), read(path("back.bvh"))), "b")),
            1e-6);

  does({"convert", clip, path("walk.glb")});
  const std::string glb = read(path("walk.glb"));
  const auto from_glb = formats::read_gltf(std::as_bytes(std::span(glb)), "walk.glb", {.rate = samples::make_human_walk().rate});
  ASSERT_TRUE(from_glb) << from_glb.error().text();
  EXPECT_LT(off(from_glb->at(0)), 1e-5);

  does({"convert", clip, path("places.csv"), "--positions", "--decimals", "6"});
  const auto places = formats::read_csv(read(path("places.csv")), "places.csv");
  ASSERT_TRUE(places) << places.error().text();
  EXPECT_EQ(places->marker_count(), samples::make_human_walk().joint_count());

  // Coordinates can be read only together with their mechanism.
  does({"convert", clip, path("angles.csv"), "--radians"});
  does({"convert", clip, path("man.json")});
  const std::string head = read(path("angles.csv")).substr(0, 2000);
  EXPECT_NE(head.find("[rad]"), std::string::npos) << head;
  fails({"convert", path("angles.csv"), path("out.bvh")}, "--mechanism");
  does({"convert", path("angles.csv"), path("out.bvh"), "--mechanism", path("man.json")});
  EXPECT_EQ(formats::read_bvh(read(path("out.bvh")), "out.bvh")->frames, samples::make_human_walk().frames);
}

TEST_F(ConvertCliTest, LibraryMotionConverts) {
  json({"import", walk()});
  const Json j = json({"convert", "walk", path("out.bvh")});
  EXPECT_FALSE(j["report"].empty()) << "the report should mention the masses";
  EXPECT_EQ(formats::read_bvh(read(path("out.bvh")), "out.bvh")->frames, samples::make_human_walk().frames);
  fails({"convert", "stroll", path("other.bvh")}, "stroll");
}

TEST_F(ConvertCliTest, MarkersConvertAsMarkers) {
  const auto source = formats::read_trc(read(markers()), "markers.trc", {.up = formats::UpAxis::y});
  ASSERT_TRUE(source);
  does({"convert", path("markers.trc"), path("a.c3d")});
  does({"convert", path("a.c3d"), path("b.csv")});
  does({"convert", path("b.csv"), path("c.trc")});
  for (const char* name : {"a.c3d", "b.csv", "c.trc"}) {
    SCOPED_TRACE(name);
    const std::string bytes = read(path(name));
    const auto back = std::string(name) == "a.c3d"   ? formats::read_c3d(std::as_bytes(std::span(bytes)), name)
                      : std::string(name) == "b.csv" ? formats::read_csv(bytes, name)
                                                     : formats::read_trc(bytes, name, {.up = formats::UpAxis::y});
    ASSERT_TRUE(back) << back.error().text();
    EXPECT_EQ(back->labels, source->labels);
    EXPECT_EQ(back->rate, 50);
    ASSERT_EQ(back->frames, 3);
    EXPECT_FALSE(back->seen(1, 1));
    for (std::size_t i = 0; i < back->positions.size(); ++i) EXPECT_LT(norm(back->positions[i] - source->positions[i]), 1e-6);
  }
  fails({"convert", walk(), path("a.trc")}, "no markers");
  fails({"convert", path("markers.trc"), path("m.bvh")}, "markers");  // three markers are not enough for a skeleton
}

TEST_F(ConvertCliTest, MechanismConvertsToEveryFormat) {
  const std::string clip = walk();
  for (const char* name : {"man.json", "man.urdf", "man.xml"}) {
    SCOPED_TRACE(name);
    does({"convert", clip, path(name)});
    const Json info = json({"info", path(name), "--base", "floating"});
    EXPECT_EQ(info["kind"], "mechanism");
  }
  const Json from_json = json({"info", path("man.json")}), from_xml = json({"info", path("man.xml")});
  EXPECT_EQ(from_json["dofs"], from_xml["dofs"]);
  EXPECT_NEAR(from_json["mass_kg"].get<double>(), from_xml["mass_kg"].get<double>(), 1e-9);
  fails({"convert", path("man.json"), path("man.bvh")}, "no motion");
  fails({"convert", path("man.json"), path("man.glb")}, "no motion");
  fails({"convert", markers(), path("markers.json")}, "markers.trc");
}

TEST_F(ConvertCliTest, BadInputIsRefusedWithRemedy) {
  const std::string clip = walk();
  fails({"convert", clip, path("walk.doc")}, "walk.doc");
  fails({"convert", clip, path("walk")}, "Files with this extension cannot be written");
  fails({"convert", path("absent.bvh"), path("out.bvh")}, "absent.bvh");
  fails({"convert", write("empty.bvh", ""), path("out.glb")}, "empty.bvh");
  fails({"convert", write("half.bvh", read(clip).substr(0, 5000)), path("out.amc")}, "half.bvh:");
  fails({"convert", clip, path("no/such/folder.bvh")}, "folder.bvh");
  fails({"convert", clip, path("no/such/folder_1.amc")}, "folder");
  fails({"convert", write("walk_1.amc", ":FULLY-SPECIFIED\n:DEGREES\n1\nroot 0 0 0 0 0 0\n"), path("out.bvh")}, "walk.asf");
  fails({"convert", write("broken.urdf", "<robot name='r'><link name='a'>"), path("out.json")}, "broken.urdf:1");
  fails({"convert", write("macro.xacro", "<robot xmlns:xacro='x'>\n<xacro:macro name='a'/></robot>"), path("out.json")}, "macro.xacro:2");
  fails({"convert", write("b.csv", "time,other\n0,1\n1,2\n"), path("out.bvh")}, "b.csv");
  misunderstands({"convert", clip});
  misunderstands({"convert", clip, path("out.bvh"), "--decimals", "40"});
  misunderstands({"convert", clip, path("out.bvh"), "--unit", "0"});
  misunderstands({"convert", clip, path("out.bvh"), "--rate", "fast"});
  const Output o = ugoki({"convert", path("half.bvh"), path("out.bvh"), "--json"});
  EXPECT_FALSE(Json::parse(o.out)["error"]["problems"].empty());
}

TEST_F(ConvertCliTest, InputsAndNeededSkeletonsAreNotOverwritten) {
  const std::string clip = walk();
  fails({"convert", clip, clip}, "walk.bvh");
  fs::create_symlink(clip, path("link.bvh"));
  fails({"convert", clip, path("link.bvh")}, "link.bvh");
  does({"convert", clip, path("man_1.amc")});
  // man_1.amc needs man.asf, which a motion of another skeleton must not overwrite.
  const std::string other = write("other.bvh",
                                  "HIERARCHY\nROOT a\n{\nOFFSET 0 0 0\nCHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation "
                                  "Yrotation\nJOINT b\n{\nOFFSET 0 1 0\nCHANNELS 3 Zrotation Xrotation Yrotation\nEnd Site\n{\nOFFSET 0 "
                                  "1 0\n}\n}\n}\nMOTION\nFrames: 2\nFrame Time: 0.01\n0 0 0 0 0 0 0 0 0\n0 0 0 9 0 0 9 0 0\n");
  fails({"convert", other, path("man_2.amc")}, "man.asf");
  does({"convert", clip, path("man_1.amc")});  // identical files may be written again
  does({"convert", clip, path("man_3.amc")});  // man_3.amc needs the same skeleton as man_1.amc
  fails({"convert", path("man_1.amc"), path("man_1.amc")}, "man_1.amc");
}

TEST_F(ConvertCliTest, RealFilesConvert) {
  const fs::path data = UGOKI_SHARED_DATA;
  if (!fs::exists(data / "human")) GTEST_SKIP() << "no shared data next to the project";
  const struct {
    const char *file, *out;
  } files[] = {{"human/asf_amc/02_01.amc", "02_01.bvh"},
               {"human/c3d/02_01.c3d", "02_01.csv"},
               {"animal/Fox.glb", "fox.bvh"},
               {"mechanism/closed_loop/example-parallel-robots/robot_delta/robot.urdf", "delta.xml"},
               {"mechanism/open_chain/menagerie_xml_only/unitree_a1/a1.xml", "a1.urdf"},
               {"mechanism/closed_loop/cassie_sdf/cassie_v2.sdf", "cassie.json"}};
  for (const auto& f : files) {
    SCOPED_TRACE(f.file);
    does({"convert", (data / f.file).string(), path(f.out), "--meshes", "none"});
    EXPECT_FALSE(read(path(f.out)).empty());
  }
}

}  // namespace
// The joints of the BVH file are where the table of the same export has the links.
TEST_F(ConvertCliTest, SimulatedMotionIsWrittenAsBvh) {
  does({"new", path("park.ugoki")});
  json({"export", path("park.ugoki"), "--bvh", path("dog.bvh"), "--csv", path("park.csv"), "--character", "dog", "--duration", "0.2", "--rate",
        "50", "--json"});
  const auto motion = formats::read_bvh(read(path("dog.bvh")), "dog.bvh", {.metres_per_unit = 0.01});
  ASSERT_TRUE(motion) << motion.error().text();
  EXPECT_EQ(motion->frames, 11);
  EXPECT_NEAR(motion->rate, 50, 1e-3);
  std::istringstream lines(read(path("park.csv")));
  std::string line;
  const auto cells_of = [](const std::string& text) {
    std::vector<std::string> out;
    std::istringstream cells(text);
    for (std::string cell; std::getline(cells, cell, ',');) out.push_back(cell);
    return out;
  };
  std::getline(lines, line);
  const std::vector<std::string> columns = cells_of(line);
  int compared = 0;
  for (int f = 0; f < motion->frames; ++f) {
    ASSERT_TRUE(std::getline(lines, line));
    const std::vector<std::string> row = cells_of(line);
    std::vector<Pose> X(motion->skeleton.joints.size());
    motion->calc_joint_poses(f, X);
    for (std::size_t j = 0; j < X.size(); ++j) {
      const auto column = std::ranges::find(columns, "dog/" + motion->skeleton.joints[j].name + " x");
      if (column == columns.end()) continue;
      const auto at = static_cast<std::size_t>(column - columns.begin());
      const Vec3 link = {std::stod(row[at]), std::stod(row[at + 1]), std::stod(row[at + 2])};
      EXPECT_LT(norm(X[j].p - link), 1e-6) << f << " " << motion->skeleton.joints[j].name;
      ++compared;
    }
  }
  EXPECT_GT(compared, 11 * 15);
  fails({"export", path("park.ugoki"), "--bvh", path("cat.bvh"), "--character", "cat"}, "no such character");
}

}  // namespace ugoki::cli
