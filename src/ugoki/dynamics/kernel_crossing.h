#pragma once
// Transformation of vectors and inertias across one joint, between the frames of a node and its parent. Templates on the scalar T.
// For kernels_*.cpp only.

#include "ugoki/dynamics/kernels.h"
#include "ugoki/spatial/lanes_elementary.h"
#include "ugoki/spatial/spatial.h"

namespace ugoki::dynamics {
namespace {  // NOLINT(google-build-namespaces): see spatial/lanes.h

#define UGOKI_INLINE inline __attribute__((always_inline))

template <class T>
using V3 = Vec3T<T>;

template <class T, class Constant>
UGOKI_INLINE V3<T> vector_of(const Constant* p) {
  return {T(p[0]), T(p[1]), T(p[2])};
}
template <class T, class Constant>
UGOKI_INLINE Sym3T<T> symmetric_of(const Constant* p) {
  return {T(p[0]), T(p[1]), T(p[2]), T(p[3]), T(p[4]), T(p[5])};
}
template <class T, class Constant>
UGOKI_INLINE Mat3T<T> matrix_of(const Constant* p) {
  return {T(p[0]), T(p[1]), T(p[2]), T(p[3]), T(p[4]), T(p[5]), T(p[6]), T(p[7]), T(p[8])};
}
template <class Real>
UGOKI_INLINE bool is_zero(Real x) {
  return x == Real(0);
}
template <class Real, int N>
UGOKI_INLINE bool is_zero(const LaneArray<Real, N>& x) {
  bool zero = true;
  for (const Real a : x.x) zero = zero && a == Real(0);
  return zero;
}
template <class T>
UGOKI_INLINE T load(const typename T::Real* array, int i, std::ptrdiff_t stride) {
  return T::load(array + i * stride);
}

/// Applies the cyclic permutation K of x, y, z (see Crossing), from the child's axes to the parent's axes. exchange_down() is the inverse.
template <Crossing K, class T>
UGOKI_INLINE V3<T> exchange_up(const V3<T>& v) {
  if constexpr (K == Crossing::cycle) return {v.z, v.x, v.y};
  if constexpr (K == Crossing::cycle_back) return {v.y, v.z, v.x};
  return v;
}
template <Crossing K, class T>
UGOKI_INLINE V3<T> exchange_down(const V3<T>& v) {
  if constexpr (K == Crossing::cycle) return {v.y, v.z, v.x};
  if constexpr (K == Crossing::cycle_back) return {v.z, v.x, v.y};
  return v;
}
template <Crossing K, class T>
UGOKI_INLINE Sym3T<T> exchange_up(const Sym3T<T>& s) {
  if constexpr (K == Crossing::cycle) return {s.zz, s.xx, s.yy, s.xz, s.yz, s.xy};
  if constexpr (K == Crossing::cycle_back) return {s.yy, s.zz, s.xx, s.yz, s.xy, s.xz};
  return s;
}
template <Crossing K, class T>
UGOKI_INLINE Mat3T<T> exchange_up(const Mat3T<T>& m) {
  if constexpr (K == Crossing::cycle) return {m.zz, m.zx, m.zy, m.xz, m.xx, m.xy, m.yz, m.yx, m.yy};
  if constexpr (K == Crossing::cycle_back) return {m.yy, m.yz, m.yx, m.zy, m.zz, m.zx, m.xy, m.xz, m.xx};
  return m;
}

/// Rotation of a revolute joint about z with the sine s and cosine c of its angle, followed by the permutation K.
/// up(): from the node's axes to the parent's axes; down(): the inverse.
template <class T, Crossing K>
struct RevoluteCrossing {
  T s, c;

