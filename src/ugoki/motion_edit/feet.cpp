#include "ugoki/motion_edit/feet.h"

#include <algorithm>

#include "ugoki/mechanism/state.h"

namespace ugoki::motion_edit {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

bool is_behind(const Mechanism& m, int link, int ancestor) {
  while (link > ancestor) link = m.link(link).parent;
  return link == ancestor;
}

double lowest(std::span<const Pose> X_WB, int link, std::span<const SupportPoint> places) {
  double low = 1e300;
  for (const SupportPoint& s : places) low = std::min(low, (X_WB[at(link)] * s.p).z - s.radius);
  return low;
}

/// Links at the ends of limbs that have a point within a tenth of the character's height above the lowest point of all links, in the
/// neutral position.
std::vector<int> lowest_ends(const Mechanism& m) {
  std::vector<Pose> X(at(m.link_count()));
  calc_poses(m, m.neutral(), X);
  std::vector<double> low(X.size(), 1e300);
  double minimum = 1e300, maximum = -1e300;
  for (int i = 0; i < m.link_count(); ++i) {
    low[at(i)] = lowest(X, i, support_points(m.link(i)));
    minimum = std::min(minimum, low[at(i)]);
    maximum = std::max(maximum, X[at(i)].p.z);
  }
  std::vector<int> ends;
  for (int i = 1; i < m.link_count(); ++i) {
    if (low[at(i)] > minimum + 0.1 * std::max(0.0, maximum - minimum)) continue;
    const bool last = std::none_of(m.links().begin() + i + 1, m.links().end(), [&](const Link& other) {
      const int k = static_cast<int>(&other - m.links().data());
      return low[at(k)] < 1e299 && is_behind(m, k, i);
    });
    if (last) ends.push_back(i);
  }
  return ends;
}

/// Splits the points of the sole into back and front along the longer horizontal side of the sole at rest. The back is closer to the ankle.
void find_heel_and_toe(std::span<const Pose> X, FootLimb& foot) {
  std::vector<Vec3> p;
  for (const LinkPoint& q : foot.points) p.push_back(X[at(q.link)] * q.location.p - X[at(foot.link)].p);
  Vec3 low{1e300, 1e300, 0}, high{-1e300, -1e300, 0};
  for (const Vec3& v : p) {
    low = {std::min(low.x, v.x), std::min(low.y, v.y), 0};
    high = {std::max(high.x, v.x), std::max(high.y, v.y), 0};
  }
  const bool along_x = high.x - low.x >= high.y - low.y;
  const double front = along_x ? high.x : high.y, back = along_x ? low.x : low.y;
  const bool shorter_back = front + back >= 0;
  const bool has_length = front - back > 0.08 * foot.length;
  for (int i = 0; i < static_cast<int>(p.size()); ++i) {
    const double x = ((along_x ? p[at(i)].x : p[at(i)].y) - 0.5 * (front + back)) * (shorter_back ? 1 : -1);
    if (!has_length || x < 0) foot.heel.push_back(i);
    if (!has_length || x >= 0) foot.toe.push_back(i);
  }
}

std::vector<FootLimb> limbs_of(const Mechanism& m, std::span<const int> links) {
  std::vector<FootLimb> feet;
  std::vector<int> feet_behind(at(m.link_count()), 0);
  for (const int link : links) {  // parents first
    const auto group = std::find_if(feet.begin(), feet.end(), [&](const FootLimb& f) { return is_behind(m, link, f.link); });
    FootLimb& foot = group == feet.end() ? feet.emplace_back() : *group;
    if (foot.parts.empty()) {
      foot.link = link;
      for (int i = link; i >= 0; i = m.link(i).parent) ++feet_behind[at(i)];
    }
    foot.parts.push_back(link);
    for (const SupportPoint& s : support_points(m.link(link))) foot.points.push_back({link, s});
  }
  std::vector<Pose> X(at(m.link_count()));
  calc_poses(m, m.neutral(), X);
  for (FootLimb& foot : feet) {
    for (int i = foot.link; i > 0 && feet_behind[at(i)] == 1; i = m.link(i).parent) foot.chain.insert(foot.chain.begin(), i);
    const auto moves = [&](int i) { return m.link(i).joint.nv() > 0; };
    foot.chain.erase(foot.chain.begin(), std::find_if(foot.chain.begin(), foot.chain.end(), moves));
    for (std::size_t k = 1; k < foot.chain.size(); ++k) foot.length += norm(X[at(foot.chain[k])].p - X[at(foot.chain[k - 1])].p);
    find_heel_and_toe(X, foot);
  }
  return feet;
}

}  // namespace

std::vector<FootLimb> find_foot_limbs(const Mechanism& m) {
  const std::vector<int> labelled = find_feet(m);
  return limbs_of(m, labelled.empty() ? lowest_ends(m) : labelled);
}

Result<std::vector<FootLimb>> find_foot_limbs(const Mechanism& m, std::span<const std::string> names) {
  Error errors;
  std::vector<int> links;
  for (const std::string& name : names) {
    const int link = m.find_link(name);
    if (link < 0)
      errors.add(ErrorCode::unknown, "foot '" + name + "'", "Mechanism " + m.name() + " has no such link.", "Name one of its links.");
    else if (support_points(m.link(link)).empty())
      errors.add(ErrorCode::structure, "foot '" + name + "'", "The link has no colliding shape, so it cannot touch the ground.",
                 "Name the link with the sole.");
    else
      links.push_back(link);
  }
  if (!errors.empty()) return fail(std::move(errors));
  std::sort(links.begin(), links.end());
  links.erase(std::unique(links.begin(), links.end()), links.end());
  return limbs_of(m, links);
}

double mean_leg_length(std::span<const FootLimb> feet) {
  double sum = 0;
  for (const FootLimb& f : feet) sum += f.length;
  return feet.empty() ? 0 : sum / static_cast<double>(feet.size());
}

}  // namespace ugoki::motion_edit
