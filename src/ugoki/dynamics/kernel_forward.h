#pragma once
// Forward dynamics from (q, v, tau) in three sweeps: the articulated-body algorithm in the nodes' frames.
//
// The acceleration of a node is that of the material point at its origin, as in kernel_inverse.h:
//   a_i = X a_P + c_i + S_i vdot_i,   c_i = ((E^T w_P) x s_w, E^T (w_P x (w_P x r)) + 2 w x s_v),   S v = (s_w, s_v)
//   U = IA S,  D = S^T U + armature,  u = tau - S^T (pA + IA c),  vdot = (u - U^T X a_P) / D
//   passed to the parent: IA - U U^T / D  and  pA + IA c + U u / D
// i is the node, P its parent, w the angular velocity of a node in its own axes, r the node's origin in the parent's frame, E the rotation
// to the parent's axes, X the transform of accelerations to the node. IA and pA are the articulated inertia and bias force. The column S
// of a DOF has one or two nonzero entries in the node's frame, so U is a column of IA or a sum of two columns. DOFs of one node are
// eliminated one by one. Source: Featherstone (2008), ch. 7. For kernels_*.cpp only.

#include "ugoki/dynamics/kernel_articulated.h"

namespace ugoki::dynamics {
namespace {  // NOLINT(google-build-namespaces): see spatial/lanes.h

/// The Loops policy of ForwardKernel for an open system: does nothing. LoopPass (kernel_loops.h), the policy for closed systems, describes
/// the functions.
struct NoLoops {
  static constexpr bool present_at(int) { return false; }
  template <class... A>
  UGOKI_INLINE void begin(A&&...) {}
  template <class... A>
  UGOKI_INLINE void eliminate(A&&...) {}
  template <class... A>
  UGOKI_INLINE void dof(A&&...) {}
  template <class... A>
  UGOKI_INLINE void velocity_product(A&&...) {}
  template <class... A>
  UGOKI_INLINE void pass_up(A&&...) {}
  template <class... A>
  UGOKI_INLINE void floating(A&&...) {}
  template <class... A>
  UGOKI_INLINE void eliminate_world(A&&...) {}
  template <class... A>
  UGOKI_INLINE void recover(A&&...) {}
};

/// Forward dynamics of the nodes that KernelArguments lists: a whole mechanism, its trunk, or a pair of twins, two subtrees
/// of the same structure (link_twins.h).
/// @tparam Loops NoLoops, or LoopPass, which processes the multipliers of closed loops in every elimination
/// @tparam Constant LaneArray for a pair of twins. The base is then not the world, but the node that is the parent of both subtrees.
template <class T, class Loops = NoLoops, class Constant = typename T::Real>
class ForwardKernel {
 public:
  using Real = typename T::Real;
  using Mask = typename T::Mask;

  static constexpr bool twins = !std::is_same_v<Constant, Real>;
  static constexpr bool closed = !std::is_same_v<Loops, NoLoops>;

  explicit ForwardKernel(const KernelArguments<Real, Constant>& arguments, Loops loops = {})
      : loops_(loops),
        pass_(arguments),
        a_(pass_.a),
        w_(pass_.scratch.template take<V3<T>>(a_.nodes + 1)),
        velocity_product_(pass_.scratch.template take<V3<T>>(a_.nodes)),
        dof_(pass_.scratch.template take<DofPass>(a_.nv)),
        acceleration_(pass_.scratch.template take<Vec6T<T>>(a_.nodes + 1)),
        slots_(pass_.scratch.template take<Articulated<T>>(a_.slots)) {}

  /// Runs all sweeps. @return mask of the lanes in which a pivot was not positive (singular inertia)
  Mask run() {
    turn_all();
    return accelerate();
  }

