#pragma once
// The table of one width: included once by each closed_kernels_*.cpp, which defines UGOKI_WIDTH and UGOKI_DOUBLE_LANES.

#include "ugoki/dynamics/kernel_paths.h"

namespace ugoki::dynamics {
namespace {

using One = Lanes<double, 1>;
using ClosedForward = ForwardKernel<One, LoopPass<One>>;

void store(const V3<One>& v, double* to) {
  to[0] = v.x.v;
  to[1] = v.y.v;
  to[2] = v.z.v;
}

Mat3T<One> of_rows(const V3<One>& x, const V3<One>& y, const V3<One>& z) { return {x.x, x.y, x.z, y.x, y.y, y.z, z.x, z.y, z.z}; }

template <Crossing K>
Mat3T<One> turned(const Pass<One>& pass, const NodeOrder& o, const Mat3T<One>& R) {
  const RevoluteCrossing<One, K> X = pass.revolute<K>(o);
  return of_rows(X.down(R.row(0)), X.down(R.row(1)), X.down(R.row(2)));
}
/// A matrix whose rows are vectors of the parent, in the axes of node i.
Mat3T<One> turned(const Pass<One>& pass, const NodeOrder& o, int i, const Mat3T<One>& R) {
  switch (o.crossing) {
    case Crossing::none: return turned<Crossing::none>(pass, o, R);
    case Crossing::cycle: return turned<Crossing::cycle>(pass, o, R);
    case Crossing::cycle_back: return turned<Crossing::cycle_back>(pass, o, R);
    case Crossing::matrix: break;
  }
  return of_rows(pass.down(i, R.row(0)), pass.down(i, R.row(1)), pass.down(i, R.row(2)));
}

/// Where a node is and how it moves; `to` has its rotation, `R` is that of the parent.
void move_node(const ClosedForward& kernel, const KernelArguments<double>& a, const NodeMotion* up, int i, const Mat3T<One>& R,
               NodeMotion& to) {
  const NodeOrder& o = a.order[i];
  V3<One> p{0, 0, 0}, w{0, 0, 0}, v{0, 0, 0};
  if (up != nullptr) {
    p = vector_of<One>(up->p);
    w = vector_of<One>(up->w);
    v = vector_of<One>(up->v);
  }
  const V3<One> arm = R * kernel.pass().origin(i);
  v += cross(w, arm);
  if (o.kind == NodeKind::prismatic || o.kind == NodeKind::helical) {
    const NodeConstants<double>& k = a.constants[i];
    const V3<One> z{k.R[2], k.R[5], k.R[8]};
    v += R * (z * One(k.sign * (o.kind == NodeKind::helical ? k.pitch : 1.0) * a.v[o.v]));
  }
  if (o.kind == NodeKind::floating) v += R * (matrix_of<One>(a.constants[i].R) * V3<One>{a.v[o.v + 3], a.v[o.v + 4], a.v[o.v + 5]});
  store(p + arm, to.p);
  store(matrix_of<One>(to.R) * kernel.angular_velocity(i), to.w);
  store(v, to.v);
}

/// Motions of the wanted nodes, from the base on.
void move_nodes(const ClosedForward& kernel, const KernelArguments<double>& a, const ClosedArguments& c) {
  for (int i = 0; i < a.nodes; ++i) {
    if (c.moves[i] == NodeWanted::nothing) continue;
    const NodeOrder& o = a.order[i];
    NodeMotion& to = c.motion[i];
    const NodeMotion* const up = o.parent >= 0 ? c.motion + o.parent : nullptr;
    const Mat3T<One> R_up = up != nullptr ? matrix_of<One>(up->R) : Mat3T<One>::identity();
    const Mat3T<One> R = turned(kernel.pass(), o, i, R_up);
    store(R.row(0), to.R);
    store(R.row(1), to.R + 3);
    store(R.row(2), to.R + 6);
    if (c.moves[i] == NodeWanted::motion)
      move_node(kernel, a, up, i, R_up, to);
    else
      store(kernel.angular_velocity(i), to.spin);
  }
}

void closed_motion(const KernelArguments<double>& a, const ClosedArguments& c) {
  ClosedForward kernel(a, LoopPass<One>(c));
  if (c.twins == nullptr) {
    kernel.turn_all();
  } else {
    twins::Forward open(*c.twins);
    open.turn();
    open.for_each_node([&](int node, const auto& part, int its_node, int lane) {
      if (c.moves[node] != NodeWanted::nothing) kernel.copy_turning(node, part, its_node, lane);
    });
    kernel.rest_base();
  }
  move_nodes(kernel, a, c);
}

bool closed_forward(const KernelArguments<double>& a, const ClosedArguments& c) {
  return !ClosedForward(a, LoopPass<One>(c)).accelerate()[0];
}

bool closed_forward_by_paths(const KernelArguments<double>& a, const ClosedArguments& c) { return PathForward(a, c).run(); }

}  // namespace

namespace UGOKI_WIDTH {
extern const ClosedKernels closed_table;
const ClosedKernels closed_table = {closed_motion, closed_forward, closed_forward_by_paths};
}  // namespace UGOKI_WIDTH

}  // namespace ugoki::dynamics
