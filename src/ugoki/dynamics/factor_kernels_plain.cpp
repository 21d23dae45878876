#define UGOKI_WIDTH plain
#include "ugoki/dynamics/factor_kernels_width.h"
