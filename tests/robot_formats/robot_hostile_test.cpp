// Damaged and hostile URDF, SDF, YAML and mesh files: they are refused with file:line, a message and a remedy, or read with a note.
#include <gtest/gtest.h>

#include <cmath>

#include "ugoki/robot_formats/assets.h"
#include "ugoki/robot_formats/inertia_repair.h"
#include "ugoki/robot_formats/mesh_file.h"
#include "ugoki/robot_formats/robot_file.h"
#include "ugoki/robot_formats/sdf.h"
#include "ugoki/robot_formats/symmetric_eigen.h"
#include "ugoki/robot_formats/urdf.h"

namespace ugoki::robot_formats {
namespace {

/// One defect: a replacement in a valid file, and the error that it must cause.
struct Case {
  const char* defect;
  std::string from, to;  ///< text of the valid file and its replacement; empty `from`: `to` is the complete file
  int line;
  const char* word;  ///< part of the expected message
};

std::string changed(const std::string& good, const Case& c) {
  if (c.from.empty()) return c.to;
  std::string text = good;
  const std::size_t at = text.find(c.from);
  EXPECT_NE(at, std::string::npos) << c.from;
  return at == std::string::npos ? text : text.replace(at, c.from.size(), c.to);
}

/// Expects a problem in the case's line whose message contains the word; all problems must have a location and a message.
void expect_problem(const Error& error, const Case& c, const std::string& file) {
  ASSERT_FALSE(error.empty());
  EXPECT_LE(error.problems.size(), 20u);
  bool found = false;
  for (const Problem& p : error.problems) {
    EXPECT_TRUE(p.location.starts_with(file)) << p.location;
    EXPECT_FALSE(p.message.empty());
    found = found || (p.location.starts_with(file + ":" + std::to_string(c.line)) && p.message.find(c.word) != std::string::npos);
  }
  EXPECT_TRUE(found) << "wanted line " << c.line << " and '" << c.word << "', got\n" << error.text();
}

template <class Read>
void refuse_all(const std::string& good, const std::vector<Case>& cases, const std::string& file, Read read) {
  for (const Case& c : cases) {
    SCOPED_TRACE(c.defect);
    const auto result = read(changed(good, c));
    ASSERT_FALSE(result.has_value()) << "was read";
    expect_problem(result.error(), c, file);
  }
}

const std::string good_urdf =
    "<robot name='r'>\n"                                                                                  // line 1
    "<link name='base'><inertial><mass value='1'/>\n"                                                     // 2
    "<inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial></link>\n"                      // 3
    "<link name='arm'>\n"                                                                                 // 4
    "<inertial><origin xyz='0 0 1' rpy='0 0 0'/><mass value='2'/>\n"                                      // 5
    "<inertia ixx='1' iyy='1' izz='1'/></inertial>\n"                                                     // 6
    "<collision><geometry><box size='1 1 1'/></geometry></collision>\n"                                   // 7
    "</link>\n"                                                                                           // 8
    "<joint name='j' type='revolute'><parent link='base'/><child link='arm'/>\n"                          // 9
    "<origin xyz='0 0 0.5' rpy='0 0 0'/><axis xyz='0 1 0'/>\n"                                            // 10
    "<limit lower='-1' upper='1' effort='5'/><dynamics damping='1' friction='1'/></joint>\n"              // 11
    "<link name='tip'><inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1'/></inertial></link>\n"  // 12
    "<joint name='k' type='continuous'><parent link='arm'/><child link='tip'/>\n"                         // 13
    "<mimic joint='j' multiplier='2'/></joint>\n"                                                         // 14
    "</robot>\n";                                                                                         // 15

Result<RobotModel> urdf(const std::string& text) { return read_urdf(text, "bad.urdf"); }

TEST(RobotHostile, ValidUrdfIsRead) { ASSERT_TRUE(urdf(good_urdf).has_value()); }

TEST(RobotHostile, UrdfErrorsNameTheLine) {
  refuse_all(good_urdf,
             {
                 {"empty", "", "", 1, "empty"},
                 {"blank", "", " \n\t ", 1, "empty"},
                 {"binary", "", std::string("<robot>\n\x01\x02</robot>"), 2, "not text"},
                 {"UTF-16", "", std::string("\xFF\xFE<\0r\0", 6), 1, "UTF-16"},
                 {"no XML", "", "links: 3", 1, "no XML element"},
                 {"a comment only", "", "<!-- robot -->", 1, "no XML element"},
                 {"SDF", "", "<sdf version='1.7'/>", 1, "not <robot>"},
                 {"xacro", "<robot name='r'>", "<xacro name='r'>", 15, "not valid XML"},
                 {"macros of xacro", "</joint>\n</robot>", "</joint>\n<xacro:leg side='left'/></robot>", 15, "not yet expanded"},
                 {"cut off", "</joint>\n</robot>\n", "", 14, "not valid XML"},
                 {"closed in the wrong order", "</collision>\n</link>", "</link>\n</collision>", 7, "not valid XML"},
                 {"attribute without quotes", "lower='-1'", "lower=-1", 11, "not valid XML"},
                 {"attribute twice", "lower='-1'", "lower='-1' lower='-2'", 11, "twice"},
                 {"second robot", "</robot>\n", "</robot>\n<robot/>", 16, "second"},
                 {"own entities", "<robot name", "<!DOCTYPE r [<!ENTITY a 'b'>]>\n<robot name", 1, "entities"},
                 {"nothing in it", "", "<robot name='r'/>", 1, "no link"},
                 {"link without name", "<link name='arm'>", "<link>", 4, "missing"},
                 {"link with an empty name", "<link name='arm'>", "<link name=' '>", 4, "empty"},
                 {"two links of one name", "<link name='tip'>", "<link name='arm'>", 12, "Two links"},
                 {"joint without name", "<joint name='k'", "<joint", 13, "missing"},
                 {"two joints of one name", "<joint name='k'", "<joint name='j'", 13, "Two joints"},
                 {"joint without type", " type='continuous'", "", 13, "type"},
                 {"joint of unknown type", "type='continuous'", "type='hinge2'", 13, "hinge2"},
                 {"no parent", "<parent link='arm'/>", "", 13, "parent"},
                 {"no child", "<child link='tip'/>", "", 13, "child"},
                 {"unknown parent", "<parent link='arm'/>", "<parent link='leg'/>", 13, "'leg'"},
                 {"unknown child", "<child link='tip'/>", "<child link='leg'/>", 13, "'leg'"},
                 {"two parents", "<child link='tip'/>", "<child link='arm'/>", 13, "already the child"},
                 {"its own parent", "<parent link='arm'/><child link='tip'/>", "<parent link='tip'/><child link='tip'/>", 12, "cycle"},
                 {"a cycle of two", "<parent link='base'/><child link='arm'/>", "<parent link='tip'/><child link='arm'/>", 4, "cycle"},
                 {"a base too many", "</robot>", "<link name='lost'/></robot>", 15, "have no parent joint"},
                 {"mass is a word", "<mass value='2'/>", "<mass value='heavy'/>", 5, "not a number"},
                 {"mass is missing", "<mass value='2'/>", "", 5, "missing"},
                 {"mass is negative", "<mass value='2'/>", "<mass value='-2'/>", 5, "out of range"},
                 {"mass is NaN", "<mass value='2'/>", "<mass value='nan'/>", 5, "finite"},
                 {"mass is infinite", "<mass value='2'/>", "<mass value='inf'/>", 5, "finite"},
                 {"mass is huge", "<mass value='2'/>", "<mass value='1e300'/>", 5, "large"},
                 {"moment with a comma", "ixx='1' iyy='1' izz='1'/></inertial>\n<coll", "ixx='1,5' iyy='1' izz='1'/></inertial>\n<coll", 6,
                  "comma"},
                 {"two inertials", "</inertial>\n<collision>", "</inertial><inertial/>\n<collision>", 6, "two <inertial>"},
                 {"origin of two numbers", "xyz='0 0 1'", "xyz='0 0'", 5, "fewer"},
                 {"origin of four numbers", "xyz='0 0 1'", "xyz='0 0 1 2'", 5, "more"},
                 {"origin of words", "xyz='0 0 1'", "xyz='a b c'", 5, "not a number"},
                 {"angle of 1e8", "xyz='0 0 0.5' rpy='0 0 0'", "xyz='0 0 0.5' rpy='1e8 0 0'", 10, "out of range"},
                 {"axis of zeros", "<axis xyz='0 1 0'/>", "<axis xyz='0 0 0'/>", 10, "zero length"},
                 {"axis of NaN", "<axis xyz='0 1 0'/>", "<axis xyz='nan 0 0'/>", 10, "finite"},
                 {"limits swapped", "lower='-1' upper='1'", "lower='1' upper='-1'", 11, "greater than"},
                 {"limit is NaN", "lower='-1'", "lower='nan'", 11, "finite"},
                 {"negative effort", "effort='5'", "effort='-5'", 11, "negative"},
                 {"negative damping", "damping='1'", "damping='-1'", 11, "out of range"},
                 {"mimics an unknown joint", "<mimic joint='j'", "<mimic joint='x'", 14, "'x'"},
                 {"mimics itself", "<mimic joint='j'", "<mimic joint='k'", 14, "mimics"},
                 {"mimics nothing", "<mimic joint='j'", "<mimic", 14, "missing"},
                 {"box without size", "<box size='1 1 1'/>", "<box/>", 7, "missing"},
                 {"box of negative size", "size='1 1 1'", "size='1 1 -1'", 7, "out of range"},
                 {"sphere without radius", "<box size='1 1 1'/>", "<sphere/>", 7, "missing"},
                 {"cylinder without length", "<box size='1 1 1'/>", "<cylinder radius='1'/>", 7, "missing"},
                 {"mesh without file", "<box size='1 1 1'/>", "<mesh/>", 7, "missing"},
                 {"mesh of scale zero by words", "<box size='1 1 1'/>", "<mesh filename='a.stl' scale='x'/>", 7, "number"},
             },
             "bad.urdf", urdf);
}

TEST(RobotHostile, UrdfDepthAndAttributesAreBounded) {
  std::string deep = "<robot>", end;
  for (int i = 0; i < 100'000; ++i) deep += "<a>";
  for (int i = 0; i < 100'000; ++i) end += "</a>";
  const Result<RobotModel> nested = urdf(deep + end + "</robot>");
  ASSERT_FALSE(nested);
  EXPECT_NE(nested.error().text().find("deeper"), std::string::npos);
  std::string wide = "<robot ";
  for (int i = 0; i < 10'000; ++i) wide += "a" + std::to_string(i) + "='1' ";
  EXPECT_FALSE(urdf(wide + "/>"));
  // An entity bomb is refused, not expanded.
  EXPECT_FALSE(urdf("<!DOCTYPE r [<!ENTITY a '1'><!ENTITY b '&a;&a;&a;'>]><robot name='&b;'/>"));
  // At most twenty problems are reported.
  std::string many = "<robot>";
  for (int i = 0; i < 1000; ++i) many += "<link/>\n";
  EXPECT_EQ(urdf(many + "</robot>").error().problems.size(), 20u);
}

TEST(RobotHostile, ReadsHundredThousandLinks) {
  constexpr int n = 100'000;
  const auto write = [](bool chain) {
    std::string text = "<robot name='long'>\n";
    for (int i = 0; i < n; ++i) {
      const std::string k = std::to_string(i);
      text += "<link name='l" + k + "'><inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1'/></inertial></link>\n";
      if (i > 0)
        text += "<joint name='j" + k + "' type='revolute'><parent link='l" + (chain ? std::to_string(i - 1) : "0") + "'/><child link='l" +
                k + "'/></joint>\n";
    }
    return text + "</robot>";
  };
  for (const bool chain : {true, false}) {
    const Result<RobotModel> m = urdf(write(chain));
    ASSERT_TRUE(m.has_value()) << m.error().text();
    EXPECT_EQ(m->mechanism->link_count(), n);
    EXPECT_EQ(m->mechanism->nv(), n - 1 + 6);
  }
}

TEST(RobotHostile, UnusualUrdfIsReadWithNotes) {
  const auto notes = [](const std::string& from, const std::string& to) {
    const Result<RobotModel> m = urdf(changed(good_urdf, {"", from, to, 0, ""}));
    EXPECT_TRUE(m.has_value()) << m.error().text();
    std::string all;
    if (m)
      for (const std::string& n : m->notes) all += n + "\n";
    return all;
  };
  EXPECT_NE(notes("<box size='1 1 1'/>", "<box size='0 0 0'/>").find("zero size"), std::string::npos);
  EXPECT_NE(notes("<box size='1 1 1'/>", "<cone/>").find("left out"), std::string::npos);
  EXPECT_NE(notes("<box size='1 1 1'/>", "<mesh filename='http://a/b.stl'/>").find("were not found"), std::string::npos);
  EXPECT_NE(notes("</robot>", "<gazebo/><gazebo/></robot>").find("<gazebo> in <robot> is not read. (bad.urdf:15, 15)"), std::string::npos);
  notes("ixx='1' iyy='1' izz='1'/></inertial>\n<coll", "/></inertial>\n<coll");  // a point mass
  notes("<robot name='r'>", "\xEF\xBB\xBF<?xml version='1.0'?>\n<!DOCTYPE robot>\n<robot>");
}

const std::string good_sdf =
    "<sdf version='1.7'><model name='m'>\n"                                                                               // line 1
    "<link name='a'><inertial><mass>1</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial></link>\n"  // 2
    "<link name='b'><pose relative_to='a'>1 0 0 0 0 0</pose>\n"                                                           // 3
    "<inertial><mass>1</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial>\n"                        // 4
    "<collision name='c'><geometry><sphere><radius>1</radius></sphere></geometry></collision></link>\n"                   // 5
    "<frame name='f' attached_to='b'><pose>0 0 1 0 0 0</pose></frame>\n"                                                  // 6
    "<joint name='j' type='revolute'><parent>a</parent><child>f</child>\n"                                                // 7
    "<axis><xyz expressed_in='__model__'>0 0 1</xyz><limit><lower>-1</lower><upper>1</upper></limit></axis></joint>\n"    // 8
    "<joint name='w' type='fixed'><parent>world</parent><child>a</child></joint>\n"                                       // 9
    "</model></sdf>\n";                                                                                                   // 10

Result<RobotModel> sdf(const std::string& text) { return read_sdf(text, "bad.sdf"); }

TEST(RobotHostile, ValidSdfIsRead) {
  const auto m = sdf(good_sdf);
  ASSERT_TRUE(m.has_value()) << m.error().text();
}

TEST(RobotHostile, SdfErrorsNameTheLine) {
  const std::string triangle = "<joint name='x' type='screw'><parent>a</parent><child>b</child><axis><xyz>0 0 1</xyz></axis></joint>";
  refuse_all(
      good_sdf,
      {
          {"URDF", "", "<robot name='r'/>", 1, "not <sdf>"},
          {"no version", " version='1.7'", "", 1, "version"},
          {"version 1.3", "version='1.7'", "version='1.3'", 1, "version"},
          {"version 2.0", "version='1.7'", "version='2.0'", 1, "version"},
          {"version of words", "version='1.7'", "version='new'", 1, "version"},
          {"no model", "", "<sdf version='1.7'/>", 1, "no <model>"},
          {"model without link", "", "<sdf version='1.7'><model name='m'/></sdf>", 1, "no link"},
          {"include", "<frame name='f'", "<include><uri>model://x</uri></include><frame name='f'", 6, "include"},
          {"drake:joint", "<frame name='f'", "<drake:joint name='q'/><frame name='f'", 6, "drake:joint"},
          {"link without name", "<link name='a'>", "<link>", 2, "missing"},
          {"reserved name", "<link name='a'>", "<link name='world'>", 2, "reserved"},
          {"reserved underscores", "<link name='a'>", "<link name='__a__'>", 2, "reserved"},
          {"scoped name", "<link name='a'>", "<link name='x::a'>", 2, "reserved"},
          {"two links of one name", "<link name='b'>", "<link name='a'>", 3, "Two elements"},
          {"link and joint of one name", "<joint name='j'", "<joint name='a'", 7, "Two elements"},
          {"pose of five numbers", "1 0 0 0 0 0</pose>\n<inertial>", "1 0 0 0 0</pose>\n<inertial>", 3, "fewer"},
          {"pose of words", "1 0 0 0 0 0</pose>\n<inertial>", "a b c d e f</pose>\n<inertial>", 3, "not a number"},
          {"pose of NaN", "1 0 0 0 0 0</pose>\n<inertial>", "1 0 0 nan 0 0</pose>\n<inertial>", 3, "finite"},
          {"angle of 1e8", "1 0 0 0 0 0</pose>\n<inertial>", "1 0 0 1e8 0 0</pose>\n<inertial>", 3, "angle"},
          {"quaternion of zeros", "<pose relative_to='a'>1 0 0 0 0 0", "<pose rotation_format='quat_xyzw'>1 0 0 0 0 0 0", 3, "quaternion"},
          {"placed relative to nothing", "relative_to='a'", "relative_to='z'", 3, "'z'"},
          {"placed relative to itself", "relative_to='a'", "relative_to='f'", 3, "itself"},
          {"attached to nothing", "attached_to='b'", "attached_to='z'", 6, "'z'"},
          {"attached to itself", "attached_to='b'", "attached_to='f'", 6, "itself"},
          {"joint without type", " type='revolute'", "", 7, "type"},
          {"joint of unknown type", "type='revolute'", "type='magnet'", 7, "magnet"},
          {"no parent", "<parent>a</parent>", "", 7, "missing"},
          {"no child", "<child>f</child>", "", 7, "does not exist"},
          {"unknown parent", "<parent>a</parent>", "<parent>z</parent>", 7, "'z'"},
          {"joins a link with itself", "<parent>a</parent>", "<parent>b</parent>", 7, "itself"},
          {"no axis", "<axis><xyz expressed_in='__model__'>0 0 1</xyz><limit><lower>-1</lower><upper>1</upper></limit></axis>", "", 7,
           "axis"},
          {"axis of zeros", "0 0 1</xyz>", "0 0 0</xyz>", 8, "zero length"},
          {"axis in no frame", "expressed_in='__model__'", "expressed_in='z'", 8, "'z'"},
          {"limits swapped", "<lower>-1</lower>", "<lower>2</lower>", 8, "greater than"},
          {"mass is negative", "<mass>1</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial>\n<coll",
           "<mass>-1</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial>\n<coll", 4, "out of range"},
          {"mass is a word", "<mass>1</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial>\n<coll",
           "<mass>x</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial>\n<coll", 4, "not a number"},
          {"sphere without radius", "<radius>1</radius>", "", 5, "missing"},
          {"restitution of two", "</geometry></collision>",
           "</geometry><surface><bounce><restitution_coefficient>2</restitution_coefficient></bounce></surface></collision>", 5, "range"},
          {"a screw that closes a loop", "<joint name='j'",
           triangle +
               "<joint name='s' type='screw'><parent>world</parent><child>b</child><axis><xyz>0 0 1</xyz></axis></joint>\n<joint name='j'",
           7, "closes a loop"},
          {"screw without pitch", "<joint name='j'",
           "<joint name='x' type='screw'><parent>a</parent><child>b</child><axis><xyz>0 0 "
           "1</xyz></axis><thread_pitch>0</thread_pitch></joint><joint name='j'",
           7, "pitch"},
          {"gearbox against nothing", "<joint name='j'",
           "<joint name='x' "
           "type='gearbox'><parent>a</parent><child>b</child><gearbox_reference_body>z</gearbox_reference_body><axis><xyz>0 0 "
           "1</xyz></axis></joint><joint name='j'",
           7, "'z'"},
          {"gearbox without joints", "<joint name='j'",
           "<joint name='x' "
           "type='gearbox'><parent>a</parent><child>b</child><gearbox_reference_body>b</gearbox_reference_body><axis><xyz>0 0 "
           "1</xyz></axis></joint><joint name='j'",
           7, "reference body"},
          {"mimics nothing", "<limit>", "<mimic joint='z'/><limit>", 8, "mimics"},
          {"weld of a frame with its own link", "<joint name='j'",
           "<drake:weld_constraint><parent>b</parent><child>f</child></drake:weld_constraint><joint name='j'", 7, "itself"},
          {"weld of nothing", "<joint name='j'",
           "<drake:weld_constraint><parent>b</parent><child>z</child></drake:weld_constraint><joint name='j'", 7, "'z'"},
          {"placement frame", "<frame name='f'", "<model name='n' placement_frame='x'><link name='l'/></model><frame name='f'", 6,
           "placement_frame"},
      },
      "bad.sdf", sdf);
}

TEST(RobotHostile, SdfNestingIsBoundedAndLongFilesAreRead) {
  std::string deep = "<sdf version='1.7'><model name='m'><link name='a'/>", end;
  for (int i = 0; i < 200; ++i) {
    deep += "<model name='n'><link name='a'/>";
    end += "</model>";
  }
  const Result<RobotModel> nested = sdf(deep + end + "</model></sdf>");
  ASSERT_FALSE(nested);
  EXPECT_NE(nested.error().text().find("deeper than 50"), std::string::npos) << nested.error().text();
  // A long chain of frames, each relative to the next one, and a long ladder of loops.
  constexpr int n = 20'000;
  std::string text = "<sdf version='1.7'><model name='m'>\n";
  for (int i = 0; i < n; ++i) {
    const std::string k = std::to_string(i), next = std::to_string(i + 1);
    text += "<link name='l" + k + "'><pose relative_to='f" + k + "'/></link>\n<frame name='f" + k + "' attached_to='" +
            (i + 1 < n ? "f" + next : "l" + k) + "'>" + (i + 1 < n ? "" : "<pose relative_to='__model__'/>") + "</frame>\n";
    if (i > 0)
      text += "<joint name='j" + k + "' type='fixed'><parent>l" + std::to_string(i - 1) + "</parent><child>l" + k + "</child></joint>\n";
    if (i > 1)
      text += "<joint name='k" + k + "' type='ball'><parent>l" + std::to_string(i - 2) + "</parent><child>l" + k + "</child></joint>\n";
  }
  const Result<RobotModel> m = sdf(text + "</model></sdf>");
  ASSERT_TRUE(m.has_value()) << m.error().text();
  EXPECT_EQ(m->mechanism->link_count(), n);
  EXPECT_EQ(m->mechanism->nv(), 6);
  EXPECT_EQ(static_cast<int>(m->mechanism->loops().size()), n - 2);
}

const std::string good_yaml =
    "closed_loop: [[base, tip], [j, arm]]\n"  // line 1
    "type: [6d, ball]\n"                      // 2
    "name_mot: [j]\n"                         // 3
    "joint_name: [k]\n"                       // 4
    "joint_type: [UJOINT_XY]\n";              // 5

Result<RobotModel> with_yaml(const std::string& yaml) {
  RobotOptions options;
  options.loops = SideFile{"bad.yaml", yaml};
  std::string text = good_urdf;
  text.replace(text.find("<mimic joint='j' multiplier='2'/>"), 33, "");
  text.replace(text.find("</robot>"), 8,
               "<link name='end'/><joint name='e' type='fixed'><parent link='tip'/><child link='end'/></joint></robot>");
  return read_urdf(text, "good.urdf", options);
}

TEST(RobotHostile, ValidLoopsFileIsRead) {
  const Result<RobotModel> m = with_yaml(
      "closed_loop: [[base, tip], [base, end]]\ntype: [6d, ball]\nname_mot: [j]\njoint_name: [k]\n"
      "joint_type: [UJOINT_XY]\nowner: me\n");
  ASSERT_TRUE(m.has_value()) << m.error().text();
  ASSERT_EQ(m->mechanism->loops().size(), 2u);
  EXPECT_EQ(m->mechanism->loops()[0].type, LoopType::weld);
  EXPECT_EQ(m->mechanism->loops()[1].type, LoopType::ball);
  EXPECT_EQ(m->mechanism->link(2).joint.type, JointType::universal);
  EXPECT_EQ(m->driven, std::vector<std::string>{"arm"});
  bool noted = false;
  for (const std::string& n : m->notes) noted = noted || n.find("'owner'") != std::string::npos;
  EXPECT_TRUE(noted);
}

TEST(RobotHostile, LoopsFileErrorsNameTheLine) {
  std::string deep;
  for (int i = 0; i < 100'000; ++i) deep += "[";
  refuse_all(good_yaml,
             {
                 {"empty", "", "", 1, "empty"},
                 {"binary", "", std::string("a: \x01"), 1, "not text"},
                 {"a list", "", "[1, 2]", 1, "not a map of keys"},
                 {"a word", "", "hello", 1, "not a map of keys"},
                 {"open bracket", "tip], [", "tip, [", 2, "not valid YAML"},
                 {"nested without end", "", "type: " + deep, 1, "not valid YAML"},
                 {"tab", "type: [6d", "\t type: [6d", 2, "not valid YAML"},
                 {"one frame", "[base, tip]", "[base]", 1, "must be a pair"},
                 {"three frames", "[base, tip]", "[base, tip, arm]", 1, "must be a pair"},
                 {"no list", "[[base, tip], [j, arm]]", "base", 1, "list is missing"},
                 {"fewer types", "[6d, ball]", "[6d]", 1, "2 pairs"},
                 {"unknown type", "6d", "5d", 2, "'5d'"},
                 {"gear", "6d", "gear", 2, "'gear'"},
                 {"unknown frame", "base, tip", "base, nose", 1, "'nose'"},
                 {"unknown motor", "name_mot: [j]", "name_mot: [x]", 3, "'x'"},
                 {"unknown joint", "joint_name: [k]", "joint_name: [x]", 4, "'x'"},
                 {"unknown joint type", "UJOINT_XY", "UJOINT_XX", 4, "UJOINT_XX"},
                 {"fewer joint types", "[UJOINT_XY]", "[]", 1, "joint_type"},
                 {"a name that is a list", "name_mot: [j]", "name_mot: [[j]]", 3, "name is missing"},
                 {"an endless alias", "", "a: &a [*a]\nclosed_loop: *a\ntype: *a\n", 1, ""},
             },
             "bad.yaml", with_yaml);
  // A loop between a link and itself is refused by Mechanism::make.
  EXPECT_FALSE(with_yaml("closed_loop: [[j, arm]]\ntype: [6d]\n"));
}

TEST(RobotHostile, DamagedMeshFilesAreRefused) {
  const auto refused = [](const std::string& bytes, const char* name) { return !read_mesh(bytes, name).has_value(); };
  EXPECT_TRUE(refused("", "a.stl"));
  EXPECT_TRUE(refused("solid nothing\nendsolid\n", "a.stl"));
  EXPECT_TRUE(refused(std::string(84, '\0') + "x", "a.stl"));
  EXPECT_TRUE(refused(std::string(80, '\0') + "\xFF\xFF\xFF\xFF" + std::string(100, 'x'), "a.stl"));  // declares 4 billion triangles
  EXPECT_TRUE(refused("solid x\nvertex 1 2\n", "a.stl"));
  EXPECT_TRUE(refused("solid x\nvertex 1 2 nan\n", "a.stl"));
  EXPECT_TRUE(refused("solid x\nvertex 1 2 1e7\n", "a.stl"));
  EXPECT_TRUE(refused("v 1 2 3\nf 1 2 3\n", "a.obj"));
  EXPECT_TRUE(refused("v 1 2 3\nf 1 0 1\n", "a.obj"));
  EXPECT_TRUE(refused("v 1 2 3\nf -9999999999999999999 1 1\n", "a.obj"));
  EXPECT_TRUE(refused("# nothing\n", "a.obj"));
  EXPECT_TRUE(refused("<COLLADA/>", "a.dae"));
  EXPECT_TRUE(refused("not XML", "a.dae"));
  EXPECT_TRUE(refused("v 1 2 3\n", "a.ply"));
  std::string nan_stl = std::string(80, '\0') + std::string("\1\0\0\0", 4) + std::string(50, '\xFF');
  EXPECT_TRUE(refused(nan_stl, "a.stl"));

  const Result<MeshFile> quad = read_mesh("v 0 0 0\nv 1 0 0\r\nv 1 1 0 0.5\nv 0 1 0\nf 1/1 2/2 3/3 -1/4\n", "A.OBJ");
  ASSERT_TRUE(quad.has_value());
  EXPECT_EQ(quad->points.size(), 4u);
  EXPECT_EQ(quad->triangles, (std::vector<std::array<int, 3>>{{0, 1, 2}, {0, 2, 3}}));
  EXPECT_EQ(box_around(quad->points).half_extents.z, 1e-4);  // flat meshes get a minimum thickness

  const Result<MeshFile> dae = read_mesh(
      "<COLLADA><asset><unit meter='0.01'/></asset><library_geometries><geometry id='g'><mesh><source id='s'><float_array>"
      "0 0 0 100 0 0 0 200 0 0 0 300</float_array></source><vertices><input semantic='POSITION' source='#s'/></vertices></mesh></geometry>"
      "</library_geometries><library_visual_scenes><visual_scene><node><translate>100 0 0</translate><scale>2 2 "
      "2</scale><instance_geometry "
      "url='#g'/></node></visual_scene></library_visual_scenes></COLLADA>",
      "a.dae");
  ASSERT_TRUE(dae.has_value()) << dae.error().text();
  const Shape box = box_around(dae->points);
  EXPECT_NEAR(box.half_extents.x, 1, 1e-12);
  EXPECT_NEAR(box.half_extents.y, 2, 1e-12);
  EXPECT_NEAR(box.X_BS.p.x, 2, 1e-12);
}

TEST(RobotHostile, ColladaFacesAreTransformedAndOriented) {
  const auto dae = [](const std::string& faces, const std::string& placed) {
    return read_mesh(
        "<COLLADA><library_geometries><geometry id='g'><mesh><source id='s'><float_array>0 0 0 1 0 0 1 1 0 0 1 0</float_array>"
        "</source><vertices id='v'><input semantic='POSITION' source='#s'/></vertices>" +
            faces + "</mesh></geometry></library_geometries><library_visual_scenes><visual_scene><node>" + placed +
            "<instance_geometry url='#g'/></node></visual_scene></library_visual_scenes></COLLADA>",
        "a.dae");
  };
  const std::string inputs = "<input semantic='NORMAL' offset='0'/><input semantic='VERTEX' source='#v' offset='1'/>";
  using Triangles = std::vector<std::array<int, 3>>;
  const Triangles quad = {{0, 1, 2}, {0, 2, 3}};
  EXPECT_EQ(dae("<triangles>" + inputs + "<p>9 0 9 1 9 2 9 0 9 2 9 3</p></triangles>", "").value().triangles, quad);
  EXPECT_EQ(dae("<polylist>" + inputs + "<vcount>4</vcount><p>9 0 9 1 9 2 9 3</p></polylist>", "").value().triangles, quad);
  EXPECT_EQ(dae("<polygons>" + inputs + "<p>9 0 9 1 9 2 9 3</p></polygons>", "").value().triangles, quad);
  EXPECT_EQ(dae("<triangles>" + inputs + "<p>9 0 9 1 9 2</p></triangles>", "<scale>1 1 -1</scale>").value().triangles,
            (Triangles{{0, 2, 1}}));
  EXPECT_FALSE(dae("<triangles>" + inputs + "<p>9 0 9 1 9 4</p></triangles>", "").has_value());
  EXPECT_EQ(dae("<polylist>" + inputs + "<vcount>0 3 0 99</vcount><p>9 0 9 1 9 2 9 3</p></polylist>", "").value().triangles.size(), 1U);
}

TEST(RobotHostile, BoxFollowsPrincipalAxesOfDiagonalRod) {
  std::vector<Vec3> points;
  for (const double s : {-1.0, 1.0})
    for (const double t : {-0.01, 0.01})
      for (const double u : {-0.02, 0.02}) points.push_back(Vec3{s + t, s - t, u} + Vec3{5, 0, 0});
  const Shape box = box_around(points);
  EXPECT_NEAR(volume(box), 8 * std::sqrt(2.0) * (0.01 * std::sqrt(2.0)) * 0.02, 1e-12);
  for (const Vec3& p : points) {
    const Vec3 local = box.X_BS.inverse() * p;
    for (int i = 0; i < 3; ++i) EXPECT_LE(std::fabs(local[i]), box.half_extents[i] + 1e-12);
  }
}

TEST(RobotHostile, AssetSearchPaths) {
  const auto first = [](std::string_view uri, std::string_view file) { return candidate_paths(uri, file).at(0); };
  EXPECT_EQ(first("meshes/a.stl", "/r/x.urdf"), "/r/meshes/a.stl");
  EXPECT_EQ(first("/abs/a.stl", "/r/x.urdf"), "/abs/a.stl");
  EXPECT_EQ(first("file:///abs/a.stl", "/r/x.urdf"), "/abs/a.stl");
  EXPECT_EQ(first("package:///a.stl", "/r/x.urdf"), "/r/a.stl");
  EXPECT_TRUE(candidate_paths("http://host/a.stl", "/r/x.urdf").empty());
  EXPECT_TRUE(candidate_paths("", "/r/x.urdf").empty());
  const std::vector<std::string> paths = candidate_paths("package://robot/meshes/a.stl", "/home/robot/urdf/x.urdf");
  const auto has = [&](const char* path) { return std::find(paths.begin(), paths.end(), path) != paths.end(); };
  EXPECT_TRUE(has("/home/robot/meshes/a.stl"));
  EXPECT_TRUE(has("/home/robot/robot/meshes/a.stl"));
  EXPECT_TRUE(has("/home/robot/urdf/a.stl"));
  EXPECT_FALSE(has("/a.stl"));  // a file name without its folders is only searched in the description's folder
  std::string many = "package://";
  for (int i = 0; i < 10'000; ++i) many += "a/";
  EXPECT_LT(candidate_paths(many, many).size(), 200u);
}

TEST(RobotHostile, SymmetricEigenAndInertiaRepair) {
  const SymmetricEigen e = symmetric_eigen({2, 3, 4, 0.5, -0.25, 1});
  const Mat3 back = e.V * Mat3::diagonal(e.values.x, e.values.y, e.values.z) * e.V.transposed();
  const Mat3 S = Sym3{2, 3, 4, 0.5, -0.25, 1}.matrix();
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(back.row(i)[k], S.row(i)[k], 1e-14);
  EXPECT_NEAR(e.V.determinant(), 1, 1e-14);
  // Any moments are repaired to physically possible ones; possible moments are not changed.
  unsigned seed = 1;
  const auto random = [&] { return (seed = seed * 1664525u + 1013904223u) / 2147483648.0 - 1; };
  for (int i = 0; i < 1000; ++i) {
    Inertia inertia =
        Inertia::from_centre(1 + random(), {random(), random(), random()}, {random(), random(), random(), random(), random(), random()});
    const double mass = inertia.mass;
    (void)make_physical(inertia);
    EXPECT_EQ(inertia.mass, mass);
    MechanismSpec spec;
    spec.links.resize(1);
    spec.links[0].name = "l";
    spec.links[0].inertia = inertia;
    EXPECT_TRUE(Mechanism::make(std::move(spec)).has_value()) << "case " << i;
  }
}

TEST(RobotHostile, RootElementSelectsFormat) {
  EXPECT_EQ(robot_format_of("<?xml version='1.0'?>\n<!-- <sdf> -->\n<!DOCTYPE x>\n<robot name='r'>"), RobotFormat::urdf);
  EXPECT_EQ(robot_format_of("<sdf version='1.7'/>"), RobotFormat::sdf);
  EXPECT_EQ(robot_format_of("\xEF\xBB\xBF<mujoco>"), RobotFormat::mjcf);
  EXPECT_EQ(robot_format_of("<html>"), std::nullopt);
  EXPECT_EQ(robot_format_of("<!-- <robot>"), std::nullopt);
  EXPECT_EQ(robot_format_of("<"), std::nullopt);
  EXPECT_FALSE(read_robot_file("no XML at all", "x.xml"));
}

}  // namespace
}  // namespace ugoki::robot_formats
