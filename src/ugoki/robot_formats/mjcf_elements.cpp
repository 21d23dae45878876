#include "ugoki/robot_formats/mjcf_elements.h"

#include <algorithm>
#include <cmath>

namespace ugoki::robot_formats {
namespace {

void read_joint_range(const MjcfSource& source, const MjcfAttributes& a, MjcfJoint& joint) {
  if (joint.type == MjcfJointType::free || !mjcf_limited(source.compiler(), a, "limited", "range")) return;
  double range[2] = {0, 0};
  if (!a.range("range", range)) return;
  const bool turns = joint.type != MjcfJointType::slide;
  const double lower = turns ? source.compiler().radians(range[0]) : range[0];
  const double upper = turns ? source.compiler().radians(range[1]) : range[1];
  if (joint.type == MjcfJointType::ball) {
    if (lower != 0) a.own().problem(ErrorCode::range, "The range of a ball joint does not begin with 0.", "Give 0 and the maximum angle.");
    joint.dof.lower = -upper;
    joint.dof.upper = upper;
    a.own().note("The maximum angle of a ball joint limits each component of the rotation vector, not its length.");
  } else {
    joint.dof.lower = lower - joint.ref;
    joint.dof.upper = upper - joint.ref;
  }
  if (!(joint.dof.lower < joint.dof.upper))
    a.own().problem(ErrorCode::range, "The joint range " + formats::in_quotes(a.text("range")) + " is empty.",
                    "Give the lower bound first.");
}

double first_number(const MjcfAttributes& a, const char* name, Bounds bounds = not_negative) {
  double v[5] = {};
  (void)a.overlay(name, v, bounds);  // MuJoCo 3 allows polynomials, in which the first coefficient is the linear term
  for (const double higher : std::span(v).subspan(1))
    if (higher != 0) {
      a.own().note("Nonlinear terms of '" + std::string(name) + "' are left out.");
      break;
    }
  return v[0];
}

}  // namespace

bool mjcf_limited(const MjcfCompiler& compiler, const MjcfAttributes& a, const char* limited, const char* range) {
  const int word = a.keyword(limited, {"false", "true", "auto"}, 2);
  if (word == 2) {
    double v[2] = {0, 0};
    return compiler.autolimits && a.has(range) && a.range(range, v) && !(v[0] == 0 && v[1] == 0);
  }
  return word == 1;
}

MjcfJoint read_mjcf_joint(const MjcfSource& source, const MjcfAttributes& a, const Pose& X_BF) {
  MjcfJoint j;
  j.element = a.own();
  j.type = j.element.kind() == "freejoint"
               ? MjcfJointType::free
               : static_cast<MjcfJointType>(a.keyword("type", {"free", "ball", "slide", "hinge"}, static_cast<int>(j.type)));
  if (j.type == MjcfJointType::slide || j.type == MjcfJointType::hinge) {
    const Vec3 axis = a.vec3("axis", {0, 0, 1});
    if (norm(axis) < 1e-14) j.element.problem(ErrorCode::structure, "The joint axis has zero length.", "Give an axis that is not zero.");
    j.axis = X_BF.R * normalized(axis);
    j.ref = a.number("ref", 0);
    if (j.type == MjcfJointType::hinge) j.ref = source.compiler().radians(j.ref);
  }
  if (j.type != MjcfJointType::free) j.pos = X_BF * a.vec3("pos", {});
  if (j.element.kind() == "freejoint") return j;

  Dof& f = j.dof;
  f.damping = first_number(a, "damping");
  f.stiffness = first_number(a, "stiffness");
  f.armature = a.number("armature", 0, not_negative);
  f.friction = a.number("frictionloss", 0, not_negative);
  const double springref = a.number("springref", 0);
  if (j.type == MjcfJointType::hinge) f.rest = source.compiler().radians(springref) - j.ref;
  if (j.type == MjcfJointType::slide) f.rest = springref - j.ref;
  if (j.type == MjcfJointType::free && f.stiffness > 0) {
    f.stiffness = 0;
    j.element.note("The spring of a free joint is left out.");
  }
  (void)a.numbers("springdamper", j.springdamper, not_negative);
  read_joint_range(source, a, j);
  if ((j.type == MjcfJointType::slide || j.type == MjcfJointType::hinge) &&
      mjcf_limited(source.compiler(), a, "actuatorfrclimited", "actuatorfrcrange")) {
    double range[2] = {0, 0};
    if (a.range("actuatorfrcrange", range)) f.effort = std::max(std::fabs(range[0]), std::fabs(range[1]));
  }
  return j;
}

Pose read_mjcf_placement(const MjcfSource& source, const MjcfAttributes& a, MjcfGeomType type, Vec3& size) {
  double ends[6];
  if (!a.numbers("fromto", ends)) return source.pose(a);
  const bool round = type == MjcfGeomType::capsule || type == MjcfGeomType::cylinder;
  if (!round && type != MjcfGeomType::box && type != MjcfGeomType::ellipsoid) {
    a.own().problem(ErrorCode::structure, "'fromto' is given for a shape that does not have two ends.",
                    "Make it a capsule, cylinder, box or ellipsoid, or give pos and size.");
    return {};
  }
  const Vec3 from{ends[0], ends[1], ends[2]}, to{ends[3], ends[4], ends[5]};
  const double half = 0.5 * norm(from - to);
  if (half < 1e-14) {
    a.own().problem(ErrorCode::structure, "The two points of 'fromto' are equal.", "Give two points, or make it a sphere.");
    return {};
  }
  size = round ? Vec3{size.x, half, 0} : Vec3{size.x, size.x, half};
  return {z_turned_to((from - to) / (2 * half)), (from + to) * 0.5};
}

MjcfGeom read_mjcf_geom(const MjcfSource& source, const MjcfAttributes& a, const Pose& X_BF) {
  MjcfGeom g;
  g.element = a.own();
  g.type = static_cast<MjcfGeomType>(
      a.keyword("type", {"plane", "hfield", "sphere", "capsule", "ellipsoid", "cylinder", "box", "mesh", "sdf"}, static_cast<int>(g.type)));
  g.mesh = a.text("mesh");
  g.height_field = a.text("hfield");
  double size[3] = {0, 0, 0};
  (void)a.overlay("size", size, not_negative);
  g.size = {size[0], size[1], size[2]};
  g.X_BG = X_BF * read_mjcf_placement(source, a, g.type, g.size);
  constexpr int sizes_of[] = {0, 0, 1, 2, 3, 2, 3, 0, 0};
  const int needed = g.mesh.empty() ? sizes_of[static_cast<int>(g.type)] : 0;
  for (int i = 0; i < needed; ++i)
    if (!(g.size[i] > 0)) {
      g.element.problem(ErrorCode::range,
                        g.element.title() + " needs " + std::to_string(needed) + (needed == 1 ? " size above zero." : " sizes above zero."),
                        "Give size=\"...\".");
      break;
    }
  if (a.has("mass")) g.mass = a.number("mass", 0, not_negative);
  g.density = a.number("density", 1000, not_negative);
  g.shell = a.flag("shellinertia", false);
  g.group = a.integer("group", 0, -1'000'000, 1'000'000);
  g.contype = a.integer("contype", 1, -2147483647, 2147483647);
  g.conaffinity = a.integer("conaffinity", 1, -2147483647, 2147483647);
  g.condim = a.integer("condim", 3, 1, 6);
  double friction[3] = {1, 0, 0}, rgba[4] = {1, 1, 1, 1};
  (void)a.overlay("friction", friction, not_negative);
  g.friction = friction[0];
  if (a.numbers("rgba", rgba)) g.transparent = rgba[3] == 0;
  return g;
}

}  // namespace ugoki::robot_formats
