// Writes mechanisms as URDF, with a YAML file for their loops.

#include <cmath>
#include <set>

#include "ugoki/base/number.h"
#include "ugoki/robot_formats/robot_writer.h"
#include "ugoki/robot_formats/written_notes.h"
#include "ugoki/robot_formats/xml_text.h"

namespace ugoki::robot_formats {
namespace {

class UrdfWriter {
 public:
  UrdfWriter(const Mechanism& m, std::string_view stem, const RobotMotion& motion) : m_(m), stem_(stem), motion_(motion) {
    for (const Link& l : m.links()) names_.insert(l.name);
  }

  RobotText write() {
    xml_.begin("robot", attribute("name", m_.name().empty() ? std::string("mechanism") : m_.name()));
    write_bases();
    for (int i = 0; i < m_.link_count(); ++i) {
      write_link(m_.link(i));
      if (m_.link(i).parent >= 0) write_joint(m_.link(i), m_.link(m_.link(i).parent).name);
    }
    write_loops();
    write_motion();
    xml_.end();
    out_.text = xml_.take();
    for (std::string& note : notes_.take()) out_.notes.push_back(std::move(note));
    return std::move(out_);
  }

  /// True if the link represents the world: it is named "world", has no parent, and is fixed at the world's frame.
  static bool is_world(const Link& l) {
    return l.name == "world" && l.parent < 0 && l.joint.type == JointType::fixed && is_identity(l.joint.X_PJ);
  }

 private:
  static std::string origin(const Pose& X) {
    const Vec3 zyx = to_euler(X.R, "ZYX");
    return attribute("xyz", X.p) + attribute("rpy", Vec3{zyx.z, zyx.y, zyx.x});
  }
  static bool is_identity(const Pose& X) { return X.p == Vec3{} && X.R == Mat3::identity(); }

  std::string unique_name(std::string name) {
    const std::string wanted = name;
    for (int n = 2; !names_.insert(name).second; ++n) name = wanted + "_" + std::to_string(n);
    return name;
  }

  /// Writes a link without inertia and shapes.
  void write_massless(const std::string& name) { xml_.element("link", attribute("name", name)); }

  /// Writes the base. A URDF has exactly one base: a single floating base at the world's frame is kept; otherwise the base is a link
  /// "world".
  void write_bases() {
    std::vector<const Link*> bases;
    for (const Link& l : m_.links())
      if (l.parent < 0) bases.push_back(&l);
    for (const Link* l : bases)
      if (is_world(*l)) {
        for (const Link* other : bases)
          if (other != l) write_joint(*other, l->name);
        return;
      }
    if (bases.size() == 1 && bases[0]->joint.type == JointType::floating && is_identity(bases[0]->joint.X_PJ)) {
      add_columns(*bases[0], bases[0]->name);
      return;
    }
    names_.insert("world");
    write_massless("world");
    for (const Link* l : bases) write_joint(*l, "world");
  }

  void write_link(const Link& l) {
    xml_.begin("link", attribute("name", l.name));
    if (l.inertia.mass > 0 || l.inertia.I != Sym3{}) {
      const Sym3 I = l.inertia.about_centre();
      xml_.begin("inertial");
      xml_.element("origin", attribute("xyz", l.inertia.centre()) + attribute("rpy", Vec3{}));
      xml_.element("mass", attribute("value", l.inertia.mass));
      xml_.element("inertia", attribute("ixx", I.xx) + attribute("ixy", I.xy) + attribute("ixz", I.xz) + attribute("iyy", I.yy) +
                                  attribute("iyz", I.yz) + attribute("izz", I.zz));
      xml_.end();
    }
    for (const Shape& s : l.shapes) {
      if (s.collides) write_shape(l, s, "collision");
      if (s.visible) write_shape(l, s, "visual");
      if (s.friction != Shape{}.friction) notes_.add("URDF cannot store surface friction; that of % is left out.", l.name);
      if (s.restitution != 0) notes_.add("URDF cannot store restitution; that of % is left out.", l.name);
    }
    xml_.end();
  }

