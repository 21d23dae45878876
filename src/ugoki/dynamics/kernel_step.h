#pragma once
// Semi-implicit Euler step of one SIMD register of instances: v += dt vdot, then q is integrated with the new v on the configuration
// manifold, with the same result as joint_integrate(). For kernels_*.cpp only.

#include "ugoki/dynamics/kernel_crossing.h"

namespace ugoki::dynamics {
namespace {  // NOLINT(google-build-namespaces): see spatial/lanes.h

template <class T>
class StepKernel {
 public:
  using Real = typename T::Real;
  using Mask = typename T::Mask;

  /// @param a arguments, with vdot as `in` @param q, v [in and out] @param dt s @param stays lanes whose q and v must not change
  StepKernel(const KernelArguments<Real>& a, Real* q, Real* v, Real dt, Mask stays) : a_(a), q_(q), v_(v), dt_(dt), stays_(stays) {}

  void run() {
    for (int k = 0; k < a_.nv; ++k) put(v_, k, at(v_, k) + at(a_.in, k) * dt_);
    for (int i = 0; i < a_.nodes; ++i) {
      const NodeOrder& o = a_.order[i];
      if (o.kind == NodeKind::floating) {
        for (int k = 0; k < 3; ++k) slide(o.q + k, o.v + 3 + k);
        turn(o.q + 3, o.v);
      } else if (o.kind == NodeKind::spherical) {
        turn(o.q, o.v);
      } else {
        slide(o.q, o.v);
      }
    }
  }

 private:
  UGOKI_INLINE T at(const Real* x, int k) const { return load<T>(x, k, a_.stride); }
  UGOKI_INLINE void put(Real* x, int k, T value) const { select(stays_, at(x, k), value).store(x + k * a_.stride); }
  UGOKI_INLINE void slide(int q, int v) const { put(q_, q, at(q_, q) + at(v_, v) * dt_); }

  /// Multiplies the unit quaternion at index q by the exponential of the rotation vector w dt, and normalises it. w is the angular velocity
  /// at index v.
  void turn(int q, int v) const {
    const T one(1), half(Real(0.5));
    const V3<T> r{at(v_, v) * dt_, at(v_, v + 1) * dt_, at(v_, v + 2) * dt_};
    const T square = dot(r, r), angle = sqrt(square);
    const auto small = !(angle > T(Real(1e-4)));
    const LaneSinCos<T> sc = lane_sin_cos(half * angle);
    const T f = select(small, half - square * T(Real(1.0 / 48.0)), sc.sin / angle);
    const T w = select(small, one - square * T(Real(1.0 / 8.0)), sc.cos);
    const T bw = at(q_, q);
    const V3<T> b{at(q_, q + 1), at(q_, q + 2), at(q_, q + 3)}, d = r * f;
    const T x = bw * w - dot(b, d);
    const V3<T> y = d * bw + b * w + cross(b, d);
    const T scale = one / sqrt(x * x + dot(y, y));
    put(q_, q, x * scale);
    put(q_, q + 1, y.x * scale);
    put(q_, q + 2, y.y * scale);
    put(q_, q + 3, y.z * scale);
  }

  const KernelArguments<Real>& a_;
  Real *q_, *v_;
  T dt_;
  Mask stays_;
};

}  // namespace
}  // namespace ugoki::dynamics
