#include "ugoki/robot_formats/written_notes.h"

namespace ugoki::robot_formats {

std::vector<SimpleJoint> simple_joints(const Joint& joint) {
  switch (joint.type) {
    case JointType::revolute: return {{false, joint.axis, 0}};
    case JointType::prismatic: return {{true, joint.axis, 0}};
    case JointType::helical: return {{false, joint.axis, 0}, {true, joint.axis, 0}};
    case JointType::cylindrical: return {{false, joint.axis, 0}, {true, joint.axis, 1}};
    case JointType::planar: return {{true, {1, 0, 0}, 0}, {true, {0, 1, 0}, 1}, {false, {0, 0, 1}, 2}};
    case JointType::universal: return {{false, joint.axis, 0}, {false, joint.axis2, 1}};
    default: return {};
  }
}

std::vector<LoopSpec> all_loops(const Mechanism& m) {
  std::vector<LoopSpec> loops = m.spec().loops;
  for (const Link& l : m.links())
    if (l.real >= 0) {
      LoopSpec loop;
      loop.name = l.name;
      loop.link_a = m.link(l.real).name;
      loop.link_b = l.name;
      loop.X_AJ = l.X_RV;
      loops.push_back(std::move(loop));
    }
  return loops;
}

}  // namespace ugoki::robot_formats