  /// Computes joint rotations and the angular velocities of all nodes. The base does not rotate.
  void turn_all() { turn_all({T(0), T(0), T(0)}); }
  /// Computes the same for a base that rotates. @param w angular velocity of the base, rad/s, in its own axes
  void turn_all(const V3<T>& w) {
    pass_.prepare();
    w_[0] = w;
    for (int i = 0; i < a_.nodes; ++i) {
      switch (a_.order[i].crossing) {
        case Crossing::none: turn_revolute<Crossing::none>(i); break;
        case Crossing::cycle: turn_revolute<Crossing::cycle>(i); break;
        case Crossing::cycle_back: turn_revolute<Crossing::cycle_back>(i); break;
        case Crossing::matrix: turn(i); break;
      }
    }
  }

  /// Sets the base's angular velocity to zero. For kernels whose nodes are set by copy_turning() instead of turn_all().
  void rest_base() { w_[0] = {T(0), T(0), T(0)}; }

  /// Inward and outward sweeps. Call turn_all() first. @return as run()
  Mask accelerate() {
    condense();
    loops_.eliminate_world(a_.nodes, acceleration_[0]);
    move();
    return bad_;
  }

  /// Inward sweep: articulated inertias, and U, 1 / D and u of all DOFs. The caller may change the reduced forces u before move().
  void condense() {
    const T none(0);
    pass_.transform_wrenches();
    loops_.begin();
    for (int i = a_.nodes; i-- > 0;) {
      switch (a_.order[i].crossing) {
        case Crossing::none: inward_revolute<Crossing::none>(i); break;
        case Crossing::cycle: inward_revolute<Crossing::cycle>(i); break;
        case Crossing::cycle_back: inward_revolute<Crossing::cycle_back>(i); break;
        case Crossing::matrix: inward(i); break;
      }
      if (i % flush_interval == 0) {
        from_child_.n = flush_tiny(from_child_.n);
        from_child_.f = flush_tiny(from_child_.f);
      }
    }
    acceleration_[0] = {{none, none, none}, -vector_of<T>(a_.gravity)};
  }

  /// Outward sweep: accelerations of all DOFs and nodes. @param base acceleration of the base, in its own axes
  void move(const Vec6T<T>& base) {
    acceleration_[0] = base;
    move();
  }
  void move() {
    for (int i = 0; i < a_.nodes; ++i) {
      switch (a_.order[i].crossing) {
        case Crossing::none: outward_revolute<Crossing::none>(i); break;
        case Crossing::cycle: outward_revolute<Crossing::cycle>(i); break;
        case Crossing::cycle_back: outward_revolute<Crossing::cycle_back>(i); break;
        case Crossing::matrix: outward(i); break;
      }
      if (i % flush_interval == 0)
        acceleration_[state_index(i)] = {flush_tiny(acceleration_[state_index(i)].w), flush_tiny(acceleration_[state_index(i)].v)};
    }
  }

  /// Angular velocity of node i in its own axes, rad/s.
  [[nodiscard]] const V3<T>& angular_velocity(int i) const { return w_[i + 1]; }
  [[nodiscard]] const Vec6T<T>& acceleration(int i) const { return acceleration_[i + 1]; }
  /// Articulated inertia that each of the two twins passes to the base, one twin per lane, in the base's frame. Valid after condense().
  [[nodiscard]] const Articulated<T>& passed_up() const { return from_child_; }
  /// Sets the articulated inertias that pairs of twins passed to nodes of this kernel. @param passed_up indexed by NodeOrder::twin_slot
  void set_twins(const Articulated<T>* passed_up) { twins_ = passed_up; }
  [[nodiscard]] Mask bad() const { return bad_; }

