#include "ugoki/control/force_kernels.h"

#include "ugoki/dynamics/kernels.h"

namespace ugoki::control {

namespace forces_plain {
extern const ForceKernels table;
}
#ifdef UGOKI_X86_WIDTHS
namespace forces_avx2 {
extern const ForceKernels table;
}
#endif

const ForceKernels& force_kernels() {
#ifdef UGOKI_X86_WIDTHS
  if (dynamics::uses_avx2()) return forces_avx2::table;
#endif
  return forces_plain::table;
}

}  // namespace ugoki::control
