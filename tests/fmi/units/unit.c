/* One of the models, as an FMU. */
#include "unit.h"