  /// Copies the results of turn_all() for node `i` from lane `lane` of node `j` of another kernel.
  template <class Other>
  UGOKI_INLINE void copy_turning(int i, const Other& other, int j, int lane) {
    const NodeOrder &o = a_.order[i], &x = other.a_.order[j];
    if (o.angle >= 0) {
      pass_.sin[o.angle] = one_of(other.pass_.sin[x.angle], lane);
      pass_.cos[o.angle] = one_of(other.pass_.cos[x.angle], lane);
    }
    if (o.crossing == Crossing::matrix) {
      const auto& E = other.pass_.E[j];
      pass_.E[i] = {one_of(E.xx, lane), one_of(E.xy, lane), one_of(E.xz, lane), one_of(E.yx, lane), one_of(E.yy, lane),
                    one_of(E.yz, lane), one_of(E.zx, lane), one_of(E.zy, lane), one_of(E.zz, lane)};
    }
    w_[i + 1] = one_of(other.w_[j + 1], lane);
  }
  /// Copies the results of condense() for node `i` from lane `lane` of node `j` of another kernel.
  template <class Other>
  UGOKI_INLINE void copy_dofs(int i, const Other& other, int j, int lane) {
    const NodeOrder &o = a_.order[i], &x = other.a_.order[j];
    velocity_product_[i] = one_of(other.velocity_product_[j], lane);
    for (int k = 0; k < dofs_of(o.kind); ++k) {
      const auto& f = other.dof_[x.v + k];
      dof_[o.v + k] = {{one_of(f.U.w, lane), one_of(f.U.v, lane)}, one_of(f.d, lane), one_of(f.u, lane)};
    }
  }
  /// Copies the reduced forces u of node `i` to lane `lane` of node `j` of another kernel.
  template <class Other>
  UGOKI_INLINE void copy_forces_to(Other& other, int j, int lane, int i) const {
    const NodeOrder &o = a_.order[i], &x = other.a_.order[j];
    for (int k = 0; k < dofs_of(o.kind); ++k) {
      auto& u = other.dof_[x.v + k].u;
      if constexpr (Other::lanes == 1)
        u = dof_[o.v + k].u;
      else
        u.v[lane] = dof_[o.v + k].u.v;
    }
  }
  [[nodiscard]] const Pass<T, Constant>& pass() const { return pass_; }
  /// Scratch memory that the kernel does not use before accelerate(). It has room for 18 values of T per node and two 64-byte alignments.
  [[nodiscard]] Scratch free_scratch() const { return pass_.scratch; }

 private:
  friend class PathForward;
  template <class, class, class>
  friend class ForwardKernel;

  static constexpr int lanes = T::count;
  template <class X>
  UGOKI_INLINE static Lanes<Real, 1> one_of(const X& x, int lane) {
    if constexpr (X::count == 1)
      return x;
    else
      return x.v[lane];
  }
  template <class X>
  UGOKI_INLINE static V3<Lanes<Real, 1>> one_of(const V3<X>& x, int lane) {
    return {one_of(x.x, lane), one_of(x.y, lane), one_of(x.z, lane)};
  }

  /// Elimination results of one DOF.
  struct DofPass {
    Vec6T<T> U;
    T d, u;  ///< 1 / D; reduced joint force
  };

  // The effect of a force decreases exponentially along a long chain. Values below `tiny_limit` are set to zero every `flush_interval`
  // nodes, before they become subnormal: many processors compute about 100 times more slowly with subnormal numbers.
  static constexpr int flush_interval = 16;
  static constexpr Real tiny_limit = sizeof(Real) == 8 ? Real(1e-150) : Real(1e-20);
  UGOKI_INLINE static T flush_tiny(T x) { return select(x < T(tiny_limit), select(T(-tiny_limit) < x, T(0), x), x); }
  UGOKI_INLINE static V3<T> flush_tiny(const V3<T>& x) { return {flush_tiny(x.x), flush_tiny(x.y), flush_tiny(x.z)}; }

  // A batch stores accelerations by tree level: only the current node and its ancestors are kept (reason: kernel_inverse.h).
  static constexpr bool by_level = T::count > 1 && !twins && !closed;
  UGOKI_INLINE int state_index(int i) const { return (by_level ? a_.order[i].level : i) + 1; }
  UGOKI_INLINE static int parent_state(const NodeOrder& o) { return by_level ? o.level : o.parent + 1; }