  UGOKI_INLINE V3<T> up(const V3<T>& v) const { return exchange_up<K>(V3<T>{c * v.x - s * v.y, s * v.x + c * v.y, v.z}); }
  UGOKI_INLINE V3<T> down(const V3<T>& parent) const {
    const V3<T> v = exchange_down<K>(parent);
    return {c * v.x + s * v.y, c * v.y - s * v.x, v.z};
  }
  UGOKI_INLINE Sym3T<T> up(const Sym3T<T>& a) const {
    const T cs = c * s, cc = c * c, ss = s * s;
    const T difference = a.xx - a.yy;
    const T xx = a.yy + cc * difference - (cs + cs) * a.xy;
    return exchange_up<K>(
        Sym3T<T>{xx, (a.xx + a.yy) - xx, a.zz, cs * difference + (cc - ss) * a.xy, c * a.xz - s * a.yz, s * a.xz + c * a.yz});
  }
  UGOKI_INLINE Mat3T<T> up(const Mat3T<T>& a) const {
    const T cs = c * s, cc = c * c, ss = s * s;
    const T difference = a.xx - a.yy;
    const T xx = a.yy + cc * difference - cs * (a.xy + a.yx);
    const T xy = cs * difference + cc * a.xy - ss * a.yx;
    return exchange_up<K>(Mat3T<T>{xx, xy, c * a.xz - s * a.yz, xy - (a.xy - a.yx), (a.xx + a.yy) - xx, s * a.xz + c * a.yz,
                                   c * a.zx - s * a.zy, s * a.zx + c * a.zy, a.zz});
  }
};

/// Joint with any rotation, given as a matrix. up() and down() as in RevoluteCrossing.
template <class T>
struct MatrixCrossing {
  Mat3T<T> E;  ///< rotation from the node's axes to the parent's axes

