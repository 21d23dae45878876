#include "ugoki/dynamics/kernels.h"

#include <atomic>

namespace ugoki::dynamics {
namespace {

const Kernels* table_of(SimdWidth width) {
#ifdef UGOKI_X86_WIDTHS
  if (width == SimdWidth::avx512) return __builtin_cpu_supports("avx512f") ? &avx512::table : nullptr;
  if (width == SimdWidth::avx2) return __builtin_cpu_supports("avx2") ? &avx2::table : nullptr;
#endif
  return width == SimdWidth::plain ? &plain::table : nullptr;
}

std::atomic<const Kernels*> chosen = nullptr;

}  // namespace

SimdWidth widest_simd() {
  for (const SimdWidth width : {SimdWidth::avx512, SimdWidth::avx2})
    if (table_of(width) != nullptr) return width;
  return SimdWidth::plain;
}

const Kernels& kernels() {
  const Kernels* table = chosen.load(std::memory_order_relaxed);
  if (table == nullptr) {
    table = table_of(widest_simd());
    chosen.store(table, std::memory_order_relaxed);
  }
  return *table;
}

bool use_simd(SimdWidth width) {
  const Kernels* const table = table_of(width);
  if (table != nullptr) chosen.store(table, std::memory_order_relaxed);
  return table != nullptr;
}

std::size_t scratch_size(const LinkProgram& program, std::size_t bytes, int instances) {
  // numbers a node, a freedom and a slot take in the most demanding kernel, and the pieces' boundaries of 64 bytes
  const auto lanes = static_cast<std::size_t>(instances), nodes = static_cast<std::size_t>(program.nodes()) + 1;
  const std::size_t numbers = nodes * (9 + 12 + 6 + 15 + 6) + static_cast<std::size_t>(program.nv) * 10 +
                              static_cast<std::size_t>(program.slots) * 27 + static_cast<std::size_t>(program.angles() + 8) * 2;
  return numbers * bytes * lanes + 16 * 64;
}

}  // namespace ugoki::dynamics
