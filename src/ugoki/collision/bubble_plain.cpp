#define UGOKI_WIDTH plain
#define UGOKI_DOUBLE_LANES 2
#define UGOKI_FLOAT_LANES 4
#include "ugoki/collision/bubble_width.h"
