// Links, joints and shapes of MJCF bodies.

#include <algorithm>

#include "ugoki/robot_formats/mesh_file.h"
#include "ugoki/robot_formats/mjcf_build.h"
#include "ugoki/robot_formats/shape_fit.h"

namespace ugoki::robot_formats {
namespace {

std::optional<Shape> mesh_shape(MjcfBody& body, const MjcfGeom& geom, bool collides, const RobotOptions& options) {
  if (!collides) return std::nullopt;  // looks only
  if (options.meshes == Meshes::none) {
    geom.element.note("Meshes that collide are left out.");
    return std::nullopt;
  }
  const MjcfMeshAsset* const mesh = body.source->mesh(geom.mesh);
  if (!mesh) {
    geom.element.problem(ErrorCode::unknown, "no mesh is named " + formats::in_quotes(geom.mesh) + ".",
                         "Correct the name, or add the mesh.");
    return std::nullopt;
  }
  if (mesh->absent.empty()) {
    geom.element.note("A mesh that collides is taken as the box around it.");
    Shape box = box_around(mesh->points);
    box.X_BS = geom.X_BG * box.X_BS;
    return box;
  }
  if (options.meshes == Meshes::require)
    geom.element.problem(ErrorCode::io, mesh->absent + ".", "Put it there, or let meshes be left out.");
  else
    geom.element.note("A shape is left out because its mesh file is not there.");
  return std::nullopt;
}

/// How a geom lies, without what its surface is like.
std::optional<Shape> outline(MjcfBody& body, const MjcfGeom& geom, const MjcfJoint* last, bool collides, const RobotOptions& options) {
  const auto fitted = [&](const FittedShape& fit) {
    geom.element.note(fit.how);
    return fit.shape;
  };
  switch (geom.type) {
    case MjcfGeomType::plane: geom.element.note("A plane is left out: the ground belongs to the scene."); return std::nullopt;
    case MjcfGeomType::hfield: geom.element.note("A height field is left out."); return std::nullopt;
    case MjcfGeomType::sdf: geom.element.note("A signed distance field is left out."); return std::nullopt;
    case MjcfGeomType::mesh: return mesh_shape(body, geom, collides, options);
    case MjcfGeomType::sphere: return Shape::sphere(geom.size.x, geom.X_BG);
    case MjcfGeomType::box: return Shape::box(geom.size, geom.X_BG);
    case MjcfGeomType::ellipsoid: return fitted(fit_ellipsoid(geom.size, geom.X_BG));
    case MjcfGeomType::cylinder: {
      std::optional<SpinAxis> spin;
      if (last && last->type == MjcfJointType::hinge) spin = SpinAxis{last->pos, last->axis};
      return fitted(fit_cylinder(geom.size.x, 2 * geom.size.y, geom.X_BG, spin));
    }
    case MjcfGeomType::capsule: {
      Shape s;
      s.type = ShapeType::capsule;
      s.radius = geom.size.x;
      s.half_length = geom.size.y;
      s.X_BS = geom.X_BG;
      return s;
    }
  }
  return std::nullopt;
}

class LinkMaker {
 public:
  explicit LinkMaker(MjcfBuild& build) : build_(build), tree_(build.tree) {}

  void run() {
    for (MjcfBody& body : tree_.bodies) {
      names_.insert(body.name);
      fit_mjcf_geoms(body);
    }
    make_world();
    decide_bases();
    for (std::size_t i = 1; i < tree_.bodies.size(); ++i) make_body(tree_.bodies[i]);
    refuse_absent_masses();
    set_total_mass();
  }

 private:
  /// One problem for all bodies whose masses would come from meshes that are not there.
  void refuse_absent_masses() {
    const auto lacks = [](const MjcfBody& b) { return b.without_mass != nullptr; };
    const auto first = std::ranges::find_if(tree_.bodies, lacks);
    if (first == tree_.bodies.end()) return;
    const auto others = std::ranges::count_if(tree_.bodies, lacks) - 1;
    const std::string whose = formats::in_quotes(first->name) + (others > 0 ? " and of " + std::to_string(others) + " more" : "");
    first->without_mass->element.problem(
        ErrorCode::io,
        "the mass of the body " + whose + " comes from a mesh, but " + first->source->mesh(first->without_mass->mesh)->absent + ".",
        "Put the file there, give the body an <inertial>, or leave meshes out: they then weigh nothing.");
  }

  void add(LinkSpec link, const MjcfElement& element, const Pose& X_BF) {
    build_.spec.links.push_back(std::move(link));
    build_.link_elements.push_back(element);
    build_.X_BF.push_back(X_BF);
  }

  void append_shapes(MjcfBody& body, std::vector<Shape>& out) {
    const MjcfJoint* const last = body.joints.empty() ? nullptr : &body.joints.back();
    for (const MjcfGeom& geom : body.geoms)
      if (std::optional<Shape> shape = mjcf_shape(body, geom, last, build_.options)) {
        shape->X_BS = body.X_LB * shape->X_BS;
        out.push_back(*shape);
      }
  }

  /// Shapes of the world become those of a link that is fixed to it.
  void make_world() {
    LinkSpec link;
    link.name = "world";
    append_shapes(tree_.bodies[0], link.shapes);
    if (!link.shapes.empty()) add(std::move(link), tree_.bodies[0].geoms[0].element, {});
  }

