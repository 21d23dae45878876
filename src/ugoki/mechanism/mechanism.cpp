#include "ugoki/mechanism/mechanism.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace ugoki {
namespace {

bool finite(const Mat3& m) { return is_finite(m.row(0)) && is_finite(m.row(1)) && is_finite(m.row(2)); }
bool is_pose(const Pose& X) {
  if (!finite(X.R) || !is_finite(X.p)) return false;
  const Mat3 e = X.R.transposed() * X.R - Mat3::identity();
  double worst = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) worst = std::max(worst, std::fabs(e.row(i)[j]));
  return worst < 1e-6 && X.R.determinant() > 0;
}

/// Explains why no rigid body can have this inertia; empty if the inertia is possible.
std::string impossible_inertia(const Inertia& inertia) {
  const Sym3& I = inertia.I;
  if (!std::isfinite(inertia.mass) || !is_finite(inertia.h) || !is_finite(Vec3{I.xx, I.yy, I.zz}) || !is_finite(Vec3{I.xy, I.xz, I.yz}))
    return "A value of the link's inertia is not finite.";
  if (inertia.mass < 0) return "The link's mass is negative.";
  if (inertia.mass == 0 && norm(inertia.h) > 0) return "The link has a centre of mass but no mass.";
  const Sym3 c = inertia.about_centre();
  const double scale = std::max({std::fabs(I.xx), std::fabs(I.yy), std::fabs(I.zz), 1e-300});
  const double slack = 1e-9 * scale;
  // The inertia c about the centre of mass and the second moments of mass tr(c)/2 1 - c must be positive semidefinite (for the moments: the
  // triangle inequality). The principal minors are checked with a relative slack of 1e-9, as inputs are rounded.
  const double t = 0.5 * (c.xx + c.yy + c.zz);
  const Sym3 moments{t - c.xx, t - c.yy, t - c.zz, -c.xy, -c.xz, -c.yz};
  for (const Sym3& s : {c, moments}) {
    const bool bad = s.xx < -slack || s.yy < -slack || s.zz < -slack || s.xx * s.yy - s.xy * s.xy < -slack * scale ||
                     s.xx * s.zz - s.xz * s.xz < -slack * scale || s.yy * s.zz - s.yz * s.yz < -slack * scale ||
                     s.matrix().determinant() < -slack * scale * scale;
    if (bad)
      return "No rigid body has these moments of inertia (about the centre of mass they must be positive, and each at most the sum of "
             "the other two).";
  }
  return {};
}

void check_joint(const LinkSpec& link, const std::string& location, Error& errors) {
  const Joint& j = link.joint;
  const auto add = [&](const char* message, const char* remedy) { errors.add(ErrorCode::structure, location, message, remedy); };
  if (!is_pose(j.X_PJ)) add("The joint's frame is not a rotation and a finite position.", "Use an orthonormal right-handed rotation.");
  const bool uses_axis = j.type == JointType::revolute || j.type == JointType::prismatic || j.type == JointType::helical ||
                         j.type == JointType::cylindrical || j.type == JointType::universal;
  if (uses_axis && !(std::fabs(norm(j.axis) - 1) < 1e-6)) add("The joint's axis is not a unit vector.", "Use an axis of length 1.");
  if (j.type == JointType::universal) {
    if (!(std::fabs(norm(j.axis2) - 1) < 1e-6))
      add("The joint's second axis is not a unit vector.", "Use an axis of length 1.");
    else if (norm(cross(j.axis, j.axis2)) < 1e-6)
      add("The two axes of the universal joint are parallel.", "Rotate one of them, or use a revolute joint.");
  }
  if (!std::isfinite(j.pitch)) add("The joint's pitch is not finite.", "Enter the pitch in metres per radian.");
  for (int i = 0; i < j.nv(); ++i) {
    const Dof& f = j.dofs[static_cast<std::size_t>(i)];
    if (!(f.lower <= f.upper))
      add("The lower limit of the joint is above its upper limit, or not a number.", "Swap or correct the limits.");
    const bool negative = !(f.damping >= 0) || !(f.stiffness >= 0) || !(f.armature >= 0) || !(f.friction >= 0) || !(f.effort >= 0);
    const bool not_finite = !std::isfinite(f.damping) || !std::isfinite(f.stiffness) || !std::isfinite(f.armature) ||
                            !std::isfinite(f.friction) || !std::isfinite(f.rest);
    if (negative || not_finite)
      add("The joint's damping, stiffness, armature, friction and effort must be at least 0, and finite except for the effort.",
          "Correct the joint's values.");
  }
}

