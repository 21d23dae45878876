#pragma once
// Commands on the lists of variables, markers, stored poses, cameras and shots of a scenario. docs/scenario.md lists them. Internal to content.

#include <cstddef>
#include <functional>
#include <string>

#include "ugoki/content/json_fields.h"
#include "ugoki/content/scenario.h"

namespace ugoki::content {

constexpr std::size_t max_command_size = 16u << 20;  ///< bytes of JSON of a command: 16 MiB

/// Keeps an id that a command gives, and makes a new id of this letter and a number if `id` is empty.
using AssignId = std::function<void(std::string& id, char letter)>;

// Each of these functions reads the fields of one command and changes the scenario; problems are added to the fields' list.
// @return the label for undo menus

std::string add_variable(Fields& f, Scenario& scenario, const AssignId& assign_id);
std::string set_variable(Fields& f, Scenario& scenario);
/// `variable.remove`: removes the variable together with the rules that compare or change it.
std::string drop_variable(Fields& f, Scenario& scenario);

std::string add_marker(Fields& f, Scenario& scenario, const AssignId& assign_id);
std::string set_marker(Fields& f, Scenario& scenario);
std::string remove_marker(Fields& f, Scenario& scenario);

std::string add_pose(Fields& f, Scenario& scenario, const AssignId& assign_id);
std::string set_pose(Fields& f, Scenario& scenario);
std::string remove_pose(Fields& f, Scenario& scenario);

std::string add_camera(Fields& f, Scenario& scenario, const AssignId& assign_id);
std::string set_camera(Fields& f, Scenario& scenario);
/// `camera.remove`: removes the camera together with its shots.
std::string remove_camera(Fields& f, Scenario& scenario);

std::string add_shot(Fields& f, Scenario& scenario, const AssignId& assign_id);
std::string set_shot(Fields& f, Scenario& scenario);
std::string remove_shot(Fields& f, Scenario& scenario);

}  // namespace ugoki::content
