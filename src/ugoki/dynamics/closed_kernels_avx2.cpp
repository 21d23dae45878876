#define UGOKI_WIDTH avx2
#define UGOKI_DOUBLE_LANES 4
#include "ugoki/dynamics/closed_kernels_width.h"