bool has_size(const Shape& s) {
  const bool extents = s.half_extents.x > 0 && s.half_extents.y > 0 && s.half_extents.z > 0 && is_finite(s.half_extents);
  const bool radius = s.radius > 0 && std::isfinite(s.radius) && std::isfinite(s.half_length);
  switch (s.type) {
    case ShapeType::sphere:
    case ShapeType::capsule: return radius && s.half_length >= 0;
    case ShapeType::cylinder: return radius && s.half_length > 0;
    case ShapeType::box:
    case ShapeType::ellipsoid: return extents;
    case ShapeType::mesh: return s.geometry != nullptr;
    case ShapeType::height_field: return s.field != nullptr;
  }
  return false;
}

void check_shapes(const LinkSpec& link, const std::string& location, Error& errors) {
  for (const Shape& s : link.shapes) {
    if (!has_size(s))
      errors.add(ErrorCode::structure, location, "A shape has no size.", "Set a positive radius or extents, a mesh or a height field.");
    if (!is_pose(s.X_BS))
      errors.add(ErrorCode::structure, location, "A shape's frame is not a rotation and a finite position.",
                 "Use an orthonormal right-handed rotation.");
    if (!(s.friction >= 0) || !(s.restitution >= 0 && s.restitution <= 1))
      errors.add(ErrorCode::range, location, "A shape's friction or restitution is out of range.",
                 "Use a friction of at least 0 and a restitution from 0 to 1.");
  }
}

using LinkIndex = std::map<std::string, int, std::less<>>;

/// Checks one loop and adds its problems to `errors`. @param index_of link names -> indices in spec.links
void check_loop(const LoopSpec& loop, const MechanismSpec& spec, const LinkIndex& index_of, Error& errors) {
  const std::string location = "loop " + loop.name;
  const auto add = [&](std::string message, const char* remedy) { errors.add(ErrorCode::structure, location, std::move(message), remedy); };
  const LinkSpec* ends[2] = {};
  bool known = true;
  for (int i = 0; i < 2; ++i) {
    const std::string& name = i == 0 ? loop.link_a : loop.link_b;
    if (name.empty()) continue;
    if (const auto it = index_of.find(name); it != index_of.end()) {
      ends[i] = &spec.links[static_cast<std::size_t>(it->second)];
    } else {
      errors.add(ErrorCode::unknown, location, "The loop's link '" + name + "' does not exist.",
                 "Name an existing link, or none for the world.");
      known = false;
    }
  }
  if (loop.type == LoopType::gear) {
    const int dofs[2] = {loop.dof_a, loop.dof_b};
    for (int i = 0; i < 2 && known; ++i)
      if (!ends[i] || dofs[i] < 0 || dofs[i] >= ends[i]->joint.nv() || ends[i]->joint.type == JointType::floating ||
          ends[i]->joint.type == JointType::spherical)
        add("The gear's " + std::string(i == 0 ? "first" : "second") +
                " degree of freedom does not exist, or belongs to a spherical or floating joint.",
            "Name a link whose joint is neither spherical nor floating, and one of its degrees of freedom, counted from 0.");
    if (known && loop.link_a == loop.link_b && loop.dof_a == loop.dof_b)
      add("The gear couples a degree of freedom with itself.", "Name two different degrees of freedom.");
    if (!std::ranges::all_of(loop.polynomial, [](double c) { return std::isfinite(c); }))
      add("A coefficient of the gear's polynomial is not finite.", "Correct the coefficient.");
    return;
  }
  if (known && loop.link_a == loop.link_b)
    add("The loop joins a link with itself.", "Name two different links, or one link and the world.");
  if (!is_pose(loop.X_AJ) || !is_pose(loop.X_BJ))
    add("A frame of the loop is not a rotation and a finite position.", "Use an orthonormal right-handed rotation.");
  const bool uses_axis = loop.type == LoopType::revolute || loop.type == LoopType::prismatic || loop.type == LoopType::cylindrical ||
                         loop.type == LoopType::planar || loop.type == LoopType::universal;
  if (uses_axis && !(std::fabs(norm(loop.axis) - 1) < 1e-6)) add("The loop's axis is not a unit vector.", "Use an axis of length 1.");
  if (loop.type == LoopType::universal && !(std::fabs(norm(loop.axis2) - 1) < 1e-6))
    add("The loop's second axis is not a unit vector.", "Use an axis of length 1.");
  if (loop.type == LoopType::distance && !(loop.length > 0 && std::isfinite(loop.length)))
    add("The loop's length is not above 0 m.", "Enter a length in metres, or use a ball loop.");
}

}  // namespace

