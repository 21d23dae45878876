// MJCF files that are damaged, impossible, unbounded or malicious: they are refused with a line, a message and a remedy, or read safely.

#include <gtest/gtest.h>

#include <cctype>
#include <map>
#include <string>

#include "ugoki/robot_formats/mjcf.h"

namespace ugoki::robot_formats {
namespace {

using Files = std::map<std::string, std::string>;

Result<RobotModel> read(const std::string& text, const Files& files = {}) {
  RobotOptions options;
  options.read_asset = [&](const std::string& path) -> Result<std::string> {
    const auto it = files.find(path);
    if (it == files.end()) return fail(ErrorCode::io, path, "the file does not exist.", "Copy it there.");
    return it->second;
  };
  return read_mjcf(text, "m.xml", options);
}

/// Expects an error whose message contains `part`, in this line of m.xml (0: in any file).
void refused(const std::string& text, int line, const std::string& part, const Files& files = {}) {
  SCOPED_TRACE(text.substr(0, 400));
  const auto m = read(text, files);
  ASSERT_FALSE(m.has_value()) << "accepted";
  ASSERT_FALSE(m.error().problems.empty());
  EXPECT_LE(m.error().problems.size(), 20U);
  bool found = false;
  for (const Problem& p : m.error().problems) {
    const std::size_t colon = p.location.find(':');
    EXPECT_TRUE(colon != std::string::npos && colon + 1 < p.location.size() &&
                std::isdigit(static_cast<unsigned char>(p.location[colon + 1])))
        << p.text();
    EXPECT_TRUE(p.message.ends_with('.')) << p.text();
    EXPECT_FALSE(p.remedy.empty()) << p.text();
    const bool here =
        line == 0 || p.location == "m.xml:" + std::to_string(line) || p.location.starts_with("m.xml:" + std::to_string(line) + ",");
    found = found || (here && p.message.find(part) != std::string::npos);
  }
  EXPECT_TRUE(found) << "no such message in this line: " << part << "\n" << m.error().text();
}

/// A valid body on lines 4 to 7, with the tested element on line 5.
std::string in_body(const std::string& line5) {
  return "<mujoco>\n<worldbody>\n<geom size='1'/>\n<body name='b'><joint name='j' axis='0 1 0'/><geom name='g' size='0.1' pos='0 0 1'/>\n" +
         line5 + "\n<site name='s'/>\n</body>\n</worldbody>\n</mujoco>";
}
/// A valid model on line 2, with the tested element on line 3.
std::string next_to_body(const std::string& line3) {
  return "<mujoco>\n<worldbody><body name='b'><joint name='j' axis='0 1 0'/><geom size='0.1' pos='0 0 1'/><site name='s'/><body "
         "name='c'><joint "
         "name='k' axis='1 0 0'/><geom size='0.1' pos='0 0 1'/></body></body></worldbody>\n" +
         line3 + "\n</mujoco>";
}

TEST(MjcfHostile, FilesWithoutModelAreRefused) {
  refused("", 1, "empty");
  refused("   \n\n", 1, "empty");
  refused("<mujoco>", 1, "not valid XML");
  refused("<mujoco></mujoco", 1, "not valid XML");
  refused("<mujoco/>", 1, "no body");
  refused("<mujoco><worldbody/></mujoco>", 1, "no body");
  refused("<robot/>", 1, "not <mujoco>");
  refused("<mujoco/><mujoco/>", 1, "second outermost");
  refused("{}", 1, "no XML element");
  refused(std::string("<mujoco>\n\0</mujoco>", 19), 2, "not text");
  refused("\xFF\xFE<mujoco/>", 1, "UTF-16");
  refused("<!DOCTYPE m [<!ENTITY a 'b'>]><mujoco/>", 1, "entities");
  refused("<mujoco model='a' model='b'/>", 1, "twice");
}

TEST(MjcfHostile, InvalidBodiesAreRefused) {
  refused(in_body("<body name='b'/>"), 5, "Two bodies");
  refused(in_body("<joint name='j'/>"), 5, "Two joints");
  refused(in_body("<site name='s'/><body name='c'/>"), 6, "Two sites");
  refused(in_body("<freejoint/>"), 5, "and another joint");
  refused(in_body("<body name='c'><freejoint/></body>"), 5, "parent is another body");
  refused(in_body("<body name='c' childclass='none'/>"), 5, "No default class");
  refused(in_body("<geom class='none'/>"), 5, "No default class");
  refused(in_body("<body pos='1 2'/>"), 5, "fewer than 3");
  refused(in_body("<body pos='1 2 3 4'/>"), 5, "more than 3");
  refused(in_body("<body pos='1 x 3'/>"), 5, "'pos' of <body>");
  refused(in_body("<body pos='nan 0 0'/>"), 5, "'pos' of <body>");
  refused(in_body("<body pos='1e300 0 0'/>"), 5, "'pos' of <body>");
  refused(in_body("<body quat='0 0 0 0'/>"), 5, "not define a direction");
  refused(in_body("<body xyaxes='1 0 0 2 0 0'/>"), 5, "not define a direction");
  refused(in_body("<body zaxis='0 0 0'/>"), 5, "not define a direction");
  refused(in_body("<body axisangle='0 0 0 1'/>"), 5, "not define a direction");
  refused(in_body("<body euler='0 0 1' zaxis='1 0 0'/>"), 5, "given more than once");
  refused(in_body("<body mocap='maybe'/>"), 5, "neither true nor false");
  refused("<mujoco><worldbody>\n<joint/></worldbody></mujoco>", 2, "The world has a joint");
  refused("<mujoco><worldbody>\n<inertial pos='0 0 0' mass='1'/></worldbody></mujoco>", 2, "The world has an <inertial>");
}

TEST(MjcfHostile, InvalidJointsAreRefused) {
  refused(in_body("<joint type='screw'/>"), 5, "not an allowed value");
  refused(in_body("<joint axis='0 0 0'/>"), 5, "zero length");
  refused(in_body("<joint range='1 -1'/>"), 5, "is empty");
  refused(in_body("<joint range='1'/>"), 5, "exactly two numbers");
  refused(in_body("<joint range='1 2 3'/>"), 5, "exactly two numbers");
  refused(in_body("<joint type='ball' range='1 2'/>"), 5, "begin with 0");
  refused(in_body("<joint limited='perhaps' range='0 1'/>"), 5, "not an allowed value");
  refused(in_body("<joint damping='-1'/>"), 5, "out of range");
  refused(in_body("<joint armature='many'/>"), 5, "'armature'");
  refused(in_body("<joint damping='1 2 3 4 5 6'/>"), 5, "more than");
}

TEST(MjcfHostile, InvalidInertiaAndGeomsAreRefused) {
  refused(in_body("<inertial mass='1'/>"), 5, "no pos");
  refused(in_body("<inertial pos='0 0 0'/>"), 5, "no mass");
  refused(in_body("<inertial pos='0 0 0' mass='-1'/>"), 5, "out of range");
  refused(in_body("<inertial pos='0 0 0' mass='1' diaginertia='1 1 1' fullinertia='1 1 1 0 0 0'/>"), 5, "given twice");
  refused(in_body("<inertial pos='0 0 0' mass='1'/><inertial pos='0 0 0' mass='1'/>"), 5, "two <inertial>");
  refused(in_body("<geom type='torus'/>"), 5, "not an allowed value");
  refused(in_body("<geom type='box' size='1 1'/>"), 5, "needs 3 sizes");
  refused(in_body("<geom size='0'/>"), 5, "needs 1 size above");
  refused(in_body("<geom size='-1'/>"), 5, "out of range");
  refused(in_body("<geom size='0.1' fromto='0 0 0 1 0 0'/>"), 5, "not have two ends");
  refused(in_body("<geom type='capsule' size='0.1' fromto='1 1 1 1 1 1'/>"), 5, "are equal");
  refused(in_body("<geom size='0.1' density='-2'/>"), 5, "out of range");
  refused(in_body("<geom type='mesh' mesh='none'/>"), 5, "No mesh is named");
  refused(in_body("<geom type='sdf'/>"), 5, "cannot be computed");
  refused(in_body("<geom type='sphere' size='1' shellinertia='true'/>"), 5, "cannot be computed");
  refused(in_body("<geom size='0.1' friction='1 1 1 1'/>"), 5, "more than");
  // a movable joint without mass
  refused("<mujoco><worldbody>\n<body name='b'><joint/><geom size='0.1' density='0'/></body></worldbody></mujoco>", 2, "has mass");
  refused("<mujoco><worldbody>\n<body name='b'><freejoint/></body></worldbody></mujoco>", 2, "has mass");
  // physically impossible inertia: refused with Inertias::strict, repaired otherwise
  RobotOptions strict;
  strict.inertias = Inertias::strict;
  EXPECT_FALSE(read_mjcf(in_body("<inertial pos='0 0 0' mass='1' diaginertia='1 1 5'/>"), "m.xml", strict).has_value());
  EXPECT_TRUE(read(in_body("<inertial pos='0 0 0' mass='1' diaginertia='1 1 5'/>")).has_value());
}

TEST(MjcfHostile, InvalidDefaultsAreRefused) {
  refused(next_to_body("<default class='a'><default class='a'/></default>"), 3, "Two default classes");
  refused(next_to_body("<default><default class='a'/></default><default class='a'/>"), 3, "Two default classes");
  refused(next_to_body("<default><default/></default>"), 3, "no name");
  refused(next_to_body("<default><default class='a'/><default class='a'/></default>"), 3, "Two default classes");
  refused(next_to_body("<default><joint damping='x'/></default>"), 3, "'damping'");
  refused(next_to_body("<default><geom type='mesh' mesh='none'/></default>"), 0, "No mesh is named");
}

TEST(MjcfHostile, InvalidCompilerAndAssetsAreRefused) {
  refused(next_to_body("<compiler angle='grad'/>"), 3, "not an allowed value");
  refused(next_to_body("<compiler eulerseq='xyw'/>"), 3, "eulerseq");
  refused(next_to_body("<compiler coordinate='global'/>"), 3, "global coordinates");
  refused(next_to_body("<compiler inertiagrouprange='0 99'/>"), 3, "out of range");
  refused(next_to_body("<asset><mesh name='m' vertex='0 0 0'/><mesh name='m' vertex='0 0 0'/></asset>"), 3, "Two meshes");
  refused(next_to_body("<asset><model file='gone.xml'/></asset>"), 3, "cannot be read");
  const auto mesh = [](const std::string& attributes) {
    return "<mujoco><asset>\n<mesh name='m' " + attributes +
           "/></asset><worldbody><body><joint/><geom type='mesh' mesh='m'/></body></worldbody></mujoco>";
  };
  refused(mesh("vertex='0 0 0 1 0 0 0 1 0'"), 2, "fewer than 12");
  refused(mesh("vertex='0 0 0 1 0 0 0 1 0 1 1 0'"), 0, "no volume");
  refused(mesh("vertex='0 0 0 1 0 0 0 1 0 0 0 1' face='0 1 4'"), 2, "refers to a vertex");
  refused(mesh("vertex='0 0 0 1 0 0 0 1 0 0 0 1' face='0 1 2' inertia='exact'"), 0, "no volume");
  refused(mesh("file='m.stl'"), 0, "is damaged", {{"m.stl", "solid x\nvertex 1 2\n"}});
  refused(mesh("file='m.obj'"), 2, "is not a mesh", {{"m.obj", "v 1 2 3\nf 1 2 3\n"}});
  refused(mesh("file='m.step'"), 2, "is not a mesh", {{"m.step", "?"}});
}

TEST(MjcfHostile, UnreadableIncludesAreRefused) {
  const std::string text = "<mujoco>\n<include file='a.xml'/>\n<worldbody><body><joint/><geom size='0.1'/></body></worldbody></mujoco>";
  refused(text, 2, "cannot be read");
  refused(text, 0, "not valid XML", {{"a.xml", "<x><worldbody><body>/></x>"}});
}

TEST(MjcfHostile, CyclicIncludesAreRefused) {
  const std::string text = "<mujoco>\n<include file='a.xml'/>\n<worldbody><body><joint/><geom size='0.1'/></body></worldbody></mujoco>";
  refused(text, 0, "more than once", {{"a.xml", "<x>\n<include file='a.xml'/></x>"}});
  refused(text, 0, "more than once", {{"a.xml", "<x><include file='b.xml'/></x>"}, {"b.xml", "<x>\n<include file='a.xml'/></x>"}});
  refused(text, 0, "more than once", {{"a.xml", "<x><include file='m.xml'/></x>"}});
  refused("<mujoco>\n<include/></mujoco>", 2, "is missing");
  Files many;
  for (int i = 0; i < 300; ++i) many["f" + std::to_string(i)] = "<x><include file='f" + std::to_string(i + 1) + "'/></x>";
  refused("<mujoco><include file='f0'/></mujoco>", 0, "more than 200 files", many);
}

TEST(MjcfHostile, InvalidAttachmentsAreRefused) {
  const auto model = [](const std::string& attach) {
    return "<mujoco><asset><model name='h' file='h.xml'/></asset><worldbody>\n" + attach +
           "<body><joint/><geom size='0.1'/></body></worldbody></mujoco>";
  };
  const std::string h = "<mujoco><worldbody><body name='p'><joint/><geom size='0.1'/></body></worldbody></mujoco>";
  refused(model("<attach model='x' prefix='a'/>"), 2, "No model", {{"h.xml", h}});
  refused(model("<attach model='h' body='x' prefix='a'/>"), 2, "no body named", {{"h.xml", h}});
  refused(model("<attach model='h' prefix='a'/><attach model='h' prefix='a'/>"), 0, "Two bodies", {{"h.xml", h}});
  refused(model(""), 0, "contains itself", {{"h.xml", "<mujoco><asset><model file='h.xml'/></asset></mujoco>"}});
  // 22 models, each of which attaches the next one twice: millions of bodies
  Files doubling;
  for (int i = 0; i < 22; ++i)
    doubling["d" + std::to_string(i) + ".xml"] =
        "<mujoco model='d'><asset><model name='n' file='d" + std::to_string(i + 1) +
        ".xml'/></asset><worldbody><attach model='n' prefix='a'/><attach model='n' prefix='b'/></worldbody></mujoco>";
  doubling["d22.xml"] = h;
  refused("<mujoco><asset><model name='n' file='d0.xml'/></asset><worldbody><attach model='n' prefix=''/></worldbody></mujoco>", 0,
          "more than", doubling);
}

TEST(MjcfHostile, InvalidReplicatesAreRefused) {
  refused(in_body("<replicate/>"), 5, "no count");
  refused(in_body("<replicate count='0'/>"), 5, "out of range");
  refused(in_body("<replicate count='-3'/>"), 5, "out of range");
  refused(in_body("<replicate count='1e9'/>"), 5, "an integer");
  refused(in_body("<replicate count='2'><body name='x'/></replicate><body name='x0'/>"), 5, "Two bodies");
  refused(in_body("<replicate count='100000'><replicate count='100000'><replicate count='100000'/></replicate></replicate>"), 5,
          "more than");
  refused(in_body("<replicate count='1000'><replicate count='1000'><body/></replicate></replicate>"), 5, "more than");
  refused(in_body("<replicate count='2'><site name='q' pos='x'/></replicate>"), 5, "'pos'");
}

TEST(MjcfHostile, InvalidEqualitiesAreRefused) {
  refused(next_to_body("<equality><connect body1='x' body2='b' anchor='0 0 0'/></equality>"), 3, "no body is named 'x'");
  refused(next_to_body("<equality><connect body1='b'/></equality>"), 3, "neither body1 and anchor");
  refused(next_to_body("<equality><weld/></equality>"), 3, "neither body1");
  refused(next_to_body("<equality><connect site1='s' body2='b'/></equality>"), 3, "both sites and bodies");
  refused(next_to_body("<equality><connect site1='s' site2='t'/></equality>"), 3, "no site is named 't'");
  refused(next_to_body("<equality><weld body1='b' body2='b'/></equality>"), 3, "to itself");
  refused(next_to_body("<equality><weld body1='world'/></equality>"), 3, "to itself");
  refused(next_to_body("<equality><joint joint1='j' joint2='j'/></equality>"), 3, "with itself");
  refused(next_to_body("<equality><joint joint1='x'/></equality>"), 3, "no joint is named");
  refused(next_to_body("<equality><joint joint1='j' polycoef='1 2 3 4 5 6'/></equality>"), 3, "more than");
  refused(next_to_body("<equality><weld body1='b' body2='c' relpose='0 0 0 1 0 0'/></equality>"), 3, "fewer than 7");
  refused(next_to_body("<tendon><fixed name='t'><joint joint='j' coef='0'/></fixed></tendon><equality><tendon tendon1='t'/></equality>"), 3,
          "is zero");
}

TEST(MjcfHostile, InvalidActuatorsAndKeyframesAreRefused) {
  refused(next_to_body("<actuator><motor joint='x'/></actuator>"), 3, "no joint is named");
  refused(next_to_body("<actuator><motor joint='j' gear='x'/></actuator>"), 3, "'gear'");
  refused(next_to_body("<actuator><motor class='none' joint='j'/></actuator>"), 3, "No default class");
  refused(next_to_body("<keyframe><key qpos='1'/></keyframe>"), 3, "fewer than 2");
  refused(next_to_body("<keyframe><key qpos='1 2 3'/></keyframe>"), 3, "more than 2");
}

TEST(MjcfHostile, DepthIsBounded) {
  const auto nested = [](int n) {
    std::string text = "<mujoco><worldbody>";
    for (int i = 0; i < n; ++i) text += "<body><joint axis='0 1 0'/><geom size='0.1' pos='0 0 1'/>";
    for (int i = 0; i < n; ++i) text += "</body>";
    return text + "</worldbody></mujoco>";
  };
  const auto deep = read(nested(900));
  ASSERT_TRUE(deep.has_value()) << deep.error().text();
  EXPECT_EQ(deep->mechanism->nv(), 900);
  refused(nested(1500), 1, "deeper than");
  refused(nested(5000), 1, "deeper than");
  std::string classes = "<mujoco><default>", ends;
  for (int i = 0; i < 1500; ++i) classes += "<default class='c" + std::to_string(i) + "'>", ends += "</default>";
  refused(classes + ends + "</default><worldbody/></mujoco>", 1, "deeper than");
}

TEST(MjcfHostile, ReportsAtMostTwentyProblems) {
  std::string text = "<mujoco><worldbody>";
  for (int i = 0; i < 500; ++i) text += "<body pos='x'><joint type='y'/><geom size='z'/></body>\n";
  const auto m = read(text + "</worldbody></mujoco>");
  ASSERT_FALSE(m.has_value());
  EXPECT_EQ(m.error().problems.size(), 20U);
}

TEST(MjcfHostile, UnusualButValidFilesAreAccepted) {
  // unknown elements and attributes of a later dialect, comments, CDATA, blank attributes
  EXPECT_TRUE(read(in_body("<!-- no --><hologram/><geom size=' 0.1 ' shine='1'/><joint damping='1 0 0'/>")).has_value());
  EXPECT_TRUE(read(in_body("<body name='\xE8\x84\x9A'/>")).has_value());
  EXPECT_TRUE(read(in_body("<body name='&lt;&amp;'/>")).has_value());
  EXPECT_TRUE(read("\xEF\xBB\xBF" + in_body("")).has_value());
  EXPECT_TRUE(read(in_body("<joint axis='1 0 0' range='-inf inf'/>")).has_value());
  // generated names avoid the names given in the file
  const auto m = read(in_body("<body/><body name='body_2'/>"));
  ASSERT_TRUE(m.has_value()) << m.error().text();
  EXPECT_GE(m->mechanism->find_link("body_2_"), 0);
}

TEST(MjcfHostile, EveryTruncationIsRefused) {
  const std::string text = next_to_body("<equality><joint joint1='j' joint2='k'/></equality><actuator><motor joint='j'/></actuator>");
  ASSERT_TRUE(read(text).has_value());
  for (std::size_t n = 0; n < text.size(); ++n) EXPECT_FALSE(read(text.substr(0, n)).has_value()) << n;
}

}  // namespace
}  // namespace ugoki::robot_formats
