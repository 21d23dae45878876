#define UGOKI_WIDTH avx2
#define UGOKI_DOUBLE_LANES 4
#define UGOKI_FLOAT_LANES 8
#include "ugoki/collision/bubble_width.h"
