#include "ugoki/publish/usda_physics.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <vector>

#include "ugoki/publish/number_text.h"
#include "ugoki/robot_formats/symmetric_eigen.h"
#include "ugoki/spatial/rotation.h"

namespace ugoki::publish {
namespace {

std::string tuple(std::initializer_list<double> values) {
  std::string out = "(";
  for (const double x : values) {
    if (out.size() > 1) out += ", ";
    add_number(out, x);
  }
  return out + ')';
}
std::string vec(const Vec3& v) { return tuple({v.x, v.y, v.z}); }
std::string quat(const Quat& q) { return tuple({q.w, q.x, q.y, q.z}); }
std::string number(double x) {
  std::string out;
  add_number(out, x);
  return out;
}

/// Names of the six motions of a joint in UsdPhysics: translations and rotations along and about x, y, z.
constexpr const char* motions[6] = {"transX", "transY", "transZ", "rotX", "rotY", "rotZ"};

/// A joint of UsdPhysics. For the generic type PhysicsJoint, `free` lists the motions that are not locked.
struct UsdJoint {
  std::string type;
  Mat3 R;             // USD joint's frame in the joint's frame: z is along the axis; universal joint: x and y are along the two axes
  bool free[6] = {};  // [motions] true: the motion is free
};
Mat3 along(const Vec3& axis) { return to_matrix(rotation_between({0, 0, 1}, axis)); }

class PhysicsWriter {
 public:
  PhysicsWriter(const Mechanism& m, std::span<const Pose> poses, const std::string& name) : m_(m), poses_(poses), name_(name) {}

  std::string write() {
    out_ = "    def Xform \"" + name_ + "\" (\n        prepend apiSchemas = [\"PhysicsArticulationRootAPI\"]\n    )\n    {\n";
    for (const Link& l : m_.links()) names_.push_back(usd_name(l.name, used_));
    for (int i = 0; i < m_.link_count(); ++i) add_body(i);
    for (int i = 0; i < m_.link_count(); ++i) add_joint(i);
    for (const Loop& loop : m_.loops()) add_loop(loop);
    out_ += "    }\n\n";
    return std::move(out_);
  }

 private:
  [[nodiscard]] const std::string& name_of_link(int i) const { return names_[static_cast<std::size_t>(i)]; }

  void pose(const std::string& indent, const Pose& X) {
    out_ += indent + "quatf xformOp:orient = " + quat(to_quat(X.R)) + '\n' + indent + "double3 xformOp:translate = " + vec(X.p) + '\n';
  }

  void add_body(int i) {
    const Link& l = m_.link(i);
    out_ += "        def Xform \"" + name_of_link(i) +
            "\" (\n            prepend apiSchemas = [\"PhysicsRigidBodyAPI\", \"PhysicsMassAPI\"]\n        )\n        {\n";
    if (l.inertia.mass > 0) {
      const robot_formats::SymmetricEigen principal = robot_formats::symmetric_eigen(l.inertia.about_centre());
      out_ += "            float physics:mass = " + number(l.inertia.mass) +
              "\n            point3f physics:centerOfMass = " + vec(l.inertia.centre()) +
              "\n            float3 physics:diagonalInertia = " + vec(principal.values) +
              "\n            quatf physics:principalAxes = " + quat(to_quat(principal.V)) + '\n';
    }
    pose("            ", poses_[static_cast<std::size_t>(i)]);
    out_ += "            uniform token[] xformOpOrder = [\"xformOp:translate\", \"xformOp:orient\"]\n";
    std::set<std::string> used;
    for (const Shape& s : l.shapes)
      if (s.collides) add_shape(s, used);
    out_ += "        }\n\n";
  }

  void add_shape(const Shape& s, std::set<std::string>& used) {
    std::string type, size;
    Vec3 scale{1, 1, 1};
    switch (s.type) {
      case ShapeType::sphere:
      case ShapeType::ellipsoid:
        type = "Sphere";
        size = "double radius = " + number(s.type == ShapeType::sphere ? s.radius : 1);
        if (s.type == ShapeType::ellipsoid) scale = s.half_extents;
        break;
      case ShapeType::capsule:
      case ShapeType::cylinder:
        type = s.type == ShapeType::capsule ? "Capsule" : "Cylinder";
        size = "uniform token axis = \"Z\"\n                double height = " + number(2 * s.half_length) +
               "\n                double radius = " + number(s.radius);
        break;
      case ShapeType::box:
        type = "Cube";
        size = "double size = 2";
        scale = s.half_extents;
        break;
      default: return;
    }
    out_ += "            def " + type + " \"" + usd_name(type, used) +
            "\" (\n                prepend apiSchemas = [\"PhysicsCollisionAPI\"]\n            )\n            {\n                " + size +
            "\n                uniform token purpose = \"guide\"\n";
    pose("                ", s.X_BS);
    out_ +=
        "                float3 xformOp:scale = " + vec(scale) +
        "\n                uniform token[] xformOpOrder = [\"xformOp:translate\", \"xformOp:orient\", \"xformOp:scale\"]\n            }\n";
  }

