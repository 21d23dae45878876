#include "ugoki/robot_formats/sdf_frames.h"

#include <array>
#include <cmath>
#include <functional>

namespace ugoki::robot_formats {
namespace {

constexpr double max_angle = 1e6;  // in the file's unit; a larger value has too few digits left for a meaningful angle

}  // namespace

SdfFrames::SdfFrames(XmlFields& xml, int version) : xml_(xml), version_(version) {
  frames_.push_back({.name = "world", .kind = SdfFrameKind::world});
  index_.emplace("world", 0);
}

Pose SdfFrames::pose(pugi::xml_node node) {
  const pugi::xml_node element = node.child("pose");
  const XmlField field = xml_.content(element);
  Pose X;
  if (field.text.empty()) return X;
  if (xml_.attribute(element, "rotation_format").text == "quat_xyzw") {
    std::array<double, 7> v;
    if (!xml_.numbers(field, v)) return X;
    const Quat q{v[6], v[3], v[4], v[5]};
    if (!(norm(q.vec()) + std::fabs(q.w) > 1e-6))
      xml_.problem(element, ErrorCode::structure, "The quaternion of <pose> is zero.", "Give a unit quaternion x y z w.");
    return {to_matrix(normalized(q)), {v[0], v[1], v[2]}};
  }
  std::array<double, 6> v;
  if (!xml_.numbers(field, v)) return X;
  const double unit = xml_.flag(xml_.attribute(element, "degrees"), false) ? pi / 180 : 1;
  X.p = {v[0], v[1], v[2]};
  if (std::fabs(v[3]) <= max_angle && std::fabs(v[4]) <= max_angle && std::fabs(v[5]) <= max_angle)
    X.R = from_euler({v[5] * unit, v[4] * unit, v[3] * unit}, "ZYX");
  else
    xml_.problem(element, ErrorCode::range, "An angle of <pose> is greater than 1e6.", "Correct the angle.");
  return X;
}

std::string SdfFrames::relative_to(pugi::xml_node node, std::string_view otherwise) {
  // The attribute `relative_to` was called `frame` in versions 1.5 and 1.6.
  const XmlField field = xml_.attribute(node.child("pose"), version_ >= 107 ? "relative_to" : "frame");
  return field.text.empty() ? std::string(otherwise) : xml_.text(field);
}

void SdfFrames::add(SdfFrame frame) {
  if (!index_.emplace(frame.name, count()).second) {
    xml_.problem(frame.node, ErrorCode::duplicate, "Two elements of the model are named " + formats::in_quotes(frame.name) + ".",
                 "Rename one of them.");
    return;
  }
  frames_.push_back(std::move(frame));
}

int SdfFrames::find(std::string_view scope, std::string_view name) const {
  std::string full;
  if (name == "world")
    full = name;
  else if (name == "__model__" && !scope.empty())
    full = scope.substr(0, scope.size() - 2);
  else
    full = std::string(scope) + std::string(name);
  const auto it = index_.find(full);
  return it == index_.end() ? -1 : it->second;
}

int SdfFrames::target(int from, const std::string& name, const char* purpose) {
  const int to = find(at(from).scope, name);
  if (to < 0)
    xml_.problem(at(from).node, ErrorCode::unknown,
                 xml_.title(at(from).node) + " " + purpose + " " + formats::in_quotes(name) + ", which does not exist.",
                 "Name a link, joint or frame of this model.");
  return to;
}

void SdfFrames::resolve() {
  const auto n = frames_.size();
  // Follows the references given by `next` up to a frame that is already settled, then returns along this path and calls `settle` for each
  // frame. Each frame is settled once. A reference back to a frame of the path is a cycle.
  const auto follow = [&](const std::function<int(int)>& next, const std::function<void(int, int)>& settle) {
    std::vector<char> state(n, 0);  // 1: on the current path, 2: settled
    for (std::size_t first = 0; first < n && !xml_.full(); ++first) {
      std::vector<int> path;
      int at = static_cast<int>(first);
      while (at >= 0 && state[static_cast<std::size_t>(at)] == 0) {
        state[static_cast<std::size_t>(at)] = 1;
        path.push_back(at);
        at = next(at);
      }
      if (at >= 0 && state[static_cast<std::size_t>(at)] == 1)
        xml_.problem(
            frames_[static_cast<std::size_t>(at)].node, ErrorCode::structure,
            xml_.title(frames_[static_cast<std::size_t>(at)].node) + " is placed relative to itself, directly or through other frames.",
            "Remove the cycle of relative_to and attached_to.");
      for (auto it = path.rbegin(); it != path.rend(); at = *it++) {
        if (at >= 0 && state[static_cast<std::size_t>(at)] == 2) settle(*it, at);
        state[static_cast<std::size_t>(*it)] = 2;
      }
    }
  };
  follow([&](int i) { return at(i).kind == SdfFrameKind::world ? -1 : target(i, at(i).relative_to, "is placed relative to"); },
         [&](int i, int base) { frames_[static_cast<std::size_t>(i)].X_W = at(base).X_W * at(i).X; });
  for (std::size_t i = 0; i < n; ++i)
    if (frames_[i].kind == SdfFrameKind::link) frames_[i].link = static_cast<int>(i);
  follow([&](int i) { return at(i).attached_to.empty() ? -1 : target(i, at(i).attached_to, "is attached to"); },
         [&](int i, int base) { frames_[static_cast<std::size_t>(i)].link = at(base).link; });
}

Pose SdfFrames::pose_in(int owner, pugi::xml_node node) {
  const Pose X = pose(node);
  const std::string base = relative_to(node, "");
  if (base.empty()) return X;
  const int i = find(at(owner).scope, base);
  if (i >= 0) return at(owner).X_W.inverse() * at(i).X_W * X;
  xml_.problem(node, ErrorCode::unknown,
               xml_.title(node) + " is placed relative to " + formats::in_quotes(base) + ", which does not exist.",
               "Name a link, joint or frame of this model.");
  return X;
}

}  // namespace ugoki::robot_formats
