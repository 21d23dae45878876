#include "ugoki/retarget/findings.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "ugoki/base/number.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/motion_edit/foot_contacts.h"
#include "ugoki/retarget/feet_plan.h"

namespace ugoki::retarget {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Whether DOF `k` of a joint that is not floating is measured by an angle (rad), otherwise by a distance (m).
bool is_angle(JointType type, int k) {
  switch (type) {
    case JointType::prismatic: return false;
    case JointType::cylindrical: return k == 0;
    case JointType::planar: return k == 2;
    default: return true;
  }
}

void find_margins(const Mechanism& m, const Motion& motion, RetargetReport& report) {
  report.min_margin = 1e300;
  for (const Link& link : m.links()) {
    const int nv = link.joint.nv();
    bool limited = false;
    for (int k = 0; k < nv; ++k)
      limited = limited || std::isfinite(link.joint.dofs[at(k)].lower) || std::isfinite(link.joint.dofs[at(k)].upper);
    if (!limited || link.joint.type == JointType::floating) continue;
    int frames = 0;
    for (int f = 0; f < motion.frames; ++f) {
      double x[6], margin = 1e300;
      bool turns = true;
      joint_displacement(link.joint, motion.frame(f) + link.q_index, x);
      for (int k = 0; k < nv; ++k) {
        const Dof& dof = link.joint.dofs[at(k)];
        const double to_limit = std::min(x[k] - dof.lower, dof.upper - x[k]);
        if (to_limit < margin) turns = is_angle(link.joint.type, k);
        margin = std::min(margin, to_limit);
      }
      if (margin < 1e-6) ++frames;
      if (margin < report.min_margin) {
        report.min_margin = margin;
        report.margin_link = link.name;
        report.margin_turns = turns;
      }
    }
    if (frames > 0) report.at_limit.emplace_back(link.name, frames);
  }
  if (report.min_margin > 1e299) report.min_margin = INFINITY;
  std::sort(report.at_limit.begin(), report.at_limit.end(),
            [](const auto& a, const auto& b) { return a.second != b.second ? a.second > b.second : a.first < b.first; });
}

void find_speeds(const Mechanism& m, const Mapping& mapping, const Motion& motion, RetargetReport& report) {
  if (!(mapping.speed > 0) && mapping.link_speeds.empty()) return;
  for (const Link& link : m.links()) {
    if (link.joint.type == JointType::floating || link.joint.nv() == 0) continue;
    double maximum = mapping.speed;
    for (const auto& [name, speed] : mapping.link_speeds)
      if (name == link.name) maximum = speed;
    if (!(maximum > 0)) continue;
    for (int f = 1; f < motion.frames; ++f) {
      double v[6];
      joint_difference(link.joint, motion.frame(f - 1) + link.q_index, motion.frame(f) + link.q_index, v);
      for (int k = 0; k < link.joint.nv(); ++k)
        if (const double share = std::fabs(v[k]) * motion.rate / maximum; share > report.max_speed) {
          report.max_speed = share;
          report.speed_link = link.name;
        }
    }
  }
}

/// Longest horizontal path [m] of the foot in one stance, for a limb whose sole is a single point.
double skate_of_point(const LimbRig& limb, const Mechanism& m, const Motion& motion, const std::vector<std::uint8_t>& on, int& stances) {
  motion_edit::FootPath path;
  path.bears = on;
  std::vector<Pose> X(at(m.link_count()));
  for (int f = 0; f < motion.frames; ++f) {
    calc_poses(m, std::span<const double>(motion.frame(f), at(motion.nq)), X);
    path.X_WF.push_back({Mat3::identity(), X[at(limb.end)] * limb.end_point});
    for (const LinkPoint& p : limb.sole.points) path.points.push_back(p.location);
  }
  return path_skate(path, stances);
}

void find_skate(const Rig& rig, const Driver& driver, const Motion& motion, RetargetReport& report) {
  const Mechanism& m = *rig.mechanism;
  report.stances = 0;
  std::size_t i = 0;
  for (int k = 0; k < limb_count; ++k) {
    if (!driver.limb(k).ground || driver.limb(k).source < 0) continue;
    const LimbRig& limb = rig.limbs[at(k)];
    const std::vector<std::uint8_t>& on = motion.contacts[i++].on;
    if (limb.point_foot) {
      report.skate_after = std::max(report.skate_after, skate_of_point(limb, m, motion, on, report.stances));
      continue;
    }
    const motion_edit::SkateReport skate =
        motion_edit::measure_skate(m, motion, {.feet = {limb.sole}, .ground = 0, .bears = {on}, .heel = {}, .toe = {}});
    report.stances += skate.stances;
    report.skate_after = std::max(report.skate_after, 0.01 * skate.worst_cm);
  }
}

}  // namespace

void complete_report(const Rig& target, const Driver& driver, const RetargetOptions& options, Retargeted& result) {
  RetargetReport& report = result.report;
  find_margins(*target.mechanism, result.motion, report);
  find_skate(target, driver, result.motion, report);
  find_speeds(*target.mechanism, options.mapping, result.motion, report);
  if (!(report.max_speed > 1)) return;
  if (!options.slow_down) {
    report.notes.push_back(report.speed_link + " moves at " + to_fixed(report.max_speed, 2) +
                           " times its allowed speed; slow the motion down by that factor.");
    return;
  }
  report.slowed = report.max_speed;
  result.motion.rate /= report.slowed;
  report.notes.push_back("The motion was slowed down by the factor " + to_fixed(report.slowed, 2) + ", so that " + report.speed_link +
                         " keeps its allowed speed.");
}

std::vector<std::string> describe(const RetargetReport& r) {
  std::vector<std::string> lines;
  const auto mm = [](double metres, int digits) { return to_fixed(1000 * metres, digits) + " mm"; };
  lines.push_back("Lengths were scaled by " + to_fixed(r.scale, 3) + "; in " + std::to_string(r.stances) +
                  " stances a foot slides by at most " + mm(r.skate_after, 2) + " (" + mm(r.skate_before, 1) +
                  " without foot correction).");
  if (r.max_shift > 1e-3)
    lines.push_back("The root was moved by up to " + mm(r.max_shift, 0) + " (frame " + std::to_string(r.shift_frame) +
                    "), so that the feet reach the ground.");
  if (!r.margin_link.empty()) {
    const double margin = std::max(0.0, r.min_margin);
    lines.push_back("No joint limit is exceeded; the closest is that of " + r.margin_link + ", " +
                    (r.margin_turns ? to_fixed(margin * 180 / std::numbers::pi, 1) + " degrees away." : mm(margin, 1) + " away."));
  }
  for (std::size_t i = 0; i < r.at_limit.size() && i < 5; ++i)
    lines.push_back(r.at_limit[i].first + " is at a limit in " + std::to_string(r.at_limit[i].second) + " frames.");
  for (const Miss& m : r.misses)
    lines.push_back(m.link + " misses its goal by up to " + mm(m.maximum, 1) + " (frame " + std::to_string(m.frame) +
                    "), by more than 1 mm in " + std::to_string(m.frames) + " frames.");
  lines.insert(lines.end(), r.holds.begin(), r.holds.end());
  lines.insert(lines.end(), r.notes.begin(), r.notes.end());
  return lines;
}

}  // namespace ugoki::retarget
