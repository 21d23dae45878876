#pragma once
// The frames of an SDF model: links, joints, frames and nested models place one another by name; internal to robot_formats.

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/robot_formats/xml_fields.h"

namespace ugoki::robot_formats {

enum class SdfFrameKind { world, model, link, joint, frame };

struct SdfFrame {
  std::string name = {};   ///< from the read model on: "arm::hand"
  std::string scope = {};  ///< of the model in which it stands, with "::" at its end: "arm::"
  SdfFrameKind kind = SdfFrameKind::frame;
  pugi::xml_node node = {};
  std::string relative_to = {};  ///< name in its scope of the frame in which X is given
  std::string attached_to = {};  ///< name in its scope of the frame that carries it; empty for links and the world
  Pose X = {};
  Pose X_W = {};  ///< resolved: in the world, all joints at zero
  int link = -1;  ///< resolved: frame index of the link that carries it; -1: the world
};

class SdfFrames {
 public:
  SdfFrames(XmlFields& xml, int version);

  /// `<pose>` of the node: x y z roll pitch yaw, or a quaternion where its rotation_format says so.
  [[nodiscard]] Pose pose(pugi::xml_node node);
  /// The frame that its `<pose>` names, `otherwise` if none.
  [[nodiscard]] std::string relative_to(pugi::xml_node node, std::string_view otherwise);

  /// A problem where the name is taken.
  void add(SdfFrame frame);
  /// Places all frames. Problems: unknown names, circles.
  void resolve();

  /// Index of the frame that `name` means in a scope; -1: none.
  [[nodiscard]] int find(std::string_view scope, std::string_view name) const;
  [[nodiscard]] const SdfFrame& at(int i) const { return frames_[static_cast<std::size_t>(i)]; }
  [[nodiscard]] int count() const { return static_cast<int>(frames_.size()); }

  /// Pose of what stands in `owner`, whose node has a `<pose>`, in the owner's own frame.
  [[nodiscard]] Pose pose_in(int owner, pugi::xml_node node);

 private:
  /// Index of the frame to which `name` leads; -1 with a problem.
  int target(int from, const std::string& name, const char* purpose);

  XmlFields& xml_;
  int version_;
  std::vector<SdfFrame> frames_;
  std::map<std::string, int, std::less<>> index_;
};

}  // namespace ugoki::robot_formats
