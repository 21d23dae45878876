#include "ugoki/content/list_commands.h"

#include <algorithm>

#include "ugoki/content/poses.h"
#include "ugoki/content/scenario_json.h"

namespace ugoki::content {
namespace {

/// The item that the field `id` names; null and a problem if it does not exist.
template <class Item>
Item* find_item(Fields& f, std::vector<Item>& list, std::string_view kind) {
  std::string id;
  f.require("id", "the " + std::string(kind) + "'s id");
  f.text("id", id);
  if (!f.problems().empty()) return nullptr;
  const auto found = std::find_if(list.begin(), list.end(), [&](const Item& item) { return item.id == id; });
  if (found != list.end()) return &*found;
  f.report(ErrorCode::unknown, f.path("id"), "There is no " + std::string(kind) + " '" + id + "'.",
           "It may have been removed; reload the document.");
  return nullptr;
}

/// Reads the object in the field `kind` into an item.
template <class Item>
void read_item(Fields& f, std::string_view kind, void (*read)(Fields&, Item&), Item& item) {
  f.require(kind, "an object with the fields of the " + std::string(kind));
  if (const Json* object = f.find(kind)) {
    Fields g(*object, f.path(kind), f.problems());
    read(g, item);
    g.refuse_others();
  }
}

template <class Item>
void erase_item(std::vector<Item>& list, const Item* item) {
  if (item) list.erase(list.begin() + (item - list.data()));
}

}  // namespace

std::string add_variable(Fields& f, Scenario& scenario, const AssignId& assign_id) {
  ScenarioVariable variable;
  read_item(f, "variable", read_variable, variable);
  if (!f.problems().empty()) return {};
  assign_id(variable.id, 'x');
  if (variable.name.empty()) variable.name = "Variable " + std::to_string(scenario.variables.size() + 1);
  scenario.variables.push_back(std::move(variable));
  return "Add variable";
}

std::string set_variable(Fields& f, Scenario& scenario) {
  ScenarioVariable* variable = find_item(f, scenario.variables, "variable");
  if (!variable) return {};
  const ScenarioVariable before = *variable;
  read_item(f, "variable", read_variable, *variable);
  variable->id = before.id;
  return variable->name != before.name ? "Rename variable" : "Change variable";
}

std::string drop_variable(Fields& f, Scenario& scenario) {
  if (const ScenarioVariable* variable = find_item(f, scenario.variables, "variable")) remove_variable(scenario, std::string(variable->id));
  return "Remove variable";
}

std::string add_marker(Fields& f, Scenario& scenario, const AssignId& assign_id) {
  f.require("time", "the marker's time in seconds");
  ScenarioMarker marker;
  read_marker(f, marker);
  if (!f.problems().empty()) return {};
  assign_id(marker.id, 'm');
  if (marker.name.empty()) marker.name = "Marker " + std::to_string(scenario.markers.size() + 1);
  scenario.markers.push_back(std::move(marker));
  return "Add marker";
}

std::string set_marker(Fields& f, Scenario& scenario) {
  ScenarioMarker* marker = find_item(f, scenario.markers, "marker");
  if (!marker) return {};
  const ScenarioMarker before = *marker;
  read_marker(f, *marker);
  marker->id = before.id;
  return marker->time != before.time ? "Move marker" : "Rename marker";
}

std::string remove_marker(Fields& f, Scenario& scenario) {
  erase_item<ScenarioMarker>(scenario.markers, find_item(f, scenario.markers, "marker"));
  return "Remove marker";
}

std::string add_pose(Fields& f, Scenario& scenario, const AssignId& assign_id) {
  ScenarioPose pose;
  read_item(f, "pose", read_pose, pose);
  const int count = static_cast<int>(scenario.poses.size());
  int at = count;
  f.integer("at", at);
  if (!f.problems().empty()) return {};
  assign_id(pose.id, 'p');
  if (pose.name.empty()) pose.name = "Pose " + std::to_string(count + 1);
  scenario.poses.insert(scenario.poses.begin() + std::clamp(at, 0, count), std::move(pose));
  return "Store pose";
}

std::string set_pose(Fields& f, Scenario& scenario) {
  ScenarioPose* pose = find_item(f, scenario.poses, "pose");
  if (!pose) return {};
  const ScenarioPose before = *pose;
  read_item(f, "pose", read_pose, *pose);
  pose->id = before.id;
  return pose->joints != before.joints ? "Replace stored pose" : "Rename pose";
}

std::string remove_pose(Fields& f, Scenario& scenario) {
  erase_item<ScenarioPose>(scenario.poses, find_item(f, scenario.poses, "pose"));
  return "Remove pose";
}

std::string add_camera(Fields& f, Scenario& scenario, const AssignId& assign_id) {
  FilmCamera camera;
  read_item(f, "camera", read_camera, camera);
  if (!f.problems().empty()) return {};
  assign_id(camera.id, 'v');
  if (camera.name.empty()) camera.name = "Camera " + std::to_string(scenario.cameras.size() + 1);
  scenario.cameras.push_back(std::move(camera));
  return "Add camera";
}

std::string set_camera(Fields& f, Scenario& scenario) {
  FilmCamera* camera = find_item(f, scenario.cameras, "camera");
  if (!camera) return {};
  const FilmCamera before = *camera;
  read_item(f, "camera", read_camera, *camera);
  camera->id = before.id;
  if (camera->name != before.name) return "Rename camera";
  if (camera->keys.size() > before.keys.size()) return "Key camera";
  if (camera->keys.size() < before.keys.size()) return "Remove camera key";
  return camera->follow != before.follow ? "Set followed character" : "Move camera";
}

std::string remove_camera(Fields& f, Scenario& scenario) {
  if (const FilmCamera* camera = find_item(f, scenario.cameras, "camera")) remove_camera(scenario, std::string(camera->id));
  return "Remove camera";
}

std::string add_shot(Fields& f, Scenario& scenario, const AssignId& assign_id) {
  FilmShot shot;
  read_item(f, "shot", read_shot, shot);
  if (!f.problems().empty()) return {};
  assign_id(shot.id, 'h');
  scenario.shots.push_back(std::move(shot));
  return "Add shot";
}

std::string set_shot(Fields& f, Scenario& scenario) {
  FilmShot* shot = find_item(f, scenario.shots, "shot");
  if (!shot) return {};
  const FilmShot before = *shot;
  read_item(f, "shot", read_shot, *shot);
  shot->id = before.id;
  if (shot->camera != before.camera) return "Change camera of shot";
  return shot->length != before.length ? "Trim shot" : "Move shot";
}

std::string remove_shot(Fields& f, Scenario& scenario) {
  erase_item<FilmShot>(scenario.shots, find_item(f, scenario.shots, "shot"));
  return "Remove shot";
}

}  // namespace ugoki::content
