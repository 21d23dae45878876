#define UGOKI_WIDTH avx2
#include "ugoki/dynamics/factor_kernels_width.h"