Result<std::shared_ptr<const Mechanism>> Mechanism::make(MechanismSpec spec) {
  Error errors;
  const std::size_t n = spec.links.size();
  const std::string mechanism_location = "mechanism " + (spec.name.empty() ? "(no name)" : spec.name);
  if (n == 0) errors.add(ErrorCode::structure, mechanism_location, "The mechanism has no links.", "Add at least one link.");
  if (n > 1'000'000)
    return fail(ErrorCode::range, mechanism_location, "The mechanism has " + std::to_string(n) + " links; at most 1000000 are allowed.");

  LinkIndex index_of;
  for (std::size_t i = 0; i < n; ++i) {
    const LinkSpec& l = spec.links[i];
    if (l.name.empty())
      errors.add(ErrorCode::structure, mechanism_location + ", link " + std::to_string(i), "The link has no name.", "Name the link.");
    else if (!index_of.emplace(l.name, static_cast<int>(i)).second)
      errors.add(ErrorCode::duplicate, "link " + l.name, "Two links have this name.", "Rename one of them.");
  }
  std::vector<int> parent(n, -1);
  for (std::size_t i = 0; i < n; ++i) {
    const LinkSpec& l = spec.links[i];
    const std::string location = "link " + l.name;
    if (!l.parent.empty()) {
      const auto it = index_of.find(l.parent);
      if (it == index_of.end())
        errors.add(ErrorCode::unknown, location, "The link's parent '" + l.parent + "' does not exist.",
                   "Name an existing link, or none for the world.");
      else
        parent[i] = it->second;
    }
    if (!l.real.empty()) {
      const auto it = index_of.find(l.real);
      if (it == index_of.end())
        errors.add(ErrorCode::unknown, location, "The real link '" + l.real + "' does not exist.",
                   "Name the link at which the loop is cut.");
      else if (it->second == static_cast<int>(i))
        errors.add(ErrorCode::structure, location, "The link is its own real link.", "Name another link.");
      else if (!spec.links[static_cast<std::size_t>(it->second)].real.empty())
        errors.add(ErrorCode::structure, location, "The real link '" + l.real + "' is itself virtual.", "Name the real link.");
      if (!is_pose(l.X_RV))
        errors.add(ErrorCode::structure, location, "The loop's frame is not a rotation and a finite position.",
                   "Use an orthonormal right-handed rotation.");
    }
    check_joint(l, location, errors);
    check_shapes(l, location, errors);
    if (std::string why = impossible_inertia(l.inertia); !why.empty())
      errors.add(ErrorCode::structure, location, why, "Correct the mass, centre of mass and moments of inertia.");
  }
  LinkIndex loop_names;
  for (std::size_t i = 0; i < spec.loops.size(); ++i) {
    const LoopSpec& l = spec.loops[i];
    if (l.name.empty())
      errors.add(ErrorCode::structure, mechanism_location + ", loop " + std::to_string(i), "The loop has no name.", "Name the loop.");
    else if (const auto it = index_of.find(l.name);
             !loop_names.emplace(l.name, static_cast<int>(i)).second ||
             (it != index_of.end() && !spec.links[static_cast<std::size_t>(it->second)].real.empty()))
      errors.add(ErrorCode::duplicate, "loop " + l.name, "Two loops have this name.",
                 "Rename one of them. The loop of a virtual link has the link's name.");
    check_loop(l, spec, index_of, errors);
  }
  for (const auto& [a, b] : spec.exclusions) {
    const std::string location = mechanism_location + ", exclusion";
    for (const std::string& name : {a, b})
      if (!index_of.contains(name))
        errors.add(ErrorCode::unknown, location, "The mechanism has no link '" + name + "'.", "Name two of its links.");
    if (a == b) errors.add(ErrorCode::structure, location, "Both links are '" + a + "'.", "Name two different links.");
  }
  if (spec.skin) check_skin(*spec.skin, spec.skin_bones.size(), mechanism_location + ", skin", errors);
  for (const SkinBone& bone : spec.skin_bones) {
    if (!index_of.contains(bone.link))
      errors.add(ErrorCode::unknown, mechanism_location + ", skin", "The mechanism has no link '" + bone.link + "'.",
                 "Attach the bone to one of its links.");
    if (!is_finite(bone.p) || !is_finite(bone.A.column(0) + bone.A.column(1) + bone.A.column(2)))
      errors.add(ErrorCode::range, mechanism_location + ", skin", "The place of a bone on '" + bone.link + "' is not finite.",
                 "Correct its matrix.");
  }
  if (!errors.empty()) return fail(std::move(errors));

  // Order the links: parents before children, otherwise in the order given.
  std::vector<int> order;
  std::vector<int> new_index(n, -1);
  order.reserve(n);
  std::vector<char> on_path(n, 0);
  for (std::size_t i = 0; i < n; ++i) {
    std::vector<int> chain;
    int k = static_cast<int>(i);
    while (k >= 0 && new_index[static_cast<std::size_t>(k)] < 0) {
      if (on_path[static_cast<std::size_t>(k)])
        return fail(ErrorCode::structure, "link " + spec.links[static_cast<std::size_t>(k)].name, "The link's parents form a cycle.",
                    "Cut the loop with a virtual link.");
      on_path[static_cast<std::size_t>(k)] = 1;
      chain.push_back(k);
      k = parent[static_cast<std::size_t>(k)];
    }
    for (auto it = chain.rbegin(); it != chain.rend(); ++it) {
      new_index[static_cast<std::size_t>(*it)] = static_cast<int>(order.size());
      order.push_back(*it);
    }
  }

  std::shared_ptr<Mechanism> m(new Mechanism());
  m->name_ = std::move(spec.name);
  m->links_.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    LinkSpec& from = spec.links[static_cast<std::size_t>(order[i])];
    Link& to = m->links_[i];
    const int p = parent[static_cast<std::size_t>(order[i])];
    to.name = std::move(from.name);
    to.label = std::move(from.label);
    to.parent = p < 0 ? -1 : new_index[static_cast<std::size_t>(p)];
    to.joint = from.joint;
    to.inertia = from.inertia;
    to.shapes = std::move(from.shapes);
    to.X_RV = from.X_RV;
    if (!from.real.empty()) to.real = new_index[static_cast<std::size_t>(index_of.find(from.real)->second)];
    to.q_index = m->nq_;
    to.v_index = m->nv_;
    m->nq_ += to.joint.nq();
    m->nv_ += to.joint.nv();
    m->mass_ += to.inertia.mass;
    m->places_.push_back({to.parent, to.q_index, to.v_index, to.joint.type, static_cast<std::uint8_t>(to.joint.nv())});
  }
  for (std::size_t i = n; i-- > 0;) {  // backwards, so that siblings are linked in the order of links
    Link& l = m->links_[i];
    if (l.parent < 0) continue;
    Link& p = m->links_[static_cast<std::size_t>(l.parent)];
    l.sibling = p.child;
    p.child = static_cast<int>(i);
  }
  int last_base = -1;
  for (std::size_t i = 0; i < n; ++i) {
    if (m->links_[i].parent >= 0) continue;
    if (last_base >= 0) m->links_[static_cast<std::size_t>(last_base)].sibling = static_cast<int>(i);
    last_base = static_cast<int>(i);
  }

  const auto link_named = [&](const std::string& name) {
    return name.empty() ? -1 : new_index[static_cast<std::size_t>(index_of.find(name)->second)];
  };
  for (LoopSpec& from : spec.loops) {
    Loop to{.name = std::move(from.name),
            .type = from.type,
            .link_a = link_named(from.link_a),
            .link_b = link_named(from.link_b),
            .X_AJ = from.X_AJ,
            .X_BJ = from.X_BJ,
            .axis = from.axis,
            .axis2 = from.axis2,
            .length = from.length,
            .polynomial = from.polynomial,
            .closed = from.closed};
    if (to.type == LoopType::gear) {
      to.dof_a = m->link(to.link_a).v_index + from.dof_a;
      to.dof_b = m->link(to.link_b).v_index + from.dof_b;
    }
    m->loops_.push_back(std::move(to));
  }
  for (std::size_t i = 0; i < n; ++i)
    if (const Link& l = m->links_[i]; l.real >= 0)
      m->loops_.push_back({.name = l.name,
                           .type = LoopType::weld,
                           .link_a = l.real,
                           .link_b = static_cast<int>(i),
                           .X_AJ = l.X_RV,
                           .of_virtual_link = true});

  for (const auto& [a, b] : spec.exclusions) {
    const int first = link_named(a), second = link_named(b);
    m->exclusions_.push_back({std::min(first, second), std::max(first, second)});
  }
  m->skin_ = std::move(spec.skin);
  if (m->skin_) m->skin_bones_ = std::move(spec.skin_bones);
  std::ranges::sort(m->exclusions_);
  m->exclusions_.erase(std::ranges::unique(m->exclusions_).begin(), m->exclusions_.end());

  // Parent DOFs (Featherstone's lambda) and the link of each DOF.
  std::vector<int> last_dof(n, -1);
  for (std::size_t i = 0; i < n; ++i) {
    const Link& l = m->links_[i];
    int parent_dof = l.parent < 0 ? -1 : last_dof[static_cast<std::size_t>(l.parent)];
    for (int k = 0; k < l.joint.nv(); ++k) {
      m->dof_parents_.push_back(parent_dof);
      m->link_of_dof_.push_back(static_cast<int>(i));
      parent_dof = l.v_index + k;
    }
    last_dof[i] = parent_dof;
  }

  // A movable joint must carry mass or have armature; otherwise the mass matrix is singular.
  std::vector<double> mass_behind(n, 0.0);
  for (std::size_t i = n; i-- > 0;) {
    const Link& l = m->links_[i];
    const Sym3& I = l.inertia.I;
    mass_behind[i] += l.inertia.mass + I.xx + I.yy + I.zz;
    if (l.parent >= 0) mass_behind[static_cast<std::size_t>(l.parent)] += mass_behind[i];
    bool armature = l.joint.nv() > 0;
    for (int k = 0; k < l.joint.nv(); ++k) armature = armature && l.joint.dofs[static_cast<std::size_t>(k)].armature > 0;
    if (l.joint.nv() > 0 && mass_behind[i] <= 0 && !armature && l.real < 0)
      errors.add(ErrorCode::structure, "link " + l.name, "The joint can move, but no link that it carries has mass.",
                 "Add mass or armature, or make the joint fixed.");
  }
  if (!errors.empty()) return fail(std::move(errors));
  return m;
}

