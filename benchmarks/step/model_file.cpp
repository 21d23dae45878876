// Reads the models of the shared data, for us and as text for MuJoCo.

#include <algorithm>
#include <filesystem>
#include <pugixml.hpp>
#include <set>
#include <sstream>
#include <stdexcept>

#include "source.h"
#include "ugoki/base/number.h"
#include "ugoki/collision/scene.h"
#include "ugoki/files/files.h"
#include "ugoki/robot_formats/robot_file.h"

namespace ugoki::benchmarks {
namespace {

const std::string folder = UGOKI_SHARED_DATA "/";

template <class T>
T value_of(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().text());
  return std::move(*result);
}

/// Removes descendants that only affect the picture (cameras, lights, sites, default materials) or that use a mesh. Removes the attribute
/// `material` of all other nodes.
void clean(pugi::xml_node node) {
  node.remove_attribute("material");
  for (pugi::xml_node child = node.first_child(); child;) {
    const pugi::xml_node next = child.next_sibling();
    const std::string name = child.name();
    const bool drawn = name == "camera" || name == "light" || name == "site";
    if (drawn || child.attribute("mesh") || (name == "material" && node.name() == std::string("default")))
      node.remove_child(child);
    else
      clean(child);
    child = next;
  }
}

}  // namespace

bool have_model(const std::string& path) { return std::filesystem::exists(folder + path); }

StepModel read_model(const std::string& path, double friction, const std::vector<std::string>& without) {
  const std::string text = value_of(files::read_file(folder + path));
  robot_formats::RobotOptions options;
  options.meshes = robot_formats::Meshes::none;
  if (path.ends_with(".sdf")) options.base = robot_formats::Base::floating;
  options.read_asset = [](const std::string& asset) {
    const std::string renamed = "mechanism/open_chain/mujoco/model__humanoid__";  // the shared data has the folder in the file's name
    const bool humanoid = asset == "mechanism/open_chain/mujoco/humanoid.xml";
    return files::read_file(folder + (humanoid ? renamed + "humanoid.xml" : asset));
  };
  const robot_formats::RobotModel model = value_of(robot_formats::read_robot_file(text, path, options));
  const Mechanism& read = *model.mechanism;
  MechanismSpec spec = read.spec();
  std::set<std::string> left_out;
  StepModel out;
  for (int i = 0; i < read.link_count(); ++i) {
    const Link& l = read.link(i);
    const bool of_world = l.parent < 0 && l.joint.type == JointType::fixed;
    const bool attached = l.parent >= 0 && left_out.contains(read.link(l.parent).name);
    if (of_world || attached || std::ranges::find(without, l.name) != without.end()) left_out.insert(l.name);
    out.file_frames[l.name] = model.X_BF[static_cast<std::size_t>(i)];
  }
  std::erase_if(spec.links, [&](const LinkSpec& l) { return left_out.contains(l.name); });
  std::erase_if(spec.loops, [&](const LoopSpec& l) { return left_out.contains(l.link_a) || left_out.contains(l.link_b); });
  for (LinkSpec& l : spec.links)
    for (Shape& s : l.shapes) {
      s.friction = friction;
      s.restitution = 0;
      // all programs get the same pairs, without filters (see peer_mujoco.cpp)
      s.groups = s.partners = 1;
      s.smooth = false;
    }
  for (LoopSpec& l : spec.loops)
    if (l.type == LoopType::revolute) l.type = LoopType::ball;
  // Every floating base begins a mechanism of its own.
  std::map<std::string, std::size_t> mechanism_of;
  std::vector<MechanismSpec> specs;
  for (int i = 0; i < read.link_count(); ++i) {
    const Link& l = read.link(i);
    const auto it = std::ranges::find(spec.links, l.name, &LinkSpec::name);
    if (it == spec.links.end()) continue;
    if (l.parent < 0) specs.push_back({.name = l.name, .links = {}});
    const std::size_t k = mechanism_of[l.name] = l.parent < 0 ? specs.size() - 1 : mechanism_of[read.link(l.parent).name];
    specs[k].links.push_back(*it);
  }
  for (const LoopSpec& l : spec.loops) specs[mechanism_of[l.link_a]].loops.push_back(l);
  for (MechanismSpec& one : specs) out.mechanisms.push_back(value_of(Mechanism::make(std::move(one))));
  if (path.ends_with(".xml")) out.mjcf = reduce_mjcf(text, without);
  return out;
}

std::string reduce_mjcf(const std::string& text, const std::vector<std::string>& without) {
  pugi::xml_document document;
  if (!document.load_string(text.c_str())) throw std::runtime_error("The MJCF file is not XML.");
  pugi::xml_node root = document.child("mujoco");
  for (pugi::xml_node child = root.first_child(); child;) {
    const pugi::xml_node next = child.next_sibling();
    const std::string name = child.name();
    if (name != "compiler" && name != "default" && name != "worldbody") root.remove_child(child);
    child = next;
  }
  clean(root);
  pugi::xml_node world = root.child("worldbody");
  for (pugi::xml_node child = world.first_child(); child;) {
    const pugi::xml_node next = child.next_sibling();
    if (child.name() != std::string("body") || std::ranges::find(without, child.attribute("name").value()) != without.end())
      world.remove_child(child);
    child = next;
  }
  pugi::xml_node floor = world.prepend_child("geom");
  floor.append_attribute("name") = "floor of the benchmark";
  floor.append_attribute("type") = "plane";
  floor.append_attribute("size") = "50 50 1";
  floor.append_attribute("contype") = "1";
  floor.append_attribute("conaffinity") = "1";
  std::ostringstream out;
  document.save(out, "", pugi::format_raw);
  return out.str();
}

void finish_mjcf(StepSource& source, const std::string& reduced) {
  pugi::xml_document document;
  if (!document.load_string(reduced.c_str())) throw std::runtime_error("The reduced MJCF file is not XML.");
  pugi::xml_node root = document.child("mujoco");
  root.append_child("option").append_attribute("timestep") = source.dt;
  pugi::xml_node size = root.append_child("size");
  size.append_attribute("nconmax") = source.max_contacts;
  size.append_attribute("njmax") = 4 * source.max_contacts + 500;
  // Excludes each pair of links of which our scene leaves out at least one pair of shapes. Pairs of links are listed, because links that
  // are fixed to each other are separate bodies in the file.
  const Mechanism& m = *source.mechanisms.at(0);
  const collision::Scene scene({source.mechanisms.at(0)});
  std::set<std::pair<int, int>> touching;
  std::map<std::pair<int, int>, int> missing;
  const auto& shapes = scene.shapes();
  for (std::size_t i = 0; i < shapes.size(); ++i)
    for (std::size_t j = i + 1; j < shapes.size(); ++j)
      if (shapes[i].link != shapes[j].link) ++missing[std::minmax(shapes[i].link, shapes[j].link)];
  for (const collision::ShapePair& p : scene.self_pairs(0))
    --missing[std::minmax(shapes[static_cast<std::size_t>(p.a)].link, shapes[static_cast<std::size_t>(p.b)].link)];
  pugi::xml_node contact = root.append_child("contact");
  for (const auto& [pair, count] : missing) {
    if (count == 0) continue;
    pugi::xml_node exclude = contact.append_child("exclude");
    exclude.append_attribute("body1") = m.link(pair.first).name.c_str();
    exclude.append_attribute("body2") = m.link(pair.second).name.c_str();
  }
  std::ostringstream out;
  document.save(out, "", pugi::format_raw);
  source.mjcf = out.str();
}

}  // namespace ugoki::benchmarks
