#include "ugoki/studio/pose_json.h"

#include <vector>

#include "ugoki/mechanism/state.h"

namespace ugoki::studio {

json::Json poses_json(const Mechanism& m, std::span<const double> q, double unit) {
  std::vector<Pose> X(static_cast<std::size_t>(m.link_count()));
  calc_poses(m, q, X);
  json::Json out = json::Json::array();
  for (const Pose& pose : X) {
    const Quat r = to_quat(pose.R);
    for (const double value : {pose.p.x, pose.p.y, pose.p.z, r.w, r.x, r.y, r.z}) out.push_back(rounded(value, unit));
  }
  return out;
}

}  // namespace ugoki::studio
