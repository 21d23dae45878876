#pragma once
// Where the nodes of a scene file are in the frames of the joints that were read from it. Internal to scene_formats.

#include <map>
#include <string>

#include "ugoki/spatial/spatial.h"

namespace ugoki::scene_formats {

/// A point x [file units] of the node's own frame is at A x + p [m] in the frame of a joint, in the first frame of the first motion.
struct NodePlace {
  std::string joint;
  Mat3 A = Mat3::identity();
  Vec3 p;
};
/// By the name of the node: joints, and nodes below joints.
using NodePlaces = std::map<std::string, NodePlace, std::less<>>;

}  // namespace ugoki::scene_formats
