#pragma once
// Inverse dynamics from (q, v, vdot) in two sweeps: recursive Newton-Euler in the nodes' frames.
//
// The acceleration of a node is that of the material point at its origin, (w', a), not the spatial acceleration. Of the velocities, only
// the angular velocity w is then needed. For a revolute joint about z with rate v, parent P, r the node's origin in the parent's frame, and
// E the rotation from the node's axes to the parent's axes:
//   w = E^T w_P + z v        w' = E^T w'_P + (E^T w_P) x z v + z vdot        a = E^T (a_P + w'_P x r + w_P x (w_P x r))
//   K = [w'x] + [wx] [wx]    f = m a + K h        n = vee(K Sigma - (K Sigma)^T) + h x a
// [wx] is the matrix of the cross product and vee its inverse. m, h and I are mass, first moment and inertia about the node's origin.
// Sigma = tr(I)/2 1 - I are the second moments of mass, so that n = I w' + w x I w + h x a.
// Sources: Luh, Walker, Paul (1980); Featherstone (2008), ch. 5. For kernels_*.cpp only.

#include "ugoki/dynamics/kernel_crossing.h"

namespace ugoki::dynamics {
namespace {  // NOLINT(google-build-namespaces): see spatial/lanes.h

/// Inverse dynamics of the nodes that KernelArguments lists: a whole mechanism, its trunk, or a pair of twins, two subtrees
/// of the same structure (link_twins.h).
/// @tparam Constant LaneArray for a pair of twins. The base is then not the world, but the node that is the parent of both subtrees.
template <class T, class Constant = typename T::Real>
class InverseKernel {
 public:
  using Real = typename T::Real;

  explicit InverseKernel(const KernelArguments<Real, Constant>& arguments)
      : pass_(arguments),
        a_(pass_.a),
        motion_(pass_.scratch.template take<Motion>(a_.nodes + 1)),
        force_(pass_.scratch.template take<Force>(a_.nodes + 1)) {}

  /// Motion of a node, in its own axes.
  struct Motion {
    Mat3T<T> K;      ///< matrix with K r = w' x r + w x (w x r) for every r
    V3<T> a, w, wd;  ///< acceleration of the origin, angular velocity, angular acceleration w'
  };
  /// Wrench in a node's axes: moment n about its origin, N m, and force f, N.
  struct Force {
    V3<T> n, f;
  };

  void run() {
    const T none(0);
    const V3<T> zero{none, none, none};
    move({{none, none, none, none, none, none, none, none, none}, -vector_of<T>(a_.gravity), zero, zero});
    propagate_forces();
  }

  /// Outward sweep: motions of all nodes, and the force that each node's own body needs. @param base motion of the base
  void move(const Motion& base) {
    pass_.prepare();
    pass_.transform_wrenches();
    motion_[0] = base;
    for (int i = 0; i < a_.nodes; ++i) {
      switch (a_.order[i].crossing) {
        case Crossing::none: outward_revolute<Crossing::none>(i); break;
        case Crossing::cycle: outward_revolute<Crossing::cycle>(i); break;
        case Crossing::cycle_back: outward_revolute<Crossing::cycle_back>(i); break;
        case Crossing::matrix: outward(i); break;
      }
    }
  }

  /// Inward sweep: joint forces, and the forces that nodes pass to their parents.
  void propagate_forces() {
    for (int i = a_.nodes; i-- > 0;) {
      switch (a_.order[i].crossing) {
        case Crossing::none: inward_revolute<Crossing::none>(i); break;
        case Crossing::cycle: inward_revolute<Crossing::cycle>(i); break;
        case Crossing::cycle_back: inward_revolute<Crossing::cycle_back>(i); break;
        case Crossing::matrix: inward(i); break;
      }
    }
  }

  [[nodiscard]] const Motion& motion(int i) const { return motion_[i + 1]; }
  /// Force that each of the two twins passes to the base, one twin per lane, in the base's frame.
  [[nodiscard]] const Force& passed_up() const { return passed_up_; }
  /// Adds a moment n and a force f to node `i`, in the node's axes about its origin. Call it between move() and propagate_forces().
  void add_force(int i, const V3<T>& n, const V3<T>& f) {
    force_[i].n += n;
    force_[i].f += f;
  }

