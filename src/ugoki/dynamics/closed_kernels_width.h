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

/// Motions of the wanted nodes, from the base on.
void move_nodes(const ClosedForward& kernel, const KernelArguments<double>& a, const ClosedArguments& c) {
  const Pass<One>& pass = kernel.pass();
  for (int i = 0; i < a.nodes; ++i) {
    if (!c.moves[i]) continue;
    const NodeOrder& o = a.order[i];
    NodeMotion& to = c.motion[i];
    const V3<One> r = pass.origin(i);
    Mat3T<One> R = Mat3T<One>::identity();  // columns: the world's axes in the parent's, turned below
    V3<One> p{0, 0, 0}, w{0, 0, 0}, v{0, 0, 0};
    if (o.parent >= 0) {
      const NodeMotion& up = c.motion[o.parent];
      R = matrix_of<One>(up.R);
      p = vector_of<One>(up.p);
      w = vector_of<One>(up.w);
      v = vector_of<One>(up.v);
    }
    const V3<One> arm = R * r;
    v += cross(w, arm);
    if (o.kind == NodeKind::prismatic || o.kind == NodeKind::helical) {
      const NodeConstants<double>& k = a.constants[i];
      const V3<One> z{k.R[2], k.R[5], k.R[8]};
      v += R * (z * One(k.sign * (o.kind == NodeKind::helical ? k.pitch : 1.0) * a.v[o.v]));
    }
    if (o.kind == NodeKind::floating) v += R * (matrix_of<One>(a.constants[i].R) * V3<One>{a.v[o.v + 3], a.v[o.v + 4], a.v[o.v + 5]});
    const V3<One> x = pass.down(i, R.row(0)), y = pass.down(i, R.row(1)), z = pass.down(i, R.row(2));
    store(x, to.R);
    store(y, to.R + 3);
    store(z, to.R + 6);
    store(p + arm, to.p);
    const V3<One> spin = kernel.angular_velocity(i);
    store({dot(x, spin), dot(y, spin), dot(z, spin)}, to.w);
    store(v, to.v);
  }
}

void closed_motion(const KernelArguments<double>& a, const ClosedArguments& c) {
  ClosedForward kernel(a, LoopPass<One>(c));
  kernel.turn_all();
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