  /// The options may take free joints away, or give them to bodies that the file fixes and that carry movable ones.
  void decide_bases() {
    if (build_.options.base == Base::by_file) return;
    std::vector<char> movable(tree_.bodies.size(), 0);
    for (std::size_t i = tree_.bodies.size(); i-- > 1;) {
      MjcfBody& body = tree_.bodies[i];
      if (build_.options.base == Base::fixed) std::erase_if(body.joints, [](const MjcfJoint& j) { return j.type == MjcfJointType::free; });
      movable[i] = static_cast<char>(movable[i] || !body.joints.empty());
      if (build_.options.base == Base::floating && body.parent == 0 && body.joints.empty() && movable[i] && !body.mocap) {
        MjcfJoint joint;
        joint.element = body.element;
        joint.type = MjcfJointType::free;
        body.joints.push_back(joint);
      }
      if (movable[i]) movable[static_cast<std::size_t>(body.parent)] = 1;
    }
  }

  std::string invented_name(const MjcfBody& body, const MjcfJoint& joint, std::size_t number) {
    std::string name = body.name + ":" + (joint.name.empty() ? std::to_string(number) : joint.name);
    while (!names_.insert(name).second) name += "_";
    return name;
  }

  static Joint joint_of(const MjcfJoint& from, const Pose& X_PJ) {
    Joint joint;
    joint.X_PJ = X_PJ;
    joint.axis = from.axis;
    switch (from.type) {
      case MjcfJointType::free: joint.type = JointType::floating; break;
      case MjcfJointType::ball: joint.type = JointType::spherical; break;
      case MjcfJointType::slide: joint.type = JointType::prismatic; break;
      case MjcfJointType::hinge: joint.type = JointType::revolute; break;
    }
    if (joint.type == JointType::floating || joint.type == JointType::spherical) joint.axis = {0, 0, 1};
    for (int i = 0; i < joint.nv(); ++i) joint.freedoms[static_cast<std::size_t>(i)] = from.freedom;
    return joint;
  }

  void make_body(MjcfBody& body) {
    const MjcfBody& above = tree_.bodies[static_cast<std::size_t>(body.parent)];
    std::string parent = above.link < 0 ? std::string() : build_.spec.links[static_cast<std::size_t>(above.link)].name;
    Pose X_LB = above.X_LB * body.X_PB;  // the body in the link below which the next joint hangs, all joints at zero
    Vec3 at;                             // where in the body the frame of that joint lies
    LinkSpec link;
    MjcfElement element = body.element;
    link.joint.X_PJ = X_LB;
    for (std::size_t k = 0; k < body.joints.size(); ++k) {
      MjcfJoint& joint = body.joints[k];
      if (joint.type != MjcfJointType::slide) at = joint.pos;
      link.joint = joint_of(joint, X_LB * Pose{Mat3::identity(), at});
      joint.link = static_cast<int>(build_.spec.links.size());
      X_LB = {Mat3::identity(), -at};
      const bool last = k + 1 == body.joints.size();
      link.name = last ? body.name : invented_name(body, joint, k + 1);
      link.parent = parent;
      if (!joint.name.empty()) build_.joints.push_back({joint.name, link.name});
      element = joint.element;
      if (last) break;
      parent = link.name;
      add(std::move(link), element, X_LB);
      link = {};
    }
    if (body.joints.empty()) X_LB = {};
    if (body.mocap) body.element.note("A body that a program moves (mocap) stands still.");
    link.name = body.name;
    link.parent = parent;
    body.X_LB = X_LB;
    body.link = static_cast<int>(build_.spec.links.size());
    link.inertia = mjcf_inertia(body, build_.options).in_parent(X_LB);
    append_shapes(body, link.shapes);
    add(std::move(link), element, X_LB);
  }

  void set_total_mass() {
    const double wanted = tree_.bodies[0].source->compiler().total_mass;
    double mass = 0;
    for (const LinkSpec& link : build_.spec.links) mass += link.inertia.mass;
    if (!(wanted > 0) || !(mass > 0)) return;
    const double f = wanted / mass;
    for (LinkSpec& link : build_.spec.links) link.inertia = {link.inertia.mass * f, link.inertia.h * f, link.inertia.I * f};
  }

  MjcfBuild& build_;
  MjcfTree& tree_;
  std::set<std::string> names_;
};

}  // namespace

std::optional<Shape> mjcf_shape(MjcfBody& body, const MjcfGeom& geom, const MjcfJoint* last, const RobotOptions& options) {
  const bool collides = geom.contype != 0 || geom.conaffinity != 0;
  std::optional<Shape> shape = outline(body, geom, last, collides, options);
  if (!shape) return shape;
  if (collides && !(geom.contype == 1 && geom.conaffinity == 1))
    geom.element.note("Which pairs of shapes collide (contype, conaffinity) is left out; the shape collides with all.");
  shape->friction = geom.friction;
  shape->collides = collides;
  shape->visible = !geom.transparent && (collides || geom.group <= 2);
  return shape;
}

void make_mjcf_links(MjcfBuild& build) { LinkMaker(build).run(); }

}  // namespace ugoki::robot_formats
