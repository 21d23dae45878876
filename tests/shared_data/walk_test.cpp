// Every file of the shared data is opened by the reader of its format, or refused for the right reason.
#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <pugixml.hpp>
#include <sstream>

#include "shared_files.h"
#include "ugoki/formats/asf.h"
#include "ugoki/formats/c3d.h"
#include "ugoki/intake/intake.h"
#include "ugoki/robot_formats/loops_yaml.h"
#include "ugoki/robot_formats/mesh_file.h"

namespace ugoki {
namespace {

namespace fs = std::filesystem;

bool holds(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }
bool is_there(const fs::path& path) { return fs::exists(fs::path(UGOKI_SHARED_DATA) / path); }

pugi::xml_document document_of(const std::string& path) {
  pugi::xml_document out;
  EXPECT_TRUE(out.load_string(shared_text(path).c_str())) << path;
  return out;
}

/// Text that the refusal of an MJCF file must contain, determined with pugixml only; empty: the file must be opened.
std::string reason_against(const std::string& path) {
  const pugi::xml_document document = document_of(path);
  const fs::path folder = fs::path(path).parent_path();
  const pugi::xml_node root = document.document_element();
  bool any_body = false;
  for (const pugi::xpath_node n : root.select_nodes("//include|//asset/model")) {
    const std::string file = n.node().attribute("file").value();
    if (!is_there(folder / file)) return file + "' cannot be read";
    any_body = any_body || document_of((folder / file).generic_string()).select_node("//worldbody//body");
  }
  if (!any_body && !root.select_node("//worldbody//body")) return "no body";
  // A body without <inertial> has the mass of its geoms, which is unknown if a mesh is missing.
  const pugi::xml_node compiler = root.child("compiler");
  const fs::path meshes = folder / compiler.attribute("meshdir").as_string(compiler.attribute("assetdir").value());
  for (const pugi::xpath_node n : root.select_nodes("//asset/mesh[@file]")) {
    const std::string file = n.node().attribute("file").value();
    if (is_there(meshes / file)) continue;
    std::string name = n.node().attribute("name").value();
    if (name.empty()) name = fs::path(file).stem().string();
    for (const pugi::xpath_node g : root.select_nodes("//body[not(inertial)]/geom[@mesh]"))
      if (g.node().attribute("mesh").value() == name) return "comes from a mesh, but the mesh file";
  }
  return {};
}

/// Number of triangles and vertices of an STL or OBJ file; in STL each triangle has its own vertices.
struct MeshCount {
  std::size_t triangles = 0, points = 0;
};
MeshCount count_mesh(const std::string& path, const std::string& bytes) {
  MeshCount out;
  if (ending_of(path) == ".stl" && bytes.size() >= 84) {
    std::uint32_t n = 0;
    std::memcpy(&n, bytes.data() + 80, 4);
    if (bytes.size() == 84 + 50 * std::size_t{n}) return {n, 3 * std::size_t{n}};
  }
  std::istringstream lines(bytes);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string word;
    words >> word;
    if (word == "facet") out.triangles += 1, out.points += 3;
    if (word == "v") ++out.points;
    if (word == "f") {
      std::size_t corners = 0;
      for (std::string corner; words >> corner;) ++corners;
      out.triangles += corners - 2;
    }
  }
  return out;
}

enum class Fate { opened, refused };

void expect_refused_by_ending(const std::string& path) {
  const auto taken = intake::take_in(shared_text(path), path);
  ASSERT_FALSE(taken);
  EXPECT_TRUE(holds(taken.error().text(), "Files with this extension cannot be imported.")) << taken.error().text();
}

/// Reads a file with the reader of its extension. The expected reason of a refusal is determined from the file itself.
Fate walk(const std::string& path) {
  SCOPED_TRACE(path);
  const std::string ending = ending_of(path), text = shared_text(path), name = fs::path(path).filename().string();
  EXPECT_FALSE(text.empty());
  if (!is_whole(path)) {
    const auto taken = intake::take_in(text, path);
    EXPECT_TRUE(!taken && holds(taken.error().text(), ".bin', which is not available"))
        << (taken ? "the file was opened" : taken.error().text());
    return Fate::refused;
  }
  if (ending == ".bvh" || ending == ".amc" || ending == ".gltf" || ending == ".glb") {
    for (const MeasuredMotion& m : read_motions(path)) EXPECT_GT(m.frames, 0);
    return Fate::opened;
  }
  if (ending == ".c3d" || ending == ".trc") {
    EXPECT_GT(read_markers(path).frames, 0);
    return Fate::opened;
  }
  if (ending == ".asf") {
    EXPECT_TRUE(formats::read_asf(text, path));
    const auto taken = intake::take_in(text, path);  // an ASF file has no motion
    EXPECT_TRUE(!taken && holds(taken.error().text(), "a skeleton without motion"));
    return Fate::opened;
  }
  if (ending == ".stl" || ending == ".obj") {
    const auto mesh = robot_formats::read_mesh(text, path);
    EXPECT_TRUE(mesh) << (mesh ? "" : mesh.error().text());
    if (mesh) {
      const MeshCount count = count_mesh(path, text);
      EXPECT_EQ(mesh->triangles.size(), count.triangles);
      EXPECT_EQ(mesh->points.size(), count.points);
    }
    return Fate::opened;
  }
  if (ending == ".yaml") {  // lists the loops of the URDF of the same name
    EXPECT_TRUE(is_there(fs::path(path).replace_extension(".urdf"))) << "there should be a URDF of the same name";
    const auto loops = robot_formats::read_loops_yaml({path, text});
    EXPECT_TRUE(loops) << (loops ? "" : loops.error().text());
    if (loops) EXPECT_EQ(loops->closures.size() > 0, holds(text, "closed_loop"));
    return Fate::opened;
  }
  if (ending == ".urdf" || ending == ".sdf" || ending == ".xml") {
    const std::string reason = ending == ".xml" ? reason_against(path) : std::string();
    const auto robot = read_robot(path, {});
    if (reason.empty()) {
      EXPECT_TRUE(robot) << (robot ? "" : robot.error().text());
      return Fate::opened;
    }
    EXPECT_FALSE(robot) << "the file should be refused: " << reason;
    if (!robot) EXPECT_TRUE(holds(robot.error().text(), reason)) << robot.error().text() << "\nexpected: " << reason;
    return Fate::refused;
  }
  if (ending == ".xacro") {
    EXPECT_TRUE(holds(text, "<xacro:"));
    const auto taken = intake::take_in(text, path);
    EXPECT_FALSE(taken);
    if (!taken) EXPECT_TRUE(holds(taken.error().text(), "xacro")) << taken.error().text();
    return Fate::refused;
  }
  if (ending == ".srdf")
    EXPECT_TRUE(!document_of(path).select_node("//robot/link"));  // SRDF: groups of a robot's joints, not a robot
  else if (ending == ".mtl")
    EXPECT_TRUE(holds(text, "newmtl"));  // materials of an OBJ
  else if (holds(name, "LICENSE"))
    EXPECT_TRUE(holds(text, "opyright"));
  else
    EXPECT_EQ(ending, ".md") << "the test has no rule for this file";
  expect_refused_by_ending(path);
  return Fate::refused;
}

TEST(SharedFiles, AreOpenedOrRefusedForTheRightReason) {
  NEEDS_SHARED_FILES();
  int opened = 0, refused = 0;
  for (const std::string& path : shared_files()) (walk(path) == Fate::opened ? opened : refused)++;
  RecordProperty("opened", opened);
  RecordProperty("refused", refused);
  std::cout << opened << " files opened, " << refused << " refused\n";
  EXPECT_GT(opened, 8 * refused);
}

}  // namespace
}  // namespace ugoki
