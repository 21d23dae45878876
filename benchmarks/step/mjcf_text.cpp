// Writes a scene as MJCF.

#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "scene.h"

namespace ugoki::benchmarks {
namespace {

std::string numbers(const double* x, int count) {
  std::string out;
  char text[32];
  for (int i = 0; i < count; ++i) {
    std::snprintf(text, sizeof text, i == 0 ? "%.17g" : " %.17g", x[i]);
    out += text;
  }
  return out;
}
std::string attribute(const char* name, const double* x, int count) { return ' ' + std::string(name) + "=\"" + numbers(x, count) + '"'; }
std::string attribute(const char* name, double x) { return attribute(name, &x, 1); }

std::string placement(const Frame& X) {
  double q[4];
  quaternion_of(X.R, q);
  return attribute("pos", X.p, 3) + attribute("quat", q, 4);
}

class Writer {
 public:
  explicit Writer(const StepScene& scene) : scene_(scene) {}

  std::string write() {
    char head[512];
    std::snprintf(head, sizeof head,
                  "<mujoco><compiler angle=\"radian\"/><option timestep=\"%.17g\"/><size nconmax=\"%d\" njmax=\"%d\"/>"
                  "<default><geom %s/></default><worldbody><geom type=\"plane\" size=\"50 50 1\"/>\n",
                  scene_.dt, scene_.max_contacts, 4 * scene_.max_contacts + 500, scene_.mjcf_geom.c_str());
    text_ = head;
    std::string contact, equality;
    for (std::size_t b = 0; b < scene_.bodies.size(); ++b) {
      body_ = &scene_.bodies[b];
      prefix_ = std::to_string(b) + '/';
      write_link(0, body_->base, {});
      for (const auto& pair : body_->excluded) contact += "<exclude" + both(pair.first, pair.second) + "/>\n";
      for (const StepLoop& l : body_->loops) equality += "<connect" + both(l.a, l.b) + attribute("anchor", l.point_a, 3) + "/>\n";
    }
    return text_ + "</worldbody>\n<contact>" + contact + "</contact>\n<equality>" + equality + "</equality></mujoco>\n";
  }

 private:
  struct Carried {
    const StepLink* link;
    Frame frame;  ///< pose of the joint in the body that the joint moves
  };

  std::string name_of(int link) const { return prefix_ + body_->links[static_cast<std::size_t>(link)].name; }
  std::string both(int a, int b) const { return " body1=\"" + name_of(a) + "\" body2=\"" + name_of(b) + '"'; }

  /// Writes link i and its descendants.
  /// @param X pose of the link in the parent body @param joints joints of the auxiliary links (without mass) before link i, with their
  /// frames in link i
  void write_link(int i, const Frame& X, std::vector<Carried> joints) {
    const StepLink& l = body_->links[static_cast<std::size_t>(i)];
    joints.push_back({&l, {}});
    if (l.mass == 0) {
      int child = -1;
      for (std::size_t c = 0; c < body_->links.size(); ++c)
        if (body_->links[c].parent == i) child = child < 0 ? static_cast<int>(c) : throw std::runtime_error(l.name + " has no mass");
      if (child < 0) throw std::runtime_error(l.name + " has no mass");
      const Frame& next = body_->links[static_cast<std::size_t>(child)].joint_frame;
      for (Carried& c : joints) c.frame = inverse(next) * c.frame;
      write_link(child, X * next, joints);
      return;
    }
    text_ += "<body name=\"" + name_of(i) + '"' + placement(X) + ">";
    for (const Carried& c : joints) write_joint(*c.link, c.frame);
    text_ += "<inertial" + attribute("pos", l.centre, 3) + attribute("mass", l.mass) + attribute("fullinertia", l.inertia, 6) + "/>\n";
    for (const StepShape& s : body_->shapes)
      if (s.link == i) write_shape(s);
    for (std::size_t c = 0; c < body_->links.size(); ++c)
      if (body_->links[c].parent == i) write_link(static_cast<int>(c), body_->links[c].joint_frame, {});
    text_ += "</body>\n";
  }

  void write_joint(const StepLink& l, const Frame& X) {
    if (l.joint == StepJoint::floating) {
      text_ += "<freejoint/>\n";
      return;
    }
    double axis[3];
    rotate(X.R, l.axis, axis);
    text_ += "<joint name=\"" + prefix_ + l.name + '"' + attribute("pos", X.p, 3);
    if (l.joint == StepJoint::spherical)
      text_ += " type=\"ball\"";
    else
      text_ += std::string(l.joint == StepJoint::prismatic ? " type=\"slide\"" : " type=\"hinge\"") + attribute("axis", axis, 3);
    if (std::isfinite(l.lower) || std::isfinite(l.upper)) {
      const double range[2] = {std::fmax(l.lower, -1e3), std::fmin(l.upper, 1e3)};
      text_ += " limited=\"true\"" + attribute("range", range, 2);
    }
    if (l.damping != 0) text_ += attribute("damping", l.damping);
    if (l.stiffness != 0) text_ += attribute("stiffness", l.stiffness) + attribute("springref", l.rest);
    if (l.armature != 0) text_ += attribute("armature", l.armature);
    text_ += "/>";
  }

  void write_shape(const StepShape& s) {
    const char* const types[] = {"sphere", "capsule", "box", "cylinder", "ellipsoid"};
    text_ +=
        "<geom type=\"" + std::string(types[static_cast<int>(s.type)]) + '"' + attribute("size", s.size, 3) + placement(s.frame) + "/>\n";
  }

  const StepScene& scene_;
  const StepBody* body_ = nullptr;
  std::string prefix_, text_;
};

}  // namespace

std::string write_scene_mjcf(const StepScene& scene) { return Writer(scene).write(); }

}  // namespace ugoki::benchmarks
