#pragma once
// The loops file: YAML that defines the closed loops of a description that can only store a tree (format of example-parallel-robots):
//
//   closed_loop: [[frame_a, frame_b], ...]   names of links, joints (meaning their child links) or frames of the description
//   type: [6d, 3d, revolute, ...]            6d: weld, 3d: ball, or a loop type of loop.h; the axis of the loop is the frames' z axis
//   name_mot: [joint, ...]                   actuated joints
//   joint_name: [joint, ...]                 joints whose type differs from the type in the description
//   joint_type: [SPHERICAL, UJOINT_XY, ...]

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/robot_formats/robot_draft.h"

namespace ugoki::robot_formats {

/// Contents of the loops file. The members `line` are line numbers in this file, for error messages.
struct LoopsYaml {
  struct Closure {
    std::string a, b;
    LoopType type = LoopType::weld;
    int line = 0;
  };
  struct JointChange {
    std::string joint;
    JointType type = JointType::spherical;
    Vec3 axis{0, 0, 1}, axis2{0, 1, 0};
    int line = 0;
  };
  struct Driven {
    std::string joint;
    int line = 0;
  };
  std::vector<Closure> closures;
  std::vector<JointChange> joints;
  std::vector<Driven> driven;  ///< actuated joints
  std::vector<std::string> notes;
};

/// Parses the loops file. Errors: more than 4 MB, more than 100,000 entries in a list, syntax. Unknown keys give a note.
[[nodiscard]] Result<LoopsYaml> read_loops_yaml(const SideFile& file);

/// Location of an end of a loop: a frame in a link.
struct LoopEnd {
  int link = -1;  ///< index in the draft; -1: the world
  Pose X;         ///< pose of the frame in the frame of `link`
};

/// Adds the loops, joint types and actuated joints of the YAML file to the draft.
/// @param find_frame, find_joint functions that look up a name of the description; std::nullopt: unknown. find_joint returns the index in
/// the draft of a tree joint's child link
/// @return problems with unknown names; empty if all names are known
[[nodiscard]] Error apply_loops(const LoopsYaml& yaml, const SideFile& file,
                                const std::function<std::optional<LoopEnd>(std::string_view)>& find_frame,
                                const std::function<std::optional<int>(std::string_view)>& find_joint, RobotDraft& draft);

}  // namespace ugoki::robot_formats
