// Writes mechanisms as MJCF, MuJoCo's XML format.

#include <cmath>
#include <set>

#include "ugoki/base/number.h"
#include "ugoki/mechanism/state.h"
#include "ugoki/robot_formats/robot_writer.h"
#include "ugoki/robot_formats/written_notes.h"
#include "ugoki/robot_formats/xml_text.h"

namespace ugoki::robot_formats {
namespace {

class MjcfWriter {
 public:
  MjcfWriter(const Mechanism& m, const RobotMotion& motion) : m_(m), motion_(motion) {}

  RobotText write() {
    xml_.begin("mujoco", attribute("model", m_.name().empty() ? std::string("mechanism") : m_.name()));
    xml_.element("compiler", attribute("angle", "radian") + attribute("inertiafromgeom", "false"));
    write_meshes();
    xml_.begin("worldbody");
    for (int i = 0; i < m_.link_count(); ++i) {
      if (m_.link(i).parent >= 0) continue;
      if (is_world(m_.link(i))) {
        for (const Shape& s : m_.link(i).shapes) write_geom(m_.link(i), s);
        for (int c = m_.link(i).child; c >= 0; c = m_.link(c).sibling) write_tree(c);
      } else {
        write_tree(i);
      }
    }
    xml_.end();
    write_motors();
    write_exclusions();
    write_equalities();
    write_keys();
    xml_.end();
    RobotText out;
    out.text = xml_.take();
    out.notes = notes_.take();
    return out;
  }

 private:
  /// True if the link is the link that read_mjcf makes for the shapes of the world body.
  static bool is_world(const Link& l) {
    return l.name == "world" && l.parent < 0 && l.joint.type == JointType::fixed && l.joint.X_PJ.p == Vec3{} &&
           l.joint.X_PJ.R == Mat3::identity();
  }
  /// Name of the link's body. MJCF reserves "world", so any other link with the name "world" is written as "world link".
  static std::string body_name(const Link& l) { return l.name == "world" && !is_world(l) ? "world link" : l.name; }

  static std::string placement(const Pose& X) {
    std::string out;
    if (X.p != Vec3{}) out += attribute("pos", X.p);
    if (X.R != Mat3::identity()) out += attribute("quat", to_quat(X.R));
    return out;
  }

  void write_meshes() {
    for (const Link& l : m_.links())
      for (const Shape& s : l.shapes)
        if (s.type == ShapeType::mesh) meshes_.emplace(s.geometry.get(), "mesh" + std::to_string(meshes_.size() + 1));
    if (meshes_.empty()) return;
    xml_.begin("asset");
    for (const Link& l : m_.links())
      for (const Shape& s : l.shapes) {
        const auto it = s.type == ShapeType::mesh ? meshes_.find(s.geometry.get()) : meshes_.end();
        if (it == meshes_.end() || !written_.insert(it->second).second) continue;
        std::string vertices, faces;
        for (const Vec3& v : s.geometry->vertices) vertices += (vertices.empty() ? "" : " ") + numbers(v);
        for (const Triangle& t : s.geometry->triangles)
          for (const std::int32_t i : t) faces += (faces.empty() ? "" : " ") + std::to_string(i);
        xml_.element("mesh", attribute("name", it->second) + attribute("vertex", vertices) + attribute("face", faces));
      }
    xml_.end();
  }

  /// Writes the link and its descendants; without recursion, so that a long chain cannot exhaust the stack.
  void write_tree(int root) {
    struct Visit {
      int next;  ///< next child to write; -1: none left
    };
    std::vector<Visit> stack;
    open(root);
    stack.push_back({m_.link(root).child});
    while (!stack.empty()) {
      const int child = stack.back().next;
      if (child < 0) {
        xml_.end();
        stack.pop_back();
        continue;
      }
      stack.back().next = m_.link(child).sibling;
      open(child);
      stack.push_back({m_.link(child).child});
    }
  }

