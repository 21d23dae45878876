#pragma once
// Inertia matrix from q as chain rows: composite rigid bodies in the nodes' frames.
//
// From the leaves on, each node's composite inertia gives the forces F = Ic S of its own freedoms, and all forces of its subtree,
// which by then are in its frame, give their entries S^T F; then inertia and forces are carried to the parent. The forces of a
// subtree are a range, and cross a joint in lanes. Source: Featherstone (2008), ch. 6. For kernels_*.cpp only.

#include "ugoki/dynamics/kernel_crossing.h"

namespace ugoki::dynamics {
namespace {  // NOLINT(google-build-namespaces): see spatial/lanes.h

class InertiaKernel {
 public:
  using T = Lanes<double, 1>;

  explicit InertiaKernel(const KernelArguments<double>& arguments)
      : pass_(arguments),
        a_(pass_.a),
        composite_(pass_.scratch.template take<InertiaT<T>>(a_.nodes)),
        nx_(forces()),
        ny_(forces()),
        nz_(forces()),
        fx_(forces()),
        fy_(forces()),
        fz_(forces()),
        row_(pass_.scratch.template take<int>(a_.nv)) {}

  void run() {
    pass_.prepare();
    for (int k = 0; k < a_.nv; ++k) row_[k] = a_.row_start[a_.force_freedom[k]];
    for (int i = 0; i < a_.nodes; ++i) {
      const NodeConstants<double>& c = a_.constants[i];
      composite_[i] = {T(c.mass), vector_of<T>(c.h), symmetric_of<T>(c.I)};
    }
    for (int i = a_.nodes; i-- > 0;) {
      switch (a_.order[i].crossing) {
        case Crossing::none: revolute<Crossing::none>(i); break;
        case Crossing::cycle: revolute<Crossing::cycle>(i); break;
        case Crossing::cycle_back: revolute<Crossing::cycle_back>(i); break;
        case Crossing::matrix: other(i); break;
      }
    }
  }

 private:
  using Wide = Lanes<double, UGOKI_DOUBLE_LANES>;

  double* forces() { return pass_.scratch.template take<double>(a_.nv + Wide::count); }

  UGOKI_INLINE void start(int place, const V3<T>& n, const V3<T>& f) const {
    nx_[place] = n.x.v;
    ny_[place] = n.y.v;
    nz_[place] = n.z.v;
    fx_[place] = f.x.v;
    fy_[place] = f.y.v;
    fz_[place] = f.z.v;
  }
  /// Entry of the force at `place` and freedom `above`; the one that comes later in v has the row.
  UGOKI_INLINE double& entry(int place, int above, int depth) const {
    const int freedom = a_.force_freedom[place];
    return above <= freedom ? a_.out[row_[place] + depth] : a_.out[a_.row_start[above] + a_.depth[freedom]];
  }

  UGOKI_INLINE static V3<Wide> load_wide(const double* x, const double* y, const double* z, int k) {
    return {Wide::load(x + k), Wide::load(y + k), Wide::load(z + k)};
  }
  UGOKI_INLINE static void store_wide(const V3<Wide>& v, double* x, double* y, double* z, int k) {
    v.x.store(x + k);
    v.y.store(y + k);
    v.z.store(z + k);
  }

  /// Inertia and forces into the parent's frame. The last lanes may run over the range's end: into forces of nodes that come
  /// later and start them anew.
  template <class One, class Many>
  UGOKI_INLINE void carry(int i, const One& crossing, const Many& crossing_wide, const V3<T>& r) {
    const NodeOrder& o = a_.order[i];
    const InertiaT<T>& c = composite_[i];
    InertiaT<T>& up = composite_[o.parent];
    const V3<T> h = crossing.up(c.h);
    Sym3T<T> I = crossing.up(c.I);
    // the parallel-axis theorem for a first moment h about the old origin, which is at r
    const V3<T> rm = r * c.mass, g = rm + h + h;
    const T x = r.x * g.x, y = r.y * g.y, z = r.z * g.z;
    I.xx += y + z;
    I.yy += x + z;
    I.zz += x + y;
    I.xy -= r.x * (rm.y + h.y) + r.y * h.x;
    I.xz -= r.x * (rm.z + h.z) + r.z * h.x;
    I.yz -= r.y * (rm.z + h.z) + r.z * h.y;
    up.mass += c.mass;
    up.h += h + rm;
    up.I = up.I + I;
    const V3<Wide> wide_r{Wide(r.x.v), Wide(r.y.v), Wide(r.z.v)};
    double *const nx = nx_, *const ny = ny_, *const nz = nz_, *const fx = fx_, *const fy = fy_, *const fz = fz_;
    for (int k = o.force_begin, end = o.force_end; k < end; k += Wide::count) {
      const V3<Wide> f = crossing_wide.up(load_wide(fx, fy, fz, k));
      const V3<Wide> n = crossing_wide.up(load_wide(nx, ny, nz, k)) + cross(wide_r, f);
      store_wide(f, fx, fy, fz, k);
      store_wide(n, nx, ny, nz, k);
    }
  }

