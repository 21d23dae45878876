#include "characters.h"

#include <algorithm>
#include <cmath>

#include "ugoki/body/body.h"
#include "ugoki/files/files.h"
#include "ugoki/formats/asf.h"
#include "ugoki/formats/bvh.h"
#include "ugoki/formats/gltf.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/motion/contact_labels.h"
#include "ugoki/robot_formats/robot_file.h"
#include "ugoki/samples/samples.h"

namespace ugoki::retarget_test {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }
std::string data(const std::string& path) { return std::string(UGOKI_SHARED_DATA) + "/" + path; }

}  // namespace

MechanismPtr make_person(double height) { return *samples::make_person(height); }

Clip human_walk() {
  const MeasuredMotion walk = samples::make_human_walk();
  const auto body = body::make_body(walk);
  Clip out{"walk", body->mechanism, body::to_motion(*body, walk)};
  out.motion.cyclic = true;
  return out;
}

Clip dog_trot() {
  const MechanismPtr dog = samples::make_dog();
  return {"trot", dog, samples::make_dog_trot(*dog)};
}

MechanismPtr make_hinged_robot() {
  MechanismSpec spec;
  spec.name = "hinged robot";
  const auto add = [&](const std::string& name, const std::string& parent, const Vec3& p, const Vec3& axis, double lower, double upper,
                       std::vector<Shape> shapes = {}) {
    LinkSpec l;
    l.name = name;
    l.parent = parent;
    l.joint.type = parent.empty() ? JointType::floating : JointType::revolute;
    l.joint.X_PJ.p = p;
    l.joint.axis = axis;
    l.joint.dofs[0].lower = lower;
    l.joint.dofs[0].upper = upper;
    l.inertia = Inertia::from_centre(1, {}, {0.01, 0.01, 0.01, 0, 0, 0});
    l.shapes = std::move(shapes);
    spec.links.push_back(std::move(l));
  };
  const Vec3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
  add("base", "", {0, 0, 0.85}, x, 0, 0);
  add("waist_yaw", "base", {0, 0, 0.15}, z, -1.2, 1.2);
  add("waist_pitch", "waist_yaw", {0, 0, 0}, y, -0.4, 0.8);
  add("head_yaw", "waist_pitch", {0, 0, 0.45}, z, -1, 1, {Shape::sphere(0.1, {Mat3::identity(), {0, 0, 0.1}})});
  for (const double s : {1.0, -1.0}) {
    const std::string n = s > 0 ? "left_" : "right_";
    add(n + "hip_yaw", "base", {0, 0.1 * s, 0}, z, -0.8, 0.8);
    add(n + "hip_roll", n + "hip_yaw", {}, x, -0.6, 0.6);
    add(n + "hip_pitch", n + "hip_roll", {}, y, -2.0, 0.8);
    add(n + "knee", n + "hip_pitch", {0, 0, -0.38}, y, 0, 2.4);
    add(n + "ankle_pitch", n + "knee", {0, 0, -0.38}, y, -0.9, 0.7);
    add(n + "ankle_roll", n + "ankle_pitch", {}, x, -0.4, 0.4, {Shape::box({0.11, 0.05, 0.02}, {Mat3::identity(), {0.04, 0, -0.07}})});
    add(n + "shoulder_pitch", "waist_pitch", {0, 0.2 * s, 0.4}, y, -3, 3);
    add(n + "shoulder_roll", n + "shoulder_pitch", {}, x, s > 0 ? -0.2 : -3.0, s > 0 ? 3.0 : 0.2);
    add(n + "shoulder_yaw", n + "shoulder_roll", {0, 0, -0.1}, z, -2, 2);
    add(n + "elbow", n + "shoulder_yaw", {0, 0, -0.18}, y, -2.4, 0);
    add(n + "wrist", n + "elbow", {0, 0, -0.25}, z, -1.5, 1.5, {Shape::sphere(0.05, {Mat3::identity(), {0, 0, -0.05}})});
  }
  return *Mechanism::make(std::move(spec));
}

bool load_clip(const std::string& path, Clip& clip) {
  const std::string file = data(path);
  const auto bytes = files::read_file(file);
  if (!bytes) return false;
  Result<MeasuredMotion> measured = fail(ErrorCode::io, "", "");
  if (path.ends_with(".amc")) {
    const std::string name = file.substr(0, file.find_last_of('_')) + ".asf";
    const auto text = files::read_file(name);
    if (!text) return false;
    const auto asf = formats::read_asf(*text, name, {});
    if (asf) measured = formats::read_amc(*bytes, file, *asf, {});
  } else if (path.ends_with(".bvh")) {
    measured = formats::read_bvh(*bytes, file, {});
  } else {
    const auto* p = reinterpret_cast<const std::byte*>(bytes->data());
    auto all = formats::read_gltf({p, bytes->size()}, file);
    if (all && !all->empty()) measured = std::move(all->front());
  }
  if (!measured) return false;
  const auto body = body::make_body(*measured);
  if (!body) return false;
  clip = {path.substr(path.find_last_of('/') + 1), body->mechanism, body::to_motion(*body, *measured)};
  return true;
}

MechanismPtr load_robot(const std::string& path) {
  const auto bytes = files::read_file(data(path));
  if (!bytes) return nullptr;
  robot_formats::RobotOptions options;
  options.base = robot_formats::Base::floating;
  options.meshes = robot_formats::Meshes::none;
  const auto robot = robot_formats::read_robot_file(*bytes, path, options);
  return robot ? robot->mechanism : nullptr;
}

double worst_excess(const Mechanism& m, const Motion& motion) {
  double worst = -1e300;
  for (int f = 0; f < motion.frames; ++f)
    for (const Link& link : m.links()) {
      if (link.joint.type == JointType::floating) continue;
      double x[6];
      joint_displacement(link.joint, motion.frame(f) + link.q_index, x);
      for (int k = 0; k < link.joint.nv(); ++k) {
        const Dof& dof = link.joint.dofs[at(k)];
        worst = std::max({worst, dof.lower - x[k], x[k] - dof.upper});
      }
    }
  return worst;
}

double worst_skate(const Mechanism& m, const Motion& motion) {
  double worst = 0;
  for (const ContactTrack& track : motion.contacts) {
    const int foot = m.find_link(track.link);
    std::vector<LinkPoint> points;
    for (int i = foot; i < m.link_count(); ++i) {
      int up = i;
      while (up > foot) up = m.link(up).parent;
      if (up != foot) continue;
      for (const SupportPoint& p : support_points(m.link(i))) points.push_back({i, p});
    }
    if (points.empty()) points.push_back({foot, {}});
    std::vector<Pose> X(at(m.link_count())), before(X.size());
    double path = 0;
    for (int f = 0; f < motion.frames; ++f) {
      std::swap(X, before);
      calc_poses(m, std::span<const double>(motion.frame(f), at(motion.nq)), X);
      if (!track.on[at(f)] || f == 0 || !track.on[at(f - 1)]) {
        path = 0;
        continue;
      }
      double low = 1e300;
      Vec3 step;
      for (const LinkPoint& p : points) {
        const Pose& now = X[at(p.link)];
        const Vec3 bottom = p.location.p + transpose_times(now.R, Vec3{0, 0, -p.location.radius});
        if ((now * bottom).z >= low) continue;
        low = (now * bottom).z;
        step = now * bottom - before[at(p.link)] * bottom;
      }
      path += std::sqrt(step.x * step.x + step.y * step.y);
      worst = std::max(worst, path);
    }
  }
  return worst;
}

}  // namespace ugoki::retarget_test