  void open(int i) {
    const Link& l = m_.link(i);
    xml_.begin("body", attribute("name", body_name(l)) + placement(l.joint.X_PJ));
    if (l.inertia.mass > 0) {
      const Sym3 I = l.inertia.about_centre();
      std::string moments;
      for (const double x : {I.xx, I.yy, I.zz, I.xy, I.xz, I.yz}) moments += (moments.empty() ? "" : " ") + to_text(x);
      xml_.element("inertial",
                   attribute("pos", l.inertia.centre()) + attribute("mass", l.inertia.mass) + attribute("fullinertia", moments));
    } else if (l.joint.nv() > 0) {
      notes_.add("MuJoCo refuses moving bodies without mass; % has no mass.", l.name);
    }
    write_joints(l);
    for (const Shape& s : l.shapes) write_geom(l, s);
  }

  static std::string properties(const Dof& f) {
    std::string out;
    if (f.stiffness != 0) out += attribute("stiffness", f.stiffness) + attribute("springref", f.rest);
    if (f.damping != 0) out += attribute("damping", f.damping);
    if (f.armature != 0) out += attribute("armature", f.armature);
    if (f.friction != 0) out += attribute("frictionloss", f.friction);
    return out;
  }
  static std::string range(const Dof& f) {
    if ((!std::isfinite(f.lower) && !std::isfinite(f.upper)) || f.lower == f.upper) return {};  // equal limits: an equality locks the joint
    return attribute("limited", "true") +
           attribute("range", std::string_view(to_text(std::max(f.lower, -no_limit)) + ' ' + to_text(std::min(f.upper, no_limit))));
  }

  void write_joints(const Link& l) {
    const Joint& j = l.joint;
    const std::vector<SimpleJoint> parts = simple_joints(j);
    if (parts.size() > 1)
      notes_.add("The " + std::string(name_of(j.type)) + " joint of % became " + std::to_string(parts.size()) + " joints of one body.",
                 l.name);
    for (std::size_t k = 0; k < parts.size(); ++k) {
      const bool follows = j.type == JointType::helical && k == 1;
      const Dof f = follows ? Dof{} : j.dofs[static_cast<std::size_t>(parts[k].dof)];
      xml_.element("joint", attribute("name", joint_name(l, static_cast<int>(k))) + attribute("type", parts[k].slides ? "slide" : "hinge") +
                                attribute("axis", parts[k].axis) + range(f) + properties(f));
      coordinates_.push_back({&l, l.q_index + parts[k].dof, follows ? j.pitch : 1});
    }
    if (j.type != JointType::spherical && j.type != JointType::floating) return;
    // MJCF has only one set of properties for all DOFs of a ball or free joint.
    Dof f = j.dofs[0];
    for (int k = 0; k < j.nv(); ++k) {
      const Dof& one = j.dofs[static_cast<std::size_t>(k)];
      if (one.damping != f.damping || one.stiffness != f.stiffness || one.armature != f.armature || one.friction != f.friction)
        notes_.add(
            "The degrees of freedom of % have different stiffness, damping, armature or friction; the values of the first one are written.",
            l.name);
      if (one.rest != 0)
        notes_.add("MJCF cannot store the rest position of springs of ball and free joints (%); they are relaxed in the neutral position.",
                   l.name);
    }
    f.rest = 0;
    if (j.type == JointType::floating && l.parent < 0) {
      if (properties(f).empty())
        xml_.element("freejoint", attribute("name", l.name));
      else
        xml_.element("joint", attribute("name", l.name) + attribute("type", "free") + properties(f));
      coordinates_.push_back({&l, -1, 0});
      return;
    }
    if (j.type == JointType::floating) {
      notes_.add("The floating joint of % became three slides and a ball: MuJoCo has free joints only at the world.", l.name);
      const char* const names[] = {" x", " y", " z"};
      for (int k = 0; k < 3; ++k) {
        Vec3 axis;
        axis[k] = 1;
        xml_.element("joint", attribute("name", l.name + names[k]) + attribute("type", "slide") + attribute("axis", axis));
        coordinates_.push_back({&l, l.q_index + k, 1});
      }
    }
    for (int k = 0; k < 4; ++k) coordinates_.push_back({&l, l.q_index + (j.type == JointType::floating ? 3 : 0) + k, 1});
    double maximum = 0;
    bool limited = false, even = true;
    for (std::size_t k = 0; k < 3 && j.type == JointType::spherical; ++k) {
      const Dof& one = j.dofs[k];
      limited = limited || std::isfinite(one.lower) || std::isfinite(one.upper);
      even = even && one.lower == -one.upper && one.upper == j.dofs[0].upper;
      maximum = std::max(maximum, std::max(-one.lower, one.upper));
    }
    if (limited && !even)
      notes_.add("A ball joint of MJCF has one maximum angle for all directions; the limits of % are left out.", l.name);
    xml_.element("joint",
                 attribute("name", l.name) + attribute("type", "ball") + properties(f) +
                     (limited && even ? attribute("limited", "true") + attribute("range", std::string_view("0 " + to_text(maximum)))
                                      : std::string()));
  }

