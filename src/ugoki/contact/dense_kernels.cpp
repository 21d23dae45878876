#include "ugoki/contact/dense_kernels.h"

namespace ugoki::contact {

namespace dense_plain {
extern const DenseKernels table;
}
#ifdef UGOKI_X86_WIDTHS
namespace dense_avx2 {
extern const DenseKernels table;
}
#endif

namespace {

const DenseKernels* wide_table() {
#ifdef UGOKI_X86_WIDTHS
  if (__builtin_cpu_supports("avx2")) return &dense_avx2::table;
#endif
  return nullptr;
}

// Table that use_dense_kernels() selected, or null. Not synchronised: that function must not run concurrently with other threads.
const DenseKernels* chosen = nullptr;

}  // namespace

const DenseKernels& dense_kernels() {
  static const DenseKernels* const widest = wide_table() != nullptr ? wide_table() : &dense_plain::table;
  return chosen != nullptr ? *chosen : *widest;
}

bool use_dense_kernels(bool wide) {
  const DenseKernels* const table = wide ? wide_table() : &dense_plain::table;
  if (table != nullptr) chosen = table;
  return table != nullptr;
}

}  // namespace ugoki::contact