  UGOKI_INLINE T v(int k) const { return load<T>(a_.v, k, a_.stride); }
  UGOKI_INLINE T tau(int k) const { return a_.in == nullptr ? T(0) : load<T>(a_.in, k, a_.stride); }
  UGOKI_INLINE void write_out(int k, T vdot) const { vdot.store(a_.out + k * a_.stride); }
  UGOKI_INLINE T inverse_pivot(T pivot) {
    bad_ = bad_ | !(pivot > T(0));
    return T(1) / pivot;
  }

  // First sweep, outward: angular velocities.

  template <Crossing K>
  UGOKI_INLINE void turn_revolute(int i) {
    const NodeOrder& o = a_.order[i];
    V3<T> w = pass_.template revolute<K>(o).down(w_[o.parent + 1]);
    w.z += with_sign(o, a_.constants[i], v(o.v));
    w_[i + 1] = w;
  }
  void turn(int i) {
    const NodeOrder& o = a_.order[i];
    V3<T> w = pass_.down(i, w_[o.parent + 1]);
    if (o.kind == NodeKind::revolute || o.kind == NodeKind::helical) w.z += v(o.v) * T(a_.constants[i].sign);
    if (o.kind == NodeKind::spherical || o.kind == NodeKind::floating) w += V3<T>{v(o.v), v(o.v + 1), v(o.v + 2)};
    w_[i + 1] = w;
  }

  // Second sweep, inward: articulated inertias.

  /// Articulated inertia of the node: that of its own body plus those passed up by its children.
  UGOKI_INLINE Articulated<T> gather(int i) {
    const NodeOrder& o = a_.order[i];
    Articulated<T> A;
    if (o.has_child) {
      A = from_child_;
      if (!o.massless) add_body(A, o, a_.constants[i], w_[i + 1]);
    } else {
      A = body(o, a_.constants[i], w_[i + 1]);
    }
    if (pass_.wrench != nullptr) {
      A.n -= pass_.wrench[i].w;
      A.f -= pass_.wrench[i].v;
    }
    if (o.slot >= 0) add(A, slots_[o.slot]);
    if (T::count == 1 && o.twin_slot >= 0) add(A, twins_[o.twin_slot]);
    return A;
  }
  UGOKI_INLINE void pass_up(const NodeOrder& o, const Articulated<T>& A) {
    if (o.first_child || (twins && o.parent < 0)) {
      from_child_ = A;
    } else if (o.last_child) {
      slots_[a_.order[o.parent].slot] = A;
    } else {
      add(slots_[a_.order[o.parent].slot], A);
    }
  }

