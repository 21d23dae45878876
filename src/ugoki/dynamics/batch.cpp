#include "ugoki/dynamics/batch.h"

#include <algorithm>
#include <type_traits>

#include "ugoki/base/check.h"
#include "ugoki/dynamics/kernels.h"

namespace ugoki::dynamics {
namespace {

template <class Real>
const BatchKernels<Real>& batch_kernels() {
  if constexpr (std::is_same_v<Real, double>)
    return kernels().in_double;
  else
    return kernels().in_single;
}

template <class Real>
std::vector<NodeConstants<Real>> constants_in(const LinkProgram& program) {
  if constexpr (std::is_same_v<Real, double>)
    return program.constants;
  else
    return in_single_precision(program.constants);
}

}  // namespace

/// Kernel arguments for one SIMD register of instances.
template <class Real>
struct BatchWorkspace<Real>::Access {
  BatchWorkspace& b;
  KernelArguments<Real> a;

  Access(BatchWorkspace& batch, const Vec3& gravity) : b(batch) {
    const LinkProgram& p = b.program_;
    a = {.order = p.order.data(),
         .constants = b.constants_.data(),
         .nodes = p.nodes(),
         .slots = p.slots,
         .nv = p.nv,
         .links = p.links.data(),
         .link_count = static_cast<int>(p.links.size()),
         .angle_q = p.angle_q.data(),
         .angle_sign = p.angle_sign.data(),
         .angles = p.angles(),
         .q = nullptr,
         .v = nullptr,
         .in = nullptr,
         .external = nullptr,
         .out = nullptr,
         .gravity = {static_cast<Real>(gravity.x), static_cast<Real>(gravity.y), static_cast<Real>(gravity.z)},
         .scratch = b.scratch_.data()->bytes,
         .entry_index = nullptr,
         .stride = lanes};
    const auto block_count = static_cast<std::size_t>(b.blocks_);
    const std::size_t block_v = block_count * static_cast<std::size_t>(p.nv) * lanes;
    UGOKI_CHECK(b.q.size() == block_count * static_cast<std::size_t>(p.nq) * lanes && b.v.size() == block_v && b.tau.size() == block_v &&
                b.vdot.size() == block_v && b.singular.size() == block_count * lanes);
    UGOKI_CHECK(b.external.empty() || b.external.size() == block_count * p.links.size() * 6 * lanes);
  }

  /// Sets the argument pointers to the instances that start at `lane` of `block`.
  void point(int block, int lane, const std::vector<Real>& in, std::vector<Real>& out) {
    const LinkProgram& p = b.program_;
    const auto at = [&](int count) {
      return static_cast<std::size_t>(block) * static_cast<std::size_t>(count) * lanes + static_cast<std::size_t>(lane);
    };
    a.q = b.q.data() + at(p.nq);
    a.v = b.v.data() + at(p.nv);
    a.in = in.data() + at(p.nv);
    a.out = out.data() + at(p.nv);
    a.external = b.external.empty() ? nullptr : b.external.data() + at(6 * a.link_count);
  }

