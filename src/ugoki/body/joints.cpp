#include "ugoki/body/joints.h"

#include <algorithm>
#include <optional>

#include "ugoki/base/number.h"

namespace ugoki::body {
namespace {

constexpr double degree = pi / 180;
constexpr double unmoved = 0.01 * degree;    // rad, joints that turn less count as fixed
constexpr double position_tolerance = 2e-7;  // m, position error that one joint may add for its descendants
constexpr double hinge_tolerance = 8e-7;     // m, position error that a hinge may add for its children
constexpr double reported_shift = 5e-5;      // m, smaller shifts are rounding in the file and are not reported

std::size_t at(int i) { return static_cast<std::size_t>(i); }

const Quat& rotation(const MeasuredMotion& m, int frame, int joint) {
  return m.rotations[at(frame) * m.skeleton.joints.size() + at(joint)];
}
const Vec3& translation(const MeasuredMotion& m, int frame, int joint) {
  return m.translations[at(frame) * m.skeleton.joints.size() + at(joint)];
}

/// Upper bound [m] of the distance of any descendant from joint `i` in any posture.
double reach_of(const Skeleton& s, int i) {
  std::vector<double> distance(s.joints.size(), -1.0);
  distance[at(i)] = 0;
  double reach = 0;
  for (std::size_t k = at(i) + 1; k < s.joints.size(); ++k) {
    const int parent = s.joints[k].parent;
    if (parent < 0 || distance[at(parent)] < 0) continue;
    distance[k] = distance[at(parent)] + norm(s.joints[k].offset);
    reach = std::max(reach, distance[k]);
  }
  return reach;
}

/// Twist angle [rad] of q about `axis` (swing-twist decomposition).
double twist_angle(const Quat& q, const Vec3& axis) { return 2 * atan2(dot(q.vec(), axis), q.w); }
double angle_of(const Quat& q) { return norm(log_map(q)); }

/// Angles (outer, inner) [rad] of a universal joint that approximate R; exact if R is a rotation about axis followed by one about axis2.
void universal_angles(const Vec3& axis, const Vec3& axis2, const Mat3& R, double* q) {
  const Vec3 from = axis2 - axis * dot(axis2, axis), moved = R * axis2;
  const Vec3 to = moved - axis * dot(moved, axis);
  q[0] = atan2(dot(axis, cross(from, to)), dot(from, to));
  q[1] = twist_angle(to_quat(rotation_about(axis, -q[0]) * R), axis2);
}

/// `angle` plus the multiple of 2 pi that brings it closest to `reference`.
double nearest(double angle, double reference) {
  const double turns = (angle - reference) / (2 * pi);
  return angle - 2 * pi * std::floor(turns + 0.5);
}

/// Largest angle [rad] between the measured rotations and the closest rotations that the joint allows.
double worst_misfit(const MeasuredMotion& m, int i, const Joint& joint) {
  double worst = 0;
  double q[7];
  for (int f = 0; f < m.frames; ++f) {
    const Mat3 R = to_matrix(rotation(m, f, i));
    find_coordinates(joint, R, nullptr, q);
    const Mat3 fitted = joint.X_PJ.R * joint_pose(joint, q).R;
    worst = std::max(worst, angle_of(to_quat(fitted.transposed() * R)));
  }
  return worst;
}

/// Unit principal direction of the rotation vectors v (power iteration on their second moments).
Vec3 principal_direction(const std::vector<Vec3>& v) {
  Mat3 moments{};
  Vec3 best{};
  for (const Vec3& r : v) {
    moments += Mat3{r.x * r.x, r.x * r.y, r.x * r.z, r.y * r.x, r.y * r.y, r.y * r.z, r.z * r.x, r.z * r.y, r.z * r.z};
    if (norm(r) > norm(best)) best = r;
  }
  Vec3 d = normalized(best);
  for (int k = 0; k < 50; ++k) d = normalized(moments * d, d);
  return d;
}

/// Hinge that reproduces all measured rotations within `tolerance` [rad]; nothing if there is none.
std::optional<Joint> fit_hinge(const MeasuredMotion& m, int i, const Joint& base, double tolerance) {
  const Quat first = rotation(m, 0, i);
  std::vector<Vec3> turns(at(m.frames));
  for (int f = 0; f < m.frames; ++f) turns[at(f)] = log_map(first.conjugate() * rotation(m, f, i));
  Joint joint = base;
  joint.type = JointType::revolute;
  joint.axis = principal_direction(turns);
  // The axis is signed so that the mean angle is positive: knees and elbows flex in the positive sense.
  double mean = 0;
  for (int f = 0; f < m.frames; ++f) mean += twist_angle(rotation(m, f, i), joint.axis);
  if (mean < 0) joint.axis = -joint.axis;
  // Decompose the first rotation into a constant rotation and a twist about the axis; the constant is usually the identity.
  const Quat constant = normalized(first * axis_angle(joint.axis, -twist_angle(first, joint.axis)));
  joint.X_PJ.R = angle_of(constant) < 1e-5 ? Mat3::identity() : to_matrix(constant);
  if (worst_misfit(m, i, joint) > tolerance) return std::nullopt;
  return joint;
}

}  // namespace

Joint fit_joint(const MeasuredMotion& m, int i, const BodyOptions& options, bool strict, const Mat3& zero,
                std::vector<std::string>& report) {
  const SkeletonJoint& source = m.skeleton.joints[at(i)];
  Joint joint;
  if (source.parent < 0) {
    joint.type = JointType::floating;
    return joint;
  }
  joint.X_PJ.p = source.offset;
  if (m.frames == 0) {
    joint.type = source.dofs.empty() ? JointType::fixed : JointType::spherical;
    return joint;
  }
  // Position relative to the parent: the mean of the measured translations if they vary.
  Vec3 mean{};
  double shift = 0;
  for (int f = 0; f < m.frames; ++f) {
    mean += translation(m, f, i) - translation(m, 0, i);
    shift = std::max(shift, norm(translation(m, f, i) - translation(m, 0, i)));
  }
  joint.X_PJ.p = translation(m, 0, i);
  if (shift > position_tolerance) {
    joint.X_PJ.p += mean / m.frames;
    if (shift > reported_shift)
      report.push_back("Joint " + source.name + " is measured to shift by up to " + to_fixed(1000 * shift, 1) +
                       " mm against its parent; the body holds it at the mean position, so joints below it differ by up to as much.");
  }
  // Rotation: angle tolerances follow from the position tolerances and the lengths below the joint.
  const double reach = reach_of(m.skeleton, i);
  const double tolerance = std::min(1e-5, reach > 0 ? position_tolerance / reach : 1.0);
  double near = 0;
  for (const SkeletonJoint& j : m.skeleton.joints)
    if (j.parent == i) near = std::max(near, norm(j.offset));
  const double near_tolerance = std::min(1e-5, near > 0 ? hinge_tolerance / near : 1.0);
  double moved = 0;
  for (int f = 1; f < m.frames; ++f) moved = std::max(moved, angle_of(rotation(m, 0, i).conjugate() * rotation(m, f, i)));
  // A single frame contains no information about joint types: joints that carry a bone become spherical.
  const bool carries = near > 0 || std::ranges::any_of(source.end_sites, [](const Vec3& e) { return norm(e) > 0; });
  const bool unknown = m.frames == 1 && carries;
  const bool still = !unknown && moved < std::min(unmoved, std::max(tolerance, 1e-9));
  if (still && (source.dofs.empty() || !options.keep_unmoved)) {
    if (angle_of(rotation(m, 0, i)) > 1e-9) joint.X_PJ.R = to_matrix(rotation(m, 0, i));
    return joint;
  }
  // The DOFs of the file, if they have limits or if their zero position is the rest pose.
  const bool at_rest = zero == Mat3::identity();
  const bool use_dofs = at_rest || std::ranges::all_of(source.dofs, [](const MeasuredDof& d) { return d.limited; });
  if (use_dofs) joint.X_PJ.R = zero;
  if (source.dofs.size() == 1 && use_dofs) {
    joint.type = JointType::revolute;
    joint.axis = source.dofs[0].axis;
    if (worst_misfit(m, i, joint) <= tolerance) return joint;
  } else if (source.dofs.size() == 2 && use_dofs && norm(cross(source.dofs[0].axis, source.dofs[1].axis)) > 0.1) {
    joint.type = JointType::universal;
    joint.axis = source.dofs[0].axis;
    joint.axis2 = source.dofs[1].axis;
    if (worst_misfit(m, i, joint) <= tolerance) return joint;
  }
  joint.X_PJ.R = Mat3::identity();
  if (!options.keep_unmoved && !unknown)
    if (const auto hinge = fit_hinge(m, i, joint, strict ? tolerance : near_tolerance)) return *hinge;
  joint.type = JointType::spherical;
  joint.axis = {0, 0, 1};
  joint.axis2 = {0, 1, 0};
  return joint;
}

void find_coordinates(const Joint& joint, const Mat3& R_PB, const double* previous, double* q) {
  const Mat3 R = joint.X_PJ.R.transposed() * R_PB;
  switch (joint.type) {
    case JointType::revolute:
      q[0] = twist_angle(to_quat(R), joint.axis);
      q[0] = nearest(q[0], previous ? previous[0] : 0);
      return;
    case JointType::universal:
      universal_angles(joint.axis, joint.axis2, R, q);
      q[0] = nearest(q[0], previous ? previous[0] : 0);
      q[1] = nearest(q[1], previous ? previous[1] : 0);
      return;
    case JointType::spherical: {
      Quat r = to_quat(R);
      if (previous && r.w * previous[0] + r.x * previous[1] + r.y * previous[2] + r.z * previous[3] < 0) r = {-r.w, -r.x, -r.y, -r.z};
      q[0] = r.w;
      q[1] = r.x;
      q[2] = r.y;
      q[3] = r.z;
      return;
    }
    default: return;
  }
}

std::optional<MeasuredMotion> with_measured_offsets(const MeasuredMotion& motion) {
  constexpr double held = 0.01, far = 0.1;  // shares of the distance from the offset, and of the extent of the skeleton
  if (motion.frames < 2) return std::nullopt;
  std::vector<Pose> X;
  motion.calc_joint_poses(0, X);
  double extent = 0;
  for (const Pose& x : X) extent = std::max(extent, norm(x.p - X[0].p));
  std::optional<MeasuredMotion> out;
  for (int i = 0; i < motion.joint_count(); ++i) {
    const SkeletonJoint& joint = motion.skeleton.joints[at(i)];
    if (joint.parent < 0) continue;
    const Vec3 first = translation(motion, 0, i);
    const double apart = norm(first - joint.offset);
    if (apart <= far * extent || norm(joint.offset) <= far * extent) continue;
    double shift = 0;
    for (int f = 1; f < motion.frames; ++f) shift = std::max(shift, norm(translation(motion, f, i) - first));
    if (shift > held * apart) continue;
    if (!out) out = motion;
    out->skeleton.joints[at(i)].offset = first;
  }
  return out;
}

}  // namespace ugoki::body