  template <Crossing K>
  UGOKI_INLINE void inward_revolute(int i) {
    const NodeOrder& o = a_.order[i];
    const bool has_armature = o.has_armature;
    if (closed && loops_.present_at(i)) {  // separate code for nodes with loops: the others then need fewer registers
      if (has_armature)
        eliminate_revolute<K, true, true>(i, o);
      else
        eliminate_revolute<K, false, true>(i, o);
    } else if (has_armature) {
      eliminate_revolute<K, true, false>(i, o);
    } else {
      eliminate_revolute<K, false, false>(i, o);
    }
  }
  /// Eliminates a revolute joint.
  /// @tparam has_armature the DOF has armature; without armature, the z rows of I and H passed to the parent are zero
  template <Crossing K, bool has_armature, bool loops>
  UGOKI_INLINE void eliminate_revolute(int i, const NodeOrder& o) {
    const NodeConstants<Constant>& c = a_.constants[i];
    const T none(0);
    Articulated<T> A = gather(i);
    if constexpr (loops) loops_.eliminate(i, A);
    const RevoluteCrossing<T, K> X = pass_.template revolute<K>(o);
    const V3<T> w = w_[i + 1];
    const T rate = with_sign(o, c, v(o.v));
    V3<T> c_v{none, none, none};  // in the parent's axes
    if (o.offset != 0) {
      c_v = centripetal(w_[o.parent + 1], o.offset, c.p);
      velocity_product_[i] = c_v;
    }
    const T cx = w.y * rate, cy = -(w.x * rate);
    DofPass& f = dof_[o.v];
    const V3<T> Uw{A.I.xz, A.I.yz, A.I.zz}, Uv = A.H.row(2);
    const T d = inverse_pivot(has_armature ? Uw.z + T(c.armature[0]) : Uw.z);
    const T drive = with_sign(o, c, tau(o.v));
    const T u = drive - A.n.z;
    const T step = u * d;
    f = {{Uw, Uv}, d, u};
    if constexpr (loops) {
      loops_.dof(i, 0, o.v, f.U, d, u, T(c.sign), [](const auto& P) { return P.w.z; });
      loops_.velocity_product(i, Vec6T<T>{{cx, cy, none}, X.down(c_v)});
      loops_.pass_up(i, X, vector_of<T>(c.p));
    }
    if (!twins && o.parent < 0) return;

    const T dx = Uw.x * d, dy = Uw.y * d;
    const V3<T> dv = Uv * d;
    A.I.xx -= Uw.x * dx;
    A.I.yy -= Uw.y * dy;
    A.I.xy -= Uw.x * dy;
    if constexpr (has_armature) {
      const T dz = Uw.z * d;
      A.I.xz -= Uw.x * dz;
      A.I.yz -= Uw.y * dz;
      A.I.zz -= Uw.z * dz;
      A.H.zx -= Uw.z * dv.x;
      A.H.zy -= Uw.z * dv.y;
      A.H.zz -= Uw.z * dv.z;
    } else {
      A.I.xz = A.I.yz = A.I.zz = A.H.zx = A.H.zy = A.H.zz = none;
    }
    A.H.xx -= Uw.x * dv.x;
    A.H.xy -= Uw.x * dv.y;
    A.H.xz -= Uw.x * dv.z;
    A.H.yx -= Uw.y * dv.x;
    A.H.yy -= Uw.y * dv.y;
    A.H.yz -= Uw.y * dv.z;
    A.M.xx -= Uv.x * dv.x;
    A.M.yy -= Uv.y * dv.y;
    A.M.zz -= Uv.z * dv.z;
    A.M.xy -= Uv.x * dv.y;
    A.M.xz -= Uv.x * dv.z;
    A.M.yz -= Uv.y * dv.z;
    // Bias force passed to the parent: pA + (IA - U U^T / D) c + U u / D. Without armature its moment about z equals the joint force.
    A.n.x += (A.I.xx * cx + A.I.xy * cy) + Uw.x * step;
    A.n.y += (A.I.xy * cx + A.I.yy * cy) + Uw.y * step;
    if constexpr (has_armature)
      A.n.z += (A.I.xz * cx + A.I.yz * cy) + Uw.z * step;
    else
      A.n.z = drive;
    A.f += V3<T>{A.H.xx * cx + A.H.yx * cy, A.H.xy * cx + A.H.yy * cy, A.H.xz * cx + A.H.yz * cy} + Uv * step;
    if constexpr (has_armature) {
      A.I = X.up(A.I);
      A.H = X.up(A.H);
    } else {
      up_without_z(X, A);
    }
    A.M = X.up(A.M);
    A.n = X.up(A.n);
    A.f = X.up(A.f);
    constexpr int zero_row = has_armature ? 3 : K == Crossing::cycle ? 0 : K == Crossing::cycle_back ? 1 : 2;
    if (o.offset != 0) {
      if constexpr (zero_row != 0) A.n.x += dot(A.H.row(0), c_v);
      if constexpr (zero_row != 1) A.n.y += dot(A.H.row(1), c_v);
      if constexpr (zero_row != 2) A.n.z += dot(A.H.row(2), c_v);
      A.f += A.M * c_v;
    }
    shift<zero_row>(A, o.offset, c.p);
    pass_up(o, A);
  }