  void write_shape(const Link& l, const Shape& s, const char* use) {
    std::string kind, size;
    switch (s.type) {
      case ShapeType::sphere:
        kind = "sphere";
        size = attribute("radius", s.radius);
        break;
      case ShapeType::capsule:
      case ShapeType::cylinder:
        kind = s.type == ShapeType::capsule ? "capsule" : "cylinder";
        if (kind == "capsule") notes_.add("Capsules (%) are widely used in URDF, but are not in its specification.", l.name);
        size = attribute("radius", s.radius) + attribute("length", 2 * s.half_length);
        break;
      case ShapeType::box:
        kind = "box";
        size = attribute("size", s.half_extents * 2);
        break;
      case ShapeType::mesh:
        kind = "mesh";
        size = attribute("filename", mesh_file(*s.geometry));
        break;
      case ShapeType::ellipsoid: notes_.add("URDF cannot store ellipsoids; those of % are left out.", l.name); return;
      case ShapeType::height_field: notes_.add("URDF cannot store height fields; those of % are left out.", l.name); return;
    }
    xml_.begin(use);
    xml_.element("origin", origin(s.X_BS));
    xml_.begin("geometry");
    xml_.element(kind, size);
    xml_.end();
    xml_.end();
  }

  /// Returns the name of the side file with the mesh. The first call for a mesh creates this file.
  std::string mesh_file(const Geometry& mesh) {
    const auto [it, is_new] = meshes_.emplace(&mesh, stem_ + "_mesh" + std::to_string(meshes_.size() + 1) + ".obj");
    if (is_new) {
      std::string obj;
      for (const Vec3& v : mesh.vertices) obj += "v " + numbers(v) + '\n';
      for (const Triangle& t : mesh.triangles)
        obj += "f " + std::to_string(t[0] + 1) + ' ' + std::to_string(t[1] + 1) + ' ' + std::to_string(t[2] + 1) + '\n';
      out_.files.push_back({it->second, std::move(obj)});
    }
    return it->second;
  }

  /// Writes the joint between `l` and its parent. Joints of several DOFs become a chain of joints with massless links between them.
  void write_joint(const Link& l, const std::string& parent) {
    const Joint& j = l.joint;
    const std::vector<SimpleJoint> parts = j.type == JointType::planar ? std::vector<SimpleJoint>{} : simple_joints(j);
    if (parts.size() > 1)
      notes_.add("The " + std::string(name_of(j.type)) + " joint of % became two joints with a massless link between.", l.name);
    if (parts.empty()) {
      const char* type = j.type == JointType::fixed      ? "fixed"
                         : j.type == JointType::floating ? "floating"
                         : j.type == JointType::planar   ? "planar"
                                                         : "spherical";
      if (j.type == JointType::spherical)
        notes_.add("Spherical joints (%) are widely used in URDF, but are not in its specification.", l.name);
      for (int k = 0; k < j.nv(); ++k) note_lost_properties(l, j.dofs[static_cast<std::size_t>(k)], true);
      one_joint(l.name, type, parent, l.name, j.X_PJ, {0, 0, 1}, j.nv() > 0 ? &j.dofs[0] : nullptr, {});
      add_columns(l, joint_name(l.name));
      return;
    }
    std::string above = parent;
    Pose X = j.X_PJ;
    for (std::size_t k = 0; k < parts.size(); ++k) {
      const bool last = k + 1 == parts.size();
      const Dof& f = j.dofs[static_cast<std::size_t>(parts[k].dof)];
      const bool follows = j.type == JointType::helical && k == 1;
      note_lost_properties(l, f, false);
      const std::string below = last ? l.name : unique_name(l.name + "_" + std::to_string(k + 1));
      if (!last) write_massless(below);
      const Dof none;
      const bool limited = std::isfinite(f.lower) || std::isfinite(f.upper);
      const char* type = parts[k].slides ? "prismatic" : limited && !follows ? "revolute" : "continuous";
      one_joint(last ? l.name : below, type, above, below, X, parts[k].axis, follows ? &none : &f,
                follows ? attribute("joint", joint_name(above)) + attribute("multiplier", j.pitch)
                        : mimic_of(l.name, static_cast<int>(parts[k].dof)));
      columns_.push_back({joint_name(last ? l.name : below), l.q_index + parts[k].dof, follows ? j.pitch : 1});
      above = below;
      X = {};
    }
  }

  /// Adds the columns of a joint with several coordinates to the motion table.
  void add_columns(const Link& l, const std::string& name) {
    std::vector<const char*> suffixes;
    switch (l.joint.type) {
      case JointType::floating: suffixes = {".x", ".y", ".z", ".qw", ".qx", ".qy", ".qz"}; break;
      case JointType::spherical: suffixes = {".qw", ".qx", ".qy", ".qz"}; break;
      case JointType::planar: suffixes = {".x", ".y", ".angle"}; break;
      default: return;
    }
    for (std::size_t k = 0; k < suffixes.size(); ++k) columns_.push_back({name + suffixes[k], l.q_index + static_cast<int>(k), 1});
  }