 private:
  static constexpr bool twins = !std::is_same_v<Constant, Real>;

  // A batch stores motions by tree level: only the current node and its ancestors are kept, so the scratch memory fits in the L1 cache.
  static constexpr bool by_level = T::count > 1 && !twins;
  UGOKI_INLINE int state_index(int i) const { return (by_level ? a_.order[i].level : i) + 1; }
  UGOKI_INLINE static int parent_state(const NodeOrder& o) { return by_level ? o.level : o.parent + 1; }

  UGOKI_INLINE T v(int k) const { return load<T>(a_.v, k, a_.stride); }
  UGOKI_INLINE T vdot(int k) const { return a_.in == nullptr ? T(0) : load<T>(a_.in, k, a_.stride); }
  UGOKI_INLINE void write_out(int k, T tau) const { tau.store(a_.out + k * a_.stride); }

  /// Stores the motion of node `i`. Also stores the force that its own body needs for this motion, minus the external wrench.
  UGOKI_INLINE void finish(int i, const V3<T>& w, const V3<T>& wd, const V3<T>& a) {
    const NodeConstants<Constant>& c = a_.constants[i];
    const T xx = w.x * w.x, yy = w.y * w.y, zz = w.z * w.z, xy = w.x * w.y, xz = w.x * w.z, yz = w.y * w.z;
    const Mat3T<T> K{-(yy + zz), xy - wd.z, xz + wd.y, xy + wd.z, -(xx + zz), yz - wd.x, xz - wd.y, yz + wd.x, -(xx + yy)};
    const NodeOrder& o = a_.order[i];
    Motion& m = motion_[state_index(i)];
    if (o.children_offset) m.K = K;
    m.a = a;
    m.w = w;
    m.wd = wd;
    Force& g = force_[i];
    if (o.massless) {
      const T none(0);
      g = {{none, none, none}, {none, none, none}};
    } else {
      const Sym3T<T> S = symmetric_of<T>(c.second);
      V3<T> f = a * T(c.mass), n{K.zy * S.yy - K.yz * S.zz, K.xz * S.zz - K.zx * S.xx, K.yx * S.xx - K.xy * S.yy};
      if (o.oblique) {
        n.x += (K.zx * S.xy + K.zz * S.yz) - (K.yx * S.xz + K.yy * S.yz);
        n.y += (K.xx * S.xz + K.xy * S.yz) - (K.zy * S.xy + K.zz * S.xz);
        n.z += (K.yy * S.xy + K.yz * S.xz) - (K.xx * S.xy + K.xz * S.yz);
      }
      add_product(f, K, o.moment, c.h);
      add_cross(n, o.moment, c.h, a);
      g = {n, f};
    }
    if (pass_.wrench != nullptr) {
      g.n -= pass_.wrench[i].w;
      g.f -= pass_.wrench[i].v;
    }
  }

  template <Crossing K>
  UGOKI_INLINE void outward_revolute(int i) {
    const NodeOrder& o = a_.order[i];
    const NodeConstants<Constant>& c = a_.constants[i];
    const RevoluteCrossing<T, K> X = pass_.template revolute<K>(o);
    const Motion& p = motion_[parent_state(o)];
    V3<T> a = p.a;
    add_product(a, p.K, o.offset, c.p);
    a = X.down(a);
    const V3<T> w = X.down(p.w), wd = X.down(p.wd);
    const T rate = with_sign(o, c, v(o.v));
    finish(i, {w.x, w.y, w.z + rate}, {wd.x + w.y * rate, wd.y - w.x * rate, wd.z + with_sign(o, c, vdot(o.v))}, a);
  }