  UGOKI_INLINE V3<T> up(const V3<T>& v) const { return E * v; }
  UGOKI_INLINE V3<T> down(const V3<T>& v) const { return transpose_times(E, v); }
  UGOKI_INLINE Sym3T<T> up(const Sym3T<T>& s) const {
    const V3<T> x = s * E.row(0), y = s * E.row(1), z = s * E.row(2);  // columns of s E^T
    return {dot(E.row(0), x), dot(E.row(1), y), dot(E.row(2), z), dot(E.row(0), y), dot(E.row(0), z), dot(E.row(1), z)};
  }
  UGOKI_INLINE Mat3T<T> up(const Mat3T<T>& m) const { return E * (m * E.transposed()); }
};

// Constant vectors of a node are often parallel to a coordinate axis. The functions below use only the nonzero coordinates of such a
// vector. The argument `present` lists these coordinates (Axes in link_program.h).

/// x times NodeConstants::sign. For a pair of twins (link_twins.h) the sign has one value per lane, because the twins' signs may differ.
template <class T, class Constant>
UGOKI_INLINE T with_sign(const NodeOrder& o, const NodeConstants<Constant>& c, T x) {
  if constexpr (std::is_same_v<Constant, typename T::Real>)
    return o.reversed ? -x : x;
  else
    return x * T(c.sign);
}
/// Calls f(k, x[k]) for each axis k in `present`; k is a compile-time constant.
template <class T, class Constant, class F>
UGOKI_INLINE void for_axes(Axes present, const Constant* x, F&& f) {
  if ((present & 1) != 0) f(std::integral_constant<int, 0>{}, T(x[0]));
  if ((present & 2) != 0) f(std::integral_constant<int, 1>{}, T(x[1]));
  if ((present & 4) != 0) f(std::integral_constant<int, 2>{}, T(x[2]));
}

template <int k, class T>
UGOKI_INLINE auto& entry(T& v) {
  if constexpr (k == 0) return v.x;
  if constexpr (k == 1) return v.y;
  if constexpr (k == 2) return v.z;
}
template <int i, int j, class T>
UGOKI_INLINE T& entry(Sym3T<T>& s) {
  if constexpr (i == j) {
    if constexpr (i == 0) return s.xx;
    if constexpr (i == 1) return s.yy;
    if constexpr (i == 2) return s.zz;
  } else {
    if constexpr (i + j == 1) return s.xy;
    if constexpr (i + j == 2) return s.xz;
    if constexpr (i + j == 3) return s.yz;
  }
}
template <int i, int j, class T>
UGOKI_INLINE T& entry(Mat3T<T>& m) {
  if constexpr (i == 0) return j == 0 ? m.xx : j == 1 ? m.xy : m.xz;
  if constexpr (i == 1) return j == 0 ? m.yx : j == 1 ? m.yy : m.yz;
  if constexpr (i == 2) return j == 0 ? m.zx : j == 1 ? m.zy : m.zz;
}

/// out <- out + x (e_k x v)
template <int k, class T>
UGOKI_INLINE void add_cross(V3<T>& out, T x, const V3<T>& v) {
  constexpr int i = (k + 1) % 3, j = (k + 2) % 3;
  entry<i>(out) -= x * entry<j>(v);
  entry<j>(out) += x * entry<i>(v);
}
constexpr Axes all_axes = 7;  // computed in one expression, with shorter dependency chains than axis by axis

/// out <- out + c x v
template <class T, class Constant>
UGOKI_INLINE void add_cross(V3<T>& out, Axes present, const Constant* c, const V3<T>& v) {
  if (present == all_axes)
    out += cross(vector_of<T>(c), v);
  else
    for_axes<T>(present, c, [&](auto k, T x) { add_cross<k>(out, x, v); });
}
/// out <- out + v x c
template <class T, class Constant>
UGOKI_INLINE void subtract_cross(V3<T>& out, Axes present, const Constant* c, const V3<T>& v) {
  if (present == all_axes)
    out += cross(v, vector_of<T>(c));
  else
    for_axes<T>(present, c, [&](auto k, T x) { add_cross<k>(out, -x, v); });
}
/// out <- out + A c
template <class T, class Constant>
UGOKI_INLINE void add_product(V3<T>& out, const Mat3T<T>& A, Axes present, const Constant* c) {
  if (present == all_axes)
    out += A * vector_of<T>(c);
  else
    for_axes<T>(present, c, [&](auto k, T x) {
      out += (k == 0 ? V3<T>{A.xx, A.yx, A.zx} : k == 1 ? V3<T>{A.xy, A.yy, A.zy} : V3<T>{A.xz, A.yz, A.zz}) * x;
    });
}

/// Returns w x (w x (x e_k)), e_k: unit vector of axis k.
template <int k, class T>
UGOKI_INLINE V3<T> centripetal(const V3<T>& w, T x) {
  constexpr int i = (k + 1) % 3, j = (k + 2) % 3;
  const T a = entry<i>(w), b = entry<j>(w), along = entry<k>(w) * x;
  V3<T> out;
  entry<i>(out) = a * along;
  entry<j>(out) = b * along;
  entry<k>(out) = -(x * (a * a + b * b));
  return out;
}
/// w x (w x c) for a nonzero c
template <class T, class Constant>
UGOKI_INLINE V3<T> centripetal(const V3<T>& w, Axes present, const Constant* c) {
  switch (present) {
    case 1: return centripetal<0>(w, T(c[0]));
    case 2: return centripetal<1>(w, T(c[1]));
    case 4: return centripetal<2>(w, T(c[2]));
    default: return cross(w, cross(w, vector_of<T>(c)));
  }
}

/// Rotation matrix of the unit quaternion at q (w first).
template <class T>
UGOKI_INLINE Mat3T<T> matrix_of_quaternion(const typename T::Real* q, std::ptrdiff_t stride) {
  const T w = load<T>(q, 0, stride), x = load<T>(q, 1, stride), y = load<T>(q, 2, stride), z = load<T>(q, 3, stride);
  const T one(1), two(2);
  const T xx = x * x, yy = y * y, zz = z * z, xy = x * y, xz = x * z, yz = y * z, wx = w * x, wy = w * y, wz = w * z;
  return {one - two * (yy + zz), two * (xy - wz), two * (xz + wy), two * (xy + wz),      one - two * (xx + zz),
          two * (yz - wx),       two * (xz - wy), two * (yz + wx), one - two * (xx + yy)};
}

/// Returns R times the rotation about z by the angle whose sine is s and cosine is c.
template <class T>
UGOKI_INLINE Mat3T<T> turned_about_z(const Mat3T<T>& R, T s, T c) {
  return {R.xx * c + R.xy * s, R.xy * c - R.xx * s, R.xz, R.yx * c + R.yy * s, R.yy * c - R.yx * s, R.yz,
          R.zx * c + R.zy * s, R.zy * c - R.zx * s, R.zz};
}

/// Allocates arrays one after another from scratch memory, each on a boundary of 64 bytes. Never frees.
class Scratch {
 public:
  explicit Scratch(std::byte* begin) : next_(begin) {}
  template <class X>
  X* take(int n) {
    X* const at = reinterpret_cast<X*>(next_);
    next_ += (sizeof(X) * static_cast<std::size_t>(n) + 63) / 64 * 64;
    return at;
  }

