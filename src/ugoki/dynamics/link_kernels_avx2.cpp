#define UGOKI_WIDTH avx2
#include "ugoki/dynamics/link_kernels_width.h"
