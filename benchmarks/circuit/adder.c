/* a + b, as the library of LSIs that `./bench circuit` loads through the C interface. */
#include <ugoki/lsi.h>

static int32_t add(const ugoki_call* call) {
  *(double*)call->out[0] = *(const double*)call->in[0] + *(const double*)call->in[1];
  return 0;
}

static const ugoki_input inputs[] = {{sizeof(ugoki_input), UGOKI_SCALAR, 0, 0, "a", 0, 0, 0, 0, 0},
                                     {sizeof(ugoki_input), UGOKI_SCALAR, 0, 0, "b", 0, 0, 0, 0, 0}};
static const ugoki_output outputs[] = {{sizeof(ugoki_output), UGOKI_SCALAR, 0, 0, "out", 0, 0, 0, 0, 0, 0}};
static const ugoki_class adder = {sizeof(ugoki_class), 1, "add", "a + b.", 0, inputs, outputs, 0, 0, 2, 1, 0, 0, 0, 0, add, 0, 0, 0, 0, 0};
static const ugoki_class* const classes[] = {&adder};
static const ugoki_library library = {sizeof(ugoki_library), UGOKI_LSI_ABI, "adder", 0, 0, classes, 1, 0};

const ugoki_library* ugoki_lsi_library(void) { return &library; }
