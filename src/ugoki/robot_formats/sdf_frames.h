#pragma once
// The frames of an SDF model: links, joints, frames and nested models are placed relative to each other by name. Internal to robot_formats.

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "ugoki/robot_formats/xml_fields.h"

namespace ugoki::robot_formats {

enum class SdfFrameKind { world, model, link, joint, frame };

/// A named coordinate frame with its pose.
struct SdfFrame {
  std::string name = {};   ///< name relative to the model that is read: "arm::hand"
  std::string scope = {};  ///< name of the model that contains the frame and "::", for example "arm::"; empty for the outermost model
  SdfFrameKind kind = SdfFrameKind::frame;
  pugi::xml_node node = {};
  std::string relative_to = {};  ///< name (in `scope`) of the frame in which X is given
  std::string attached_to = {};  ///< name (in `scope`) of the frame to which this frame is fixed; empty for links and the world
  Pose X = {};                   ///< pose relative to `relative_to`
  Pose X_W = {};                 ///< pose in the world with all joints at zero; set by resolve()
  int link = -1;                 ///< frame index of the link to which the frame is fixed, -1: the world; set by resolve()
};

/// All frames of a model. Index 0 is the world.
class SdfFrames {
 public:
  SdfFrames(XmlFields& xml, int version);

  /// Reads `<pose>` of the node: x y z [m] and roll pitch yaw [rad, or deg with degrees="true"], or a quaternion with
  /// rotation_format="quat_xyzw".
  [[nodiscard]] Pose pose(pugi::xml_node node);
  /// Returns the name of the frame in which the `<pose>` of the node is given; `otherwise` if the element names no frame.
  [[nodiscard]] std::string relative_to(pugi::xml_node node, std::string_view otherwise);

  /// Adds a frame. If its name is already used, adds a problem instead.
  void add(SdfFrame frame);
  /// Computes X_W and `link` of all frames. Adds a problem for each unknown name or cycle.
  void resolve();

  /// Returns the index of the frame with this name in a scope; -1: none.
  [[nodiscard]] int find(std::string_view scope, std::string_view name) const;
  [[nodiscard]] const SdfFrame& at(int i) const { return frames_[static_cast<std::size_t>(i)]; }
  [[nodiscard]] int count() const { return static_cast<int>(frames_.size()); }

  /// Returns the pose, in the frame `owner`, of a child element of `owner` that has a `<pose>`.
  [[nodiscard]] Pose pose_in(int owner, pugi::xml_node node);

 private:
  /// Returns the index of the frame called `name` in the scope of frame `from`. If there is none, adds a problem and returns -1.
  int target(int from, const std::string& name, const char* purpose);

  XmlFields& xml_;
  int version_;
  std::vector<SdfFrame> frames_;
  std::map<std::string, int, std::less<>> index_;
};

}  // namespace ugoki::robot_formats
