#define UGOKI_WIDTH forces_plain
#include "ugoki/control/force_kernels_width.h"