  /// Column U = IA S of a DOF that rotates about axis k of the node (turning), or translates along it (sliding).
  UGOKI_INLINE static Vec6T<T> turning(const Articulated<T>& A, int k) { return {A.I.matrix().row(k), A.H.row(k)}; }
  UGOKI_INLINE static Vec6T<T> sliding(const Articulated<T>& A, int k) { return {A.H.column(k), A.M.matrix().row(k)}; }

  /// Eliminates DOF `k` (velocity index) of node `i` from A. @param along as in LoopPass::dof()
  template <class Along>
  void eliminate(int i, Articulated<T>& A, int k, const Vec6T<T>& U, T pivot, T u, T sign, Along&& along) {
    const T d = inverse_pivot(pivot);
    dof_[k] = {U, d, u};
    loops_.dof(i, k - a_.order[i].v, k, U, d, u, sign, along);
    const Vec6T<T> D = U * d;
    const V3<T>&a = U.w, &b = U.v, &x = D.w, &y = D.v;
    A.I = A.I - Sym3T<T>{a.x * x.x, a.y * x.y, a.z * x.z, a.x * x.y, a.x * x.z, a.y * x.z};
    A.M = A.M - Sym3T<T>{b.x * y.x, b.y * y.y, b.z * y.z, b.x * y.y, b.x * y.z, b.y * y.z};
    A.H -= Mat3T<T>::outer(a, y);
    A.n += x * u;
    A.f += y * u;
  }

  /// Velocity-product acceleration c (see the top) of a node with Crossing::matrix, in the node's axes.
  Vec6T<T> velocity_product(int i) const {
    const NodeOrder& o = a_.order[i];
    const NodeConstants<Constant>& k = a_.constants[i];
    const T none(0), sign(k.sign), two(2);
    const V3<T> w = w_[i + 1], w_up = w_[o.parent + 1];
    Vec6T<T> c{{none, none, none}, pass_.down(i, cross(w_up, cross(w_up, pass_.origin(i))))};
    if (o.kind == NodeKind::revolute || o.kind == NodeKind::helical) {
      const T rate = v(o.v) * sign;
      c.w = {w.y * rate, -(w.x * rate), none};
    }
    if (o.kind == NodeKind::prismatic || o.kind == NodeKind::helical) {
      const T rate = v(o.v) * (o.kind == NodeKind::helical ? sign * T(k.pitch) : sign);
      c.v += V3<T>{two * w.y * rate, -(two * w.x * rate), none};
    }
    if (o.kind == NodeKind::spherical) c.w = cross(w, V3<T>{v(o.v), v(o.v + 1), v(o.v + 2)});
    return c;
  }

  void inward(int i) {
    const NodeOrder& o = a_.order[i];
    const NodeConstants<Constant>& c = a_.constants[i];
    Articulated<T> A = gather(i);
    loops_.eliminate(i, A);
    if (o.kind == NodeKind::floating) {
      solve_floating(i, A);
      return;
    }
    const Vec6T<T> vp = velocity_product(i);
    loops_.velocity_product(i, vp);
    A.n += A.I * vp.w + A.H * vp.v;
    A.f += transpose_times(A.H, vp.w) + A.M * vp.v;
    const T sign(c.sign), pitch(c.pitch), armature(c.armature[0]);
    switch (o.kind) {
      case NodeKind::revolute: {
        const Vec6T<T> U = turning(A, 2);
        eliminate(i, A, o.v, U, U.w.z + armature, tau(o.v) * sign - A.n.z, sign, [](const auto& P) { return P.w.z; });
        break;
      }
      case NodeKind::prismatic: {
        const Vec6T<T> U = sliding(A, 2);
        eliminate(i, A, o.v, U, U.v.z + armature, tau(o.v) * sign - A.f.z, sign, [](const auto& P) { return P.v.z; });
        break;
      }
      case NodeKind::helical: {
        const Vec6T<T> U = turning(A, 2) + sliding(A, 2) * pitch;
        eliminate(i, A, o.v, U, U.w.z + pitch * U.v.z + armature, tau(o.v) * sign - (A.n.z + pitch * A.f.z), sign,
                  [&](const auto& P) { return P.w.z + P.v.z * std::remove_cvref_t<decltype(P.v.z)>(c.pitch); });
        break;
      }
      default:  // spherical
        for (int k = 3; k-- > 0;) {
          const Vec6T<T> U = turning(A, k);
          eliminate(i, A, o.v + k, U, U.w[k] + T(c.armature[k]), tau(o.v + k) - A.n[k], T(1), [&](const auto& P) { return P.w[k]; });
        }
    }
    const MatrixCrossing<T> X{pass_.E[i]};
    loops_.pass_up(i, X, pass_.origin(i));
    if (!twins && o.parent < 0) return;
    A.I = X.up(A.I);
    A.H = X.up(A.H);
    A.M = X.up(A.M);
    A.n = X.up(A.n);
    A.f = X.up(A.f);
    if (o.kind == NodeKind::revolute)
      shift<3>(A, o.offset, c.p);
    else
      shift(A, pass_.origin(i));
    pass_up(o, A);
  }

