#define UGOKI_WIDTH solver_avx2
#include "ugoki/contact/solver_kernels_width.h"
