#pragma once
// Inertia matrix from q as chain rows: composite rigid bodies in the nodes' frames.
//
// From the leaves on, each node's composite inertia gives the forces F = Ic S of its own freedoms, and all forces of its subtree,
// which by then are in its frame, give their entries S^T F; then inertia and forces are carried to the parent. A subtree is a
// range of nodes and of forces. Source: Featherstone (2008), ch. 6. For kernels_*.cpp only.

#include "ugoki/dynamics/kernel_crossing.h"

namespace ugoki::dynamics {
namespace {  // NOLINT(google-build-namespaces): see spatial/lanes.h

template <class T>
class InertiaKernel {
 public:
  using Real = typename T::Real;

  explicit InertiaKernel(const KernelArguments<Real>& arguments)
      : pass_(arguments),
        a_(pass_.a),
        composite_(pass_.scratch.template take<InertiaT<T>>(a_.nodes)),
        force_(pass_.scratch.template take<Force>(a_.nv)),
        first_(pass_.scratch.template take<int>(a_.nodes + 1)) {}

  void run() {
    pass_.prepare();
    int count = 0;
    for (int i = 0; i < a_.nodes; ++i) {
      const NodeConstants<Real>& c = a_.constants[i];
      composite_[i] = {T(c.mass), vector_of<T>(c.h), symmetric_of<T>(c.I)};
      first_[i] = count;
      const NodeKind kind = a_.order[i].kind;
      count += kind == NodeKind::floating ? 6 : kind == NodeKind::spherical ? 3 : 1;
    }
    first_[a_.nodes] = count;
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
  /// Force of one freedom, and where its row is.
  struct Force {
    V3<T> n, f;
    Real* row;  ///< entry [depth[j]] belongs to freedom j above
    int freedom;
  };

  UGOKI_INLINE Real& entry(const Force& F, int above) const {
    return above <= F.freedom ? F.row[a_.depth[above]] : a_.out[a_.row_start[above] + a_.depth[F.freedom]];
  }
  UGOKI_INLINE void start(Force& F, int freedom, const V3<T>& n, const V3<T>& f) const {
    F = {n, f, a_.out + a_.row_start[freedom], freedom};
  }

  template <class X>
  UGOKI_INLINE void carry(int i, const X& crossing, const V3<T>& r) {
    const NodeOrder& o = a_.order[i];
    if (o.parent < 0) return;
    const InertiaT<T>& c = composite_[i];
    InertiaT<T>& up = composite_[o.parent];
    const V3<T> h = crossing.up(c.h);
    Sym3T<T> I = crossing.up(c.I);
    // the parallel-axis theorem for a first moment h about the old origin, which is at r
    const V3<T> g = r * c.mass + h + h;
    I.xx += dot(r, g) - r.x * g.x;
    I.yy += dot(r, g) - r.y * g.y;
    I.zz += dot(r, g) - r.z * g.z;
    I.xy -= r.x * r.y * c.mass + (r.x * h.y + r.y * h.x);
    I.xz -= r.x * r.z * c.mass + (r.x * h.z + r.z * h.x);
    I.yz -= r.y * r.z * c.mass + (r.y * h.z + r.z * h.y);
    up.mass += c.mass;
    up.h += h + r * c.mass;
    up.I = up.I + I;
    for (int k = first_[i]; k < first_[o.end]; ++k) {
      Force& F = force_[k];
      F.f = crossing.up(F.f);
      F.n = crossing.up(F.n) + cross(r, F.f);
    }
  }

  template <Crossing K>
  UGOKI_INLINE void revolute(int i) {
    const NodeOrder& o = a_.order[i];
    const NodeConstants<Real>& c = a_.constants[i];
    const InertiaT<T>& C = composite_[i];
    const T sign(c.sign), none(0);
    start(force_[first_[i]], o.v, V3<T>{C.I.xz, C.I.yz, C.I.zz} * sign, V3<T>{-C.h.y, C.h.x, none} * sign);
    for (int k = first_[i]; k < first_[o.end]; ++k) entry(force_[k], o.v) = (force_[k].n.z * sign).v;
    a_.out[a_.row_start[o.v] + a_.depth[o.v]] += c.armature[0];
    carry(i, pass_.template revolute<K>(o), vector_of<T>(c.p));
  }

  void other(int i) {
    const NodeOrder& o = a_.order[i];
    const NodeConstants<Real>& c = a_.constants[i];
    const InertiaT<T>& C = composite_[i];
    const T none(0), sign(c.sign), pitch(c.pitch);
    const V3<T> z{none, none, sign};
    Force* const own = force_ + first_[i];
    // a motion (w, v) of the node takes the force (I w + h x v, m v - h x w)
    const auto force_of = [&](Force& F, int freedom, const V3<T>& w, const V3<T>& v) {
      start(F, freedom, C.I * w + cross(C.h, v), v * C.mass - cross(C.h, w));
    };
    const V3<T> zero{none, none, none};
    const int begin = first_[i], end = first_[o.end];
    const auto entries = [&](int freedom, const V3<T>& w, const V3<T>& v) {
      for (int k = begin; k < end; ++k) entry(force_[k], freedom) = (dot(force_[k].n, w) + dot(force_[k].f, v)).v;
    };
    V3<T> w[6], v[6];
    int n = 1;
    switch (o.kind) {
      case NodeKind::revolute: w[0] = z, v[0] = zero; break;
      case NodeKind::prismatic: w[0] = zero, v[0] = z; break;
      case NodeKind::helical: w[0] = z, v[0] = z * pitch; break;
      default:
        n = o.kind == NodeKind::floating ? 6 : 3;
        for (int k = 0; k < n; ++k) {
          w[k] = v[k] = zero;
          if (k < 3)
            w[k][k] = T(1);
          else
            v[k] = pass_.E[i].row(k - 3);
        }
    }
    for (int k = 0; k < n; ++k) force_of(own[k], o.v + k, w[k], v[k]);
    for (int k = 0; k < n; ++k) entries(o.v + k, w[k], v[k]);
    for (int k = 0; k < n; ++k) a_.out[a_.row_start[o.v + k] + a_.depth[o.v + k]] += c.armature[k];
    if (o.parent >= 0) carry(i, MatrixCrossing<T>{pass_.E[i]}, pass_.origin(i));
  }

  Pass<T> pass_;
  const KernelArguments<Real>& a_;
  InertiaT<T>* composite_;  // [nodes]
  Force* force_;            // [nv] in the order of nodes
  int* first_;              // [nodes + 1] a node's first force
};

}  // namespace
}  // namespace ugoki::dynamics
