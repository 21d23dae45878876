#pragma once
// Inverse and forward dynamics and inertia matrix of one instance with twins (link_twins.h): the kernels of the trunk, and of each pair in
// two lanes. For kernels_*.cpp only.

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

/// Numbers of a pair side by side, from those of the whole and back.
UGOKI_INLINE void gather_places(const TwinArguments& a, const TwinArguments::Pair& p) {
  for (int i = 0; i < 2 * p.nq; ++i) p.q[i] = a.trunk.q[p.q_of[i]];
}
UGOKI_INLINE void gather(const TwinArguments& a, const TwinArguments::Pair& p) {
  gather_places(a, p);
  for (int i = 0; i < 2 * p.a.nv; ++i) p.v[i] = a.trunk.v[p.v_of[i]];
  if (a.trunk.in == nullptr) return;
  for (int i = 0; i < 2 * p.a.nv; ++i) p.in[i] = a.trunk.in[p.v_of[i]];
}
UGOKI_INLINE void scatter(const TwinArguments& a, const TwinArguments::Pair& p) {
  for (int i = 0; i < 2 * p.a.nv; ++i) a.trunk.out[p.v_of[i]] = p.a.out[i];
}

/// Sines and cosines of all parts.
UGOKI_INLINE void prepare(const TwinArguments& a) { sines_of(a.trunk.q, a.angle_q, a.angle_sign, a.angles, a.trunk.sin, a.trunk.cos); }

class Forward {
 public:
  using Trunk = ForwardKernel<One>;
  using Twins = ForwardKernel<Two, NoLoops, Both>;

  explicit Forward(const TwinArguments& a) : a_(a), trunk_(a.trunk) {
    for (int i = 0; i < a.pair_count; ++i) new (pairs_[i].bytes) Twins(a.pairs[i].a);
  }
  Forward(const Forward&) = delete;
  Forward& operator=(const Forward&) = delete;

  /// @return false: singular
  bool run() {
    turn();
    condense();
    return move();
  }

  void turn() {
    prepare(a_);
    trunk_.turn_all();
    for (int i = 0; i < a_.pair_count; ++i) {
      gather(a_, a_.pairs[i]);
      pair(i).turn_all(both(trunk_.angular_velocity(a_.pairs[i].base)));
    }
  }
  /// On what turn() left in the scratch.
  void condense() {
    for (int i = 0; i < a_.pair_count; ++i) {
      pair(i).condense();
      take(pair(i), a_.pairs[i]);
    }
    trunk_.take_twins(handed_on_);
    trunk_.condense();
  }
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
  /// f(kernel, pair)
  template <class F>
  UGOKI_INLINE void for_each_pair(F&& f) {
    for (int i = 0; i < a_.pair_count; ++i) f(pair(i), a_.pairs[i]);
  }

  /// f(node of the whole program, kernel, its node, its lane)
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

  void take(const Twins& pair, const TwinArguments::Pair& p) {
    const Articulated<Two>& A = pair.handed_on();
    const Articulated<One> sum{total(A.I), total(A.H), total(A.M), total(A.n), total(A.f)};
    if (p.first)
      handed_on_[p.place] = sum;
    else
      add(handed_on_[p.place], sum);
    bad_ = bad_ || any(pair.bad());
  }

  const TwinArguments& a_;
  Trunk trunk_;
  PairMemory pairs_[TwinArguments::most_pairs];  // the first pair_count hold a kernel
  Articulated<One> handed_on_[TwinArguments::most_pairs];
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
    pair.press();
    scatter(a, a.pairs[i]);
    trunk.take(a.pairs[i].base, total(pair.handed_on().n), total(pair.handed_on().f));
  }
  trunk.press();
}

inline void inertia(const TwinArguments& a) {
  prepare(a);
  using Trunk = InertiaKernel<One>;
  Trunk::Twins handed_on[TwinArguments::most_pairs];
  for (int i = 0; i < a.pair_count; ++i) {
    const TwinArguments::Pair& p = a.pairs[a.pair_count - 1 - i];  // their forces come in rising order
    gather_places(a, p);
    InertiaKernel<Two, Both> pair(p.a);
    pair.run();
    const InertiaT<Two>& C = pair.handed_on();
    handed_on[i] = {{total(C.mass), total(C.h), total(C.I)}, {}, p.force_begin, 0, p.place};
    pair.hand_on_forces(handed_on[i]);
  }
  Trunk trunk(a.trunk);
  trunk.take_twins(handed_on, a.pair_count);
  trunk.run();
}

}  // namespace twins

}  // namespace
}  // namespace ugoki::dynamics
