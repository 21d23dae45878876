#include "ugoki/body/body_motion.h"

#include <algorithm>

#include "ugoki/base/check.h"
#include "ugoki/body/build.h"
#include "ugoki/body/calibration_frames.h"
#include "ugoki/body/creature.h"
#include "ugoki/body/joints.h"
#include "ugoki/body/recognise.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/motion/contact_labels.h"

namespace ugoki::body {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Memory of reproduce().
struct Reproduction {
  std::vector<Pose> measured;  ///< [joints] world poses in the motion
  std::vector<Pose> made;      ///< [joints] world poses of the body's links
};

/// Coordinates of the body in one frame of a motion. Its links keep their lengths although joints of the motion may shift.
/// @param X_WM moves the motion to the floor  @param previous [nq] coordinates of the frame before, or null  @param q [nq, out]
void reproduce(const Body& body, const MeasuredMotion& m, int frame, const Pose& X_WM, const double* previous, double* q,
               Reproduction& poses) {
  const Mechanism& mech = *body.mechanism;
  m.calc_joint_poses(frame, poses.measured);
  poses.made.resize(poses.measured.size());
  for (std::size_t i = 0; i < poses.made.size(); ++i) {
    const Link& link = mech.link(body.link_of_joint[i]);
    const Pose wanted = X_WM * poses.measured[i];
    const int parent = m.skeleton.joints[i].parent;
    double* own = q + link.q_index;
    const double* before = previous ? previous + link.q_index : nullptr;
    if (link.joint.type == JointType::floating) {
      own[0] = wanted.p.x;
      own[1] = wanted.p.y;
      own[2] = wanted.p.z;
      Joint ball;
      ball.type = JointType::spherical;
      find_coordinates(ball, wanted.R, before ? before + 3 : nullptr, own + 3);
      poses.made[i] = wanted;
      continue;
    }
    // The rotation is taken relative to the parent's reproduced pose, so that the errors of hinges do not accumulate along a limb.
    const Pose& base = poses.made[at(parent)];
    find_coordinates(link.joint, base.R.transposed() * wanted.R, before, own);
    poses.made[i] = base * (link.joint.X_PJ * joint_pose(link.joint, own));
  }
}

/// Height [m] of the floor under a character that is not human: in most frames its lowest point touches the floor. For four-legged animals
/// only the frames count in which they stand (usually_stands). The points are those of the body: limbs of cartoon animals may shift, and
/// those of the body do not.
double lowest_level(const Body& body, const MeasuredMotion& motion) {
  std::vector<double> lows, heights, q(at(body.mechanism->nq()));
  Reproduction poses;
  const int step = std::max(1, motion.frames / 1000);
  std::vector<std::vector<SupportPoint>> points;
  for (const int link : body.link_of_joint) points.push_back(support_points(body.mechanism->link(link)));
  for (int f = count_calibration_frames(motion); f < motion.frames; f += step) {
    reproduce(body, motion, f, {}, nullptr, q.data(), poses);
    const std::vector<Pose>& X = poses.made;
    double low = 1e300;
    for (std::size_t i = 0; i < X.size(); ++i)
      for (const SupportPoint& s : points[i]) low = std::min(low, (X[i] * s.p).z - s.radius);
    lows.push_back(low);
    heights.push_back(X[0].p.z - low);
  }
  if (lows.empty()) return 0;
  if (body.anatomy.plan == "four legs") {
    const std::vector<char> stands = usually_stands(heights);
    std::size_t kept = 0;
    for (std::size_t k = 0; k < lows.size(); ++k)
      if (stands[k] != 0) lows[kept++] = lows[k];
    lows.resize(kept);
  }
  const auto middle = lows.begin() + static_cast<std::ptrdiff_t>(lows.size() / 10);
  std::nth_element(lows.begin(), middle, lows.end());
  return *middle < 1e200 ? *middle : 0;
}

}  // namespace

Pose floor_pose_at_rest(const Body& body, const MeasuredMotion& motion) {
  if (!body.level_floor) return {};
  if (!body.human) return {Mat3::identity(), {0, 0, -lowest_level(body, motion)}};
  const int calibration = count_calibration_frames(motion);
  const FloorFit fit = fit_floor(calibration > 0 ? without_first(motion, calibration) : motion, body.soles, body.height);
  if (!fit.found) return {};
  double floor = 0;
  int standing = 0;
  for (std::size_t s = 0; s < body.soles.size(); ++s)
    if (!fit.stances[s].frames.empty()) {
      floor += fit.stances[s].ball_height - body.soles[s].thickness;
      ++standing;
    }
  return {fit.R_level, {0, 0, standing > 0 ? -floor / standing : 0}};
}

Motion convert(const Body& body, const MeasuredMotion& m) {
  const Mechanism& mech = *body.mechanism;
  UGOKI_CHECK(m.skeleton.joints.size() == body.link_of_joint.size());
  Motion out;
  out.name = m.name;
  out.source = m.source;
  out.mechanism = mech.name();
  out.rate = m.rate;
  out.frames = m.frames;
  out.nq = mech.nq();
  out.q.assign(at(m.frames) * at(out.nq), 0.0);
  const Pose X_WM = floor_pose_at_rest(body, m);
  Reproduction poses;
  for (int f = 0; f < m.frames; ++f) reproduce(body, m, f, X_WM, f > 0 ? out.frame(f - 1) : nullptr, out.frame(f), poses);
  if (const int first = count_calibration_frames(m); first > 0) {
    std::vector<double> back(at(mech.nv()));
    const auto frame = [&](int f) { return std::span<double>(out.frame(f), at(out.nq)); };
    difference(mech, frame(first + 1), frame(first), back);
    for (int f = first - 1; f >= 0; --f) integrate(mech, frame(f + 1), back, 1.0, frame(f));
  }
  label_contacts(mech, out);
  return out;
}

double position_error(const Body& body, const MeasuredMotion& measured, const Motion& motion) {
  const Pose X_WM = floor_pose_at_rest(body, measured);
  std::vector<Pose> wanted, made(at(body.mechanism->link_count()));
  double worst = 0;
  for (int f = count_calibration_frames(measured); f < measured.frames; ++f) {
    measured.calc_joint_poses(f, wanted);
    calc_poses(*body.mechanism, std::span(motion.frame(f), at(motion.nq)), made);
    for (std::size_t i = 0; i < wanted.size(); ++i) worst = std::max(worst, norm(X_WM * wanted[i].p - made[at(body.link_of_joint[i])].p));
  }
  return worst;
}

namespace {
/// The motion in the body's rest pose.
MeasuredMotion at_rest_of(const Body& body, const MeasuredMotion& m) { return body.rest.empty() ? m : with_rest_pose(m, body.rest); }
}  // namespace

Pose calc_floor_pose(const Body& body, const MeasuredMotion& motion) { return floor_pose_at_rest(body, at_rest_of(body, motion)); }
Motion to_motion(const Body& body, const MeasuredMotion& m) { return convert(body, at_rest_of(body, m)); }
double calc_position_error(const Body& body, const MeasuredMotion& measured, const Motion& motion) {
  return position_error(body, at_rest_of(body, measured), motion);
}

}  // namespace ugoki::body
