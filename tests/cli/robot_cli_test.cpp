// Descriptions of mechanisms (URDF, SDF) through `ugoki info` and `ugoki import`.
#include "cli_fixture.h"

namespace ugoki::cli {
namespace {

constexpr const char* a_mass = "<inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1'/></inertial>";

class RobotCliTest : public CliTest {
 protected:
  /// Writes a URDF of bars of 1 m in the x-y plane with hinges about z: chains world - a - b and world - c. `end` is fixed to b, `tip` to
  /// c.
  std::string four_bar(const std::string& name, double length_of_b) const {
    const auto link = [](const char* of) { return "<link name='" + std::string(of) + "'>" + a_mass + "</link>"; };
    const auto hinge = [](const char* parent, const char* child, const std::string& location) {
      return "<joint name='to_" + std::string(child) + "' type='continuous'><parent link='" + parent + "'/><child link='" + child +
             "'/><origin xyz='" + location + "'/><axis xyz='0 0 1'/></joint>";
    };
    return write(name, "<robot name='bars'>" + link("world") + link("a") + link("b") + link("c") + hinge("world", "a", "0 0 0") +
                           hinge("a", "b", "0 1 0") + hinge("world", "c", "1 0 0") +
                           "<link name='end'/><joint name='to_end' type='fixed'><parent link='b'/><child link='end'/><origin xyz='" +
                           std::to_string(length_of_b) +
                           " 0 0'/></joint><link name='tip'/><joint name='to_tip' type='fixed'><parent link='c'/><child link='tip'/>"
                           "<origin xyz='0 1 0'/></joint></robot>");
  }
};

TEST_F(RobotCliTest, InfoReportsDegreesOfFreedomLeftByLoops) {
  const std::string file = four_bar("bars.urdf", 1);
  EXPECT_EQ(json({"info", file})["dofs"], 3);
  EXPECT_TRUE(json({"info", file})["loops"].empty());
  write("bars.yaml", "closed_loop: [[end, tip]]\ntype: [revolute]\nname_mot: [to_a]\n");  // used automatically: same name and folder
  const Json j = json({"info", file});
  ASSERT_EQ(j["loops"].size(), 1u);
  EXPECT_EQ(j["loops"][0]["type"], "revolute");
  EXPECT_EQ(j["closure"]["closes"], true);
  EXPECT_EQ(j["closure"]["degrees_of_freedom"], 1);
  EXPECT_EQ(j["closure"]["rank"], 2);
  EXPECT_EQ(j["closure"]["redundant"].size(), 3u);
  EXPECT_EQ(j["driven"], Json::array({"a"}));
  EXPECT_EQ(j["joints"]["revolute"], 3);
  EXPECT_EQ(j["links"][1]["joint_name"], "to_a");
  EXPECT_NE(ugoki({"info", file}).out.find("Over-constrained"), std::string::npos);
}

TEST_F(RobotCliTest, InfoReportsWhyALoopCannotClose) {
  const std::string file = four_bar("long.urdf", 5), loops = write("other.yaml", "closed_loop: [[end, tip]]\ntype: [3d]\n");
  const Json j = json({"info", file, "--loops", loops});
  EXPECT_EQ(j["closure"]["closes"], false);
  const std::string why = j["findings"][0].get<std::string>();
  EXPECT_NE(why.find("longer than all the others"), std::string::npos) << why;
}

TEST_F(RobotCliTest, OptionsReachTheReader) {
  const std::string text =
      "<robot name='r'><link name='a'><inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='3'/></inertial>"
      "<collision><geometry><mesh filename='package://r/meshes/a.obj'/></geometry></collision></link></robot>";
  const std::string file = write("r/urdf/r.urdf", text);
  EXPECT_EQ(json({"info", file})["dofs"], 6);
  EXPECT_EQ(json({"info", file, "--base", "fixed"})["dofs"], 0);
  EXPECT_EQ(json({"info", file})["links"][0]["shapes"], 0);
  const Output strict = ugoki({"info", file, "--inertias", "strict"});
  EXPECT_EQ(strict.status, 1);
  EXPECT_NE(strict.err.find("r.urdf:1: The moments of inertia"), std::string::npos) << strict.err;
  EXPECT_EQ(ugoki({"info", file, "--require-meshes"}).status, 1);
  EXPECT_EQ(ugoki({"info", file, "--base", "loose"}).status, 2);
  write("r/meshes/a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n");
  EXPECT_EQ(json({"info", file, "--require-meshes"})["links"][0]["shapes"], 1);
  EXPECT_EQ(json({"info", file, "--meshes", "none"})["links"][0]["shapes"], 0);
}

TEST_F(RobotCliTest, ImportPutsTheMechanismIntoTheLibrary) {
  const std::string urdf = four_bar("bars.urdf", 1);
  const std::string sdf = write("m.sdf", "<sdf version='1.7'><model name='crate'><link name='box'/></model></sdf>");
  const Json j = json({"import", urdf, sdf});
  ASSERT_EQ(j["files"].size(), 2u);
  EXPECT_EQ(j["files"][0]["name"], "bars");
  EXPECT_FALSE(j["files"][1]["report"].empty());
  EXPECT_EQ(json({"info", "crate"})["dofs"], 6);
  const Output page = ugoki({"import", write("page.xml", "<html/>")});
  EXPECT_EQ(page.status, 1);
  EXPECT_NE(page.err.find("URDF"), std::string::npos) << page.err;
}

}  // namespace
}  // namespace ugoki::cli