  /// Forward dynamics of all instances. Calls `then(bits)` after each SIMD register; bit i is set if its instance i is singular.
  /// @return number of singular instances
  template <class Then>
  int forward(const Then& then) {
    const BatchKernels<Real>& k = batch_kernels<Real>();
    int count = 0;
    for (int block = 0; block < b.blocks_; ++block) {
      for (int lane = 0; lane < lanes; lane += k.lanes) {
        point(block, lane, b.tau, b.vdot);
        const unsigned bad = k.forward(a);
        for (int i = 0; i < k.lanes; ++i) {
          const int instance = block * lanes + lane + i;
          const bool is_bad = (bad >> i & 1U) != 0;
          b.singular[static_cast<std::size_t>(instance)] = is_bad ? 1 : 0;
          count += is_bad && instance < b.instances_ ? 1 : 0;
        }
        then(bad);
      }
    }
    return count;
  }
};

template <class Real>
BatchWorkspace<Real>::BatchWorkspace(const Mechanism& m, int instances)
    : instances_(instances),
      blocks_((instances + lanes - 1) / lanes),
      nq_(m.nq()),
      nv_(m.nv()),
      program_(m),
      constants_(constants_in<Real>(program_)) {
  UGOKI_CHECK(instances >= 0);
  const auto size_of = [&](int count) { return static_cast<std::size_t>(blocks_) * static_cast<std::size_t>(count) * lanes; };
  q.resize(size_of(nq_));
  for (std::vector<Real>* x : {&v, &tau, &vdot}) x->resize(size_of(nv_));
  singular.resize(size_of(1));
  scratch_.resize((scratch_size(program_, sizeof(Real), lanes) + sizeof(CacheLine) - 1) / sizeof(CacheLine));
  const std::vector<double> neutral = m.neutral();
  for (int i = 0; i < blocks_ * lanes; ++i) set(q, i, neutral);
}

template <class Real>
void BatchWorkspace<Real>::use_external() {
  external.assign(static_cast<std::size_t>(blocks_) * program_.links.size() * 6 * lanes, Real(0));
}

template <class Real>
void BatchWorkspace<Real>::set(std::vector<Real>& array, int instance, std::span<const double> x) const {
  UGOKI_CHECK(instance >= 0 && instance < blocks_ * lanes && x.size() * static_cast<std::size_t>(blocks_) * lanes == array.size());
  const std::size_t begin = static_cast<std::size_t>(instance / lanes) * x.size() * lanes + static_cast<std::size_t>(instance % lanes);
  for (std::size_t i = 0; i < x.size(); ++i) array[begin + i * lanes] = static_cast<Real>(x[i]);
}

template <class Real>
void BatchWorkspace<Real>::get(const std::vector<Real>& array, int instance, std::span<double> x) const {
  UGOKI_CHECK(instance >= 0 && instance < blocks_ * lanes && x.size() * static_cast<std::size_t>(blocks_) * lanes == array.size());
  const std::size_t begin = static_cast<std::size_t>(instance / lanes) * x.size() * lanes + static_cast<std::size_t>(instance % lanes);
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = static_cast<double>(array[begin + i * lanes]);
}

template <class Real>
void BatchWorkspace<Real>::set_state(int instance, std::span<const double> q_in, std::span<const double> v_in) {
  set(q, instance, q_in);
  set(v, instance, v_in);
}

template <class Real>
void BatchWorkspace<Real>::get_state(int instance, std::span<double> q_out, std::span<double> v_out) const {
  get(q, instance, q_out);
  get(v, instance, v_out);
}

template <class Real>
void calc_inverse_dynamics(BatchWorkspace<Real>& batch, const Vec3& gravity) {
  typename BatchWorkspace<Real>::Access access(batch, gravity);
  const BatchKernels<Real>& k = batch_kernels<Real>();
  for (int block = 0; block < batch.blocks(); ++block) {
    for (int lane = 0; lane < BatchWorkspace<Real>::lanes; lane += k.lanes) {
      access.point(block, lane, batch.vdot, batch.tau);
      k.inverse(access.a);
    }
  }
}

template <class Real>
int calc_forward_dynamics(BatchWorkspace<Real>& batch, const Vec3& gravity) {
  return typename BatchWorkspace<Real>::Access(batch, gravity).forward([](unsigned) {});
}

template <class Real>
int step_semi_implicit(BatchWorkspace<Real>& batch, const Vec3& gravity, double dt) {
  typename BatchWorkspace<Real>::Access access(batch, gravity);
  return access.forward([&](unsigned bad) {
    KernelArguments<Real> a = access.a;
    a.in = a.out;
    batch_kernels<Real>().step(a, const_cast<Real*>(a.q), const_cast<Real*>(a.v), static_cast<Real>(dt), bad);
  });
}

template class BatchWorkspace<double>;
template class BatchWorkspace<float>;
template void calc_inverse_dynamics(BatchWorkspace<double>&, const Vec3&);
template void calc_inverse_dynamics(BatchWorkspace<float>&, const Vec3&);
template int calc_forward_dynamics(BatchWorkspace<double>&, const Vec3&);
template int calc_forward_dynamics(BatchWorkspace<float>&, const Vec3&);
template int step_semi_implicit(BatchWorkspace<double>&, const Vec3&, double);
template int step_semi_implicit(BatchWorkspace<float>&, const Vec3&, double);

}  // namespace ugoki::dynamics