  void write_motion() {
    const auto nq = static_cast<std::size_t>(m_.nq());
    if (motion_.q.empty() || nq == 0) return;
    std::string table = "time";
    for (const Column& c : columns_) table += c.name.find_first_of(",\"\n") == std::string::npos ? ',' + c.name : ',' + quoted(c.name);
    table += '\n';
    for (std::size_t f = 0; f < motion_.q.size() / nq; ++f) {
      table += to_text(static_cast<double>(f) / motion_.rate);
      for (const Column& c : columns_) table += ',' + to_text(c.factor * motion_.q[f * nq + static_cast<std::size_t>(c.q)]);
      table += '\n';
    }
    out_.files.push_back({stem_ + "-motion.csv", std::move(table)});
  }

  /// Adds notes about the properties of a DOF that URDF cannot store.
  /// @param no_limits the joint has several DOFs, for which URDF has neither limits nor individual properties
  void note_lost_properties(const Link& l, const Dof& f, bool no_limits) {
    if (f.stiffness != 0 || f.rest != 0) notes_.add("URDF cannot store joint springs; those of % are left out.", l.name);
    if (f.armature != 0) notes_.add("URDF cannot store rotor inertia (armature); that of % is left out.", l.name);
    if (no_limits && (std::isfinite(f.lower) || std::isfinite(f.upper)))
      notes_.add("URDF cannot store limits of joints with several degrees of freedom; those of % are left out.", l.name);
    if (no_limits && f != l.joint.dofs[0])
      notes_.add("The degrees of freedom of % have different damping, friction or effort limits; the values of the first one are written.",
                 l.name);
  }

  [[nodiscard]] static std::string joint_name(const std::string& child) { return child + "_joint"; }

  /// Returns the attributes of <mimic> for the gear whose follower is this DOF; empty if there is none.
  [[nodiscard]] std::string mimic_of(const std::string& link, int dof) const {
    for (const LoopSpec& loop : m_.spec().loops)
      if (loop.type == LoopType::gear && loop.link_a == link && loop.dof_a == dof && is_mimic(loop))
        return attribute("joint", joint_name(loop.link_b)) + attribute("multiplier", loop.polynomial[1]) +
               attribute("offset", loop.polynomial[0]);
    return {};
  }
  /// True if a gear can be written as <mimic>: it must be linear, closed, between joints of one DOF, and the first gear of its follower.
  [[nodiscard]] bool is_mimic(const LoopSpec& loop) const {
    const auto simple = [&](const std::string& name) {
      const JointType type = m_.link(m_.find_link(name)).joint.type;
      return type == JointType::revolute || type == JointType::prismatic;
    };
    const auto& c = loop.polynomial;
    if (c[2] != 0 || c[3] != 0 || c[4] != 0 || !loop.closed || !simple(loop.link_a) || !simple(loop.link_b)) return false;
    for (const LoopSpec& other : m_.spec().loops)
      if (other.type == LoopType::gear && other.link_a == loop.link_a) return other.name == loop.name;
    return false;
  }

  void one_joint(const std::string& name, const std::string& type, const std::string& parent, const std::string& child, const Pose& X,
                 const Vec3& axis, const Dof* f, const std::string& mimic) {
    xml_.begin("joint", attribute("name", joint_name(name)) + attribute("type", type));
    xml_.element("origin", origin(X));
    xml_.element("parent", attribute("link", parent));
    xml_.element("child", attribute("link", child));
    if (type != "fixed" && type != "floating" && type != "spherical") xml_.element("axis", attribute("xyz", axis));
    if (f && (type == "revolute" || type == "prismatic"))
      xml_.element("limit", attribute("lower", std::max(f->lower, -no_limit)) + attribute("upper", std::min(f->upper, no_limit)) +
                                attribute("effort", std::min(f->effort, no_limit)) + attribute("velocity", no_limit));
    else if (f && std::isfinite(f->effort))
      xml_.element("limit", attribute("effort", f->effort) + attribute("velocity", no_limit));
    if (f && (f->damping != 0 || f->friction != 0))
      xml_.element("dynamics", attribute("damping", f->damping) + attribute("friction", f->friction));
    if (!mimic.empty()) xml_.element("mimic", mimic);
    xml_.end();
  }

