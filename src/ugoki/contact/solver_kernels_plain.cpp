#define UGOKI_WIDTH solver_plain
#include "ugoki/contact/solver_kernels_width.h"