  static UsdJoint usd_joint(const Joint& j) {
    UsdJoint out;
    switch (j.type) {
      case JointType::fixed: out.type = "PhysicsFixedJoint"; break;
      case JointType::revolute:
        out.type = "PhysicsRevoluteJoint";
        out.R = along(j.axis);
        break;
      case JointType::prismatic:
        out.type = "PhysicsPrismaticJoint";
        out.R = along(j.axis);
        break;
      case JointType::spherical: out.type = "PhysicsSphericalJoint"; break;
      case JointType::cylindrical:
      case JointType::helical:
        out.type = "PhysicsJoint";
        out.R = along(j.axis);
        out.free[2] = out.free[5] = true;
        break;
      case JointType::planar:
        out.type = "PhysicsJoint";
        out.free[0] = out.free[1] = out.free[5] = true;
        break;
      case JointType::universal: {
        out.type = "PhysicsJoint";
        const Vec3 y = normalized(j.axis2 - j.axis * dot(j.axis, j.axis2));
        out.R = Mat3::columns(j.axis, y, cross(j.axis, y));
        out.free[3] = out.free[4] = true;
        break;
      }
      default: break;  // floating: no joint
    }
    return out;
  }

  /// Writes a joint between two links (-1: the world). @param X0, X1 poses of the joint's frame in the two links
  void joint(const std::string& name, const UsdJoint& j, int link0, int link1, const Pose& X0, const Pose& X1, const Dof* limits,
             bool loop) {
    std::string schemas;
    for (int k = 0; k < 6 && j.type == "PhysicsJoint"; ++k)
      if (!j.free[k]) schemas += (schemas.empty() ? "" : ", ") + ("\"PhysicsLimitAPI:" + std::string(motions[k]) + '"');
    out_ += "        def " + j.type + " \"" + usd_name(name, used_) + '"';
    if (!schemas.empty()) out_ += " (\n            prepend apiSchemas = [" + schemas + "]\n        )";
    out_ += "\n        {\n";
    for (const auto& [side, link, X] : {std::tuple{"0", link0, X0}, {"1", link1, X1}}) {
      if (link >= 0)
        out_ += "            rel physics:body" + std::string(side) + " = </Content/" + name_ + '/' + name_of_link(link) + ">\n";
      const Pose local = X * Pose{j.R, {}};
      out_ += "            point3f physics:localPos" + std::string(side) + " = " + vec(local.p) + "\n            quatf physics:localRot" +
              side + " = " + quat(to_quat(local.R)) + '\n';
    }
    const bool turns = j.type == "PhysicsRevoluteJoint";
    if (turns || j.type == "PhysicsPrismaticJoint") {
      out_ += "            uniform token physics:axis = \"Z\"\n";
      const double unit = turns ? 180 / pi : 1;  // UsdPhysics has limits of angles in degrees
      if (limits && std::isfinite(limits->lower)) out_ += "            float physics:lowerLimit = " + number(unit * limits->lower) + '\n';
      if (limits && std::isfinite(limits->upper)) out_ += "            float physics:upperLimit = " + number(unit * limits->upper) + '\n';
    }
    for (int k = 0; k < 6 && j.type == "PhysicsJoint"; ++k)  // UsdPhysics locks a motion whose lower limit is above its upper limit
      if (!j.free[k])
        out_ += "            float limit:" + std::string(motions[k]) + ":physics:low = 1\n            float limit:" + motions[k] +
                ":physics:high = -1\n";
    if (loop) out_ += "            uniform bool physics:excludeFromArticulation = 1\n";
    out_ += "        }\n\n";
  }

  void add_joint(int i) {
    const Link& l = m_.link(i);
    const UsdJoint j = usd_joint(l.joint);
    if (!j.type.empty())
      joint(name_of_link(i) + "_joint", j, l.parent, i, l.joint.X_PJ, {}, l.joint.nv() == 1 ? &l.joint.dofs[0] : nullptr, false);
  }

  void add_loop(const Loop& loop) {
    if (!loop.closed) return;
    Joint j;
    j.axis = loop.axis;
    switch (loop.type) {
      case LoopType::weld: j.type = JointType::fixed; break;
      case LoopType::ball: j.type = JointType::spherical; break;
      case LoopType::revolute: j.type = JointType::revolute; break;
      case LoopType::prismatic: j.type = JointType::prismatic; break;
      default: return;
    }
    joint(loop.name.empty() ? "loop" : loop.name, usd_joint(j), loop.link_a, loop.link_b, loop.X_AJ, loop.X_BJ, nullptr, true);
  }

  const Mechanism& m_;
  std::span<const Pose> poses_;
  std::string name_, out_;
  std::vector<std::string> names_;  // [links] USD names
  std::set<std::string> used_;
};

}  // namespace

std::string usd_name(const std::string& name, std::set<std::string>& used) {
  std::string out;
  for (const char c : name) out += std::isalnum(static_cast<unsigned char>(c)) != 0 && (c & 0x80) == 0 ? c : '_';
  if (out.empty() || std::isdigit(static_cast<unsigned char>(out[0])) != 0) out.insert(0, "_");
  std::string unique = out;
  for (int n = 2; !used.insert(unique).second; ++n) unique = out + '_' + std::to_string(n);
  return unique;
}

std::string usda_physics(const Mechanism& mechanism, std::span<const Pose> poses, const std::string& name) {
  return PhysicsWriter(mechanism, poses, name).write();
}

}  // namespace ugoki::publish
