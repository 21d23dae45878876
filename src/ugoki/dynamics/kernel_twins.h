#pragma once
// Inverse dynamics, forward dynamics and inertia matrix of one instance with twins (link_twins.h): runs the kernel of the trunk in one lane
// and the kernel of each pair of twins in two lanes. For kernels_*.cpp only.

#include <new>
#include <type_traits>

#include "ugoki/dynamics/kernel_forward.h"
#include "ugoki/dynamics/kernel_inertia.h"
#include "ugoki/dynamics/kernel_inverse.h"

namespace ugoki::dynamics {
namespace {  // NOLINT(google-build-namespaces): see spatial/lanes.h

namespace twins {
using One = Lanes<double, 1>;
using Two = Lanes<double, 2>;
using Both = LaneArray<double, 2>;

UGOKI_INLINE V3<Two> both(const V3<One>& x) { return {Two(x.x.v), Two(x.y.v), Two(x.z.v)}; }
UGOKI_INLINE Mat3T<Two> both(const Mat3T<One>& m) {
  return {Two(m.xx.v), Two(m.xy.v), Two(m.xz.v), Two(m.yx.v), Two(m.yy.v), Two(m.yz.v), Two(m.zx.v), Two(m.zy.v), Two(m.zz.v)};
}
UGOKI_INLINE One total(Two x) { return x.v[0] + x.v[1]; }
UGOKI_INLINE V3<One> total(const V3<Two>& x) { return {total(x.x), total(x.y), total(x.z)}; }
UGOKI_INLINE Sym3T<One> total(const Sym3T<Two>& s) {
  return {total(s.xx), total(s.yy), total(s.zz), total(s.xy), total(s.xz), total(s.yz)};
}
UGOKI_INLINE Mat3T<One> total(const Mat3T<Two>& m) {
  return {total(m.xx), total(m.xy), total(m.xz), total(m.yx), total(m.yy), total(m.yz), total(m.zx), total(m.zy), total(m.zz)};
}

// Copy the values of a pair of twins (link_twins.h) between the mechanism's arrays and the pair's two-lane arrays. gather() copies into the
// lanes, scatter() copies back.
UGOKI_INLINE void gather_coordinates(const TwinArguments& a, const TwinArguments::Pair& p) {
  for (int i = 0; i < 2 * p.nq; ++i) p.q[i] = a.trunk.q[p.q_of[i]];
}
UGOKI_INLINE void gather(const TwinArguments& a, const TwinArguments::Pair& p) {
  gather_coordinates(a, p);
  for (int i = 0; i < 2 * p.a.nv; ++i) p.v[i] = a.trunk.v[p.v_of[i]];
  if (a.trunk.in == nullptr) return;
  for (int i = 0; i < 2 * p.a.nv; ++i) p.in[i] = a.trunk.in[p.v_of[i]];
}
UGOKI_INLINE void scatter(const TwinArguments& a, const TwinArguments::Pair& p) {
  for (int i = 0; i < 2 * p.a.nv; ++i) a.trunk.out[p.v_of[i]] = p.a.out[i];
}

/// Computes sines and cosines of the joint angles of the trunk and all pairs of twins.
UGOKI_INLINE void prepare(const TwinArguments& a) { sines_of(a.trunk.q, a.angle_q, a.angle_sign, a.angles, a.trunk.sin, a.trunk.cos); }

/// Forward dynamics with twins. The steps of run() are public for kernel_paths.h.
class Forward {
 public:
  using Trunk = ForwardKernel<One>;
  using Twins = ForwardKernel<Two, NoLoops, Both>;

  explicit Forward(const TwinArguments& a) : a_(a), trunk_(a.trunk) {
    for (int i = 0; i < a.pair_count; ++i) new (pairs_[i].bytes) Twins(a.pairs[i].a);
  }
  Forward(const Forward&) = delete;
  Forward& operator=(const Forward&) = delete;

  /// @return false: singular inertia
  bool run() {
    turn();
    condense();
    return move();
  }

