#include "ugoki/motion_edit/to_measured.h"

#include <algorithm>

#include "ugoki/mechanism/state.h"

namespace ugoki::motion_edit {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

/// Far end of a link [m, link's frame]: among the centres of its shapes and of its capsules' caps, the point farthest from the joint.
Vec3 far_end(const Link& link) {
  Vec3 end;
  for (const Shape& s : link.shapes) {
    if (s.type == ShapeType::height_field) continue;
    for (const double e : {-1.0, 1.0})
      if (const Vec3 p = s.X_BS * Vec3{0, 0, e * (s.type == ShapeType::capsule ? s.half_length : 0.0)}; norm(p) > norm(end)) end = p;
  }
  return end;
}

}  // namespace

MeasuredMotion to_measured(const Mechanism& m, const Motion& motion) {
  MeasuredMotion out;
  out.name = motion.name;
  out.source = motion.source;
  out.rate = motion.rate;
  out.frames = motion.frames;
  out.skeleton.name = m.name();
  out.skeleton.mass = m.mass();
  std::vector<Pose> rest(at(m.link_count())), X(rest.size());
  calc_poses(m, m.neutral(), rest);
  for (int i = 0; i < m.link_count(); ++i) {
    const Link& link = m.link(i);
    SkeletonJoint joint;
    joint.name = link.name;
    joint.parent = link.parent;
    joint.offset = rest[at(i)].p - (link.parent < 0 ? Vec3{} : rest[at(link.parent)].p);
    const JointType t = link.joint.type;
    joint.translates = t == JointType::floating || t == JointType::planar || t == JointType::prismatic || t == JointType::cylindrical ||
                       t == JointType::helical;
    if (t != JointType::fixed && t != JointType::prismatic)
      for (const Vec3& axis : {Vec3{0, 0, 1}, Vec3{1, 0, 0}, Vec3{0, 1, 0}}) joint.dofs.push_back({axis});
    const bool last = std::none_of(m.links().begin(), m.links().end(), [&](const Link& other) { return other.parent == i; });
    if (const Vec3 end = rest[at(i)].R * far_end(link); last && norm(end) > 1e-6) joint.end_sites.push_back(end);
    out.skeleton.joints.push_back(std::move(joint));
  }
  for (int f = 0; f < motion.frames; ++f) {
    calc_poses(m, {motion.frame(f), at(motion.nq)}, X);
    for (int i = 0; i < m.link_count(); ++i) {
      const int parent = m.link(i).parent;
      const Mat3 R = X[at(i)].R * rest[at(i)].R.transposed();  // orientation of the joint frame, which is parallel to the world at rest
      const Pose own{R, X[at(i)].p};
      const Pose base = parent < 0 ? Pose{} : Pose{X[at(parent)].R * rest[at(parent)].R.transposed(), X[at(parent)].p};
      const Pose local = base.inverse() * own;
      out.translations.push_back(local.p);
      out.rotations.push_back(to_quat(local.R));
    }
  }
  return out;
}

}  // namespace ugoki::motion_edit