  /// Adds a massless link at the pose X in `link` and returns its name. X is rotated so that z is along `axis` or, if `axis2` is given, so
  /// that y is along `axis2`.
  std::string frame_at(const std::string& wanted, const std::string& link, const Pose& X, const Vec3& axis, const Vec3* axis2) {
    const std::string name = unique_name(wanted);
    Mat3 R = to_matrix(rotation_between({0, 0, 1}, axis));
    if (axis2) R = to_matrix(rotation_between({0, 1, 0}, *axis2));
    write_massless(name);
    one_joint(name, "fixed", link, name, X * Pose{R, {}}, {}, nullptr, {});
    return name;
  }

  static std::string quoted(const std::string& name) {
    std::string out = "\"";
    for (const char c : name) out += c == '"' || c == '\\' ? std::string("\\") + c : std::string(1, c);
    return out + "\"";
  }

  void write_loops() {
    std::string pairs, types;
    for (const LoopSpec& loop : all_loops(m_)) {
      if (loop.type == LoopType::gear) {
        if (!is_mimic(loop))
          notes_.add(
              "URDF can only store linear, closed gears between joints with one degree of freedom, one for each joint; % is left out.",
              loop.name);
        continue;
      }
      if (loop.type == LoopType::distance) {
        notes_.add("The loops file cannot store distance loops; % is left out.", loop.name);
        continue;
      }
      if (!loop.closed) {
        notes_.add("The loops file cannot store loops that are open at the start; % is left out.", loop.name);
        continue;
      }
      if (loop.link_a.empty() || loop.link_b.empty()) {
        if (!names_.contains("world")) {
          notes_.add("The loop % to the world is left out, because the base is not a link named world.", loop.name);
          continue;
        }
      }
      const bool universal = loop.type == LoopType::universal;
      const auto link = [](const std::string& name) { return name.empty() ? std::string("world") : name; };
      const std::string a = frame_at(loop.name + "_a", link(loop.link_a), loop.X_AJ, loop.axis, nullptr);
      const std::string b = frame_at(loop.name + "_b", link(loop.link_b), loop.X_BJ, loop.axis, universal ? &loop.axis2 : nullptr);
      pairs += (pairs.empty() ? "" : ", ") + ("[" + quoted(a) + ", " + quoted(b) + "]");
      types += (types.empty() ? "" : ", ") + std::string(name_of(loop.type));
    }
    if (!pairs.empty()) out_.files.push_back({stem_ + ".yaml", "closed_loop: [" + pairs + "]\ntype: [" + types + "]\n"});
  }

  /// A column of the motion table.
  struct Column {
    std::string name;
    int q;          // index into the mechanism's coordinates
    double factor;  // value = factor * coordinate
  };

  const Mechanism& m_;
  std::string stem_;
  const RobotMotion& motion_;
  std::vector<Column> columns_;
  XmlText xml_;
  WrittenNotes notes_;
  std::set<std::string> names_;
  std::map<const Geometry*, std::string> meshes_;
  RobotText out_;
};

}  // namespace

RobotText write_urdf(const Mechanism& mechanism, std::string_view stem, const RobotMotion& motion) {
  const int at = mechanism.find_link("world");
  if (at < 0 || UrdfWriter::is_world(mechanism.link(at))) return UrdfWriter(mechanism, stem, motion).write();
  // Readers take any link named "world" as the base, so another link of this name gets another name.
  MechanismSpec spec = mechanism.spec();
  std::string name = "world link";
  while (mechanism.find_link(name) >= 0) name += "_";
  const auto rename = [&](std::string& of) {
    if (of == "world") of = name;
  };
  for (LinkSpec& l : spec.links) {
    rename(l.name);
    rename(l.parent);
    rename(l.real);
  }
  for (LoopSpec& l : spec.loops) {
    rename(l.link_a);
    rename(l.link_b);
  }
  const Result<MechanismPtr> renamed = Mechanism::make(std::move(spec));
  if (!renamed) return {.text = {}, .files = {}, .notes = {renamed.error().text()}};
  RobotText out = UrdfWriter(**renamed, stem, motion).write();
  out.notes.push_back("The link 'world' is renamed to '" + name + "', because URDF readers take 'world' as the base.");
  return out;
}

}  // namespace ugoki::robot_formats