  /// Name of the k-th simple joint of a link.
  static std::string joint_name(const Link& l, int k) {
    const std::size_t count = simple_joints(l.joint).size();
    return count > 1 ? l.name + " " + std::to_string(k + 1) : l.name;
  }
  /// Name of the simple joint that has the DOF; empty if there is none.
  static std::string name_of_dof(const Link& l, int dof) {
    const std::vector<SimpleJoint> parts = simple_joints(l.joint);
    for (std::size_t k = 0; k < parts.size(); ++k)
      if (parts[k].dof == dof) return joint_name(l, static_cast<int>(k));
    return {};
  }

  void write_geom(const Link& l, const Shape& s) {
    std::string attributes;
    switch (s.type) {
      case ShapeType::sphere: attributes = attribute("type", "sphere") + attribute("size", s.radius); break;
      case ShapeType::capsule:
      case ShapeType::cylinder:
        attributes = attribute("type", s.type == ShapeType::capsule ? "capsule" : "cylinder") +
                     attribute("size", std::string_view(to_text(s.radius) + ' ' + to_text(s.half_length)));
        break;
      case ShapeType::box: attributes = attribute("type", "box") + attribute("size", s.half_extents); break;
      case ShapeType::ellipsoid: attributes = attribute("type", "ellipsoid") + attribute("size", s.half_extents); break;
      case ShapeType::mesh: attributes = attribute("type", "mesh") + attribute("mesh", meshes_.find(s.geometry.get())->second); break;
      case ShapeType::height_field: notes_.add("MJCF height fields are not written; those of % are left out.", l.name); return;
    }
    if (s.restitution != 0) notes_.add("MJCF cannot store restitution; that of % is left out.", l.name);
    if (!s.visible) attributes += attribute("rgba", "0.5 0.5 0.5 0");
    xml_.element("geom", attributes + placement(s.X_BS) +
                             (s.collides ? collision_attributes(s) : attribute("contype", "0") + attribute("conaffinity", "0")));
  }

  static std::string collision_attributes(const Shape& s) {
    const Shape standard;
    std::string out = attribute("friction", std::string_view(to_text(s.friction) + " 0.005 0.0001"));
    // MuJoCo reads the bits as signed integers.
    if (s.groups != standard.groups) out += attribute("contype", std::string_view(std::to_string(static_cast<std::int32_t>(s.groups))));
    if (s.partners != standard.partners)
      out += attribute("conaffinity", std::string_view(std::to_string(static_cast<std::int32_t>(s.partners))));
    if (s.smooth) out += attribute("condim", "1");
    return out;
  }

  void write_exclusions() {
    if (m_.exclusions().empty()) return;
    xml_.begin("contact");
    for (const auto& [a, b] : m_.exclusions()) xml_.element("exclude", bodies(a, b));
    xml_.end();
  }

