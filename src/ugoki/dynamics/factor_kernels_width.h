#pragma once
// The kernels of factor_kernels.h for one SIMD width. Each factor_kernels_*.cpp defines UGOKI_WIDTH (the namespace of the table), and
// includes this header once. The functions are local to the file, so that no code for a wide register is called on other processors.

#include <cmath>

#include "ugoki/dynamics/factor_kernels.h"

namespace ugoki::dynamics {
namespace {

/// Four numbers in SIMD lanes. Lanes do not affect each other.
typedef double Four __attribute__((vector_size(32), aligned(8), may_alias));

inline const Four& low(const Eight& e) { return *reinterpret_cast<const Four*>(e.x); }
inline const Four& high(const Eight& e) { return *reinterpret_cast<const Four*>(e.x + 4); }
inline Four& low(Eight& e) { return *reinterpret_cast<Four*>(e.x); }
inline Four& high(Eight& e) { return *reinterpret_cast<Four*>(e.x + 4); }

/// Scalar product. The order of the additions is fixed.
inline double product(const Eight& a, const Eight& b) {
  const Four sum = low(a) * low(b) + high(a) * high(b);
  return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

int eliminate(FactorDof* dofs, std::size_t n, const Vec6* S, const double* armature, const double* extra, Eight* inertias) {
  for (std::size_t k = n; k-- > 0;) {
    FactorDof& dof = dofs[k];
    Eight* const A = inertias + 6 * dof.inertia;
    const Vec6& column = S[k];
    const double s[6] = {column.w.x, column.w.y, column.w.z, column.v.x, column.v.y, column.v.z};
    Four u = low(A[0]) * s[0], u_high = high(A[0]) * s[0];
    for (int i = 1; i < 6; ++i) {
      u += low(A[i]) * s[i];
      u_high += high(A[i]) * s[i];
    }
    low(dof.S) = Four{s[0], s[1], s[2], s[3]};
    high(dof.S) = Four{s[4], s[5], 0, 0};
    low(dof.U) = u;
    high(dof.U) = u_high;
    const double pivot = product(dof.S, dof.U) + armature[k] + (extra == nullptr ? 0.0 : extra[k]);
    if (!(pivot > 0) || !std::isfinite(pivot)) return static_cast<int>(k);
    dof.pivot = pivot;
    dof.inverse = 1 / pivot;
    dof.root = std::sqrt(dof.inverse);
    if (dof.parent < 0) continue;
    Eight* const up = inertias + 6 * dofs[dof.parent].inertia;
    if (up == A) {
      for (int i = 0; i < 6; ++i) {
        const double t = dof.U.x[i] * dof.inverse;
        low(A[i]) -= t * u;
        high(A[i]) -= t * u_high;
      }
      continue;
    }
    for (int i = 0; i < 6; ++i) {
      const double t = dof.U.x[i] * dof.inverse;
      low(up[i]) += low(A[i]) - t * u;
      high(up[i]) += high(A[i]) - t * u_high;
    }
  }
  return -1;
}

/// Sets a to the acceleration of the link that the DOF moves, from that of its parent.
/// @param change acceleration of the DOF without that of its parent @return acceleration of the DOF
inline double accelerate(const FactorDof& dof, const Eight* scratch, double change, Eight& a) {
  if (dof.parent < 0) {
    low(a) = low(dof.S) * change;
    high(a) = high(dof.S) * change;
    return change;
  }
  const Eight& up = scratch[dof.parent];
  change -= dof.inverse * product(dof.U, up);
  low(a) = low(up) + low(dof.S) * change;
  high(a) = high(up) + high(dof.S) * change;
  return change;
}

void solve(const FactorDof* dofs, std::size_t n, Eight* scratch, double* x) {
  for (std::size_t k = n; k-- > 0;) {
    const FactorDof& dof = dofs[k];
    const double change = dof.inverse * (dof.leaf ? x[k] : x[k] - product(dof.S, scratch[k]));
    x[k] = change;
    if (dof.parent < 0) continue;
    Four f = low(dof.U) * change, f_high = high(dof.U) * change;
    if (!dof.leaf) {
      f = low(scratch[k]) + f;
      f_high = high(scratch[k]) + f_high;
    }
    Eight& up = scratch[dof.parent];
    low(up) = dof.last_child ? f : low(up) + f;
    high(up) = dof.last_child ? f_high : high(up) + f_high;
  }
  for (std::size_t k = 0; k < n; ++k) x[k] = accelerate(dofs[k], scratch, x[k], scratch[k]);
}

void whiten_wrenches(const FactorDof* dofs, int last, const Vec6* f, double* y) {
  Four w[6] = {{f[0].w.x, f[1].w.x, f[2].w.x, 0}, {f[0].w.y, f[1].w.y, f[2].w.y, 0}, {f[0].w.z, f[1].w.z, f[2].w.z, 0},
               {f[0].v.x, f[1].v.x, f[2].v.x, 0}, {f[0].v.y, f[1].v.y, f[2].v.y, 0}, {f[0].v.z, f[1].v.z, f[2].v.z, 0}};
  for (int k = last; k >= 0;) {
    const FactorDof& dof = dofs[k];
    const double* const S = dof.S.x;
    const Four s = (S[0] * w[0] + S[1] * w[1] + S[2] * w[2]) + (S[3] * w[3] + S[4] * w[4] + S[5] * w[5]);
    const Four t = s * dof.inverse;
    *reinterpret_cast<Four*>(y + 4 * dof.depth) = s * dof.root;
    for (int j = 0; j < 6; ++j) w[j] -= dof.U.x[j] * t;
    k = dof.parent;
  }
}

void add_whitened(const FactorDof* dofs, std::size_t n, Eight* scratch, const double* w, double* v) {
  for (std::size_t k = 0; k < n; ++k) v[k] += accelerate(dofs[k], scratch, w[k] * dofs[k].root, scratch[k]);
}

}  // namespace

namespace UGOKI_WIDTH {
extern const FactorKernels factor_table;
const FactorKernels factor_table = {eliminate, solve, whiten_wrenches, add_whitened};
}  // namespace UGOKI_WIDTH

}  // namespace ugoki::dynamics
