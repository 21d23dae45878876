#pragma once
// Inertia matrix from q as chain rows (Workspace::chain): the composite-rigid-body algorithm in the nodes' frames.
//
// Nodes are processed from the last to the first. The composite inertia Ic of a node (its body and all descendants) gives the forces
// F = Ic S of its own DOFs with axes S. The forces F of all DOFs of its subtree, in the node's frame, give the entries S^T F of the inertia
// matrix. Then Ic and the forces are transformed to the parent's frame. The forces of a subtree are a contiguous range, so they are
// transformed in SIMD lanes. The entries are collected in the order of the forces, and written to the chain rows in groups of some
// hundreds. Source: Featherstone (2008), ch. 6. For kernels_*.cpp only.

#include "ugoki/dynamics/kernel_crossing.h"

namespace ugoki::dynamics {
namespace {  // NOLINT(google-build-namespaces): see spatial/lanes.h

/// Inertia matrix of the nodes that KernelArguments lists: a whole mechanism, its trunk, or a pair of twins, two subtrees
/// of the same structure (link_twins.h).
/// @tparam Constant LaneArray for a pair of twins. The base is then not the world, but the node that is the parent of both subtrees.
template <class T, class Constant = typename T::Real>
class InertiaKernel {
 public:
  explicit InertiaKernel(const KernelArguments<double, Constant>& arguments)
      : pass_(arguments),
        a_(pass_.a),
        slots_(pass_.scratch.template take<InertiaT<T>>(a_.slots)),
        nx_(forces()),
        ny_(forces()),
        nz_(forces()),
        fx_(forces()),
        fy_(forces()),
        fz_(forces()),
        entries_(pass_.scratch.template take<double>(inertia_entries_at_once + a_.nv * lanes + Wide::count)),
        next_index_(a_.entry_index) {}

  void run() {
    pass_.prepare();
    for (int i = a_.nodes; i-- > 0;) {
      switch (a_.order[i].crossing) {
        case Crossing::none: revolute<Crossing::none>(i); break;
        case Crossing::cycle: revolute<Crossing::cycle>(i); break;
        case Crossing::cycle_back: revolute<Crossing::cycle_back>(i); break;
        case Crossing::matrix: other(i); break;
      }
    }
    write_entries();
  }
  /// Composite inertia and forces that a pair of twins passes to its base, the trunk node that carries the two subtrees (link_twins.h).
  struct Twins {
    InertiaT<T> inertia;     ///< sum of both twins
    const double* force[6];  ///< [count] components nx, ny, nz, fx, fy, fz of the forces of the pair's DOFs, in the base's frame
    int force_begin, count;  ///< first index in the trunk's force arrays; number of values (2 per DOF of a twin)
    int twin_slot;           ///< NodeOrder::twin_slot of the base
  };
  /// Sets the inertias and forces that run() adds to the trunk, which is all nodes outside the subtrees of twins.
  /// @param pairs [count] the contribution of each pair (two subtrees), in ascending order of force_begin; must outlive run()
  void set_twins(const Twins* pairs, int count) {
    twins_ = pairs;
    twin_count_ = count;
  }
  /// Composite inertia that each of the two twins passes to the base, one twin per lane.
  [[nodiscard]] const InertiaT<T>& passed_up() const { return from_child_; }
  template <class Out>
  void pass_up_forces(Out& out) const {
    const double* const from[6] = {nx_, ny_, nz_, fx_, fy_, fz_};
    for (int k = 0; k < 6; ++k) out.force[k] = from[k];
    out.count = a_.nv * lanes;
  }

 private:
  static constexpr int lanes = T::count;
  static constexpr bool twins = !std::is_same_v<Constant, double>;
  using Wide = Lanes<double, UGOKI_DOUBLE_LANES>;

  double* forces() { return pass_.scratch.template take<double>(a_.nv * lanes + Wide::count); }

  /// Repeats x in the lanes of a Wide. For a pair of twins the two values alternate, as the forces of the two twins do in memory.
  UGOKI_INLINE static Wide wide(T x) {
    if constexpr (lanes == 1) {
      return Wide(x.v);
    } else {
      Wide out;
      for (int i = 0; i < Wide::count; ++i) out.v[i] = x.v[i % lanes];
      return out;
    }
  }
  UGOKI_INLINE static V3<Wide> wide(const V3<T>& x) { return {wide(x.x), wide(x.y), wide(x.z)}; }
  UGOKI_INLINE static Mat3T<Wide> wide(const Mat3T<T>& m) {
    return {wide(m.xx), wide(m.xy), wide(m.xz), wide(m.yx), wide(m.yy), wide(m.yz), wide(m.zx), wide(m.zy), wide(m.zz)};
  }

