#include "ugoki/contact/solver_kernels.h"

namespace ugoki::contact {

namespace solver_plain {
extern const SolverKernels table;
}
#ifdef UGOKI_X86_WIDTHS
namespace solver_avx2 {
extern const SolverKernels table;
}
#endif

namespace {

const SolverKernels* wide_table() {
#ifdef UGOKI_X86_WIDTHS
  if (__builtin_cpu_supports("avx2")) return &solver_avx2::table;
#endif
  return nullptr;
}

// Table that use_solver_kernels() selected, or null. Not synchronised: that function must not run concurrently with other threads.
const SolverKernels* chosen = nullptr;

}  // namespace

const SolverKernels& solver_kernels() {
  static const SolverKernels* const widest = wide_table() != nullptr ? wide_table() : &solver_plain::table;
  return chosen != nullptr ? *chosen : *widest;
}

bool use_solver_kernels(bool wide) {
  const SolverKernels* const table = wide ? wide_table() : &solver_plain::table;
  if (table != nullptr) chosen = table;
  return table != nullptr;
}

}  // namespace ugoki::contact