  /// Solves a floating base: (IA + armature) vdot = tau - pA - IA a0 in the node's axes, by L D L^T elimination from the last DOF.
  /// a0 = -gravity is the node's acceleration for vdot = 0.
  void solve_floating(int i, const Articulated<T>& A) {
    const NodeOrder& o = a_.order[i];
    const NodeConstants<Constant>& c = a_.constants[i];
    const V3<T> a0 = pass_.down(i, -vector_of<T>(a_.gravity));
    const Mat3T<T>& E = pass_.E[i];
    const auto t = [&](int k) { return tau(o.v + k); };
    const V3<T> n = V3<T>{t(0), t(1), t(2)} - A.n - A.H * a0;
    const V3<T> f = transpose_times(E, V3<T>{t(3), t(4), t(5)}) - A.f - A.M * a0;
    Sym3T<T> M = A.M;
    const Constant* const arm = c.armature;
    if (!is_zero(arm[3]) || !is_zero(arm[4]) || !is_zero(arm[5])) {
      const T none(0);
      M = M + MatrixCrossing<T>{E.transposed()}.up(Sym3T<T>{T(arm[3]), T(arm[4]), T(arm[5]), none, none, none});
    }
    T L[6][6];
    for (int k = 0; k < 3; ++k) {
      const V3<T> I = A.I.matrix().row(k), H = A.H.column(k), m = M.matrix().row(k);
      for (int e = 0; e < 3; ++e) {
        L[k][e] = e == k ? I[e] + T(arm[k]) : I[e];
        L[k + 3][e] = H[e];
        L[k + 3][e + 3] = m[e];
      }
    }
    T x[6] = {n.x, n.y, n.z, f.x, f.y, f.z}, d[6];
    for (int k = 6; k-- > 0;) {
      d[k] = inverse_pivot(L[k][k]);
      for (int e = k; e-- > 0;) {
        const T l = L[k][e] * d[k];
        for (int g = 0; g <= e; ++g) L[e][g] -= l * L[k][g];
        x[e] -= l * x[k];
      }
    }
    for (int k = 0; k < 6; ++k) dof_[o.v + k] = {{{L[k][0], L[k][1], L[k][2]}, {L[k][3], L[k][4], L[k][5]}}, d[k], x[k]};
    loops_.floating(i, L, d, x, Vec6T<T>{{T(0), T(0), T(0)}, a0});
  }

  // Third sweep, outward: accelerations.

  /// Reduced joint force u of a DOF minus the effect of the loops' multipliers. @param which index of the DOF among the node's DOFs
  UGOKI_INLINE T reduced_force(int i, int which, const DofPass& f) const {
    if constexpr (closed) return f.u - loops_.along_multipliers(i, which);
    return f.u;
  }

