#define UGOKI_WIDTH avx512
#define UGOKI_DOUBLE_LANES 8
#include "ugoki/dynamics/closed_kernels_width.h"
