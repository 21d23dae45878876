#include "ugoki/content/poses.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace ugoki::content {
namespace {

constexpr std::size_t max_joints = 10'000;  // joints of one pose
constexpr std::size_t max_nq = 7;           // coordinates of one joint: those of a floating joint
constexpr double max_value = 1e4;           // m | rad: as for the place of a character

}  // namespace

void read_pose(Fields& f, ScenarioPose& out) {
  f.text("id", out.id);
  f.text("name", out.name);
  f.text("mechanism", out.mechanism);
  const Json* joints = f.list("joints", max_joints, "joints");
  if (!joints) return;
  out.joints.clear();
  for (std::size_t i = 0; i < joints->size(); ++i) {
    Fields g((*joints)[i], f.path("joints") + "/" + std::to_string(i), f.problems());
    PoseJoint& joint = out.joints.emplace_back();
    g.require("link", "the name of the link that the joint moves");
    g.text("link", joint.link);
    g.require("q", "the coordinates of the joint");
    if (const Json* q = g.list("q", max_nq, "coordinates")) {
      joint.q.resize(q->size());
      if (g.numbers(*q, g.path("q"), joint.q))
        for (double& x : joint.q) x = x == 0 ? 0 : x;  // negative zero becomes zero, so that equal documents have equal text
    }
    g.refuse_others();
  }
}

Json to_json(const ScenarioPose& pose) {
  Json joints = Json::array();
  for (const PoseJoint& joint : pose.joints) joints.push_back({{"link", joint.link}, {"q", joint.q}});
  return {{"id", pose.id}, {"name", pose.name}, {"mechanism", pose.mechanism}, {"joints", std::move(joints)}};
}

void check_pose(const ScenarioPose& pose, const std::string& location, Error& problems) {
  if (!is_id(pose.mechanism, max_resource_id))
    problems.add(ErrorCode::syntax, location + "/mechanism", "'" + pose.mechanism + "' cannot be the id of a mechanism.",
                 "Store the pose of a character.");
  if (pose.joints.empty())
    problems.add(ErrorCode::structure, location + "/joints", "The pose '" + pose.name + "' has no joints.",
                 "Store the joints of a character.");
  std::set<std::string> links;
  for (std::size_t i = 0; i < pose.joints.size(); ++i) {
    const PoseJoint& joint = pose.joints[i];
    const std::string at = location + "/joints/" + std::to_string(i);
    if (!links.insert(joint.link).second)
      problems.add(ErrorCode::duplicate, at + "/link", "The pose names the link '" + joint.link + "' twice.", "Give each joint once.");
    if (!std::ranges::all_of(joint.q, [](double x) { return std::fabs(x) <= max_value; }))
      problems.add(ErrorCode::range, at + "/q", "A coordinate of the link '" + joint.link + "' is out of range.",
                   "Give values from -10000 to 10000 rad or m.");
  }
}

}  // namespace ugoki::content
