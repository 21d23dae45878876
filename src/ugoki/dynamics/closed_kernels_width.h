#pragma once
// The table of closed kernels of one SIMD width. Each closed_kernels_*.cpp defines UGOKI_WIDTH and UGOKI_DOUBLE_LANES and includes this
// header once.

#include "ugoki/dynamics/kernel_paths.h"

namespace ugoki::dynamics {
namespace {

using One = Lanes<double, 1>;
using ClosedForward = ForwardKernel<One, LoopPass<One>>;

template <class T>
Mat3T<T> of_rows(const V3<T>& x, const V3<T>& y, const V3<T>& z) {
  return {x.x, x.y, x.z, y.x, y.y, y.z, z.x, z.y, z.z};
}

template <Crossing K, class P, class T>
UGOKI_INLINE Mat3T<T> turned(const P& pass, const NodeOrder& o, const Mat3T<T>& R) {
  const RevoluteCrossing<T, K> X = pass.template revolute<K>(o);
  return of_rows(X.down(R.row(0)), X.down(R.row(1)), X.down(R.row(2)));
}
/// Matrix whose rows are the rows of R, converted from the axes of the parent to the axes of node i.
template <class P, class T>
UGOKI_INLINE Mat3T<T> turned(const P& pass, const NodeOrder& o, int i, const Mat3T<T>& R) {
  switch (o.crossing) {
    case Crossing::none: return turned<Crossing::none>(pass, o, R);
    case Crossing::cycle: return turned<Crossing::cycle>(pass, o, R);
    case Crossing::cycle_back: return turned<Crossing::cycle_back>(pass, o, R);
    case Crossing::matrix: break;
  }
  return of_rows(pass.down(i, R.row(0)), pass.down(i, R.row(1)), pass.down(i, R.row(2)));
}

/// Pose and velocity of a node (see NodeMotion), one value per SIMD lane.
template <class T>
struct Moving {
  Mat3T<T> R;
  V3<T> p, w, v;
};

/// Sets to.p and to.v of node i; to.R and to.w are already set. @param up motion of the parent
template <class T, class Kernel, class Arguments>
UGOKI_INLINE void move_node(const Kernel& kernel, const Arguments& a, const Moving<T>& up, int i, Moving<T>& to) {
  const NodeOrder& o = a.order[i];
  const auto& k = a.constants[i];
  const V3<T> arm = up.R * kernel.pass().origin(i);
  const auto rate = [&](int f) { return load<T>(a.v, o.v + f, a.stride); };
  to.p = up.p + arm;
  to.v = up.v + cross(up.w, arm);
  if (o.kind == NodeKind::prismatic || o.kind == NodeKind::helical) {
    const T lead = o.kind == NodeKind::helical ? T(k.sign) * T(k.pitch) : T(k.sign);
    to.v += up.R * (V3<T>{T(k.R[2]), T(k.R[5]), T(k.R[8])} * (lead * rate(0)));
  }
  if (o.kind == NodeKind::floating) to.v += up.R * (matrix_of<T>(k.R) * V3<T>{rate(3), rate(4), rate(5)});
}

/// Computes the motions of the requested nodes of `kernel`. Call its turn_all() first.
/// @param rotations true: only R is computed @param base motion of the kernel's base
/// @param wanted (node) -> NodeWanted @param receive (node, Moving), called for every requested node, but not for NodeWanted::passage
/// @return [nodes] motions, valid for the requested nodes; stored in the kernel's free scratch memory
template <class T, class Kernel, class Arguments, class Wanted, class Receive>
const Moving<T>* move_nodes(const Kernel& kernel, const Arguments& a, bool rotations, const Moving<T>& base, Wanted&& wanted,
                            Receive&& receive) {
  Scratch scratch = kernel.free_scratch();
  Moving<T>* const all = scratch.take<Moving<T>>(a.nodes);
  for (int i = 0; i < a.nodes; ++i) {
    const NodeWanted want = wanted(i);
    if (want == NodeWanted::nothing) continue;
    const NodeOrder& o = a.order[i];
    const Moving<T>& up = o.parent < 0 ? base : all[o.parent];
    Moving<T>& to = all[i];
    to.R = turned(kernel.pass(), o, i, up.R);
    if (!rotations) {
      to.w = to.R * kernel.angular_velocity(i);
      move_node(kernel, a, up, i, to);
    }
    if (want != NodeWanted::passage) receive(i, to);
  }
  return all;
}

/// Writes one lane of a motion from move_nodes() to `to`. @param rotation true: only R and spin are written
template <class T>
void store(const Moving<T>& from, bool rotation, const V3<T>& spin, int lane, NodeMotion& to) {
  const auto value = [&](const T& x) {
    if constexpr (T::count == 1)
      return x.v;
    else
      return x.v[lane];
  };
  const auto put = [&](const V3<T>& x, double* target) {
    target[0] = value(x.x);
    target[1] = value(x.y);
    target[2] = value(x.z);
  };
  for (int k = 0; k < 3; ++k) put(from.R.row(k), to.R + 3 * k);
  if (rotation) {
    put(spin, to.spin);
  } else {
    put(from.p, to.p);
    put(from.w, to.w);
    put(from.v, to.v);
  }
}

void closed_motion(const KernelArguments<double>& a, const ClosedArguments& c) {
  ClosedForward kernel(a, LoopPass<One>(c));
  const One none(0);
  const V3<One> zero{none, none, none};
  const Moving<One> world{Mat3T<One>::identity(), zero, zero, zero};
  if (c.twins == nullptr) {
    kernel.turn_all();
    move_nodes(
        kernel, a, c.world_bound, world, [&](int i) { return c.needed[i]; },
        [&](int i, const Moving<One>& m) { store(m, c.world_bound, kernel.angular_velocity(i), 0, c.motion[i]); });
    return;
  }
  twins::Forward open(*c.twins);
  open.turn();
  open.for_each_node([&](int node, const auto& part, int its_node, int lane) {
    if (c.needed[node] != NodeWanted::nothing) kernel.copy_turning(node, part, its_node, lane);
  });
  kernel.rest_base();
  const twins::Forward::Trunk& trunk = open.trunk();
  const int* const trunk_node = c.twins->trunk_node;
  const Moving<One>* const trunk_moving = move_nodes(
      trunk, c.twins->trunk, c.world_bound, world, [&](int i) { return c.needed[trunk_node[i]]; },
      [&](int i, const Moving<One>& m) { store(m, c.world_bound, trunk.angular_velocity(i), 0, c.motion[trunk_node[i]]); });
  open.for_each_pair([&](const auto& pair, const TwinArguments::Pair& p) {
    const NodeWanted* const needed = c.needed;
    const int* const node = p.node;
    const auto wanted = [&](int i) {
      return needed[node[2 * i]] < needed[node[2 * i + 1]] ? needed[node[2 * i + 1]] : needed[node[2 * i]];
    };
    if (wanted(0) == NodeWanted::nothing) return;
    const Moving<One>& up = trunk_moving[p.base];
    move_nodes(pair, p.a, c.world_bound, Moving<twins::Two>{twins::both(up.R), twins::both(up.p), twins::both(up.w), twins::both(up.v)},
               wanted, [&](int i, const Moving<twins::Two>& m) {
                 for (int lane = 0; lane < 2; ++lane) store(m, c.world_bound, pair.angular_velocity(i), lane, c.motion[node[2 * i + lane]]);
               });
  });
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
