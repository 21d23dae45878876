#define UGOKI_WIDTH dense_avx2
#include "ugoki/contact/dense_kernels_width.h"