  template <Crossing K>
  UGOKI_INLINE void revolute(int i) {
    const NodeOrder& o = a_.order[i];
    const NodeConstants<double>& c = a_.constants[i];
    const InertiaT<T>& C = composite_[i];
    const T sign(c.sign), none(0);
    start(o.force_end - 1, V3<T>{C.I.xz, C.I.yz, C.I.zz} * sign, V3<T>{-C.h.y, C.h.x, none} * sign);
    const int depth = a_.depth[o.v];
    if (o.ordered) {
      double* const out = a_.out + depth;
      const double* const nz = nz_;
      const int* const row = row_;
      for (int k = o.force_begin, end = o.force_end; k < end; ++k) out[row[k]] = nz[k] * c.sign;
    } else {
      for (int k = o.force_begin; k < o.force_end; ++k) entry(k, o.v, depth) = nz_[k] * c.sign;
    }
    a_.out[a_.row_start[o.v] + depth] += c.armature[0];
    if (o.parent < 0) return;
    const RevoluteCrossing<T, K> X = pass_.template revolute<K>(o);
    carry(i, X, RevoluteCrossing<Wide, K>{Wide(X.s.v), Wide(X.c.v)}, vector_of<T>(c.p));
  }

  void other(int i) {
    const NodeOrder& o = a_.order[i];
    const NodeConstants<double>& c = a_.constants[i];
    const InertiaT<T>& C = composite_[i];
    const T none(0), sign(c.sign), pitch(c.pitch);
    const V3<T> z{none, none, sign}, zero{none, none, none};
    // a motion (w, v) of the node takes the force (I w + h x v, m v - h x w)
    const auto begin = [&](int k, const V3<T>& w, const V3<T>& v) {
      start(o.force_end - 1 - k, C.I * w + cross(C.h, v), v * C.mass - cross(C.h, w));
    };
    // entry(force) of the node's freedom k, with all forces of its subtree; of its own only those from k on
    const auto entries = [&](int k, const auto& along) {
      const int depth = a_.depth[o.v + k];
      for (int e = o.force_begin; e < o.force_end - k; ++e) entry(e, o.v + k, depth) = along(e);
      a_.out[a_.row_start[o.v + k] + depth] += c.armature[k];
    };
    switch (o.kind) {
      case NodeKind::revolute:
        begin(0, z, zero);
        entries(0, [&](int e) { return nz_[e] * c.sign; });
        break;
      case NodeKind::prismatic:
        begin(0, zero, z);
        entries(0, [&](int e) { return fz_[e] * c.sign; });
        break;
      case NodeKind::helical:
        begin(0, z, z * pitch);
        entries(0, [&](int e) { return (nz_[e] + fz_[e] * c.pitch) * c.sign; });
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
        entries(0, [&](int e) { return nx_[e]; });
        entries(1, [&](int e) { return ny_[e]; });
        entries(2, [&](int e) { return nz_[e]; });
        if (o.kind == NodeKind::spherical) break;
        for (int k = 0; k < 3; ++k) {
          const V3<T> row = E.row(k);
          entries(3 + k, [&](int e) { return fx_[e] * row.x.v + fy_[e] * row.y.v + fz_[e] * row.z.v; });
        }
        break;
      }
    }
    if (o.parent < 0) return;
    Mat3T<Wide> E;
    const Mat3T<T>& e = pass_.E[i];
    E = {Wide(e.xx.v), Wide(e.xy.v), Wide(e.xz.v), Wide(e.yx.v), Wide(e.yy.v), Wide(e.yz.v), Wide(e.zx.v), Wide(e.zy.v), Wide(e.zz.v)};
    carry(i, MatrixCrossing<T>{e}, MatrixCrossing<Wide>{E}, pass_.origin(i));
  }

  Pass<T> pass_;
  const KernelArguments<double>& a_;
  InertiaT<T>* composite_;                    // [nodes]
  double *nx_, *ny_, *nz_, *fx_, *fy_, *fz_;  // [nv] forces of the freedoms, last nodes first
  int* row_;                                  // [nv] where their rows start
};

}  // namespace
}  // namespace ugoki::dynamics
