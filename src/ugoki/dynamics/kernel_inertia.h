#pragma once
// Inertia matrix from q as chain rows: composite rigid bodies in the nodes' frames.
//
// From the leaves on, each node's composite inertia gives the forces F = Ic S of its own freedoms, and all forces of its subtree,
// which by then are in its frame, give their entries S^T F; then inertia and forces are carried to the parent. The forces of a
// subtree are a range, and cross a joint in lanes. So the entries of a freedom come in the order of the forces, and are written to
// their places in the chain rows some hundreds at a time. Source: Featherstone (2008), ch. 6. For kernels_*.cpp only.

#include "ugoki/dynamics/kernel_crossing.h"

namespace ugoki::dynamics {
namespace {  // NOLINT(google-build-namespaces): see spatial/lanes.h

/// @tparam Constant LaneArray: twins (link_twins.h), whose base is a node of another kernel
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
        place_(a_.entry_place) {}

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
  /// What a pair of twins hands on to the node that carries it.
  struct Twins {
    InertiaT<T> inertia;     ///< of both
    const double* force[6];  ///< nx, ny, nz, fx, fy, fz in that node's frame
    int force_begin, count;  ///< where they go
    int place;               ///< NodeOrder::twins
  };
  /// @param pairs in rising order of force_begin
  void take_twins(const Twins* pairs, int count) {
    twins_ = pairs;
    twin_count_ = count;
  }
  /// Of twins: their inertia is that of both lanes.
  [[nodiscard]] const InertiaT<T>& handed_on() const { return carry_; }
  template <class Out>
  void hand_on_forces(Out& out) const {
    const double* const from[6] = {nx_, ny_, nz_, fx_, fy_, fz_};
    for (int k = 0; k < 6; ++k) out.force[k] = from[k];
    out.count = a_.nv * lanes;
  }

 private:
  static constexpr int lanes = T::count;
  static constexpr bool twins = !std::is_same_v<Constant, double>;
  using Wide = Lanes<double, UGOKI_DOUBLE_LANES>;

  double* forces() { return pass_.scratch.template take<double>(a_.nv * lanes + Wide::count); }

  /// Forces of twins lie side by side.
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

  /// The node's own body and what its children handed on.
  UGOKI_INLINE InertiaT<T> gather(const NodeOrder& o, const NodeConstants<Constant>& c) {
    InertiaT<T> C{T(c.mass), vector_of<T>(c.h), symmetric_of<T>(c.I)};
    if (o.has_child) add(C, carry_);
    if (o.slot >= 0) add(C, slots_[o.slot]);
    if constexpr (!twins)
      if (o.twins >= 0) take_twins_of(o.twins, C);
    return C;
  }
  void take_twins_of(int place, InertiaT<T>& C) {
    double* const to[6] = {nx_, ny_, nz_, fx_, fy_, fz_};
    for (int i = 0; i < twin_count_; ++i) {
      const Twins& pair = twins_[i];
      if (pair.place != place) continue;
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
  UGOKI_INLINE void hand_on(const NodeOrder& o, const InertiaT<T>& C) {
    if (o.first_child || (twins && o.parent < 0)) {
      carry_ = C;
    } else if (o.last_child) {
      slots_[a_.order[o.parent].slot] = C;
    } else {
      add(slots_[a_.order[o.parent].slot], C);
    }
  }

  UGOKI_INLINE void start(int place, const V3<T>& n, const V3<T>& f) const {
    const int at = place * lanes;
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

  /// Entries of one freedom with the forces [begin, end), its own the last: along(k) has those of the lanes from k on. Lanes past
  /// the end write what the next freedom overwrites.
  template <class Along>
  UGOKI_INLINE void entries(int begin, int end, const Constant& armature, Along&& along) {
    double* const out = entries_ + written_;
    const int count = (end - begin) * lanes;
    for (int k = 0; k < count; k += Wide::count) along(begin * lanes + k).store(out + k);
    (T::load(out + count - lanes) + T(armature)).store(out + count - lanes);
    written_ += count;
    if (written_ >= inertia_entries_at_once) write_entries();
  }
  void write_entries() {
    const int* const place = place_;
    double* const out = a_.out;
    const double* const from = entries_;
    for (int k = 0; k < written_; ++k) out[place[k]] = from[k];
    place_ += written_;
    written_ = 0;
  }

  /// Inertia and forces into the parent's frame. The last lanes may run over the range's end: into forces of nodes that come
  /// later and start them anew.
  /// @param offset, r the node's origin in the parent's frame
  template <class One, class Many>
  UGOKI_INLINE void carry(const NodeOrder& o, const InertiaT<T>& c, const One& crossing, const Many& crossing_wide, Axes offset,
                          const T* r) {
    InertiaT<T> up{c.mass, crossing.up(c.h), crossing.up(c.I)};
    const auto axes = [&](auto&& f) {
      if ((offset & 1) != 0) f(std::integral_constant<int, 0>{});
      if ((offset & 2) != 0) f(std::integral_constant<int, 1>{});
      if ((offset & 4) != 0) f(std::integral_constant<int, 2>{});
    };
    axes([&](auto k) { shift_along<k>(up, r[k]); });
    hand_on(o, up);
    double *const nx = nx_, *const ny = ny_, *const nz = nz_, *const fx = fx_, *const fy = fy_, *const fz = fz_;
    for (int k = o.force_begin * lanes, end = o.force_end * lanes; k < end; k += Wide::count) {
      const V3<Wide> f = crossing_wide.up(load_wide(fx, fy, fz, k));
      V3<Wide> n = crossing_wide.up(load_wide(nx, ny, nz, k));
      axes([&](auto axis) { add_cross<axis>(n, wide(r[axis]), f); });
      store_wide(f, fx, fy, fz, k);
      store_wide(n, nx, ny, nz, k);
    }
  }
  /// The parallel-axis theorem, for an origin that is at r e_k.
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
    carry(o, C, X, RevoluteCrossing<Wide, K>{wide(X.s), wide(X.c)}, o.offset, r);
  }

  void other(int i) {
    const NodeOrder& o = a_.order[i];
    const NodeConstants<Constant>& c = a_.constants[i];
    const InertiaT<T> C = gather(o, c);
    const T none(0), sign(c.sign), pitch(c.pitch);
    const V3<T> z{none, none, sign}, zero{none, none, none};
    // a motion (w, v) of the node takes the force (I w + h x v, m v - h x w)
    const auto begin = [&](int k, const V3<T>& w, const V3<T>& v) {
      start(o.force_end - 1 - k, C.I * w + cross(C.h, v), v * C.mass - cross(C.h, w));
    };
    // of its own forces the freedom k takes only those from k on
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
    carry(o, C, MatrixCrossing<T>{pass_.E[i]}, MatrixCrossing<Wide>{wide(pass_.E[i])}, o.kind == NodeKind::revolute ? o.offset : Axes{7},
          r);
  }

  Pass<T, Constant> pass_;
  const KernelArguments<double, Constant>& a_;
  InertiaT<T>* slots_;
  const Twins* twins_ = nullptr;
  int twin_count_ = 0;
  InertiaT<T> carry_;
  double *nx_, *ny_, *nz_, *fx_, *fy_, *fz_;  // [nv * lanes] forces of the freedoms, last nodes first
  double* entries_;                           // not yet written to their places
  int written_ = 0;                           // of them
  const int* place_;                          // of the next ones
};

}  // namespace
}  // namespace ugoki::dynamics
