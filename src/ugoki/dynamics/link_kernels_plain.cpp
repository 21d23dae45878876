#define UGOKI_WIDTH plain
#include "ugoki/dynamics/link_kernels_width.h"