 private:
  std::byte* next_;
};

/// Sines and cosines of the angles q[angle_q[i]] * angle_sign[i], i < count.
/// @param s, c [count + 15, out] entries from `count` on may be overwritten
UGOKI_INLINE void sines_of(const double* q, const int* angle_q, const double* angle_sign, int count, double* s, double* c) {
  using Wide = Lanes<double, 2 * UGOKI_DOUBLE_LANES>;  // two registers: their polynomials are independent and overlap in the pipeline
  for (int i = 0; i < count; ++i) s[i] = q[angle_q[i]] * angle_sign[i];
  for (int i = count; i % Wide::count != 0; ++i) s[i] = 0;
  for (int i = 0; i < count; i += Wide::count) {
    const LaneSinCos<Wide> sc = lane_sin_cos(Wide::load(s + i));
    sc.sin.store(s + i);
    sc.cos.store(c + i);
  }
}

/// Data that all kernels share: the rotation of every joint, and the external wrenches in the nodes' frames.
/// @tparam Constant type of a node's constants: Real; for twins (link_twins.h) LaneArray, one value per lane
template <class T, class Constant = typename T::Real>
struct Pass {
  using Real = typename T::Real;
  static constexpr bool twins = !std::is_same_v<Constant, Real>;
  const KernelArguments<Real, Constant>& a;
  Scratch scratch;
  T* sin;            ///< [angles] sine of each joint angle
  T* cos;            ///< [angles] cosine of each joint angle
  Mat3T<T>* E;       ///< [nodes] rotation(i), node axes to parent axes; floating nodes: without constants[i].R; only for Crossing::matrix
  Vec6T<T>* wrench;  ///< [nodes] external wrench in the node's axes about its origin, or null

  explicit Pass(const KernelArguments<Real, Constant>& arguments)
      : a(arguments),
        scratch(a.scratch),
        sin(a.sin != nullptr ? reinterpret_cast<T*>(a.sin) : scratch.take<T>(a.angles + 16)),
        cos(a.sin != nullptr ? reinterpret_cast<T*>(a.cos) : scratch.take<T>(a.angles + 16)),
        E(scratch.take<Mat3T<T>>(a.nodes)),
        wrench(nullptr) {}

  /// Computes sines and cosines of all angles (unless the arguments provide them), and the matrices E.
  void prepare() {
    if constexpr (sizeof(Real) == 8 && (T::count == 1 || twins)) {
      if (a.sin == nullptr)
        sines_of(a.q, a.angle_q, a.angle_sign, a.angles, reinterpret_cast<double*>(sin), reinterpret_cast<double*>(cos));
    } else {
      // Two angles at once: the polynomials of the two are independent and overlap in the pipeline.
      using Two = Lanes<Real, 2 * T::count>;
      for (int i = 0; i < a.angles; i += 2) {
        Real x[Two::count] = {};
        for (int k = i; k < i + 2 && k < a.angles; ++k)
          (load<T>(a.q, a.angle_q[k], a.stride) * T(static_cast<Real>(a.angle_sign[k]))).store(x + (k - i) * T::count);
        const LaneSinCos<Two> sc = lane_sin_cos(Two::load(x));
        sc.sin.store(reinterpret_cast<Real*>(sin + i));
        sc.cos.store(reinterpret_cast<Real*>(cos + i));
      }
    }
    for (int i = 0; i < a.nodes; ++i)
      if (a.order[i].crossing == Crossing::matrix) E[i] = rotation(i);
  }

