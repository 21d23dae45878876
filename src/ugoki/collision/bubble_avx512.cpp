#define UGOKI_WIDTH avx512
#define UGOKI_DOUBLE_LANES 8
#define UGOKI_FLOAT_LANES 8
#include "ugoki/collision/bubble_width.h"
