#pragma once
// The kernel table of one SIMD width. Each kernels_*.cpp defines UGOKI_WIDTH (the namespace of the table), UGOKI_DOUBLE_LANES and
// UGOKI_FLOAT_LANES, and includes this header once. With UGOKI_NO_BATCH the table has no kernels for batches, and batch.cpp is not built.

#include "ugoki/dynamics/kernel_forward.h"
#include "ugoki/dynamics/kernel_inertia.h"
#include "ugoki/dynamics/kernel_inverse.h"
#include "ugoki/dynamics/kernel_step.h"
#include "ugoki/dynamics/kernel_twins.h"

namespace ugoki::dynamics {
namespace {

using One = Lanes<double, 1>;
template <class Real>
using Wide = Lanes<Real, sizeof(Real) == 8 ? UGOKI_DOUBLE_LANES : UGOKI_FLOAT_LANES>;

template <class T>
void inverse(const KernelArguments<typename T::Real>& a) {
  InverseKernel<T>(a).run();
}
bool forward_one(const KernelArguments<double>& a) { return !ForwardKernel<One>(a).run()[0]; }
void inertia_one(const KernelArguments<double>& a) { InertiaKernel<One>(a).run(); }

bool forward_twins(const TwinArguments& a) { return twins::Forward(a).run(); }

#ifndef UGOKI_NO_BATCH
template <class T>
unsigned forward_batch(const KernelArguments<typename T::Real>& a) {
  const typename T::Mask bad = ForwardKernel<T>(a).run();
  unsigned out = 0;
  for (int i = 0; i < T::count; ++i) out |= bad[i] ? 1U << i : 0U;
  return out;
}

template <class T>
void step_batch(const KernelArguments<typename T::Real>& a, typename T::Real* q, typename T::Real* v, typename T::Real dt, unsigned stays) {
  typename T::Real flags[T::count];
  for (int i = 0; i < T::count; ++i) flags[i] = (stays >> i & 1U) != 0 ? typename T::Real(1) : typename T::Real(0);
  StepKernel<T>(a, q, v, dt, T::load(flags) > T(0)).run();
}
#endif

void sines(const double* x, double* s, double* c, int n) {
  using T = Wide<double>;
  for (int i = 0; i < n; i += T::count) {
    const LaneSinCos<T> sc = lane_sin_cos(T::load(x + i));
    sc.sin.store(s + i);
    sc.cos.store(c + i);
  }
}

}  // namespace

namespace UGOKI_WIDTH {
extern const Kernels table;
const Kernels table = {inverse<One>, forward_one, inertia_one, twins::inverse, forward_twins, twins::inertia, sines,
#ifdef UGOKI_NO_BATCH
                       {},           {}};
#else
                       {UGOKI_DOUBLE_LANES, inverse<Wide<double>>, forward_batch<Wide<double>>, step_batch<Wide<double>>},
                       {UGOKI_FLOAT_LANES, inverse<Wide<float>>, forward_batch<Wide<float>>, step_batch<Wide<float>>}};
#endif
}  // namespace UGOKI_WIDTH

}  // namespace ugoki::dynamics