  void outward(int i) {
    const NodeOrder& o = a_.order[i];
    const NodeConstants<Constant>& c = a_.constants[i];
    const Motion& p = motion_[parent_state(o)];
    V3<T> w = pass_.down(i, p.w), wd = pass_.down(i, p.wd), a = p.a;
    if (o.kind == NodeKind::revolute)
      add_product(a, p.K, o.offset, c.p);
    else
      a += p.K * pass_.origin(i);
    a = pass_.down(i, a);
    const T sign(c.sign), two(2);
    if (o.kind == NodeKind::revolute || o.kind == NodeKind::helical) {
      const T rate = v(o.v) * sign;
      wd = {wd.x + w.y * rate, wd.y - w.x * rate, wd.z + vdot(o.v) * sign};
      w.z += rate;
    }
    if (o.kind == NodeKind::prismatic || o.kind == NodeKind::helical) {
      const T lead = o.kind == NodeKind::helical ? sign * T(c.pitch) : sign;
      const T rate = v(o.v) * lead;
      a += V3<T>{two * w.y * rate, -(two * w.x * rate), vdot(o.v) * lead};
    }
    if (o.kind == NodeKind::spherical || o.kind == NodeKind::floating) {
      const V3<T> spin{v(o.v), v(o.v + 1), v(o.v + 2)};
      wd += cross(w, spin) + V3<T>{vdot(o.v), vdot(o.v + 1), vdot(o.v + 2)};
      w += spin;
      if (o.kind == NodeKind::floating) a += transpose_times(pass_.E[i], V3<T>{vdot(o.v + 3), vdot(o.v + 4), vdot(o.v + 5)});
    }
    finish(i, w, wd, a);
  }

  /// Adds a node's moment n and force f to its parent. @param n, f in the parent's axes about the parent's origin
  UGOKI_INLINE void pass_up(const NodeOrder& o, const V3<T>& n, const V3<T>& f) {
    if (!twins && o.parent < 0) return;
    if (twins && o.parent < 0) {
      passed_up_ = {n, f};
      return;
    }
    Force& g = force_[o.parent];
    g.f += f;
    g.n += n;
  }

  template <Crossing K>
  UGOKI_INLINE void inward_revolute(int i) {
    const NodeOrder& o = a_.order[i];
    const NodeConstants<Constant>& c = a_.constants[i];
    const Force g = force_[i];
    const T along = with_sign(o, c, g.n.z);
    write_out(o.v, o.has_armature ? along + T(c.armature[0]) * vdot(o.v) : along);
    const RevoluteCrossing<T, K> X = pass_.template revolute<K>(o);
    V3<T> n = X.up(g.n);
    const V3<T> f = X.up(g.f);
    add_cross(n, o.offset, c.p, f);
    pass_up(o, n, f);
  }

  void inward(int i) {
    const NodeOrder& o = a_.order[i];
    const NodeConstants<Constant>& c = a_.constants[i];
    const Force g = force_[i];
    const auto drive = [&](int k, T along) { write_out(o.v + k, along + T(c.armature[k]) * vdot(o.v + k)); };
    switch (o.kind) {
      case NodeKind::revolute: drive(0, g.n.z * T(c.sign)); break;
      case NodeKind::prismatic: drive(0, g.f.z * T(c.sign)); break;
      case NodeKind::helical: drive(0, (g.n.z + g.f.z * T(c.pitch)) * T(c.sign)); break;
      case NodeKind::spherical:
      case NodeKind::floating:
        drive(0, g.n.x);
        drive(1, g.n.y);
        drive(2, g.n.z);
        if (o.kind == NodeKind::floating) {
          const V3<T> f = pass_.E[i] * g.f;
          drive(3, f.x);
          drive(4, f.y);
          drive(5, f.z);
        }
        break;
    }
    if (!twins && o.parent < 0) return;
    const MatrixCrossing<T> X{pass_.E[i]};
    const V3<T> f = X.up(g.f);
    pass_up(o, X.up(g.n) + cross(pass_.origin(i), f), f);
  }

  Pass<T, Constant> pass_;
  const KernelArguments<Real, Constant>& a_;
  Motion* motion_;  // [nodes + 1] at state_index(), the world first
  Force* force_;    // [nodes] force that the node's body needs; in the inward sweep, plus those of its children
  Force passed_up_;
};

}  // namespace
}  // namespace ugoki::dynamics
