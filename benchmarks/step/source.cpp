#include "source.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include "ugoki/collision/scene.h"
#include "ugoki/robot_formats/symmetric_eigen.h"

namespace ugoki::benchmarks {
namespace {

Frame frame_of(const Pose& X) {
  Frame out;
  for (int i = 0; i < 3; ++i) {
    const Vec3 row = X.R.transposed() * Vec3{i == 0 ? 1.0 : 0, i == 1 ? 1.0 : 0, i == 2 ? 1.0 : 0};
    for (int j = 0; j < 3; ++j) out.R[3 * i + j] = row[j];
    out.p[i] = X.p[i];
  }
  return out;
}

StepJoint joint_of(const Link& l) {
  switch (l.joint.type) {
    case JointType::floating: return StepJoint::floating;
    case JointType::revolute: return StepJoint::revolute;
    case JointType::prismatic: return StepJoint::prismatic;
    case JointType::spherical: return StepJoint::spherical;
    default: throw std::runtime_error("the peers have no joint like the one of " + l.name);
  }
}

StepShape shape_of(const Shape& s, int link, const Pose& X) {
  StepShape out;
  out.link = link;
  out.frame = frame_of(X * s.X_BS);
  switch (s.type) {
    case ShapeType::sphere: out.type = StepShapeType::sphere; break;
    case ShapeType::capsule: out.type = StepShapeType::capsule; break;
    case ShapeType::cylinder: out.type = StepShapeType::cylinder; break;
    case ShapeType::box: out.type = StepShapeType::box; break;
    case ShapeType::ellipsoid: out.type = StepShapeType::ellipsoid; break;
    default: throw std::runtime_error("a scene of this benchmark has no meshes");
  }
  const bool round = s.type == ShapeType::sphere || s.type == ShapeType::capsule || s.type == ShapeType::cylinder;
  const Vec3 size = round ? Vec3{s.radius, s.half_length, 0} : s.half_extents;
  for (int i = 0; i < 3; ++i) out.size[i] = size[i];
  return out;
}

/// Inertia tensor of a rotor with the moment A [kg m^2] about the unit axis a.
Sym3 rotor(const Vec3& a, double A) { return {A * a.x * a.x, A * a.y * a.y, A * a.z * a.z, A * a.x * a.y, A * a.x * a.z, A * a.y * a.z}; }

MechanismPtr made(MechanismSpec spec) {
  Result<MechanismPtr> m = Mechanism::make(std::move(spec));
  if (!m) throw std::runtime_error(m.error().text());
  return *m;
}

/// Principal axes and moments. If the axes of the first shape are principal axes, they are used, so that a peer need not turn the shape.
void set_principal(StepLink& link, const Inertia& inertia, const Mat3* shape_axes) {
  const Sym3 own = inertia.about_centre();
  link.mass = inertia.mass;
  const Vec3 c = inertia.centre();
  for (int i = 0; i < 3; ++i) link.centre[i] = c[i];
  const double values[6] = {own.xx, own.yy, own.zz, own.xy, own.xz, own.yz};
  std::copy_n(values, 6, link.inertia);
  Sym3 total = own;
  if (link.joint == StepJoint::revolute) total = total + rotor({link.axis[0], link.axis[1], link.axis[2]}, link.armature);
  Pose principal{Mat3::identity(), c};
  Vec3 moments;
  const auto is_principal = [&](const Mat3& R) {
    const Sym3 turned = rotated(total, R.transposed());
    moments = {turned.xx, turned.yy, turned.zz};
    principal.R = R;
    return std::fabs(turned.xy) + std::fabs(turned.xz) + std::fabs(turned.yz) <= 1e-9 * (turned.xx + turned.yy + turned.zz);
  };
  if (!(shape_axes != nullptr && is_principal(*shape_axes)) && !is_principal(Mat3::identity())) {
    const robot_formats::SymmetricEigen eigen = robot_formats::symmetric_eigen(total);
    principal.R = eigen.V;
    moments = eigen.values;
  }
  link.principal = frame_of(principal);
  for (int i = 0; i < 3; ++i) link.moments[i] = std::max(moments[i], 0.0);
}

using Names = std::set<std::pair<int, int>>;

}  // namespace

void StepSource::add(const MechanismPtr& mechanism, const Pose& base, const std::map<std::string, Pose>& file_frames,
                     std::span<const double> q0) {
  const Mechanism& m = *mechanism;
  struct Place {
    int link = -1;
    Pose X;  ///< pose of the mechanism's link in the plain link
  };
  std::vector<Place> places;
  std::vector<Inertia> inertias;
  std::vector<const Mat3*> axes;
  StepBody body;
  std::vector<int> index;
  for (const Link& l : m.links()) {
    const Place parent = l.parent < 0 ? Place{} : places[static_cast<std::size_t>(l.parent)];
    Place& place = places.emplace_back();
    if (l.joint.type == JointType::fixed && parent.link >= 0) {
      place = {parent.link, parent.X * l.joint.X_PJ};
      inertias[static_cast<std::size_t>(parent.link)] += l.inertia.in_parent(place.X);
    } else {
      if ((l.parent < 0) != (l.joint.type == JointType::floating) || (l.parent < 0 && !index.empty()))
        throw std::runtime_error(m.name() + ": a scene of this benchmark has bodies with one floating base");
      place.link = static_cast<int>(index.size());
      index.push_back(static_cast<int>(places.size()) - 1);
      inertias.push_back(l.inertia);
      axes.push_back(nullptr);
      StepLink link;
      link.name = l.name;
      link.parent = parent.link;
      link.joint = joint_of(l);
      link.joint_frame = frame_of(parent.X * l.joint.X_PJ);
      for (int i = 0; i < 3; ++i) link.axis[i] = l.joint.axis[i];
      if (link.joint != StepJoint::floating) {
        const Dof& f = l.joint.dofs[0];
        if (f.friction != 0) throw std::runtime_error(m.name() + ": dry joint friction is not compared");
        link.damping = f.damping;
        link.stiffness = f.stiffness;
        link.rest = f.rest;
        link.armature = f.armature;
        if (link.joint != StepJoint::spherical) {
          link.lower = f.lower;
          link.upper = f.upper;
          link.position = q0.empty() ? 0 : q0[static_cast<std::size_t>(l.q_index)];
        } else if (std::isfinite(f.lower) || std::isfinite(f.upper) || f.stiffness != 0) {
          throw std::runtime_error(m.name() + ": limits and springs of ball joints are not compared");
        }
      }
      if (const auto it = file_frames.find(l.name); it != file_frames.end()) link.file_frame = frame_of(it->second);
      body.links.push_back(link);
    }
    for (const Shape& s : l.shapes) {
      if (!s.collides) continue;
      body.shapes.push_back(shape_of(s, place.link, place.X));
      if (l.joint.type != JointType::fixed && axes[static_cast<std::size_t>(place.link)] == nullptr)
        axes[static_cast<std::size_t>(place.link)] = &s.X_BS.R;
    }
  }
  for (std::size_t i = 0; i < body.links.size(); ++i) set_principal(body.links[i], inertias[i], axes[i]);
  for (const Loop& loop : m.loops()) {
    if (loop.type != LoopType::ball || loop.link_a < 0 || loop.link_b < 0)
      throw std::runtime_error(m.name() + ": only ball loops between links are compared");
    const Place &a = places[static_cast<std::size_t>(loop.link_a)], &b = places[static_cast<std::size_t>(loop.link_b)];
    StepLoop out;
    out.a = a.link;
    out.b = b.link;
    const Vec3 in_a = a.X * loop.X_AJ.p, in_b = b.X * loop.X_BJ.p;
    for (int i = 0; i < 3; ++i) {
      out.point_a[i] = in_a[i];
      out.point_b[i] = in_b[i];
    }
    body.loops.push_back(out);
  }
  // Two links are excluded unless all their shapes may collide in our scene.
  const collision::Scene scene({mechanism});
  std::map<std::pair<int, int>, int> allowed, all;
  const auto pair_of = [&](int a, int b) { return std::pair(std::min(a, b), std::max(a, b)); };
  const auto plain_link = [&](std::int32_t shape) {
    return places[static_cast<std::size_t>(scene.shapes()[static_cast<std::size_t>(shape)].link)].link;
  };
  for (const collision::ShapePair& p : scene.self_pairs(0)) ++allowed[pair_of(plain_link(p.a), plain_link(p.b))];
  for (std::size_t i = 0; i < body.shapes.size(); ++i)
    for (std::size_t j = i + 1; j < body.shapes.size(); ++j)
      if (body.shapes[i].link != body.shapes[j].link) ++all[pair_of(body.shapes[i].link, body.shapes[j].link)];
  for (const auto& [pair, count] : all) {
    if (allowed[pair] == count) continue;
    body.excluded.push_back(pair);
    partly_excluded += allowed[pair] > 0 ? 1 : 0;
  }
  State& s = states.emplace_back(m);
  std::ranges::copy(q0, s.q.begin());
  const Link& root = m.link(0);
  const Pose in_joint = root.joint.X_PJ.inverse() * base;
  const Quat turn = to_quat(in_joint.R);
  const double q[7] = {in_joint.p.x, in_joint.p.y, in_joint.p.z, turn.w, turn.x, turn.y, turn.z};
  std::copy_n(q, 7, s.q.begin());
  body.base = frame_of(base);
  mechanisms.push_back(mechanism);
  bodies.push_back(std::move(body));
  links.push_back(std::move(index));
}

StepSource StepSource::probe(double speed, double height, bool armature) const {
  StepSource out = *this;
  out.limits = false;
  out.servo_gain = 0;
  out.mechanisms.clear();
  out.states.clear();
  out.bodies.clear();
  out.links.clear();
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    MechanismSpec spec = mechanisms[b]->spec();
    for (LinkSpec& l : spec.links)
      for (Dof& f : l.joint.dofs) {
        f.lower = -std::numeric_limits<double>::infinity();
        f.upper = std::numeric_limits<double>::infinity();
        if (!armature) f.armature = 0;
      }
    const Joint& root = mechanisms[b]->link(0).joint;
    Pose base = root.X_PJ * joint_pose(root, states[b].q.data());
    base.p.z += height;
    out.add(made(std::move(spec)), base, {}, states[b].q);
    for (std::size_t i = 0; i < bodies[b].links.size(); ++i) {
      StepLink& l = out.bodies[b].links[i];
      l.file_frame = bodies[b].links[i].file_frame;
      if ((l.joint != StepJoint::revolute && l.joint != StepJoint::prismatic) || !bodies[b].loops.empty()) continue;
      l.speed = speed * 0.2 * (static_cast<int>(i * 5 % 11) - 5);
      out.states[b].v[static_cast<std::size_t>(mechanisms[b]->link(links[b][i]).v_index)] = l.speed;
    }
  }
  return out;
}

std::pair<double, double> heights(const Mechanism& m, const State& s) {
  std::vector<Pose> X(static_cast<std::size_t>(m.link_count()));
  calc_poses(m, s.q, X);
  std::pair out(std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity());
  for (int i = 0; i < m.link_count(); ++i)
    for (const Shape& shape : m.link(i).shapes) {
      if (!shape.collides) continue;
      const Pose X_WS = X[static_cast<std::size_t>(i)] * shape.X_BS;
      out.first = std::min(out.first, X_WS.p.z - reach(shape, transpose_times(X_WS.R, Vec3{0, 0, -1})));
      out.second = std::max(out.second, X_WS.p.z + reach(shape, transpose_times(X_WS.R, Vec3{0, 0, 1})));
    }
  return out;
}

}  // namespace ugoki::benchmarks
