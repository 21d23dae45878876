#define UGOKI_WIDTH forces_avx2
#include "ugoki/control/force_kernels_width.h"
