#include "ugoki/dynamics/kernels.h"

#include "ugoki/dynamics/factor_kernels.h"
#include "ugoki/dynamics/link_kernels.h"

namespace ugoki::dynamics {

namespace plain {
extern const FactorKernels factor_table;
extern const LinkKernels link_table;
}  // namespace plain
#ifdef UGOKI_X86_WIDTHS
namespace avx2 {
extern const FactorKernels factor_table;
extern const LinkKernels link_table;
}  // namespace avx2
#endif

namespace {

const Kernels* table_of(SimdWidth width) {
#ifdef UGOKI_X86_WIDTHS
  if (width == SimdWidth::avx512)
    return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq") ? &avx512::table
                                                                                                                         : nullptr;
  if (width == SimdWidth::avx2) return __builtin_cpu_supports("avx2") ? &avx2::table : nullptr;
#endif
  return width == SimdWidth::plain ? &plain::table : nullptr;
}

// Table that use_simd() selected, or null. Not synchronised: use_simd() must not run concurrently with other threads.
const Kernels* chosen = nullptr;

}  // namespace

SimdWidth widest_simd() {
  for (const SimdWidth width : {SimdWidth::avx512, SimdWidth::avx2})
    if (table_of(width) != nullptr) return width;
  return SimdWidth::plain;
}

const Kernels& kernels() {
  static const Kernels* const widest = table_of(widest_simd());
  return chosen != nullptr ? *chosen : *widest;
}

bool uses_avx2() {
#ifdef UGOKI_X86_WIDTHS
  return &kernels() != &plain::table;
#else
  return false;
#endif
}

const FactorKernels& factor_kernels() {
#ifdef UGOKI_X86_WIDTHS
  if (uses_avx2()) return avx2::factor_table;
#endif
  return plain::factor_table;
}

const LinkKernels& link_kernels() {
#ifdef UGOKI_X86_WIDTHS
  if (uses_avx2()) return avx2::link_table;
#endif
  return plain::link_table;
}

bool use_simd(SimdWidth width) {
  const Kernels* const table = table_of(width);
  if (table != nullptr) chosen = table;
  return table != nullptr;
}

std::size_t scratch_size(int nodes, int nv, int slots, int angles, std::size_t bytes, int instances) {
  // Upper bound over all kernels: values per node, DOF, slot (NodeOrder::slot) and angle, plus 64-byte alignment of up to 16 arrays.
  const auto n = [](int count) { return static_cast<std::size_t>(count); };
  const std::size_t values = n(nodes + 1) * (9 + 12 + 6 + 18 + 6) + n(nv) * 10 + n(slots) * 27 + n(angles + 16) * 2;
  const std::size_t entries = inertia_entries_at_once + n(nv) + 8 * 8;
  return (values + entries) * bytes * n(instances) + 16 * 64;
}

std::size_t scratch_size(const LinkProgram& program, std::size_t bytes, int instances) {
  return scratch_size(program.nodes(), program.nv, program.slots, program.angles(), bytes, instances);
}

const double* nonzero_wrenches(std::span<const Vec6> external) {
  static_assert(sizeof(Vec6) == 6 * sizeof(double));
  for (const Vec6& f : external)
    if (f.w.x != 0 || f.w.y != 0 || f.w.z != 0 || f.v.x != 0 || f.v.y != 0 || f.v.z != 0) return &external.front().w.x;
  return nullptr;
}

}  // namespace ugoki::dynamics
