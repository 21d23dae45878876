#include "ugoki/correction/contacts.h"

#include <algorithm>
#include <cmath>

#include "ugoki/mechanism/state.h"
#include "ugoki/motion/clip.h"
#include "ugoki/motion/pass_through.h"

namespace ugoki::correction {
namespace {

using motion_edit::FootContacts;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

constexpr double hover_time = 0.4, hover_ease = 0.05;  // s, for a leg of 0.9 m; hover_ease: of the change of the hovering
constexpr double max_hover = 0.1;                      // m, for a leg of 0.9 m
constexpr double same_height = 0.012;  // m, for a leg of 0.9 m: limbs that are higher than the lowest one by less bear load too

/// Lowest or highest value within `reach` places on both sides.
std::vector<double> extreme(const std::vector<double>& x, int reach, bool highest) {
  const int n = static_cast<int>(x.size());
  std::vector<double> out(x.size());
  for (int i = 0; i < n; ++i) {
    const auto first = x.begin() + std::max(0, i - reach), last = x.begin() + std::min(n, i + reach + 1);
    out[at(i)] = highest ? *std::max_element(first, last) : *std::min_element(first, last);
  }
  return out;
}

/// The motion with its hovering removed: the lowest foot of every time span of 0.8 s is on the floor. Jumps are shorter, or higher than
/// `max_hover`.
Motion without_hovering(const Mechanism& m, const Motion& motion, const std::vector<motion_edit::FootLimb>& feet) {
  const double size = motion_edit::mean_leg_length(feet) / 0.9;
  std::vector<Pose> X(at(m.link_count()));
  std::vector<double> low(at(motion.frames), 1e300);
  for (int f = 0; f < motion.frames; ++f) {
    calc_poses(m, {motion.frame(f), at(motion.nq)}, X);
    for (const motion_edit::FootLimb& foot : feet)
      for (const LinkPoint& p : foot.points) low[at(f)] = std::min(low[at(f)], (X[at(p.link)] * p.location.p).z - p.location.radius);
  }
  const int reach = std::max(1, static_cast<int>(hover_time * std::sqrt(size) * motion.rate));
  std::vector<double> hover = extreme(extreme(low, reach, false), reach, true);
  for (double& x : hover) x = x > max_hover * size ? 0 : std::max(0.0, x);
  const std::vector<double> weight(hover.size(), 1.0);
  hover = pass_through(hover, weight, hover_ease * motion.rate * hover_ease * motion.rate);
  Motion out = motion;
  for (int f = 0; f < motion.frames; ++f) displace_root(m, {0, 0, -hover[at(f)], 0}, {out.frame(f), at(out.nq)});
  return out;
}

/// Adds the contacts of feet that slide: in times without contact in which the body stays on the floor, the lowest limbs are in contact.
FootContacts slide(const Mechanism& m, const Motion& motion, FootContacts contacts) {
  const double size = motion_edit::mean_leg_length(contacts.feet) / 0.9;
  std::vector<Pose> X(at(m.link_count()));
  std::vector<std::vector<double>> height(contacts.feet.size());  // [limbs][frames] m, of the lowest point
  std::vector<double> lowest(at(motion.frames), 1e300), others(lowest);
  const std::vector<LinkPoint> other = other_points(m, contacts);
  for (int f = 0; f < motion.frames; ++f) {
    calc_poses(m, {motion.frame(f), at(motion.nq)}, X);
    for (std::size_t k = 0; k < contacts.feet.size(); ++k) {
      double low = 1e300;
      for (const LinkPoint& p : contacts.feet[k].points) low = std::min(low, (X[at(p.link)] * p.location.p).z - p.location.radius);
      height[k].push_back(low);
      lowest[at(f)] = std::min(lowest[at(f)], low);
    }
    for (const LinkPoint& p : other) others[at(f)] = std::min(others[at(f)], (X[at(p.link)] * p.location.p).z - p.location.radius);
  }
  const auto bears = [&](int f) { return std::ranges::any_of(contacts.bears, [&](const auto& on) { return on[at(f)] != 0; }); };
  for (int f = 0; f < motion.frames; ++f) {
    if (bears(f)) continue;
    const int first = f;
    while (f + 1 < motion.frames && !bears(f + 1)) ++f;
    if (*std::max_element(lowest.begin() + first, lowest.begin() + f + 1) >= min_clearance * size) continue;
    for (std::size_t k = 0; k < contacts.feet.size(); ++k)
      for (int i = first; i <= f; ++i)
        if (height[k][at(i)] < lowest[at(i)] + same_height * size && others[at(i)] > other_height * size) contacts.bears[k][at(i)] = 1;
  }
  return contacts;
}

}  // namespace

std::vector<LinkPoint> other_points(const Mechanism& m, const motion_edit::FootContacts& contacts) {
  std::vector<LinkPoint> out;
  for (int i = 0; i < m.link_count(); ++i) {
    const auto is_left_out = [&](const SupportPoint& p) {
      return std::ranges::any_of(contacts.feet, [&](const motion_edit::FootLimb& foot) {
        if (std::ranges::count(foot.parts, i) > 0) return true;
        const Link& link = m.link(foot.link);
        return link.parent == i && norm(p.p - link.joint.X_PJ.p) < norm(p.p);
      });
    };
    for (const SupportPoint& p : support_points(m.link(i)))
      if (!is_left_out(p)) out.push_back({i, p});
  }
  return out;
}

FootContacts find_bearing_limbs(const Mechanism& m, const Motion& given) {
  const Motion motion = without_hovering(m, given, motion_edit::find_foot_limbs(m));
  motion_edit::FootContactOptions o;
  o.height_on = 0.05;
  o.height_off = 0.065;
  o.speed_on = 0.5;
  o.speed_off = 0.9;
  FootContacts out = motion_edit::find_contacts(m, motion, o);
  std::vector<std::string> names;
  for (const motion_edit::FootLimb& foot : out.feet)
    for (const int part : foot.parts) names.push_back(m.link(part).name);
  const std::size_t known = names.size();
  for (const Link& link : m.links())
    if ((link.label.starts_with("hand") || link.label.starts_with("fingers")) && !support_points(link).empty()) names.push_back(link.name);
  if (names.size() == known || out.feet.empty()) return slide(m, motion, std::move(out));
  const Result<std::vector<motion_edit::FootLimb>> limbs = motion_edit::find_foot_limbs(m, names);
  if (!limbs) return slide(m, motion, std::move(out));
  o.height_on = 0.025;  // hands that only pass near the floor do not stand on it
  o.height_off = 0.04;
  const FootContacts all = motion_edit::find_contacts(m, motion, *limbs, o);
  for (std::size_t k = 0; k < all.feet.size(); ++k) {
    const bool foot = std::ranges::any_of(out.feet, [&](const auto& other) { return other.link == all.feet[k].link; });
    if (foot || std::ranges::count(all.bears[k], 1) == 0) continue;
    out.feet.push_back(all.feet[k]);
    out.bears.push_back(all.bears[k]);
    out.heel.push_back(all.heel[k]);
    out.toe.push_back(all.toe[k]);
  }
  return slide(m, motion, std::move(out));
}

}  // namespace ugoki::correction