  /// Rotation matrix E of node i.
  Mat3T<T> rotation(int i) const {
    const NodeOrder& o = a.order[i];
    const Mat3T<T> R = matrix_of<T>(a.constants[i].R);
    switch (o.kind) {
      case NodeKind::prismatic: return R;
      case NodeKind::floating: return matrix_of_quaternion<T>(a.q + (o.q + 3) * a.stride, a.stride);
      case NodeKind::spherical: {
        const Mat3T<T> J = matrix_of_quaternion<T>(a.q + o.q * a.stride, a.stride);
        return o.turned ? R * J : J;
      }
      default: return turned_about_z(R, sin[o.angle], cos[o.angle]);
    }
  }

  template <Crossing K>
  UGOKI_INLINE RevoluteCrossing<T, K> revolute(const NodeOrder& o) const {
    return {sin[o.angle], cos[o.angle]};
  }

  /// The node's origin in the parent's frame.
  UGOKI_INLINE V3<T> origin(int i) const {
    const NodeOrder& o = a.order[i];
    const NodeConstants<Constant>& c = a.constants[i];
    V3<T> r = vector_of<T>(c.p);
    if (o.kind == NodeKind::prismatic) r += V3<T>{T(c.R[2]), T(c.R[5]), T(c.R[8])} * (load<T>(a.q, o.q, a.stride) * T(c.sign));
    if (o.kind == NodeKind::helical) r += V3<T>{T(c.R[2]), T(c.R[5]), T(c.R[8])} * (load<T>(a.q, o.q, a.stride) * (T(c.sign) * T(c.pitch)));
    if (o.kind == NodeKind::floating)
      r += matrix_of<T>(c.R) * V3<T>{load<T>(a.q, o.q, a.stride), load<T>(a.q, o.q + 1, a.stride), load<T>(a.q, o.q + 2, a.stride)};
    return r;
  }

  /// Transforms a vector from the parent's axes to the axes of node i, for any kind of crossing.
  V3<T> down(int i, const V3<T>& parent) const {
    const NodeOrder& o = a.order[i];
    switch (o.crossing) {
      case Crossing::none: return revolute<Crossing::none>(o).down(parent);
      case Crossing::cycle: return revolute<Crossing::cycle>(o).down(parent);
      case Crossing::cycle_back: return revolute<Crossing::cycle_back>(o).down(parent);
      case Crossing::matrix: break;
    }
    const bool twice = o.kind == NodeKind::floating && o.turned;  // E of a floating node does not include R, so R is applied too
    return transpose_times(E[i], twice ? transpose_times(matrix_of<T>(a.constants[i].R), parent) : parent);
  }

  /// Adds up the links' external wrenches for each node, transformed from world axes about the world origin to the node's frame.
  void transform_wrenches() {
    if (a.external == nullptr) return;
    struct Frame {
      V3<T> x, y, z, p;  // world axes x, y, z in node axes; origin of the node in world axes
    };
    Frame* const frames = scratch.take<Frame>(a.nodes);
    wrench = scratch.take<Vec6T<T>>(a.nodes);
    const T none(0), one(1);
    for (int i = 0; i < a.nodes; ++i) wrench[i] = {{none, none, none}, {none, none, none}};
    for (int l = 0; l < a.link_count; ++l) {
      if (a.links[l].node < 0) continue;
      const auto at = [&](int k) { return load<T>(a.external, 6 * l + k, a.stride); };
      wrench[a.links[l].node] += Vec6T<T>{{at(0), at(1), at(2)}, {at(3), at(4), at(5)}};
    }
    const Frame world{{one, none, none}, {none, one, none}, {none, none, one}, {none, none, none}};
    for (int i = 0; i < a.nodes; ++i) {
      const Frame& up = a.order[i].parent < 0 ? world : frames[a.order[i].parent];
      const V3<T> r = origin(i);
      const V3<T> p = up.p + V3<T>{dot(up.x, r), dot(up.y, r), dot(up.z, r)};
      const Frame frame{down(i, up.x), down(i, up.y), down(i, up.z), p};
      const V3<T> f = wrench[i].v, n = wrench[i].w - cross(p, f);
      wrench[i] = {frame.x * n.x + frame.y * n.y + frame.z * n.z, frame.x * f.x + frame.y * f.y + frame.z * f.z};
      frames[i] = frame;
    }
  }
};

}  // namespace
}  // namespace ugoki::dynamics