  /// Computes joint rotations and angular velocities of all nodes.
  void turn() {
    prepare(a_);
    trunk_.turn_all();
    for (int i = 0; i < a_.pair_count; ++i) {
      gather(a_, a_.pairs[i]);
      pair(i).turn_all(both(trunk_.angular_velocity(a_.pairs[i].base)));
    }
  }
  /// Inward sweep of the pairs and the trunk. Call turn() first.
  void condense() {
    for (int i = 0; i < a_.pair_count; ++i) {
      pair(i).condense();
      add_to_base(pair(i), a_.pairs[i]);
    }
    trunk_.set_twins(passed_up_);
    trunk_.condense();
  }
  /// Outward sweep. Call condense() first. @return false: singular inertia
  bool move() {
    trunk_.move();
    for (int i = 0; i < a_.pair_count; ++i) {
      const Vec6T<One>& base = trunk_.acceleration(a_.pairs[i].base);
      pair(i).move({both(base.w), both(base.v)});
      scatter(a_, a_.pairs[i]);
    }
    return !bad_ && !trunk_.bad()[0];
  }

  [[nodiscard]] const Trunk& trunk() const { return trunk_; }
  /// Calls f(kernel of the pair, TwinArguments::Pair) for each pair.
  template <class F>
  UGOKI_INLINE void for_each_pair(F&& f) {
    for (int i = 0; i < a_.pair_count; ++i) f(pair(i), a_.pairs[i]);
  }

  /// Calls f(node of the LinkProgram, kernel that computes it, node index in that kernel, lane in that kernel) for each node.
  template <class F>
  UGOKI_INLINE void for_each_node(F&& f) {
    for (int i = 0; i < a_.trunk.nodes; ++i) f(a_.trunk_node[i], trunk_, i, 0);
    for (int p = 0; p < a_.pair_count; ++p) {
      Twins& x = pair(p);
      for (int i = 0; i < 2 * a_.pairs[p].a.nodes; ++i) f(a_.pairs[p].node[i], x, i / 2, i % 2);
    }
  }

 private:
  static_assert(std::is_trivially_destructible_v<Twins>);
  struct alignas(Twins) PairMemory {
    std::byte bytes[sizeof(Twins)];
  };
  UGOKI_INLINE Twins& pair(int i) { return *std::launder(reinterpret_cast<Twins*>(pairs_[i].bytes)); }

  void add_to_base(const Twins& pair, const TwinArguments::Pair& p) {
    const Articulated<Two>& A = pair.passed_up();
    const Articulated<One> sum{total(A.I), total(A.H), total(A.M), total(A.n), total(A.f)};
    if (p.first)
      passed_up_[p.twin_slot] = sum;
    else
      add(passed_up_[p.twin_slot], sum);
    bad_ = bad_ || any(pair.bad());
  }

  const TwinArguments& a_;
  Trunk trunk_;
  PairMemory pairs_[TwinArguments::max_pairs];  // kernels are constructed in the first pair_count entries
  Articulated<One> passed_up_[TwinArguments::max_pairs];
  bool bad_ = false;
};

inline void inverse(const TwinArguments& a) {
  prepare(a);
  using Trunk = InverseKernel<One>;
  using Twins = InverseKernel<Two, Both>;
  Trunk trunk(a.trunk);
  const One none(0);
  const V3<One> zero{none, none, none};
  trunk.move({{none, none, none, none, none, none, none, none, none}, -vector_of<One>(a.trunk.gravity), zero, zero});
  for (int i = 0; i < a.pair_count; ++i) {
    gather(a, a.pairs[i]);
    Twins pair(a.pairs[i].a);
    const Trunk::Motion& base = trunk.motion(a.pairs[i].base);
    pair.move({both(base.K), both(base.a), both(base.w), both(base.wd)});
    pair.propagate_forces();
    scatter(a, a.pairs[i]);
    trunk.add_force(a.pairs[i].base, total(pair.passed_up().n), total(pair.passed_up().f));
  }
  trunk.propagate_forces();
}

inline void inertia(const TwinArguments& a) {
  prepare(a);
  using Trunk = InertiaKernel<One>;
  Trunk::Twins passed_up[TwinArguments::max_pairs];
  for (int i = 0; i < a.pair_count; ++i) {
    const TwinArguments::Pair& p = a.pairs[a.pair_count - 1 - i];  // reversed, so that force_begin ascends
    gather_coordinates(a, p);
    InertiaKernel<Two, Both> pair(p.a);
    pair.run();
    const InertiaT<Two>& C = pair.passed_up();
    passed_up[i] = {{total(C.mass), total(C.h), total(C.I)}, {}, p.force_begin, 0, p.twin_slot};
    pair.pass_up_forces(passed_up[i]);
  }
  Trunk trunk(a.trunk);
  trunk.set_twins(passed_up, a.pair_count);
  trunk.run();
}

}  // namespace twins

}  // namespace
}  // namespace ugoki::dynamics
