#pragma once
// The YAML file that names the loops of a description which itself can only write a tree (as in example-parallel-robots):
//
//   closed_loop: [[frame_a, frame_b], ...]   links, joints (their links) or frames of the description
//   type: [6d, 3d, revolute, ...]            6d: weld, 3d: ball, or a loop type of loop.h; its axis is the frames' z
//   name_mot: [joint, ...]                   driven joints
//   joint_name: [joint, ...]                 joints whose type is another than the description says
//   joint_type: [SPHERICAL, UJOINT_XY, ...]

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/robot_formats/robot_draft.h"

namespace ugoki::robot_formats {

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
  std::vector<Driven> driven;
  std::vector<std::string> notes;
};

/// At most 4 MB, 100,000 loops. Unknown keys are noted.
[[nodiscard]] Result<LoopsYaml> read_loops_yaml(const SideFile& file);

/// A frame of the description.
struct LoopEnd {
  int link = -1;  ///< index in the draft; -1: the world
  Pose X;         ///< in the draft's link
};

/// Puts what the YAML file names into the draft.
/// @param find_frame, find_joint by the description's names; nothing: unknown. find_joint gives the link of a tree joint
/// @return the names that are unknown or do not fit; empty: all done
[[nodiscard]] Error apply_loops(const LoopsYaml& yaml, const SideFile& file,
                                const std::function<std::optional<LoopEnd>(std::string_view)>& find_frame,
                                const std::function<std::optional<int>(std::string_view)>& find_joint, RobotDraft& draft);

}  // namespace ugoki::robot_formats