  template <Crossing K>
  UGOKI_INLINE void outward_revolute(int i) {
    if (closed && loops_.present_at(i))
      accelerate_revolute<K, true>(i);
    else
      accelerate_revolute<K, false>(i);
  }
  template <Crossing K, bool loops>
  UGOKI_INLINE void accelerate_revolute(int i) {
    const NodeOrder& o = a_.order[i];
    const NodeConstants<Constant>& c = a_.constants[i];
    const RevoluteCrossing<T, K> X = pass_.template revolute<K>(o);
    const Vec6T<T>& up = acceleration_[parent_state(o)];
    const V3<T> w = w_[i + 1];
    const T rate = with_sign(o, c, v(o.v));
    V3<T> wd = X.down(up.w);
    wd.x += w.y * rate;
    wd.y -= w.x * rate;
    V3<T> a = up.v;
    subtract_cross(a, o.offset, c.p, up.w);
    if (o.offset != 0) a += velocity_product_[i];
    a = X.down(a);
    const DofPass& f = dof_[o.v];
    const T vdot = f.d * ((loops ? reduced_force(i, 0, f) : f.u) - (dot(f.U.w, wd) + dot(f.U.v, a)));
    write_out(o.v, with_sign(o, c, vdot));
    wd.z += vdot;
    acceleration_[state_index(i)] = {wd, a};
    if constexpr (loops) loops_.recover(i, acceleration_[state_index(i)]);
  }

  void outward(int i) {
    const NodeOrder& o = a_.order[i];
    const NodeConstants<Constant>& c = a_.constants[i];
    const Vec6T<T>& up = acceleration_[parent_state(o)];
    Vec6T<T> A{pass_.down(i, up.w), pass_.down(i, up.v + cross(up.w, pass_.origin(i)))};
    if (o.kind == NodeKind::floating) {
      T x[6];
      for (int k = 0; k < 6; ++k) {
        const DofPass& f = dof_[o.v + k];
        T sum = reduced_force(i, k, f);
        for (int e = 0; e < k; ++e) sum -= (e < 3 ? f.U.w[e] : f.U.v[e - 3]) * x[e];
        x[k] = sum * f.d;
      }
      const V3<T> spin{x[0], x[1], x[2]}, slide{x[3], x[4], x[5]};
      const V3<T> out = pass_.E[i] * slide;
      for (int k = 0; k < 3; ++k) {
        write_out(o.v + k, spin[k]);
        write_out(o.v + 3 + k, out[k]);
      }
      acceleration_[state_index(i)] = {A.w + spin, A.v + slide};
      loops_.recover(i, acceleration_[state_index(i)]);
      return;
    }
    const auto reduced = [&](int k) { return dof_[k].d * (reduced_force(i, k - o.v, dof_[k]) - dot(dof_[k].U, A)); };
    const T sign(c.sign);
    if (o.kind == NodeKind::spherical) {
      for (int k = 0; k < 3; ++k) {
        const T vdot = reduced(o.v + k);
        write_out(o.v + k, vdot);
        A.w[k] += vdot;
      }
    } else {
      const T vdot = reduced(o.v);
      write_out(o.v, vdot * sign);
      if (o.kind != NodeKind::prismatic) A.w.z += vdot;
      if (o.kind == NodeKind::prismatic) A.v.z += vdot;
      if (o.kind == NodeKind::helical) A.v.z += vdot * T(c.pitch);
    }
    acceleration_[state_index(i)] = A + velocity_product(i);
    loops_.recover(i, acceleration_[state_index(i)]);
  }

  Loops loops_;
  Pass<T, Constant> pass_;
  const KernelArguments<Real, Constant>& a_;
  V3<T>* w_;                 // [nodes + 1], the world first
  V3<T>* velocity_product_;  // [nodes] linear part of c in the parent's axes; set only for revolute nodes with a nonzero offset
  DofPass* dof_;             // [nv] elimination results
  Vec6T<T>* acceleration_;   // [nodes + 1] at state_index()
  Articulated<T>* slots_;
  const Articulated<T>* twins_ = nullptr;
  Articulated<T> from_child_;
  Mask bad_{};
};

}  // namespace
}  // namespace ugoki::dynamics
