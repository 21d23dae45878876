#define UGOKI_WIDTH plain
#define UGOKI_DOUBLE_LANES 2
#include "ugoki/dynamics/closed_kernels_width.h"
