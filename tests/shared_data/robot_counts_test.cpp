// Mechanisms read from descriptions match the links, joints, DOFs, masses and loops counted with pugixml only.
#include <algorithm>
#include <filesystem>
#include <pugixml.hpp>
#include <sstream>

#include "shared_files.h"

namespace ugoki {
namespace {

namespace fs = std::filesystem;

/// Inserts the included files into the XML document.
void resolve_includes(pugi::xml_node node, const fs::path& folder) {
  for (pugi::xml_node child = node.first_child(); child;) {
    const pugi::xml_node next = child.next_sibling();
    if (std::string_view(child.name()) == "include") {
      pugi::xml_document included;
      EXPECT_TRUE(included.load_string(shared_text((folder / child.attribute("file").value()).generic_string()).c_str()));
      for (const pugi::xml_node part : included.document_element().children()) node.insert_copy_before(part, child);
      node.remove_child(child);
    } else {
      resolve_includes(child, folder);
    }
    child = next;
  }
}

pugi::xml_document document_of(const std::string& path) {
  pugi::xml_document out;
  EXPECT_TRUE(out.load_string(shared_text(path).c_str())) << path;
  resolve_includes(out.document_element(), fs::path(path).parent_path());
  return out;
}

int count(const pugi::xml_node& root, const char* what) { return static_cast<int>(root.select_nodes(what).size()); }

int loops_of(const Mechanism& m) { return static_cast<int>(m.loops().size()); }

// URDF files are counted by the test UrdfShared.CountsAndMassMatchAPlainScan in tests/robot_formats.

TEST(SharedCounts, Sdf) {
  NEEDS_SHARED_FILES();
  for (const std::string& path : shared_files({".sdf"})) {
    SCOPED_TRACE(path);
    const pugi::xml_document document = document_of(path);
    const pugi::xml_node file = document.child("sdf").child("model");
    const auto robot = read_robot(path);
    ASSERT_TRUE(robot) << robot.error().text();
    const Mechanism& m = *robot->mechanism;
    double mass = 0;
    for (const pugi::xml_node link : file.children("link")) {
      const char* value = link.child("inertial").child_value("mass");
      mass += *value ? std::strtod(value, nullptr) : 1;
    }
    EXPECT_EQ(m.link_count(), count(file, "link"));
    EXPECT_NEAR(m.mass(), mass, 1e-12 * mass);
    // Every joint belongs to the tree or closes a loop; Drake's constraints also close loops.
    EXPECT_EQ(static_cast<int>(robot->joints.size()), count(file, "joint") + count(file, "*[starts-with(name(), 'drake:')]"));
    int driven_loops = loops_of(m);
    for (const robot_formats::JointName& j : robot->joints) driven_loops -= m.find_link(j.link) < 0;
    EXPECT_EQ(driven_loops, 0) << "every joint outside the tree should be a loop";
  }
}

/// Type of an MJCF joint: its own attribute, or the default of its class or of an ancestor's class.
std::string type_of(const pugi::xml_node& joint, const pugi::xml_node& root) {
  if (std::string_view(joint.name()) == "freejoint") return "free";
  if (const char* own = joint.attribute("type").value(); *own) return own;
  std::string name = joint.attribute("class").value();
  for (pugi::xml_node n = joint.parent(); name.empty() && n; n = n.parent()) name = n.attribute("childclass").value();
  pugi::xml_node of = root.child("default");
  if (!name.empty()) of = root.select_node(("//default[@class='" + name + "']").c_str()).node();
  for (; std::string_view(of.name()) == "default"; of = of.parent())
    if (const char* type = of.child("joint").attribute("type").value(); *type) return type;
  return "hinge";
}

/// Number of copies of the element made by enclosing <replicate> elements.
int copies_of(const pugi::xml_node& node) {
  int out = 1;
  for (pugi::xml_node n = node.parent(); n; n = n.parent())
    if (std::string_view(n.name()) == "replicate") out *= n.attribute("count").as_int();
  return out;
}

TEST(SharedCounts, Mjcf) {
  NEEDS_SHARED_FILES();
  int opened = 0;
  for (const std::string& path : shared_files({".xml"})) {
    SCOPED_TRACE(path);
    const auto robot = read_robot(path);
    if (!robot) continue;  // refusals are checked by SharedFiles.AreOpenedOrRefusedForTheRightReason
    ++opened;
    const Mechanism& m = *robot->mechanism;
    const pugi::xml_document document = document_of(path);
    const pugi::xml_node root = document.document_element();
    int bodies = 0, dofs = 0;
    for (const pugi::xpath_node b : root.select_nodes("//worldbody//body")) bodies += copies_of(b.node());
    for (const pugi::xpath_node j : root.select_nodes("//worldbody//joint | //worldbody//freejoint")) {
      const std::string type = type_of(j.node(), root);
      const std::string name = j.node().attribute("name").value();
      if (!name.empty() && copies_of(j.node()) == 1)
        EXPECT_TRUE(std::ranges::any_of(robot->joints, [&](const auto& of) { return of.joint == name; })) << name;
      dofs += copies_of(j.node()) * (type == "free" ? 6 : type == "ball" ? 3 : 1);
    }
    int links = 0;
    for (const Link& l : m.links()) links += l.name != "world" && l.name.find(':') == std::string::npos;
    EXPECT_EQ(links, bodies);
    EXPECT_EQ(m.nv(), dofs);
    int loops = count(root, "equality/connect | equality/weld | equality/joint[@joint2]");
    for (const pugi::xpath_node t : root.select_nodes("equality/tendon")) {  // a tendon that couples at most two joints is a gear
      const std::string name = t.node().attribute("tendon1").value();
      loops += count(root, ("tendon/fixed[@name='" + name + "']/joint").c_str()) <= 2;
    }
    EXPECT_EQ(loops_of(m), loops);
  }
  EXPECT_GE(opened, 25);
}

}  // namespace
}  // namespace ugoki
