#pragma once
// The kernels of link_kernels.h for one SIMD width. Each link_kernels_*.cpp defines UGOKI_WIDTH (the namespace of the table), and includes
// this header once. The functions are local to the file, so that no code for a wide register is called on other processors.

#include "ugoki/dynamics/link_kernels.h"
#include "ugoki/spatial/elementary.h"

// Vectors are passed only between functions of one file, so that a calling convention which depends on the registers does no harm.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace ugoki::dynamics {
namespace {

/// Four numbers in SIMD lanes. Lanes do not affect each other. A vector of three elements has an unused value in its last lane.
typedef double Four __attribute__((vector_size(32), aligned(8), may_alias));

inline Four load(const double* p) { return *reinterpret_cast<const Four*>(p); }
inline void store(double* p, Four x) { *reinterpret_cast<Four*>(p) = x; }
inline Four yzx(Four a) { return __builtin_shufflevector(a, a, 1, 2, 0, 3); }
/// a x b
inline Four cross(Four a, Four b) { return yzx(a * yzx(b) - yzx(a) * b); }
/// Sum of the first three lanes.
inline double sum(Four a) { return (a[0] + a[1]) + a[2]; }

/// A spatial vector: angular and linear part.
struct Spatial {
  Four w, v;
};
inline Spatial load(const Vec6& x) {
  const double* const p = &x.w.x;
  const Four high = load(p + 2);  // reading four elements from p + 3 would leave the vector
  return {load(p), __builtin_shufflevector(high, high, 1, 2, 3, 0)};
}
inline Spatial load_pair(const double* p) { return {load(p), load(p + 4)}; }
inline void store_pair(double* p, const Spatial& x) {
  store(p, x.w);
  store(p + 4, x.v);
}
inline void store(Vec6& to, const Spatial& x) {
  double* const p = &to.w.x;
  const Four v = __builtin_shufflevector(x.v, x.v, 1, 2, 3, 0);  // (v1, v2, -, v0)
  store(p, __builtin_shufflevector(x.w, v, 0, 1, 2, 7));
  p[4] = v[0];
  p[5] = v[1];
}
inline Spatial operator+(const Spatial& a, const Spatial& b) { return {a.w + b.w, a.v + b.v}; }
inline Spatial operator-(const Spatial& a, const Spatial& b) { return {a.w - b.w, a.v - b.v}; }
inline Spatial operator*(const Spatial& a, double s) { return {a.w * s, a.v * s}; }
inline double dot(const Spatial& a, const Spatial& b) { return sum(a.w * b.w + a.v * b.v); }

/// V x M of two motions
inline Spatial cross_motion(const Spatial& V, const Spatial& M) { return {cross(V.w, M.w), cross(V.w, M.v) + cross(V.v, M.w)}; }

/// C = A B for rotation matrices. @param A [9] row-major @param B [10] row-major, and an unused element @param C [10, out] the same
inline void multiply(const double* A, const double* B, double* C) {
  const Four b0 = load(B), b1 = load(B + 3), b2 = load(B + 6);
  for (int i = 0; i < 3; ++i) store(C + 3 * i, (b0 * A[3 * i] + b1 * A[3 * i + 1]) + b2 * A[3 * i + 2]);
}

/// Rotation matrix of a unit quaternion, with the operations of to_matrix(). @param R [9, out] row-major
inline void set_rotation(double w, double x, double y, double z, double* R) {
  const double xx = x * x, yy = y * y, zz = z * z, xy = x * y, xz = x * z, yz = y * z, wx = w * x, wy = w * y, wz = w * z;
  R[0] = 1 - 2 * (yy + zz);
  R[1] = 2 * (xy - wz);
  R[2] = 2 * (xz + wy);
  R[3] = 2 * (xy + wz);
  R[4] = 1 - 2 * (xx + zz);
  R[5] = 2 * (yz - wx);
  R[6] = 2 * (xz - wy);
  R[7] = 2 * (yz + wx);
  R[8] = 1 - 2 * (xx + yy);
}

inline bool is_identity(const double* R) {
  return R[0] == 1 && R[4] == 1 && R[8] == 1 && R[1] == 0 && R[2] == 0 && R[3] == 0 && R[5] == 0 && R[6] == 0 && R[7] == 0;
}

/// Columns of a rotation matrix. @param R [10] row-major, and an unused element
struct Columns {
  Four c[3];
  explicit Columns(const double* R) {
    const Four x = load(R), y = load(R + 3), z = load(R + 6);
    const Four even = __builtin_shufflevector(x, y, 0, 4, 2, 6), odd = __builtin_shufflevector(x, y, 1, 5, 3, 7);
    c[0] = __builtin_shufflevector(even, z, 0, 1, 4, 7);
    c[1] = __builtin_shufflevector(odd, z, 0, 1, 5, 7);
    c[2] = __builtin_shufflevector(even, z, 2, 3, 6, 7);
  }
};
/// (a0, a0, a1) and (a1, a2, a2): factors of the products xy, xz, yz.
inline Four first_factors(Four a) { return __builtin_shufflevector(a, a, 0, 0, 1, 3); }
inline Four second_factors(Four a) { return __builtin_shufflevector(a, a, 1, 2, 2, 3); }

/// Inertia about p0 of a body whose frame has the orientation R (columns c) and the origin r. With the first moment h in world axes and
/// e = h + m r / 2, the rotational inertia is R I R^T + 2 (r . e) 1 - r e^T - e r^T (parallel-axis theorem).
inline void set_inertia(const Inertia& body, const Columns& R, Four r, Inertia& out) {
  const Sym3& I = body.I;
  const Four* const c = R.c;
  const Four D[3] = {(c[0] * I.xx + c[1] * I.xy) + c[2] * I.xz, (c[0] * I.xy + c[1] * I.yy) + c[2] * I.yz,
                     (c[0] * I.xz + c[1] * I.yz) + c[2] * I.zz};  // columns of R I
  const Four h = (c[0] * body.h.x + c[1] * body.h.y) + c[2] * body.h.z, e = h + r * (0.5 * body.mass);
  const Four re = r * e;
  const Four diagonal = ((D[0] * c[0] + D[1] * c[1]) + D[2] * c[2]) + 2.0 * (yzx(re) + yzx(yzx(re)));  // without cancellation
  const Four rest = ((first_factors(D[0]) * second_factors(c[0]) + first_factors(D[1]) * second_factors(c[1])) +
                     first_factors(D[2]) * second_factors(c[2])) -
                    (first_factors(r) * second_factors(e) + second_factors(r) * first_factors(e));
  const Four moved = h + r * body.mass;
  double* const to = &out.mass;
  store(to, Four{body.mass, moved[0], moved[1], moved[2]});
  store(to + 4, Four{diagonal[0], diagonal[1], diagonal[2], rest[0]});
  to[8] = rest[1];
  to[9] = rest[2];
}

std::size_t kinematics(const KinematicsArguments& a, std::size_t begin, std::size_t end) {
  for (std::size_t i = begin; i < end; ++i) {
    const LinkPlace& place = a.places[i];
    if (place.type != JointType::fixed && place.type != JointType::revolute && place.type != JointType::spherical) return i;
    const Joint& joint = a.links[i].joint;
    const double *const q = a.q + place.q_index, *const v = a.v + place.v_index;
    const double* const X_PJ = &joint.X_PJ.R.xx;
    double* const X_WB = &a.X_WB[i].R.xx;
    double frame[12], turn[10];  // X_WJ, rotation of X_JB
    const double* X_WJ = X_PJ;
    Spatial V{};
    if (place.parent >= 0) {
      const double* const X_WP = &a.X_WB[place.parent].R.xx;
      if (is_identity(X_PJ)) {
        store(frame, load(X_WP));
        store(frame + 4, load(X_WP + 4));
        frame[8] = X_WP[8];
      } else {
        multiply(X_WP, X_PJ, frame);
      }
      for (int k = 0; k < 3; ++k)
        frame[9 + k] = ((X_WP[3 * k] * X_PJ[9] + X_WP[3 * k + 1] * X_PJ[10]) + X_WP[3 * k + 2] * X_PJ[11]) + X_WP[9 + k];
      X_WJ = frame;
      V = load(a.V[place.parent]);
    }
    if (place.type == JointType::fixed) {
      store(X_WB, load(X_WJ));
      store(X_WB + 4, load(X_WJ + 4));
    } else if (place.type == JointType::revolute) {
      const SinCos sc = sin_cos(0.5 * q[0]);
      set_rotation(sc.cos, joint.axis.x * sc.sin, joint.axis.y * sc.sin, joint.axis.z * sc.sin, turn);
      multiply(X_WJ, turn, X_WB);
    } else {
      set_rotation(q[0], q[1], q[2], q[3], turn);
      multiply(X_WJ, turn, X_WB);
    }
    if (place.type == JointType::fixed) X_WB[8] = X_WJ[8];
    for (int k = 9; k < 12; ++k) X_WB[k] = X_WJ[k];
    if (i == 0) *a.p0 = {X_WB[9], X_WB[10], X_WB[11]};
    const Four r{X_WB[9] - a.p0->x, X_WB[10] - a.p0->y, X_WB[11] - a.p0->z, 0};
    const Columns R(X_WB);

    Spatial C{};
    if (place.type == JointType::revolute) {
      const Vec3& n = joint.axis;
      const Four axis{(X_WJ[0] * n.x + X_WJ[1] * n.y) + X_WJ[2] * n.z, (X_WJ[3] * n.x + X_WJ[4] * n.y) + X_WJ[5] * n.z,
                      (X_WJ[6] * n.x + X_WJ[7] * n.y) + X_WJ[8] * n.z, 0};
      const Spatial S{axis, cross(r, axis)};
      store(a.S[place.v_index], S);
      const Spatial vJ = S * v[0];
      C = cross_motion(V, vJ);  // vJ x vJ = 0
      V = V + vJ;
    } else if (place.type == JointType::spherical) {
      for (int k = 0; k < 3; ++k) store(a.S[place.v_index + k], Spatial{R.c[k], cross(r, R.c[k])});
      const Four w = (R.c[0] * v[0] + R.c[1] * v[1]) + R.c[2] * v[2];
      const Spatial vJ{w, cross(r, w)};
      C = cross_motion(V, vJ);
      V = V + vJ;
    }
    store(a.V[i], V);
    store(a.C[i], C);
    if (a.I != nullptr) set_inertia(a.links[i].inertia, R, r, a.I[i]);
  }
  return end;
}

/// Force I A + V x* (I V) of a body: momentum I X = (I w + h x v, m v - h x w), V x* F = (w x F.w + v x F.v, w x F.v).
inline Spatial body_force(const Inertia& body, const Spatial& A, const Spatial& V) {
  const Four diagonal = load(&body.I.xx), rest = load(&body.I.zz);  // rest: zz, xy, xz, yz
  const Four near = __builtin_shufflevector(rest, rest, 1, 1, 2, 0), far = __builtin_shufflevector(rest, rest, 2, 3, 3, 0);
  const Four h = load(&body.h.x), h_yzx = yzx(h);
  const auto times = [&](const Spatial& X) -> Spatial {
    const Four w_yzx = yzx(X.w);
    const Four turned =
        (diagonal * X.w + near * __builtin_shufflevector(X.w, X.w, 1, 0, 0, 3)) + far * __builtin_shufflevector(X.w, X.w, 2, 2, 1, 3);
    return {turned + yzx(h * yzx(X.v) - h_yzx * X.v), X.v * body.mass - yzx(h * w_yzx - h_yzx * X.w)};
  };
  const Spatial force = times(A), momentum = times(V);
  return {(force.w + cross(V.w, momentum.w)) + cross(V.v, momentum.v), force.v + cross(V.w, momentum.v)};
}

/// Sums the forces from the tips to the base. @param F [links][link_scratch], in: forces on the links, out: forces through their joints
template <bool has_acceleration>
void collect(const LinkArguments& a, double* F) {
  for (std::size_t i = a.links; i-- > 0;) {
    const LinkPlace& link = a.places[i];
    const Spatial f = load_pair(F + link_scratch * i);
    for (int k = link.v_index; k < link.v_index + link.nv; ++k) {
      a.tau[k] = dot(load(a.S[k]), f);
      if (has_acceleration) a.tau[k] += a.armature[k] * a.vdot[k];
    }
    store(a.F[i], f);
    if (link.parent < 0) continue;
    double* const up = F + link_scratch * static_cast<std::size_t>(link.parent);
    store_pair(up, load_pair(up) + f);
  }
}

inline Spatial base_acceleration(const LinkArguments& a) { return {Four{}, Four{-a.gravity[0], -a.gravity[1], -a.gravity[2], 0}}; }

void inverse(const LinkArguments& a) {
  double* const F = a.scratch + 8;
  for (std::size_t i = 0; i < a.links; ++i) {
    const LinkPlace& link = a.places[i];
    double* const own = a.scratch + link_scratch * i;  // acceleration, force
    Spatial A = link.parent >= 0 ? load_pair(a.scratch + link_scratch * static_cast<std::size_t>(link.parent)) : base_acceleration(a);
    A = A + load(a.C[i]);
    if (a.vdot != nullptr)
      for (int k = link.v_index; k < link.v_index + link.nv; ++k) A = A + load(a.S[k]) * a.vdot[k];
    store_pair(own, A);
    Spatial f = body_force(a.I[i], A, load(a.V[i]));
    if (a.external != nullptr) f = f - load(a.external[i]);
    store_pair(own + 8, f);
  }
  if (a.vdot != nullptr)
    collect<true>(a, F);
  else
    collect<false>(a, F);
}

void bias(const LinkArguments& a) {
  double* const F = a.scratch + 8;
  for (std::size_t i = 0; i < a.links; ++i) {
    const LinkPlace& link = a.places[i];
    double* const own = a.scratch + link_scratch * i;  // acceleration, force, velocity
    Spatial vJ{};
    for (int k = link.v_index; k < link.v_index + link.nv; ++k) vJ = vJ + load(a.S[k]) * a.vdot[k];
    Spatial V = vJ, A = base_acceleration(a);
    if (link.parent >= 0) {
      const double* const up = a.scratch + link_scratch * static_cast<std::size_t>(link.parent);
      V = V + load_pair(up + 16);
      A = load_pair(up);
    }
    A = A + cross_motion(V, vJ);
    if (has_joint_bias(link.type)) A = A + load(a.C[i]);
    store_pair(own, A);
    store_pair(own + 16, V);
    Spatial f{};
    if (a.I[i].mass > 0) f = body_force(a.I[i], A, V);
    if (a.external != nullptr) f = f - load(a.external[i]);
    store_pair(own + 8, f);
  }
  collect<false>(a, F);
}

}  // namespace

namespace UGOKI_WIDTH {
extern const LinkKernels link_table;
const LinkKernels link_table = {kinematics, inverse, bias};
}  // namespace UGOKI_WIDTH

}  // namespace ugoki::dynamics