  /// Composite inertia of the node: that of its own body plus those passed up by its children.
  UGOKI_INLINE InertiaT<T> gather(const NodeOrder& o, const NodeConstants<Constant>& c) {
    InertiaT<T> C{T(c.mass), vector_of<T>(c.h), symmetric_of<T>(c.I)};
    if (o.has_child) add(C, from_child_);
    if (o.slot >= 0) add(C, slots_[o.slot]);
    if constexpr (!twins)
      if (o.twin_slot >= 0) add_twins(o.twin_slot, C);
    return C;
  }
  void add_twins(int twin_slot, InertiaT<T>& C) {
    double* const to[6] = {nx_, ny_, nz_, fx_, fy_, fz_};
    for (int i = 0; i < twin_count_; ++i) {
      const Twins& pair = twins_[i];
      if (pair.twin_slot != twin_slot) continue;
      add(C, pair.inertia);
      for (int k = 0; k < 6; ++k)
        for (int e = 0; e < pair.count; e += Wide::count) Wide::load(pair.force[k] + e).store(to[k] + pair.force_begin + e);
    }
  }
  UGOKI_INLINE static void add(InertiaT<T>& a, const InertiaT<T>& b) {
    a.mass += b.mass;
    a.h += b.h;
    a.I = a.I + b.I;
  }
  UGOKI_INLINE void pass_up(const NodeOrder& o, const InertiaT<T>& C) {
    if (o.first_child || (twins && o.parent < 0)) {
      from_child_ = C;
    } else if (o.last_child) {
      slots_[a_.order[o.parent].slot] = C;
    } else {
      add(slots_[a_.order[o.parent].slot], C);
    }
  }

  UGOKI_INLINE void start(int index, const V3<T>& n, const V3<T>& f) const {
    const int at = index * lanes;
    n.x.store(nx_ + at);
    n.y.store(ny_ + at);
    n.z.store(nz_ + at);
    f.x.store(fx_ + at);
    f.y.store(fy_ + at);
    f.z.store(fz_ + at);
  }

  UGOKI_INLINE static V3<Wide> load_wide(const double* x, const double* y, const double* z, int k) {
    return {Wide::load(x + k), Wide::load(y + k), Wide::load(z + k)};
  }
  UGOKI_INLINE static void store_wide(const V3<Wide>& v, double* x, double* y, double* z, int k) {
    v.x.store(x + k);
    v.y.store(y + k);
    v.z.store(z + k);
  }

  /// Computes the matrix entries of one DOF with the forces [begin, end); the DOF's own force is the last of them. Lanes past the end write
  /// values that the next DOF overwrites. @param along (k) -> entries for the forces in the lanes from element k of the force arrays
  template <class Along>
  UGOKI_INLINE void entries(int begin, int end, const Constant& armature, Along&& along) {
    double* const out = entries_ + entry_count_;
    const int count = (end - begin) * lanes;
    for (int k = 0; k < count; k += Wide::count) along(begin * lanes + k).store(out + k);
    (T::load(out + count - lanes) + T(armature)).store(out + count - lanes);
    entry_count_ += count;
    if (entry_count_ >= inertia_entries_at_once) write_entries();
  }
  void write_entries() {
    const int* const index = next_index_;
    double* const out = a_.out;
    const double* const from = entries_;
    for (int k = 0; k < entry_count_; ++k) out[index[k]] = from[k];
    next_index_ += entry_count_;
    entry_count_ = 0;
  }

  /// Transforms inertia and forces to the parent's frame. The last lanes may extend past the end of the subtree's range. The forces there
  /// belong to nodes that are processed later and overwrite them.
  /// @param r the node's origin in the parent's frame @param offset nonzero coordinates of r
  template <class One, class Many>
  UGOKI_INLINE void transform_to_parent(const NodeOrder& o, const InertiaT<T>& c, const One& crossing, const Many& crossing_wide,
                                        Axes offset, const T* r) {
    InertiaT<T> up{c.mass, crossing.up(c.h), crossing.up(c.I)};
    const auto axes = [&](auto&& f) {
      if ((offset & 1) != 0) f(std::integral_constant<int, 0>{});
      if ((offset & 2) != 0) f(std::integral_constant<int, 1>{});
      if ((offset & 4) != 0) f(std::integral_constant<int, 2>{});
    };
    axes([&](auto k) { shift_along<k>(up, r[k]); });
    pass_up(o, up);
    double *const nx = nx_, *const ny = ny_, *const nz = nz_, *const fx = fx_, *const fy = fy_, *const fz = fz_;
    for (int k = o.force_begin * lanes, end = o.force_end * lanes; k < end; k += Wide::count) {
      const V3<Wide> f = crossing_wide.up(load_wide(fx, fy, fz, k));
      V3<Wide> n = crossing_wide.up(load_wide(nx, ny, nz, k));
      axes([&](auto axis) { add_cross<axis>(n, wide(r[axis]), f); });
      store_wide(f, fx, fy, fz, k);
      store_wide(n, nx, ny, nz, k);
    }
  }
  /// Parallel-axis theorem: changes the reference point of c from r e_k to the origin; e_k is the unit vector of axis k.
  template <int k>
  UGOKI_INLINE static void shift_along(InertiaT<T>& c, T r) {
    constexpr int i = (k + 1) % 3, j = (k + 2) % 3;
    const T rm = r * c.mass, h = entry<k>(c.h), growth = r * (rm + h + h);
    entry<i, i>(c.I) += growth;
    entry<j, j>(c.I) += growth;
    entry<i, k>(c.I) -= r * entry<i>(c.h);
    entry<j, k>(c.I) -= r * entry<j>(c.h);
    entry<k>(c.h) = h + rm;
  }

