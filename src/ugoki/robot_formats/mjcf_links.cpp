// Makes links, joints and shapes from MJCF bodies.

#include <algorithm>
#include <cmath>
#include <utility>

#include "ugoki/robot_formats/mjcf_build.h"

namespace ugoki::robot_formats {
namespace {

std::optional<Shape> mesh_shape(MjcfBody& body, const MjcfGeom& geom, bool collides, MjcfBuild& build) {
  const RobotOptions& options = build.options;
  if (!collides) return std::nullopt;  // a mesh for display only is not read
  if (options.meshes == Meshes::none) {
    geom.element.note("Collision meshes are left out.");
    return std::nullopt;
  }
  MjcfMeshAsset* const mesh = body.source->mesh(geom.mesh);
  if (!mesh) {
    geom.element.problem(ErrorCode::unknown, "No mesh is named " + formats::in_quotes(geom.mesh) + ".",
                         "Correct the name, or add the mesh.");
    return std::nullopt;
  }
  if (!mesh->absent.empty()) {
    if (options.require_meshes)
      geom.element.problem(ErrorCode::io, "A collision mesh is missing: " + mesh->absent + ".",
                           "Copy the file to that path, or read without meshes.");
    else
      geom.element.note("A shape is left out because its mesh file was not found.");
    return std::nullopt;
  }
  if (!mesh->shape) {
    Result<MeshShape> made = shape_of_mesh({mesh->points, mesh->triangles}, options.meshes, true, geom.mesh);
    if (!made) {
      const Problem& why = made.error().problems[0];
      if (options.require_meshes)
        geom.element.problem(why.code, "The mesh cannot be used: " + why.message, why.remedy);
      else
        geom.element.note("A shape is left out because its mesh cannot be used: " + why.message);
      return std::nullopt;
    }
    mesh->shape = std::move(made->shape);
    for (const std::string& sentence : made->notes) geom.element.note(sentence);
    const GeometryPtr& geometry = mesh->shape->geometry;
    build.meshes.push_back(
        {mesh->element.title(), mesh->points.size(), mesh->triangles.size(), geometry ? geometry->hash : 0, made->found});
  }
  geom.element.note(describe_mesh_use(*mesh->shape, true));
  Shape shape = *mesh->shape;
  shape.X_BS = geom.X_BG * shape.X_BS;
  return shape;
}

/// Returns the shape of a plane. The world's ground z = 0 is left out, because the scene has its own ground. Any other plane becomes a box
/// whose upper face is the plane.
std::optional<Shape> plane_shape(const MjcfBody& body, const MjcfGeom& geom) {
  constexpr double endless = 50, thick = 0.5;  // m: half side of an unbounded plane, and half thickness of the box
  const Pose X_WG = body.X_WB * geom.X_BG;
  if (body.parent < 0 && X_WG.R.zz > 1 - 1e-12 && std::fabs(X_WG.p.z) < 1e-9) {
    geom.element.note("The ground plane z = 0 is left out: the scene has its own ground.");
    return std::nullopt;
  }
  geom.element.note("A plane other than the ground z = 0 is approximated by a plate below it, 1 m thick and at most 100 m wide.");
  const auto side = [&](double half) { return half > 0 && half < endless ? half : endless; };
  return Shape::box({side(geom.size.x), side(geom.size.y), thick}, geom.X_BG * Pose{Mat3::identity(), {0, 0, -thick}});
}

std::optional<Shape> field_shape(MjcfBody& body, const MjcfGeom& geom) {
  const MjcfHeightField* const asset = body.source->height_field(geom.height_field);
  if (!asset) {
    geom.element.problem(ErrorCode::unknown, "No height field is named " + formats::in_quotes(geom.height_field) + ".",
                         "Correct the name, or add the height field.");
    return std::nullopt;
  }
  if (!asset->field) {
    geom.element.note(asset->absent);
    return std::nullopt;
  }
  return Shape::height_field(asset->field, geom.X_BG);
}

/// Returns the geom's shape and pose, without friction, visibility and collision flags.
std::optional<Shape> outline(MjcfBody& body, const MjcfGeom& geom, bool collides, MjcfBuild& build) {
  switch (geom.type) {
    case MjcfGeomType::plane: return plane_shape(body, geom);
    case MjcfGeomType::hfield: return field_shape(body, geom);
    case MjcfGeomType::sdf: geom.element.note("A shape given by a signed distance field is left out."); return std::nullopt;
    case MjcfGeomType::mesh: return mesh_shape(body, geom, collides, build);
    case MjcfGeomType::sphere: return Shape::sphere(geom.size.x, geom.X_BG);
    case MjcfGeomType::box: return Shape::box(geom.size, geom.X_BG);
    case MjcfGeomType::ellipsoid: return Shape::ellipsoid(geom.size, geom.X_BG);
    case MjcfGeomType::cylinder: return Shape::cylinder(geom.size.x, geom.size.y, geom.X_BG);
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

/// Makes the links, joints and shapes of all bodies.
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
  /// Reports one problem for all bodies whose mass depends on a mesh file that was not found.
  void refuse_absent_masses() {
    const auto lacks = [](const MjcfBody& b) { return b.missing_mass != nullptr; };
    const auto first = std::ranges::find_if(tree_.bodies, lacks);
    if (first == tree_.bodies.end()) return;
    const auto others = std::ranges::count_if(tree_.bodies, lacks) - 1;
    const std::string whose = formats::in_quotes(first->name) + (others > 0 ? " and of " + std::to_string(others) + " more" : "");
    first->missing_mass->element.problem(
        ErrorCode::io,
        "The mass of the body " + whose + " comes from a mesh, but " + first->source->mesh(first->missing_mass->mesh)->absent + ".",
        "Copy the file to that path, add an <inertial>, or read without meshes (their mass is then zero).");
  }

  void add(LinkSpec link, const MjcfElement& element, const Pose& X_BF) {
    build_.spec.links.push_back(std::move(link));
    build_.link_elements.push_back(element);
    build_.X_BF.push_back(X_BF);
  }

  void append_shapes(MjcfBody& body, std::vector<Shape>& out) {
    for (const MjcfGeom& geom : body.geoms)
      if (std::optional<Shape> shape = mjcf_shape(body, geom, build_)) {
        shape->X_BS = body.X_LB * shape->X_BS;
        out.push_back(*shape);
      }
  }

  /// Adds the shapes of the world body to a link "world", which is fixed to the world.
  void make_world() {
    LinkSpec link;
    link.name = "world";
    append_shapes(tree_.bodies[0], link.shapes);
    if (!link.shapes.empty()) add(std::move(link), tree_.bodies[0].geoms[0].element, {});
  }

  /// Applies the option `base`: `fixed` removes free joints; `floating` adds a free joint to each body that the file fixes to the world and
  /// that has movable descendants.
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

  std::string generated_name(const MjcfBody& body, const MjcfJoint& joint, std::size_t number) {
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
    for (int i = 0; i < joint.nv(); ++i) joint.dofs[static_cast<std::size_t>(i)] = from.dof;
    return joint;
  }

  void make_body(MjcfBody& body) {
    const MjcfBody& above = tree_.bodies[static_cast<std::size_t>(body.parent)];
    std::string parent = above.link < 0 ? std::string() : build_.spec.links[static_cast<std::size_t>(above.link)].name;
    Pose X_LB = above.X_LB * body.X_PB;  // pose of the body in the parent link of the next joint, with all joints at zero
    Vec3 at;                             // m, origin of the next joint's frame, in the body's frame
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
      link.name = last ? body.name : generated_name(body, joint, k + 1);
      link.parent = parent;
      if (!joint.name.empty()) build_.joints.push_back({joint.name, link.name});
      element = joint.element;
      if (last) break;
      parent = link.name;
      add(std::move(link), element, X_LB);
      link = {};
    }
    if (body.joints.empty()) X_LB = {};
    if (body.mocap) body.element.note("A body that MuJoCo lets a program move (mocap) is fixed here.");
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

std::optional<Shape> mjcf_shape(MjcfBody& body, const MjcfGeom& geom, MjcfBuild& build) {
  const bool collides = geom.contype != 0 || geom.conaffinity != 0;
  std::optional<Shape> shape = outline(body, geom, collides, build);
  if (!shape) return shape;
  shape->groups = static_cast<std::uint32_t>(geom.contype);
  shape->partners = static_cast<std::uint32_t>(geom.conaffinity);
  shape->smooth = geom.condim == 1;
  if (collides && ((shape->groups | shape->partners) & 1U) == 0)
    geom.element.note(
        "The ground collides with this shape, although contype and conaffinity do not contain the usual bit of the floor (1).");
  if (collides && geom.condim > 3) geom.element.note("Torsional and rolling friction (condim 4 and 6) are left out.");
  shape->friction = geom.friction;
  shape->collides = collides;
  shape->visible = !geom.transparent && (collides || geom.group <= 2);
  return shape;
}

void make_mjcf_links(MjcfBuild& build) { LinkMaker(build).run(); }

}  // namespace ugoki::robot_formats