  void write_motors() {
    bool any = false;
    for (const Link& l : m_.links()) {
      const std::vector<SimpleJoint> parts = simple_joints(l.joint);
      for (std::size_t k = 0; k < parts.size(); ++k) {
        const double effort = l.joint.dofs[static_cast<std::size_t>(parts[k].dof)].effort;
        if (!std::isfinite(effort) || (l.joint.type == JointType::helical && k == 1)) continue;
        if (!any) xml_.begin("actuator");
        any = true;
        const std::string joint = joint_name(l, static_cast<int>(k)), bounds = to_text(-effort) + ' ' + to_text(effort);
        xml_.element("motor", attribute("name", joint) + attribute("joint", joint) + attribute("forcelimited", "true") +
                                  attribute("forcerange", bounds));
      }
      if (parts.empty())
        for (int k = 0; k < l.joint.nv(); ++k)
          if (std::isfinite(l.joint.dofs[static_cast<std::size_t>(k)].effort))
            notes_.add("Effort limits of ball and free joints (%) are left out.", l.name);
    }
    if (any) xml_.end();
  }

  void write_equalities() {
    std::vector<std::pair<const char*, std::string>> rows;
    std::vector<Pose> X(static_cast<std::size_t>(m_.link_count()));
    const std::vector<double> q = m_.neutral();
    calc_poses(m_, q, X);
    for (const LoopSpec& loop : all_loops(m_)) {
      const std::string head = attribute("name", loop.name) + (loop.closed ? "" : attribute("active", "false"));
      const int a = m_.find_link(loop.link_a), b = m_.find_link(loop.link_b);
      switch (loop.type) {
        case LoopType::weld: {
          // relpose is the pose of body 2 in body 1. Not every version of MuJoCo accepts the world as body 1, so the world becomes body 2.
          const bool swap = a < 0;
          const Pose relative = swap ? loop.X_BJ * loop.X_AJ.inverse() : loop.X_AJ * loop.X_BJ.inverse();
          const Quat r = to_quat(relative.R);
          rows.emplace_back("weld", head + bodies(swap ? b : a, swap ? a : b) +
                                        attribute("relpose", std::string_view(numbers(relative.p) + ' ' + to_text(r.w) + ' ' +
                                                                              to_text(r.x) + ' ' + to_text(r.y) + ' ' + to_text(r.z))));
          break;
        }
        case LoopType::ball:
        case LoopType::revolute: {
          const Pose X_WA = (a < 0 ? Pose{} : X[static_cast<std::size_t>(a)]) * loop.X_AJ,
                     X_WB = (b < 0 ? Pose{} : X[static_cast<std::size_t>(b)]) * loop.X_BJ;
          const bool revolute = loop.type == LoopType::revolute;
          // MuJoCo computes the anchor in body 2 from the initial pose, so this pose must close the loop.
          if (norm(X_WA.p - X_WB.p) > 1e-9 || (revolute && norm(cross(X_WA.R * loop.axis, X_WB.R * loop.axis)) > 1e-9)) {
            notes_.add(
                "The loop % is not closed in the neutral position, from which MuJoCo computes its anchor in the second body; it is left "
                "out.",
                loop.name);
            break;
          }
          const bool swap = a < 0;
          const Pose& J = swap ? loop.X_BJ : loop.X_AJ;
          rows.emplace_back("connect", head + bodies(swap ? b : a, swap ? a : b) + attribute("anchor", J.p));
          if (!revolute) break;
          notes_.add("The revolute loop % is written as two <connect> elements at points of its axis, 0.1 m apart.", loop.name);
          rows.emplace_back("connect", attribute("name", loop.name + " axis") + (loop.closed ? "" : attribute("active", "false")) +
                                           bodies(swap ? b : a, swap ? a : b) + attribute("anchor", J.p + J.R * loop.axis * 0.1));
          break;
        }
        case LoopType::gear: {
          std::string c;
          for (const double x : loop.polynomial) c += (c.empty() ? "" : " ") + to_text(x);
          rows.emplace_back("joint", head + attribute("joint1", name_of_dof(m_.link(a), loop.dof_a)) +
                                         attribute("joint2", name_of_dof(m_.link(b), loop.dof_b)) + attribute("polycoef", c));
          break;
        }
        default: notes_.add("MJCF has no equality for loops of type " + std::string(name_of(loop.type)) + "; % is left out.", loop.name);
      }
    }
    for (const Link& l : m_.links()) {
      const std::vector<SimpleJoint> parts = simple_joints(l.joint);
      for (std::size_t k = 0; k < parts.size(); ++k) {
        const Dof& f = l.joint.dofs[static_cast<std::size_t>(parts[k].dof)];
        if (f.lower != f.upper || (l.joint.type == JointType::helical && k == 1)) continue;
        const std::string joint = joint_name(l, static_cast<int>(k));
        notes_.add("Joints with equal lower and upper limits (%) are locked by an equality.", l.name);
        rows.emplace_back("joint", attribute("name", joint + " held") + attribute("joint1", joint) +
                                       attribute("polycoef", std::string_view(to_text(f.lower) + " 0 0 0 0")));
      }
    }
    for (const Link& l : m_.links())
      if (l.joint.type == JointType::helical)
        rows.emplace_back("joint", attribute("name", l.name + " screw") + attribute("joint1", joint_name(l, 1)) +
                                       attribute("joint2", joint_name(l, 0)) +
                                       attribute("polycoef", std::string_view("0 " + to_text(l.joint.pitch) + " 0 0 0")));
    if (rows.empty()) return;
    xml_.begin("equality");
    for (const auto& [kind, attributes] : rows) xml_.element(kind, attributes);
    xml_.end();
  }