  template <Crossing K>
  UGOKI_INLINE void revolute(int i) {
    const NodeOrder& o = a_.order[i];
    const NodeConstants<Constant>& c = a_.constants[i];
    const InertiaT<T> C = gather(o, c);
    const T sign(c.sign), none(0);
    start(o.force_end - 1, V3<T>{C.I.xz, C.I.yz, C.I.zz} * sign, V3<T>{-C.h.y, C.h.x, none} * sign);
    const Wide along = wide(sign);
    entries(o.force_begin, o.force_end, c.armature[0], [&](int k) { return Wide::load(nz_ + k) * along; });
    if (!twins && o.parent < 0) return;
    const RevoluteCrossing<T, K> X = pass_.template revolute<K>(o);
    const T r[3] = {T(c.p[0]), T(c.p[1]), T(c.p[2])};
    transform_to_parent(o, C, X, RevoluteCrossing<Wide, K>{wide(X.s), wide(X.c)}, o.offset, r);
  }

  void other(int i) {
    const NodeOrder& o = a_.order[i];
    const NodeConstants<Constant>& c = a_.constants[i];
    const InertiaT<T> C = gather(o, c);
    const T none(0), sign(c.sign), pitch(c.pitch);
    const V3<T> z{none, none, sign}, zero{none, none, none};
    // The wrench for a unit motion (w, v) of the node is (I w + h x v, m v - h x w).
    const auto begin = [&](int k, const V3<T>& w, const V3<T>& v) {
      start(o.force_end - 1 - k, C.I * w + cross(C.h, v), v * C.mass - cross(C.h, w));
    };
    // Of the entries between DOF k and the node's own DOFs, only those from k on are computed, because the matrix is symmetric.
    const auto column = [&](int k, const auto& along) { entries(o.force_begin, o.force_end - k, c.armature[k], along); };
    const Wide wide_sign = wide(sign), wide_pitch = wide(pitch);
    switch (o.kind) {
      case NodeKind::revolute:
        begin(0, z, zero);
        column(0, [&](int k) { return Wide::load(nz_ + k) * wide_sign; });
        break;
      case NodeKind::prismatic:
        begin(0, zero, z);
        column(0, [&](int k) { return Wide::load(fz_ + k) * wide_sign; });
        break;
      case NodeKind::helical:
        begin(0, z, z * pitch);
        column(0, [&](int k) { return (Wide::load(nz_ + k) + Wide::load(fz_ + k) * wide_pitch) * wide_sign; });
        break;
      case NodeKind::spherical:
      case NodeKind::floating: {
        const Mat3T<T>& E = pass_.E[i];
        for (int k = 0; k < 3; ++k) {
          V3<T> w = zero;
          w[k] = T(1);
          begin(k, w, zero);
          if (o.kind == NodeKind::floating) begin(3 + k, zero, E.row(k));
        }
        column(0, [&](int k) { return Wide::load(nx_ + k); });
        column(1, [&](int k) { return Wide::load(ny_ + k); });
        column(2, [&](int k) { return Wide::load(nz_ + k); });
        if (o.kind == NodeKind::spherical) break;
        for (int k = 0; k < 3; ++k) {
          const V3<Wide> axis = wide(E.row(k));
          column(3 + k, [&](int e) { return dot(load_wide(fx_, fy_, fz_, e), axis); });
        }
        break;
      }
    }
    if (!twins && o.parent < 0) return;
    const V3<T> origin = pass_.origin(i);
    const T r[3] = {origin.x, origin.y, origin.z};
    transform_to_parent(o, C, MatrixCrossing<T>{pass_.E[i]}, MatrixCrossing<Wide>{wide(pass_.E[i])},
                        o.kind == NodeKind::revolute ? o.offset : Axes{7}, r);
  }

  Pass<T, Constant> pass_;
  const KernelArguments<double, Constant>& a_;
  InertiaT<T>* slots_;
  const Twins* twins_ = nullptr;
  int twin_count_ = 0;
  InertiaT<T> from_child_;
  double *nx_, *ny_, *nz_, *fx_, *fy_, *fz_;  // [nv * lanes] components of the DOFs' forces, last nodes first
  double* entries_;                           // computed entries that are not yet copied to the chain rows
  int entry_count_ = 0;                       // number of entries in entries_
  const int* next_index_;                     // indices in the chain rows of the next entries to copy
};

}  // namespace
}  // namespace ugoki::dynamics
