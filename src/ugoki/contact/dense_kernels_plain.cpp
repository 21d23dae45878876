#define UGOKI_WIDTH dense_plain
#include "ugoki/contact/dense_kernels_width.h"