int Mechanism::find_link(std::string_view name) const {
  for (std::size_t i = 0; i < links_.size(); ++i)
    if (links_[i].name == name) return static_cast<int>(i);
  return -1;
}

int Mechanism::find_loop(std::string_view name) const {
  for (std::size_t i = 0; i < loops_.size(); ++i)
    if (loops_[i].name == name) return static_cast<int>(i);
  return -1;
}

const Dof& Mechanism::dof(int i) const {
  const Link& l = link(link_of_dof(i));
  return l.joint.dofs[static_cast<std::size_t>(i - l.v_index)];
}

std::vector<double> Mechanism::neutral() const {
  std::vector<double> q(static_cast<std::size_t>(nq_));
  for (const Link& l : links_) joint_neutral(l.joint, q.data() + l.q_index);
  return q;
}

MechanismSpec Mechanism::spec() const {
  MechanismSpec out;
  out.name = name_;
  for (const Link& l : links_) {
    LinkSpec s;
    s.name = l.name;
    s.label = l.label;
    s.parent = l.parent < 0 ? "" : link(l.parent).name;
    s.joint = l.joint;
    s.inertia = l.inertia;
    s.shapes = l.shapes;
    s.real = l.real < 0 ? "" : link(l.real).name;
    s.X_RV = l.X_RV;
    out.links.push_back(std::move(s));
  }
  const auto name_of_link = [&](int i) { return i < 0 ? std::string() : link(i).name; };
  for (const Loop& l : loops_) {
    if (l.of_virtual_link) continue;
    const bool gear = l.type == LoopType::gear;
    out.loops.push_back({.name = l.name,
                         .type = l.type,
                         .link_a = name_of_link(l.link_a),
                         .link_b = name_of_link(l.link_b),
                         .X_AJ = l.X_AJ,
                         .X_BJ = l.X_BJ,
                         .axis = l.axis,
                         .axis2 = l.axis2,
                         .length = l.length,
                         .dof_a = gear ? l.dof_a - link(l.link_a).v_index : 0,
                         .dof_b = gear ? l.dof_b - link(l.link_b).v_index : 0,
                         .polynomial = l.polynomial,
                         .closed = l.closed});
  }
  for (const auto& [a, b] : exclusions_) out.exclusions.push_back({link(a).name, link(b).name});
  out.skin = skin_;
  out.skin_bones = skin_bones_;
  return out;
}

}  // namespace ugoki
