#include "keyed_jump.h"

#include <algorithm>
#include <cmath>

#include "ugoki/motion_edit/foot_contacts.h"
#include "ugoki/motion_edit/foot_lock.h"

namespace ugoki::correction {

using motion_edit::at;
using motion_edit::Character;

Motion keyed_jump(const Character& c, double take_off, double landing, double apex) {
  const std::vector<std::pair<double, double>> keys = {
      // s, m above the standing posture
      {0, -0.03},   {0.3, -0.03},           {take_off - 0.35, -0.22}, {take_off, 0},         {0.5 * (take_off + landing), apex},
      {landing, 0}, {landing + 0.35, -0.2}, {landing + 0.9, -0.03},   {landing + 1.5, -0.03}};
  Motion stand = c.motion;
  stand.contacts.clear();
  stand.cyclic = false;
  stand.rate = 60;
  stand.frames = static_cast<int>(keys.back().first * stand.rate);
  stand.q.clear();
  for (int f = 0; f < stand.frames; ++f) stand.q.insert(stand.q.end(), c.motion.frame(0), c.motion.frame(0) + c.motion.nq);
  motion_edit::FootContactOptions near;
  near.find_ground = true;
  const motion_edit::FootContacts contacts = motion_edit::find_contacts(c.m(), stand, near);
  for (int f = 0; f < stand.frames; ++f) stand.frame(f)[2] -= contacts.ground;
  std::vector<motion_edit::FootPath> paths = motion_edit::foot_paths(c.m(), stand, contacts);
  const auto slope = [&](std::size_t i) {
    if (i == 0 || i + 1 == keys.size()) return 0.0;
    return (keys[i + 1].second - keys[i - 1].second) / (keys[i + 1].first - keys[i - 1].first);
  };
  Motion moved = stand;
  for (int f = 0; f < moved.frames; ++f) {
    std::size_t i = 0;
    while (i + 2 < keys.size() && keys[i + 1].first < f / moved.rate) ++i;
    const double length = keys[i + 1].first - keys[i].first, s = (f / moved.rate - keys[i].first) / length, t = 1 - s;
    const double height = t * t * (1 + 2 * s) * keys[i].second + s * s * (1 + 2 * t) * keys[i + 1].second +
                          s * t * length * (t * slope(i) - s * slope(i + 1));
    moved.frame(f)[2] += height;
    for (motion_edit::FootPath& path : paths) {
      path.X_WF[at(f)].p.z += std::max(0.0, height);
      path.bears[at(f)] = height <= 0;
    }
  }
  Motion out = motion_edit::follow_paths(c.m(), moved, contacts.feet, paths, {});
  out.contacts.clear();
  return out;
}

}  // namespace ugoki::correction