  /// Writes the frames of the motion as keys. The qpos of a free joint is the pose of its body in the world; other joints have coordinates.
  void write_keys() {
    const auto nq = static_cast<std::size_t>(m_.nq());
    if (motion_.q.empty() || nq == 0) return;
    xml_.begin("keyframe");
    for (std::size_t f = 0; f < motion_.q.size() / nq; ++f) {
      const double* q = motion_.q.data() + f * nq;
      std::string qpos;
      const auto add = [&](double x) { qpos += (qpos.empty() ? "" : " ") + to_text(x); };
      for (const Coordinate& c : coordinates_) {
        if (c.q >= 0) {
          add(c.factor * q[c.q]);
          continue;
        }
        const Pose X = c.link->joint.X_PJ * joint_pose(c.link->joint, q + c.link->q_index);
        const Quat r = to_quat(X.R);
        for (const double x : {X.p.x, X.p.y, X.p.z, r.w, r.x, r.y, r.z}) add(x);
      }
      xml_.element("key", attribute("name", "frame " + std::to_string(f)) + attribute("time", static_cast<double>(f) / motion_.rate) +
                              attribute("qpos", std::string_view(qpos)));
    }
    xml_.end();
  }

  std::string bodies(int first, int second) const {
    return attribute("body1", body_name(m_.link(first))) + (second < 0 ? std::string() : attribute("body2", body_name(m_.link(second))));
  }

  /// One value of MuJoCo's qpos, or the seven values of a free joint.
  struct Coordinate {
    const Link* link;
    int q;          // index into the mechanism's coordinates; -1: free joint
    double factor;  // qpos = factor * coordinate
  };

  const Mechanism& m_;
  const RobotMotion& motion_;
  std::vector<Coordinate> coordinates_;  // in the order of the written joints
  XmlText xml_;
  WrittenNotes notes_;
  std::map<const Geometry*, std::string> meshes_;
  std::set<std::string> written_;
};

}  // namespace

RobotText write_mjcf(const Mechanism& mechanism, const RobotMotion& motion) { return MjcfWriter(mechanism, motion).write(); }

}  // namespace ugoki::robot_formats
