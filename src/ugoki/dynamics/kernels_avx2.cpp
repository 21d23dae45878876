#define UGOKI_WIDTH avx2
#define UGOKI_DOUBLE_LANES 4
#define UGOKI_FLOAT_LANES 8
#include "ugoki/dynamics/kernels_width.h"
