#pragma once
// Random trees of links with loops of every type.

#include <vector>

#include "random_mechanism.h"
#include "ugoki/dynamics/dynamics.h"

namespace ugoki::testing {

inline constexpr LoopType all_types[] = {LoopType::weld,      LoopType::ball,        LoopType::revolute,
                                         LoopType::prismatic, LoopType::cylindrical, LoopType::planar,
                                         LoopType::universal, LoopType::distance,    LoopType::gear};

/// A random tree with one loop of each type. At `state` the frames of each loop coincide, so all gaps except the gear's are zero.
struct RandomLoops {
  MechanismPtr m;
  State state;
  std::vector<Loop> loops;

  /// @param closed false: the loops have random gaps at `state`
  explicit RandomLoops(unsigned seed, bool closed = true) {
    RandomSource random(seed);
    m = *Mechanism::make(random_spec(random, 12));
    state = State(*m);
    randomize(random, *m, state);
    dynamics::Workspace ws(*m);
    dynamics::update_kinematics(*m, state.q, state.v, ws);
    for (const LoopType type : all_types) {
      Loop l{.type = type, .link_a = random.below(3) == 0 ? -1 : random.below(12)};
      do {
        l.link_b = random.below(12);
      } while (l.link_b == l.link_a);
      const Pose X_WJ{random.rotation(), random.vec(1)};
      const Pose X_WA = l.link_a < 0 ? Pose{} : ws.X_WB[static_cast<std::size_t>(l.link_a)];
      Pose X_B = ws.X_WB[static_cast<std::size_t>(l.link_b)].inverse() * X_WJ;
      l.X_AJ = X_WA.inverse() * X_WJ;
      l.axis = random.direction();
      l.axis2 = normalized(cross(l.axis, random.direction()));
      l.length = 0.7;
      if (type == LoopType::distance) X_B.p += ws.X_WB[static_cast<std::size_t>(l.link_b)].R.transposed() * (random.direction() * 0.7);
      if (type == LoopType::gear) {
        l.dof_a = coordinate_dof(m->nv() - 1);
        l.dof_b = coordinate_dof(l.dof_a - 1);
        l.polynomial = {0.3, -2, 0.5, 0.1, -0.2};
      }
      if (!closed) X_B = X_B * Pose{to_matrix(exp_map(random.vec(0.3))), random.vec(0.2)};
      l.X_BJ = X_B;
      loops.push_back(l);
    }
  }

  /// The largest DOF index up to f whose joint is neither spherical nor floating, so that the DOF is the rate of one coordinate.
  int coordinate_dof(int f) const {
    const auto type = [&] { return m->link(m->link_of_dof(f)).joint.type; };
    while (f > 0 && (type() == JointType::spherical || type() == JointType::floating)) --f;
    return f;
  }
};

/// A random tree, and the same tree with loops that duplicate joints. The joint already satisfies its loop, so the gaps and motions of
/// all rows are rounding errors.
struct DoubledJoints {
  MechanismSpec tree, doubled;

  /// @param away m: maximum distance along each axis of the first joint from the world origin
  explicit DoubledJoints(RandomSource& random, bool floating_base, double away) {
    constexpr std::pair<JointType, LoopType> kinds[] = {
        {JointType::revolute, LoopType::revolute},       {JointType::prismatic, LoopType::prismatic},
        {JointType::cylindrical, LoopType::cylindrical}, {JointType::planar, LoopType::planar},
        {JointType::universal, LoopType::universal},     {JointType::spherical, LoopType::ball}};
    constexpr JointType types[] = {JointType::revolute, JointType::prismatic, JointType::cylindrical,
                                   JointType::planar,   JointType::universal, JointType::spherical};
    tree = random_spec(random, 2 + random.below(4), types, floating_base);
    tree.links[0].joint.X_PJ.p = random.vec(away);
    for (LinkSpec& l : tree.links) l.joint.axis2 = normalized(cross(l.joint.axis, random.direction()));
    doubled = tree;
    for (const LinkSpec& l : tree.links)
      for (const auto& [joint, loop] : kinds)
        if (l.joint.type == joint && (random.below(3) != 0 || tree.links.size() == 2))
          doubled.loops.push_back({.name = "again " + l.name,
                                   .type = loop,
                                   .link_a = l.parent,
                                   .link_b = l.name,
                                   .X_AJ = l.joint.X_PJ,
                                   .axis = joint == JointType::planar ? Vec3{0, 0, 1} : l.joint.axis,
                                   .axis2 = l.joint.axis2});
  }
};

}  // namespace ugoki::testing
